"""Speeds and zones that a program computes: no other language has them, so each of their members is a variable.

The oracle is RAPID's meaning of the program: its moves run at 270, 200 and 270 mm/s.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import olp
from olp.core.source import decode
from olp.fluent import read_source
from olp.transpile import Context
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

_PROGRAM = """MODULE M
CONST robtarget p:=[[900,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget q:=[[900,100,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PERS speeddata fast;
VAR speeddata kept{3};
PROC main()
  VAR speeddata slow;
  VAR bool ok;
  fast:=[200,50,0,0];
  kept{2}:=fast;
  slow:=fast;
  IF NOT faster(slow) THEN
    RETURN;
  ENDIF
  ok:=faster(fast);
  MoveL p,slow,fine,tool0;
  MoveL q,kept{2},fine,tool0;
  MoveL p,fast,fine,tool0;
ENDPROC
FUNC bool faster(INOUT speeddata v)
  v.v_tcp:=v.v_tcp+70;
  v.v_ori:=30;
  RETURN v.v_tcp<300;
ENDFUNC
ENDMODULE
"""


def test_an_element_that_a_record_was_copied_to_keeps_its_value() -> None:
    plan = read_source(decode(_PROGRAM.encode(), "M.mod")).plan()
    assert [round(1000 * float(v)) for v in plan.moves.travel] == [270, 200, 270]


_TAKEN = """MODULE M
RECORD tray
  num row;
  bool full;
ENDRECORD
PROC main()
  WaitTime 0.3;
ENDPROC
PROC pick(tray here)
  WaitTime here.row/10;
  here:=emptied(here);
ENDPROC
FUNC tray emptied(tray t)
  t.full:=FALSE;
  RETURN t;
ENDFUNC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_a_type_of_which_there_are_parameters_and_no_data_is_a_record_too(target: str) -> None:
    made = convert(read_source(decode(_TAKEN.encode(), "M.mod")), target, Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


@pytest.mark.parametrize("target", ["krl", "tp"])
def test_speeds_handed_to_functions_and_kept_in_arrays_are_carried_over(target: str) -> None:
    made = convert(read_source(decode(_PROGRAM.encode(), "M.mod")), target, Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


_RETURNED = """MODULE M
PROC main()
  VAR part one;
  one:=made(3);
  one:=moved(one,2);
  SetAO ao1,one.count;
  SetAO ao2,one.place.x;
  one:=first();
  SetAO ao1,one.count;
  one:=again(one);
  SetAO ao1,one.count;
ENDPROC
FUNC part made(num n)
  VAR part p;
  p.count:=n;
  p.place.x:=10*n;
  RETURN p;
ENDFUNC
FUNC part moved(part p,num by)
  p.place.x:=p.place.x+by;
  IF by>5 RETURN p;
  p.count:=p.count+by;
  RETURN p;
ENDFUNC
FUNC part first()
  RETURN made(7);
ENDFUNC
FUNC part again(part p)
  IF p.count>6 RETURN moved(p,2);
  RETURN p;
ENDFUNC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_records_that_functions_return_are_handed_back_member_by_member(target: str, tmp_path: Path) -> None:
    (tmp_path / "m.mod").write_text(_RETURNED)
    layout = "MODULE T\nRECORD part\nnum count;\npos place;\nbool done;\nENDRECORD\nENDMODULE\n"
    (tmp_path / "t.mod").write_text(layout)
    program = link(olp.read(tmp_path / "m.mod"), target).program
    made = convert(program, target, Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    plan = run_converted(made, target, None)
    assert [event.value for _, event in sorted(plan.events.items())] == [5, 32, 7, 9]


_HANDED = """MODULE M
CONST robtarget p:=[[900,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget q:=[[900,100,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PERS tooldata held:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
PERS wobjdata table:=[FALSE,TRUE,"",[[0,50,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
PERS speeddata slow:=[70,20,5000,1000];
VAR speeddata now;
PROC main()
  go p,v100,z5,tool0\\WObj:=table;
  go q,slow,fine,held;
  now:=slow;
  now.v_tcp:=40;
  go p,now,z1,held\\WObj:=table;
  log now;
  twice q,v200,held;
ENDPROC
PROC go(robtarget goal,speeddata v,zonedata z,PERS tooldata tool\\PERS wobjdata WObj)
  MoveL goal,v,z,tool\\WObj?WObj;
ENDPROC
PROC twice(robtarget goal,speeddata v,PERS tooldata tool)
  go goal,v,fine,tool;
  go Offs(goal,0,0,20),v,fine,tool0;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_speeds_zones_tools_and_frames_are_handed_over(target: str) -> None:
    program = link(read_source(decode(_HANDED.encode(), "M.mod"))).program
    plan = program.plan()
    assert [round(1000 * float(v)) for v in plan.moves.travel] == [100, 70, 40, 200, 200]
    made = convert(program, target, Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    there = run_converted(made, target, None, program)
    assert [round(1000 * float(v)) for v in there.moves.travel] == [100, 70, 40, 200, 200]
    for row in range(5):
        assert there.positions.position[row + 1 - 1] == pytest.approx(plan.positions.position[row], abs=1e-6)


def test_a_routine_that_takes_tools_is_written_once_for_each_in_tp() -> None:
    program = link(read_source(decode(_HANDED.encode(), "M.mod"))).program
    made = convert(program, "tp", Context(on_loss="comment"))
    assert sorted(name.upper() for name in made.files) == [
        f"{name}.LS" for name in ("GO", "GO_2", "GO_3", "GO_4", "MAIN", "TWICE")
    ]
