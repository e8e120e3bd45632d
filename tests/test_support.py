"""The table of `olp vendors` has a row for whatever a grammar can say, and the rows say what readers and writers do."""

from __future__ import annotations

import ast
import dataclasses
import json
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

import olp
from olp.__main__ import main
from olp.core.resources import read_text
from olp.ir import program
from olp.ir.terminology import STATEMENTS, kind_of
from olp.languages.vendor import find_vendor
from olp.transpile.statement_programs import probes
from olp.transpile.support import kinds, support, timed_as

ROOT = Path(olp.__file__).resolve().parent
SAMPLES = ROOT.parent / "samples"
CLASSES = {kind.split()[0] for kind in kinds()}
# The rules of each grammar whose alternatives are statements.
STATEMENT_RULES = {
    "inform": {"statement"},
    "krl": {"motion", "flow", "signal"},
    "rapid": {"block", "statement", "simple"},
    "tp": {"instruction", "simple"},
    "urscript": {"instruction", "simple"},
}

_SHARED = "olp.languages.statement_rules"
_BASE = "olp.languages.short_reader"
_NEUTRAL = frozenset({"olp.ir.program"})
_WRITING = ("write", "templates", "limits")


def functions(vendor: str) -> dict[str, list[ast.FunctionDef]]:
    """Name -> the functions of that name in a vendor's code."""
    found: dict[str, list[ast.FunctionDef]] = {}
    for file in (ROOT / "languages" / "vendors" / vendor).glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and not file.stem.startswith("write"):
                found.setdefault(node.name, []).append(node)
    return found


def aliases(vendor: str) -> set[str]:
    """The names of the statements of a vendor's grammar."""
    text = re.sub(r"//[^\n]*", "", read_text("grammars", f"{vendor}.lark"))
    rules = re.split(r"^[?!]?(\w+)(?:\.\d+)?:", text, flags=re.MULTILINE)
    found = set()
    for name, body in zip(rules[1::2], rules[2::2], strict=True):
        if name in STATEMENT_RULES[vendor]:
            found.update(re.findall(r"->\s*(\w+)", body))
    return found


def _tree_of(module: str) -> ast.Module:
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    return ast.parse(Path(spec.origin).read_text(encoding="utf-8"))


@pytest.mark.parametrize("vendor", STATEMENT_RULES)
def test_what_a_statement_of_the_grammar_is_lowered_to_has_a_row_that_says_so(vendor):
    known = functions(vendor)
    named = aliases(vendor)
    assert len(named) >= 8
    shared = {node.name for node in ast.walk(_tree_of(_SHARED)) if isinstance(node, ast.FunctionDef)}
    assert named <= set(known) | shared
    read = {kind.split()[0] for kind in find_vendor(vendor).reads}
    for name in named:
        for function in known.get(name, ()):
            returned = ast.unparse(function.returns) if function.returns is not None else ""
            assert set(re.findall(r"\w+", returned)) & CLASSES <= read, name


def test_every_class_of_statements_has_a_row_a_name_and_a_program_that_has_it():
    made = {
        name
        for name, it in vars(program).items()
        if dataclasses.is_dataclass(it) and dataclasses.fields(it)[0].name == "line"
    }
    assert made == CLASSES
    assert set(probes()) == set(kinds()) == set(STATEMENTS) - {"program"}
    for kind, rows in probes().items():
        assert kind in {kind_of(s) for s in rows}


def test_names_that_only_look_like_statements_are_none():
    """KRL has a class Reference of its own, and tuples of what changes variables."""
    assert not {"Reference", "ReadInput", "Update"} & find_vendor("krl").reads
    assert {"Opaque", "Move linear"} <= find_vendor("val3").reads


def test_the_table_says_what_a_statement_adds_to_the_time(capsys):
    assert {kind for kind in kinds() if timed_as(kind) == "move"} == {
        k for k in kinds() if k.startswith("Move")
    }
    assert timed_as("Dwell") == timed_as("Pause") == "wait"
    assert timed_as("SetOutput") == timed_as("Process") == "signal"
    assert not any(timed_as(kind) for kind in ("Assign", "If", "Comment", "SetSpeed", "Call"))
    assert main(["vendors", "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["times"]) == set(found["statements"]) == set(kinds())
    assert found["times"]["Dwell"] == "wait"
    assert main(["vendors"]) == 0
    text = capsys.readouterr().out
    for kind, row in support().items():
        (line,) = (line for line in text.splitlines() if line.startswith(f"{STATEMENTS[kind]}  "))
        assert len(line.split()) >= len(row) + len(STATEMENTS[kind].split())
