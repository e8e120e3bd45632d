"""Configurations of FANUC positions, whose turns stand in another order than olp keeps them."""

import pytest
from tp_listings import listing, read

from olp.transpile.convert import export

CONFIGURATIONS = ["N U T, 1, 0, 0", "F D B, 0, 0, -1", "F U T, -1, 0, 2", "N D T, 1, 2, 3"]


@pytest.mark.parametrize("text", CONFIGURATIONS)
def test_the_turns_of_each_wrist_axis_come_back_as_they_were(text):
    positions = (
        f"P[1]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : '{text}',\n"
        "\tX =   100.000  mm,\tY =    12.500  mm,\tZ =     -.384  mm,\n"
        "\tW =   178.500 deg,\tP =     3.250 deg,\tR =   -21.500 deg\n};\n"
    )
    program = read(listing("L P[1] 100mm/sec FINE", positions=positions))
    assert not [d.render() for d in program.diagnostics if d.is_error]
    again = export(program, "tp", date="2025/03/04 10:11").decode("latin-1")
    assert f"CONFIG : '{text}'" in again
