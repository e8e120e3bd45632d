"""INFORM written for other languages' programs: the arm's configuration goes along."""

import re

import pytest
from inform_jobs import job, read_lines

from olp.core.source import decode
from olp.fluent import read_source
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.convert import convert, export
from olp.transpile.link import link


@pytest.mark.parametrize(
    ("status", "flags"),
    # KUKA's bits: 1 overhead area, 2 elbow as usual, 4 A5 negative; INFORM's: no flip, lower elbow, back.
    [(2, "1,0,0"), (3, "1,0,1"), (6, "0,0,0"), (0, "1,1,0"), (7, "0,0,1")],
)
def test_the_status_of_a_kuka_position_is_the_configuration_of_a_job(status, flags):
    place = f"{{X 900,Y 100,Z 500,A 0,B 0,C 180,S {status},T 0}}"
    text = "\r\n".join(["DEF PART ( )", "BAS (#VEL_PTP,20)", f"PTP {place}", "END", ""])
    program = read_source(decode(text.encode(), "part.src"), vendor="krl")
    context = Context(robot=load_robot("yaskawa/gp25"), on_loss="comment")
    made = convert(link(program).program, "inform", context, date="2026/01/01 00:00")
    written = made.files[made.main].decode()
    (found,) = re.findall(r"///RCONF ([\d,]+)", written)
    assert found.split(",")[:3] == flags.split(",")
    assert len(found.split(",")) == 24


@pytest.mark.parametrize("row", ["FOR I001 START= 1 TO 9 STEP= 2", "FOR I001 START= 9 TO 1 STEP= -1"])
def test_a_loop_keeps_its_step(row):
    program = read_lines(job([row, "TIMER T=0.50", "NEXT I001"]))
    assert not [d.render() for d in program.diagnostics if d.is_error]
    assert row in export(program, "inform").decode()
