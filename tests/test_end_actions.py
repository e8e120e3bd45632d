"""What MoveLDO and the like do at the end of their move, when the program runs.

ABB, technical reference manual, MoveLDO, MoveLGO, MoveLAO, MoveLSync: the output is set, or the procedure is called, at
the destination: at a stop point there, at a fly-by point in the middle of the corner, so before the next move.
"""

from __future__ import annotations

from olp.core.source import decode
from olp.fluent import read_source
from olp.runtime.plan import StepKind

_PROGRAM = """MODULE M
CONST robtarget p:=[[900,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget q:=[[900,100,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  MoveL q,v100,fine,tool0;
  MoveLDO p,v100,fine,tool0,do5,1;
  MoveLSync q,v100,z10,tool0,"grip";
  MoveLGO p,v100,z10,tool0,go1\\Value:=3;
  MoveLAO q,v100,z10,tool0,ao1,2.5;
  MoveCDO [[950,50,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],p,v100,fine,tool0,do5,0;
ENDPROC
PROC grip()
  SetDO do6,1;
ENDPROC
ENDMODULE
"""


def test_a_move_acts_at_its_end() -> None:
    plan = read_source(decode(_PROGRAM.encode(), "M.mod")).plan()
    happens = [
        plan.events[int(row)][1:3] if kind == StepKind.SIGNAL else int(line)
        for kind, row, line in zip(plan.kind, plan.row, plan.line, strict=True)
    ]
    assert happens == [
        5, 6, (("SIGNAL#(do5)",), 1.0),
        7, (("SIGNAL#(do6)",), 1.0),
        8, (("SIGNAL#(go1)",), 3.0),
        9, (("SIGNAL#(ao1)",), 2.5),
        10, (("SIGNAL#(do5)",), 0.0),
    ]  # fmt: skip


def test_the_corner_stays_and_the_wait_behind_it_sees_the_output() -> None:
    text = _PROGRAM.replace("MoveLDO p,v100,fine", "MoveLDO p,v100,z10").replace(
        "  MoveLSync", "  WaitDO do5,1;\n  MoveLSync"
    )
    plan = read_source(decode(text.encode(), "M.mod")).plan()
    assert not [found for found in plan.diagnostics if found.line == 7]
    assert plan.moves.blend[1] == 0.01


_TRIGGERS = """MODULE M
VAR triggdata gunon;
VAR triggdata gunoff;
VAR triggdata flow;
PROC main()
  VAR num level:=4;
  TriggIO gunon,0\\Start\\DOp:=do5,1;
  TriggEquip flow,30,0.1\\AOp:=ao1,level;
  level:=9;
  MoveL [[900,100,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
  TriggIO gunoff,10\\DOp:=do5,0;
  TriggL [[900,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,gunon\\T2:=gunoff\\T3:=flow,z10,tool0;
  MoveL [[900,100,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ENDPROC
ENDMODULE
"""


def test_a_trigger_sets_its_output_on_the_way() -> None:
    """TriggIO: with \\Start at the start of the move, else that far before its end; the value is that of then."""
    plan = read_source(decode(_TRIGGERS.encode(), "M.mod")).plan()
    happens = [
        plan.events[int(row)][1:3] if kind == StepKind.SIGNAL else int(line)
        for kind, row, line in zip(plan.kind, plan.row, plan.line, strict=True)
    ]
    assert happens == [
        10,
        (("SIGNAL#(do5)",), 1.0), 12, (("SIGNAL#(ao1)",), 4.0), (("SIGNAL#(do5)",), 0.0),
        13,
    ]  # fmt: skip
    assert [(one.metres, one.seconds) for one in plan.events.values()] == [(0, 0), (-0.03, -0.1), (-0.01, 0)]
