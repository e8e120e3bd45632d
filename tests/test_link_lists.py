"""Data of other files are found whether or not every routine is."""

from __future__ import annotations

import pytest

import olp
from olp.transpile.link import link


@pytest.mark.parametrize("call", ["", "NOWHERE ( )\n"])
def test_a_global_list_is_found_beside_a_routine_that_is_nowhere(tmp_path, call):
    (tmp_path / "p.src").write_text(f"DEF p ( )\n{call}LIN XPICK\nEND\n")
    (tmp_path / "lists.src").write_text("DEF lists ( )\nEND\n")
    (tmp_path / "lists.dat").write_text(
        "DEFDAT lists PUBLIC\nDECL GLOBAL E6POS XPICK={X 900,Y 0,Z 900,A 0,B 90,C 0}\nENDDAT\n"
    )
    assert [d.name for d in link(olp.read(tmp_path / "p.src")).program.data] == ["XPICK"]
