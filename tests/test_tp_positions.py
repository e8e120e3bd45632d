"""The /POS section: numbers, frames, configurations, groups; every convention against an independent answer."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tp_listings import HEAD, codes, listing, read

from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState
from olp.languages.vendors.tp import positions
from olp.languages.vendors.tp.positions import TpPositionReader
from olp.robots.geometry import Pose

POSE = """P[{number}]{{
   GP1:
\tUF : {user}, UT : {tool},\t\tCONFIG : '{config}',
\tX = {x}  mm,\tY =   250.750  mm,\tZ =     -.384  mm,
\tW =   -71.500 deg,\tP =    33.250 deg,\tR =   128.625 deg{more}
}};
"""
JOINTS = """P[2:"rest"]{
   GP1:
\tUF : 0, UT : 1,\t
\tJ1=     5.500 deg,\tJ2=   -12.250 deg,\tJ3=    18.750 deg,
\tJ4=     3.500 deg,\tJ5=   -47.250 deg,\tJ6=    21.000 deg
};
"""


def pose(number=1, user="1", tool="2", config="N U T, 0, 0, 0", x="   110.500", more=""):
    return POSE.format(number=number, user=user, tool=tool, config=config, x=x, more=more)


def points(rows):
    program = read(listing(positions=rows))
    return program.routines[0].points, program


def point(rows, number=1, store=Store.ROBOT):
    found = points(rows)[0].find(store, True, number)
    assert found is not None
    return found


def test_a_pose_is_in_metres_and_radians():
    values = point(pose()).values
    assert values[:3] == pytest.approx((0.1105, 0.25075, -0.000384), abs=1e-15)
    assert np.degrees(values[3:]) == pytest.approx((-71.5, 33.25, 128.625))


def test_w_p_r_turn_about_the_fixed_x_y_z():
    """The manual: R = Rz(R) Ry(P) Rx(W)."""
    turned = Pose.from_xyz_angles(point(pose()).values[:6]).rotation
    expected = Rotation.from_euler("xyz", [-71.5, 33.25, 128.625], degrees=True).as_matrix()
    np.testing.assert_allclose(turned, expected, atol=1e-12)
    for wrong in ("zyx", "XYZ", "xzy", "yxz"):
        other = Rotation.from_euler(wrong, [-71.5, 33.25, 128.625], degrees=True).as_matrix()
        assert np.abs(turned - other).max() > 0.1


def test_the_frame_and_the_tool_of_a_point():
    assert point(pose()).state == PointState(PointKind.POSE, "user", 1, 2, (1, 0, 0, 0, 0, 0))
    world = point(pose(user="0", tool="0")).state
    assert (world.frame, world.user, world.tool) == ("base", None, 0)
    selected = point(pose(user="F", tool="F")).state
    assert (selected.frame, selected.user, selected.tool) == ("active", None, -1)


@pytest.mark.parametrize(
    ("text", "flags"),
    [
        ("N U T, 0, 0, 0", (1, 0, 0, 0, 0, 0)),
        ("F U T, 0, 0, 0", (0, 0, 0, 0, 0, 0)),
        ("N D T, 0, 0, 0", (1, 1, 0, 0, 0, 0)),
        ("F D B, 0, 0, 0", (0, 1, 1, 0, 0, 0)),
        ("N R U T, 1, 0, -1", (1, 0, 0, 1, -1, 0)),
        ("N U T, -1, 0, 1", (1, 0, 0, -1, 1, 0)),
        ("N U T, 0, 1, 0", (1, 0, 0, 0, 0, 0, 1)),
        ("L, 0, 0, 0", ()),
        ("N U, 0, 0, 0", ()),
        ("N U T, 0, 0", ()),
    ],
)
def test_the_configuration(text, flags):
    assert point(pose(config=text)).state.configuration == flags


def test_joints_are_axis_values_in_radians():
    found = point(JOINTS, 2)
    assert found.state == PointState(PointKind.JOINT, "joint", 0, 1)
    assert np.degrees(found.values) == pytest.approx((5.5, -12.25, 18.75, 3.5, -47.25, 21.0))
    assert read(listing(positions=JOINTS)).routines[0].details["P[2]"] == "rest"


def test_further_axes_have_their_own_units():
    table, program = points(pose(more=",\n\tE1=   412.500  mm,\tE2=    30.000 deg"))
    values = table.find(Store.ROBOT, True, 1).values
    assert values[:6] == point(pose()).values
    assert values[6] == pytest.approx(0.4125)
    assert values[7] == pytest.approx(math.radians(30))
    assert program.routines[0].details["unit GP1 E1"] == "mm"


def test_a_second_group_stands_beside_the_first():
    text = pose().replace(
        "\n};", "\n   GP2:\n\tUF : 0, UT : 1,\t\n\tJ1=    15.000 deg,\tJ2=   -40.500 deg\n};"
    )
    table, _ = points(text)
    assert len(table.find(Store.ROBOT, True, 1).values) == 6
    assert np.degrees(table.find(Store.STATION, True, 1).values) == pytest.approx((15, -40.5))


def test_a_program_of_the_second_group_alone_is_that_of_its_robot():
    text = pose().replace("GP1", "GP2")
    table, program = points(text)
    assert table.find(Store.ROBOT, True, 1) is not None
    assert program.routines[0].details["group 1"] == "2"


def test_a_position_that_was_never_taught_is_not_a_number():
    text = pose(x="  ********")
    assert math.isnan(point(text).values[0])
    assert "P516" in codes(listing("J P[1] 50% FINE", positions=text))


def test_plain_and_slow_ways_read_the_same_position():
    plain = pose()
    odd = pose().replace("X = ", "X= ").replace("GP1:", "GP1 :").replace("W =", " W  =").replace("};", "} ;")
    turned = plain.replace("mm,\tY =   250.750  mm", "mm, Y=250.75 mm").replace("\tW", "\n\tW")
    for other in (odd, turned):
        assert point(other).values == point(plain).values
        assert point(other).state == point(plain).state


TABLE = "\n};", "\n   GP2:\n\tUF : 3, UT : 1,\t\n\tJ1=    15.000 deg,\tJ2=   -40.500 deg\n};"
DAMAGES = ("}", "\n", " ", ";", "'", "9", "F", "*", ":", "E1 = 3.0 mm,", "J3= 4", "GP3:", "1234567.", "")


def positions_with_tables():
    """Two positions of an arm and of a table, whole and with a part replaced at many places."""
    text = pose().replace(*TABLE) + pose(2, config="F U T, 0, 1, 0").replace(*TABLE)
    yield text
    for at in range(0, len(text), 5):
        for k, damage in enumerate(DAMAGES):
            yield text[:at] + damage + text[at + (at + k) % 4 :]


def test_positions_of_an_arm_and_a_table_are_read_the_same_in_the_plain_and_in_the_slow_way(monkeypatch):
    def told(text):
        table, program = points(text)
        blocks = {
            key: (b.numbers.tolist(), b.lines.tolist(), b.state.tolist()) for key, b in table.blocks.items()
        }
        values = [np.nan_to_num(block.values, nan=-1.0).tolist() for block in table.blocks.values()]
        return table.states, blocks, values, program.diagnostics

    found = [told(text) for text in positions_with_tables()]
    monkeypatch.setattr(positions, "_WITH_TABLE", re.compile("(?!)"))  # matches nothing
    assert [told(text) for text in positions_with_tables()] == found


def test_plain_positions_of_an_arm_and_a_table_are_not_read_in_the_slow_way(monkeypatch):
    monkeypatch.setattr(TpPositionReader, "_other", None)
    table, _ = points(next(positions_with_tables()))
    assert [len(block) for block in table.blocks.values()] == [2, 2]


def test_lines_of_points_are_those_of_the_file():
    text = listing(positions=pose(1) + pose(2) + pose(3).replace("mm,\tY", "mm,\n\tY") + pose(4))
    table = read(text).routines[0].points
    lines = text.split("\n")
    for number in (1, 2, 3, 4):
        line = table.find(Store.ROBOT, True, number).line
        assert lines[line - 1].startswith(f"P[{number}]")


@pytest.mark.parametrize(
    ("positions", "code"),
    [
        (pose(x="   12.5.5"), "P510"),
        (pose(x="   1e900"), "P510"),
        (pose().replace("Z = ", "T = "), "P511"),
        (pose().replace("   GP1:\n", ""), "P511"),
        (pose().replace("};\n", ""), "P510"),
        (pose() + pose(), "P512"),
        (pose(config="L, 0, 0, 0"), "P513"),
        (pose() + "rubbish\n", "P510"),
        (
            pose().replace("GP1", "GP1").replace("};", "   GP7:\n\tUF : 0, UT : 1,\n\tJ1=     1.000 deg\n};"),
            "P514",
        ),
    ],
)
def test_a_broken_position_is_told(positions, code):
    text = listing("J P[1] 50% FINE", positions=positions)
    found = [one for one in read(text).diagnostics if one.code == code]
    assert found
    assert found[0].line > len(HEAD.split("\n")) - 1


def test_a_broken_position_is_not_also_missing():
    assert "P525" not in codes(listing("J P[1] 50% FINE", positions=pose(x="  oops") + pose(2)))
