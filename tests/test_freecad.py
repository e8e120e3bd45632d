"""The FreeCAD workbench without FreeCAD: what its bridge answers, and what its add-on says of itself.

What it does inside FreeCAD is tested by hosts/freecad/test.
"""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from itertools import pairwise
from pathlib import Path

import pytest

import olp
from olp.languages.vendor import find_vendor

ROOT = Path(__file__).parent.parent
HOST = ROOT / "hosts" / "freecad"
PROGRAMS = {
    "inform": "inform/handling/HANDLING.JBI",
    "krl": "krl/handling.src",
    "rapid": "rapid/handling.mod",
    "tp": "tp/handling.ls",
    "urscript": "urscript/handling.script",
}


def asked(**request) -> dict:
    done = subprocess.run(
        [sys.executable, str(HOST / "olp_freecad" / "bridge.py")],
        input=json.dumps({"options": {"robot": "yaskawa/gp25"}} | request),
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    return json.loads(done.stdout)


@pytest.mark.slow("inform", "rapid", "tp")
@pytest.mark.parametrize("language", PROGRAMS)
def test_the_bridge_tells_the_times_of_olp_and_the_way_between_them(language):
    path = str(ROOT / "samples" / PROGRAMS[language])
    answer = asked(do="open", path=path)
    table = olp.read(path).plan(robot="yaskawa/gp25").time()
    assert answer["total_s"] == pytest.approx(table["duration_s"].sum())
    assert len(answer["segments"]) == len(table)
    assert len(answer["points"]) >= 3
    instants = [instant for row in answer["segments"] for instant, _ in row.get("way") or ()]
    assert all(later > earlier - 1e-9 for earlier, later in pairwise(instants))
    assert instants[-1] <= answer["total_s"] + 1e-9
    assert len({one["line"] for one in answer["speeds"]}) == len(answer["speeds"]) >= 6


def test_the_bridge_writes_what_was_asked_and_nothing_else(tmp_path):
    for name in ("HANDLING.JBI", "DROP.JBI", "olp.toml"):
        shutil.copy(ROOT / "samples" / "inform" / "handling" / name, tmp_path / name)
    path = tmp_path / "HANDLING.JBI"
    before = path.read_bytes().split(b"\n")
    answer = asked(do="edit", path=str(path), points=[], speeds=[{"line": 41, "value": 300.0, "scale": 1e-3}])
    assert answer["lines"] == [[str(path), 41]]
    after = path.read_bytes().split(b"\n")
    assert [i for i, pair in enumerate(zip(before, after, strict=True), 1) if len(set(pair)) > 1] == [41]


def test_the_bridge_answers_bad_questions_with_sentences(tmp_path):
    assert "cannot read" in asked(do="open", path=str(tmp_path / "none.jbi"))["problems"][0]["text"]
    path = str(ROOT / "samples" / PROGRAMS["inform"])
    told = asked(do="edit", path=path, points=[], speeds=[{"line": 1, "value": 1.0, "scale": 1.0}])
    assert "O005" in told["problems"][0]["text"]


def test_the_add_on_says_what_is_there():
    spaces = {"a": "https://wiki.freecad.org/Package_Metadata"}
    package = ElementTree.parse(HOST / "package.xml").getroot()
    assert package.findtext("a:version", namespaces=spaces) == olp.__version__
    for icon in package.iterfind(".//a:icon", spaces):
        assert (HOST / icon.text).is_file()
    assert (HOST / package.find("a:license", spaces).get("file")).read_bytes() == (
        ROOT / "LICENSE"
    ).read_bytes()
    workbench = package.findtext(".//a:classname", namespaces=spaces)
    assert f"class {workbench}(" in (HOST / "InitGui.py").read_text(encoding="utf-8")
    for icon in re.findall(r'"(\w+\.svg)"', (HOST / "olp_freecad" / "gui" / "commands.py").read_text()):
        ElementTree.parse(HOST / "resources" / icon)


def test_files_that_freecad_opens_are_those_of_the_five_languages():
    opened = set(re.findall(r"\*(\.\w+)", (HOST / "Init.py").read_text(encoding="utf-8")))
    known = {suffix for name in PROGRAMS for suffix in find_vendor(name).suffixes}
    assert opened <= known
    assert all(opened & set(find_vendor(name).suffixes) for name in PROGRAMS)


@pytest.mark.parametrize("path", sorted(HOST.rglob("*.py")), ids=lambda p: p.name)
def test_the_pythons_of_freecad_can_read_it(path):
    """Add-ons of 0.20 and newer run in Python 3.10, too; the bridge runs in olp's."""
    ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 10))
