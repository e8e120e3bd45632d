/PROG  HANDLING
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Pick and drop";
PROG_SIZE	= 0;
CREATE		= DATE 25-03-04  TIME 10:11:12;
MODIFIED	= DATE 25-03-05  TIME 11:12:14;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 75;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/APPL
/MN
   1:  !Handling: picks from the table, ;
   2:  !lifts in three steps, drops ;
   3:  !-------------------------------- ;
   4:   ;
   5:  !Tool 1 is the gripper ;
   6:  PR[81,1:gripper]=12.5 ;
   7:  PR[81,2:gripper]=(-8.25) ;
   8:  PR[81,3:gripper]=187.4 ;
   9:  PR[81,4:gripper]=0 ;
  10:  PR[81,5:gripper]=15 ;
  11:  PR[81,6:gripper]=30 ;
  12:  UTOOL[1]=PR[81:gripper] ;
  13:  !Tool 2 is the probe ;
  14:  PR[82,1:probe]=(-31) ;
  15:  PR[82,2:probe]=4.5 ;
  16:  PR[82,3:probe]=220.75 ;
  17:  PR[82,4:probe]=10 ;
  18:  PR[82,5:probe]=(-5) ;
  19:  PR[82,6:probe]=62 ;
  20:  UTOOL[2]=PR[82:probe] ;
  21:  !Frame 1 is the table ;
  22:  PR[83,1:table]=850.5 ;
  23:  PR[83,2:table]=(-210.25) ;
  24:  PR[83,3:table]=305.75 ;
  25:  PR[83,4:table]=1.5 ;
  26:  PR[83,5:table]=(-2.25) ;
  27:  PR[83,6:table]=33 ;
  28:  UFRAME[1]=PR[83:table] ;
  29:  !Frame 2 is the rack ;
  30:  PR[84,1:rack]=420 ;
  31:  PR[84,2:rack]=640.5 ;
  32:  PR[84,3:rack]=512 ;
  33:  PR[84,4:rack]=0 ;
  34:  PR[84,5:rack]=0 ;
  35:  PR[84,6:rack]=90.5 ;
  36:  UFRAME[2]=PR[84:rack] ;
  37:   ;
  38:  UFRAME_NUM=1 ;
  39:  UTOOL_NUM=1 ;
  40:J P[1:"home"] 40% FINE    ;
  41:  DO[3:gripper]=OFF ;
  42:  !Approach and pick ;
  43:J P[2:"above"] 55% CNT50    ;
  44:L P[3:"pick"] 250mm/sec FINE    ;
  45:  DO[3:gripper]=ON ;
  46:  WAIT    .35(sec) ;
  47:  !Lift by 40 mm, three times ;
  48:  PR[1,1:lift]=0 ;
  49:  PR[1,2:lift]=0 ;
  50:  PR[1,4:lift]=0 ;
  51:  PR[1,5:lift]=0 ;
  52:  PR[1,6:lift]=0 ;
  53:  FOR R[1:step]=1 TO 3 ;
  54:  PR[1,3:lift]=R[1:step]*40 ;
  55:L P[3:"pick"] 120.5mm/sec CR5 Offset,PR[1:lift]    ;
  56:  ENDFOR ;
  57:  !The next station must be free ;
  58:  WAIT DI[7:rack free]=ON    ;
  59:  R[2:parts left]=2 ;
  60:  IF R[2:parts left]<=1,JMP LBL[10] ;
  61:  CALL DROP    ;
  62:  JMP LBL[20] ;
  63:  LBL[10:back to table] ;
  64:  UFRAME_NUM=1 ;
  65:  UTOOL_NUM=1 ;
  66:L P[3:"pick"] 250mm/sec FINE    ;
  67:  LBL[20:count down] ;
  68:  IF R[2:parts left]<=0,JMP LBL[30] ;
  69:  WAIT    .10(sec) ;
  70:  R[2:parts left]=R[2:parts left]-1 ;
  71:  JMP LBL[20] ;
  72:  LBL[30:home] ;
  73:  UFRAME_NUM=1 ;
  74:  UTOOL_NUM=1 ;
  75:J P[1:"home"] 40% FINE    ;
/POS
P[1:"home"]{
   GP1:
	UF : 0, UT : 1,	
	J1=     5.500 deg,	J2=   -12.250 deg,	J3=    18.750 deg,
	J4=     3.500 deg,	J5=   -47.250 deg,	J6=    21.000 deg
};
P[2:"above"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   110.500  mm,	Y =    45.250  mm,	Z =   160.000  mm,
	W =   178.500 deg,	P =     3.250 deg,	R =   -21.500 deg
};
P[3:"pick"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   110.500  mm,	Y =    45.250  mm,	Z =    20.125  mm,
	W =   178.500 deg,	P =     3.250 deg,	R =   -21.500 deg
};
/END
