/PROG  DROP
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Into the rack";
PROG_SIZE	= 0;
CREATE		= DATE 25-03-04  TIME 10:11:12;
MODIFIED	= DATE 25-03-05  TIME 11:12:14;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 11;
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
   1:  !Round the post, then to the rack ;
   2:  UFRAME_NUM=1 ;
   3:  UTOOL_NUM=1 ;
   4:C P[1:"round"]    
    :  P[2:"behind"] 150mm/sec CR10    ;
   5:  !The probe measures in the rack ;
   6:  UFRAME_NUM=2 ;
   7:  UTOOL_NUM=2 ;
   8:L P[3:"rack"] 300mm/sec FINE    ;
   9:  DO[3:gripper]=OFF ;
  10:  R[2:parts left]=R[2:parts left]-1 ;
  11:  END ;
/POS
P[1:"round"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   180.000  mm,	Y =   120.500  mm,	Z =    95.750  mm,
	W =   175.000 deg,	P =     1.000 deg,	R =     5.000 deg
};
P[2:"behind"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   260.250  mm,	Y =    60.000  mm,	Z =    40.500  mm,
	W =   170.500 deg,	P =    -4.000 deg,	R =    18.000 deg
};
P[3:"rack"]{
   GP1:
	UF : 2, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    55.500  mm,	Y =   -20.250  mm,	Z =    88.000  mm,
	W =   160.000 deg,	P =    12.500 deg,	R =   -75.000 deg
};
/END
