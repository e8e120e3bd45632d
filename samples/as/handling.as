.PROGRAM handling() #0
  ; Takes a part from the table and hands it to the rack
  n = 2 ; parts that are left
  BASE table
  TOOL grip
  SPEED 40
  ACCURACY 0
  JMOVE #start
  SIGNAL -3 ; gripper open
  SPEED 55
  ACCURACY 25
  JMOVE above
  SPEED 250 MM/S
  ACCURACY 0
  LMOVE pick
  SIGNAL 3 ; gripper closed
  TWAIT 0.35
  ; lift in three steps
  FOR i = 1 TO 3
    SPEED 120.5 MM/S
    ACCURACY 5
    LMOVE SHIFT(pick BY 0,0,40*i)
  END
  SWAIT 1007 ; the rack is free
  IF n>1 THEN
    CALL drop
  ELSE
    SPEED 250 MM/S
    LMOVE pick
  END
  ; what is left over
  WHILE n>0 DO
    TWAIT 0.1
    n = n-1
  END
  SPEED 40
  ACCURACY 0
  JMOVE #start
.END
.PROGRAM drop() #0
  ; by an arc above the table, then at the rack with the probe
  BASE table
  TOOL grip
  C1MOVE way
  SPEED 150 MM/S
  ACCURACY 10
  C2MOVE side
  BASE rack
  TOOL probe
  SPEED 300 MM/S
  ACCURACY 0
  LMOVE place
  SIGNAL -3
  n = n-1
.END
.TRANS
grip 12.5 -8.25 187.4 30 15 0
probe -31 4.5 220.75 -54.302486 11.168953 116.740205
table 850.5 -210.25 305.75 -113.297092 2.703950 146.326550
rack 420 640.5 512 90.5 0 0
above 110.5 45.25 160 -176.708182 176.420882 24.749262
pick 110.5 45.25 20.125 -176.708182 176.420882 24.749262
way 180 120.5 95.75 -96.281387 174.901230 78.674951
side 260.25 60 40.5 -49.371271 169.699366 112.961238
place 55.5 -20.25 88 164.261619 156.551505 57.049023
.END
.JOINTS
#start 5.5 -12.25 18.75 3.5 -47.25 21
.END
