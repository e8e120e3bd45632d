MODULE PalletData(SYSMODULE,NOSTEPIN) ! tools, places, recipes
  RECORD recipe
    num rows;
    num columns;
    pos pitch; ! between two cartons
    string name;
  ENDRECORD
  ALIAS num layers;

  PERS tooldata tSucker:=[TRUE,[[3.5,-2.25,143.75],[0.965925826,0,0,0.258819045]],[2.6,[1.5,-3,61],[1,0,0,0],0.01,0.01,0.004]];
  TASK PERS wobjdata wPallet:=[FALSE,TRUE,"",[[1040.5,-412.75,88.25],[0.996194698,0,0.003,0.087]],[[12.5,7.75,0],[1,0,0,0]]];
  PERS wobjdata wBelt:=[FALSE,TRUE,"",[[905.25,388.5,402],[0.707106781,0,0,-0.707106781]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget pGrasp:=[[31.5,84.25,16.75],[0.009,0.999,-0.021,0.035],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pCorner:=[[75,62.5,24.5],[0.017,0.998,0.046,-0.031],[-1,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS jointtarget jWait:=[[12.5,-21.25,17.75,4.5,-52.5,33],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST recipe rcpHalf:=[2,3,[118.7,142.4,97.3],"half"];
  CONST speeddata vCarry:=[650,220,5000,1000];
  CONST zonedata zCarry:=[FALSE,35,52,52,5.2,52,5.2];
  LOCAL VAR intnum iVacuum;
ENDMODULE

MODULE Pallet
  VAR recipe rcpNow;
  VAR layers nLayer:=1;
  VAR num nCartons{2,3};
  VAR bool bFull:=FALSE;
  VAR clock ckCycle;

  ! Fills one pallet.
  PROC main()
    VAR num nState:=1;

    ConfL \Off;
    SingArea \Wrist;
    AccSet 80,60; ! cartons are not fixed
    VelSet 90,2000;
    rcpNow:=rcpHalf;
    CONNECT iVacuum WITH tLost;
    ISignalDI diVacuum,0,iVacuum;
    ClkReset ckCycle;
    ClkStart ckCycle;
    MoveAbsJ jWait\NoEOffs,v1000,z50,tSucker;
    WHILE NOT bFull DO
      FOR i FROM 1 TO rcpNow.rows DO
        FOR k FROM rcpNow.columns TO 1 STEP -1 DO
          pick;
          place i,k\layer:=nLayer;
          nCartons{i,k}:=nCartons{i,k}+1;
        ENDFOR
      ENDFOR
      Incr nLayer;
      IF nLayer>2 bFull:=TRUE;
    ENDWHILE
    TEST nState
    CASE 1,2:
      TPWrite "cartons: "\Num:=total();
    CASE 3:
      Stop;
    DEFAULT:
      GOTO ready;
    ENDTEST
  ready:
    ClkStop ckCycle;
    IF ClkRead(ckCycle)>120 OR (nState=1 AND NOT bFull) TPWrite "slow";
    MoveAbsJ [[11.5,-20.75,16.25,3.5,-50.5,31],[9E9,9E9,9E9,9E9,9E9,9E9]],v800,fine,tSucker;
  ERROR
    IF ERRNO=ERR_WAIT_MAXTIME THEN
      TPWrite "no carton"; ! the belt is empty
      RETRY;
    ENDIF
  ENDPROC

  ! Takes a carton from the belt.
  PROC pick()
    MoveJ Offs(pGrasp,0,0,80),v1500,z20,tSucker\WObj:=wBelt;
    WaitDI diCarton,1\MaxTime:=4;
    MoveL pGrasp,v200,fine,tSucker\WObj:=wBelt;
    Set doVacuum;
    WaitUntil diVacuum=1 AND NOT diBlocked=1\MaxTime:=1.5;
    MoveL RelTool(pGrasp,0,0,-90\Rz:=12.5),vCarry\T:=0.6,z5,
      tSucker\WObj:=wBelt;
  ENDPROC

  ! Puts it down in its row and column.
  PROC place(num row,num column\num layer|switch last)
    VAR robtarget pHere;
    VAR num z:=0;

    IF Present(layer) THEN
      z:=(layer-1)*rcpNow.pitch.z;
    ENDIF
    pHere:=Offs(pCorner,(row-1)*rcpNow.pitch.x,(column-1)*rcpNow.pitch.y,z);
    pHere.rot:=OrientZYX(EulerZYX(\Z,pHere.rot)+1.5,EulerZYX(\Y,pHere.rot),EulerZYX(\X,pHere.rot));
    TriggL Offs(pHere,0,0,60),vCarry,tgBlow\T2:=tgLight,zCarry,tSucker\WObj:=wPallet;
    MoveL pHere,v100\V:=85,fine,tSucker\WObj:=wPallet;
    Reset doVacuum;
    PulseDO\PLength:=0.2,doBlow;
    WaitTime\InPos,0.15;
    MoveC Offs(pHere,15,20,40),Offs(pHere,35.5,10,75.25),v300,z10,tSucker\WObj:=wPallet;
    IF row=rcpNow.rows RETURN;
  ENDPROC

  FUNC num total()
    VAR num sum:=0;

    FOR i FROM 1 TO rcpNow.rows DO
      FOR k FROM 1 TO rcpNow.columns DO
        sum:=sum+nCartons{i,k};
      ENDFOR
    ENDFOR
    RETURN sum;
  ENDFUNC

  LOCAL TRAP tLost
    Stop;
    RETURN;
  ENDTRAP
ENDMODULE
