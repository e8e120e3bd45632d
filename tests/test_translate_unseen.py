"""What reading the translations of real programs beside their sources showed: a small program for each cause."""

from __future__ import annotations

import re

import pytest
from translated_texts import converted, script, translated

from olp.core.source import load
from olp.languages.vendors.urscript.reader import read_program
from olp.transpile import Context
from olp.transpile.context import Fate
from olp.transpile.convert import convert
from olp.transpile.link import link

_LIBRARY = """def weld_on():
  weld = 1
  sleep(0.5)
end
def weld_off():
  weld = 0
end
"""


@pytest.mark.parametrize("target", ["krl", "rapid", "tp"])
def test_a_function_of_a_library_sets_its_values_each_time_it_is_called(tmp_path, target):
    (tmp_path / "weld.script").write_text(_LIBRARY)
    (tmp_path / "a.script").write_text(script("weld_on()", "weld_off()", "weld_on()"))
    program = link(read_program(load(str(tmp_path / "a.script"))), target).program
    made = convert(program, target, Context(on_loss="comment"), date="2026/01/01 00:00").files
    text = b"\n".join(made.values()).decode("cp1252").lower()
    on = re.search(r"(?:def|proc|/prog) +weld_on\b.*?(?:\bend\b|endproc|/end)", text, re.DOTALL)
    assert on is not None
    assert re.search(r"weld\]?:?=1\b", on[0])


@pytest.mark.parametrize(
    ("target", "place", "number"),
    [
        ("krl", "DECL E6POS p_between", "DECL REAL n"),
        ("rapid", "VAR robtarget p_between", "VAR num n"),
        ("tp", "L PR[", "IF (R["),
        ("inform", "MOVL P0", "IFTHEN R0"),
    ],
)
def test_what_a_function_of_no_file_returns_is_what_its_uses_take_it_for(target, place, number):
    rows = ("local p_between = between(1)", "movel(p_between, v=0.1)", "local n = count(1)", "if n > 3:")
    text = script(*rows, "  sleep(1)", "end")
    made = translated(text, "urscript", target)
    assert place in made
    assert number in made
    told = {
        loss.line for loss in converted(text, "urscript", target).translated.losses if loss.part == "variable"
    }
    assert told == {2, 4}
    assert all(
        loss.fate is Fate.APPROXIMATED for loss in converted(text, "urscript", target).translated.losses
    )
