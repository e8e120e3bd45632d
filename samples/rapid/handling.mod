%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Handling
  ! Takes a part from the table and hands it to the rack.
  ! Tools on the flange, work objects in the base.
  PERS tooldata tGripper:=[TRUE,[[12.5,-8.25,187.4],[0.957662197,-0.033782664,0.12607862,0.256604812]],[3.2,[4.5,-2.5,88],[1,0,0,0],0.012,0.011,0.009]];
  PERS tooldata tProbe:=[TRUE,[[-31,4.5,220.75],[0.851134781,0.097016105,0.007598966,0.515848539]],[1.4,[-9,1.5,97],[1,0,0,0],0,0,0]];
  PERS wobjdata wTable:=[FALSE,TRUE,"",[[850.5,-210.25,305.75],[0.958479794,0.018123936,-0.01510663,0.284182684]],[[0,0,0],[1,0,0,0]]];
  ! The rack's user frame stands at its foot: its object frame is the shelf.
  PERS wobjdata wRack:=[FALSE,TRUE,"",[[420,640.5,112],[0.704014724,0,0,0.710185376]],[[0,0,400],[1,0,0,0]]];

  CONST jointtarget jHome:=[[5.5,-12.25,18.75,3.5,-47.25,21],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pAbove:=[[110.5,45.25,160],[0.007565749,0.982040393,-0.186068372,-0.030298286],[-1,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pPart:=[[110.5,45.25,20.125],
    [0.007565749,0.982040393,-0.186068372,-0.030298286], ! as above
    [-1,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pArc:=[[180,120.5,95.75],[0.043956496,0.998042741,0.043956496,-0.006807353],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pEdge:=[[260.25,60,40.5],[0.076298144,0.984148611,0.152947838,0.047297606],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pShelf:=[[55.5,-20.25,88],[0.071678433,0.788165086,-0.580951697,-0.190139752],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  CONST speeddata vLift:=[120.5,500,5000,1000];
  CONST zonedata zTurn:=[FALSE,25,38,38,3.8,38,3.8]; ! between z20 and z30
  VAR num nParts:=2; ! parts that are left

  PROC main()
    ! begin where nothing is in the way
    MoveAbsJ jHome\NoEOffs,v1500,fine,tGripper;
    SetDO do3,0; ! gripper open
    MoveJ pAbove,v2000,zTurn,tGripper\WObj:=wTable;
    MoveL pPart,v100\V:=250,fine,tGripper\WObj:=wTable;
    SetDO do3,1;
    WaitTime 0.35;
    ! lift in three steps
    FOR i FROM 1 TO 3 DO
      MoveL Offs(pPart,0,0,40*i),vLift,z5,tGripper\WObj:=wTable;
    ENDFOR
    WaitDI di7,1; ! the rack is free
    IF nParts>1 THEN
      DROP;
    ELSE
      MoveL pPart,v100\V:=250,fine,tGripper\WObj:=wTable;
    ENDIF
    ! what is left over
    WHILE nParts>0 DO
      WaitTime 0.1;
      nParts:=nParts-1;
    ENDWHILE
    MoveAbsJ jHome\NoEOffs,v1500,fine,tGripper;
  ENDPROC

  ! Hands a part over: by an arc above the table, then at the rack with the probe.
  PROC DROP()
    MoveC pArc,pEdge,v150,z10,tGripper\WObj:=wTable;
    MoveL pShelf,v300,fine,tProbe\WObj:=wRack;
    SetDO do3,0;
    nParts:=nParts-1;
    RETURN;
  ENDPROC
ENDMODULE
