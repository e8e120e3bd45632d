"""Products and inverses of poses that change, for controllers that only add position registers."""

from __future__ import annotations

import numpy as np
import pytest
from handling_sample import poses
from translated_texts import ROBOT, converted, module, run_elsewhere

from olp.core.source import decode
from olp.fluent import read_source
from olp.robots.geometry import rotation_from_angles

_DATA = (
    "CONST robtarget p0:=[[900,0,700],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    "VAR pose a:=[[0,0,0],[1,0,0,0]];",
    "VAR pose b:=[[0,0,0],[1,0,0,0]];",
)
_MOVES = (
    "MoveL Offs(p0,b.trans.x,b.trans.y,b.trans.z),v100,fine,tool0;",
    "MoveL Offs(p0,EulerZYX(\\X,b.rot),EulerZYX(\\Y,b.rot),EulerZYX(\\Z,b.rot)),v100,fine,tool0;",
)
_SETS = "a.trans:=[10*i,20,-30];"


def _program(turn: str, value: str) -> str:
    rows = ("FOR i FROM -1 TO 2 DO", _SETS, f"a.rot:={turn};", f"b:={value};", *_MOVES, "ENDFOR")
    return module("MoveJ p0,v500,fine,tool0;", *rows, data=_DATA)


@pytest.mark.parametrize("turn", ["OrientZYX(40*i,20,10)", "OrientZYX(5,90*i,7*i)", "OrientZYX(170,3,177*i)"])
@pytest.mark.parametrize(
    "value", ["PoseMult(a,a)", "PoseInv(a)", "PoseMult(PoseInv(a),PoseMult(a,[[5,0,9],[1,0,0,0]]))"]
)
def test_a_routine_multiplies_and_inverts_poses_for_fanuc(turn: str, value: str) -> None:
    text = _program(turn, value)
    made = converted(text, "rapid", "tp")
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    plan, wanted = run_elsewhere(text, "rapid", "tp"), read_source(decode(text.encode(), "M.mod")).plan(ROBOT)
    ours, right = (one.positions.position[one.moves.target] for one in (plan, wanted))
    np.testing.assert_allclose(ours[1::2], right[1::2], atol=1e-7)
    assert_same_turns(ours[2::2] - right[0], right[2::2] - right[0])


def assert_same_turns(ours: np.ndarray, right: np.ndarray) -> None:
    """Angles about x, y, z [mm for deg]: of right angles about y there are many."""
    for one, other in zip(ours * 1e3, right * 1e3, strict=True):
        both = (rotation_from_angles(np.radians(angles)) for angles in (one, other))
        np.testing.assert_allclose(*both, atol=1e-6)


def test_what_a_tool_adds_leaves_the_posture_as_it_is() -> None:
    """AS: q = q+TRANS(0,0,50) was left out."""
    text = ".PROGRAM main()\nPOINT q = p\nFOR .i = 1 TO 2\nPOINT q = q+TRANS(0,0,5*.i,10,20,30)\nLMOVE q\nEND\n.END\n"
    text += ".TRANS\np 900 100 600 10 170 20\n.END\n"
    made = converted(text, "as", "tp")
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert "tool_product.ls" in made.files


_TURNS = """.PROGRAM main()
FOR .i = 1 TO 3
POINT q = TRANS(900-10*.i,20*.i,600,30*.i,170-.i,-20*.i)
LMOVE q
END
.END
"""


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_a_pose_with_computed_angles_is_set_element_by_element(target: str) -> None:
    """INFORM: "a pose whose angles are computed" was left out."""
    made = converted(_TURNS, "as", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    plan = run_elsewhere(_TURNS, "as", target)
    wanted = read_source(decode(_TURNS.encode(), "main.as")).plan(ROBOT)
    for ours, right in zip(poses(plan), poses(wanted), strict=True):
        np.testing.assert_allclose(ours, right, atol=2e-5)
