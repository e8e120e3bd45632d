"""The VS Code extension, as far as it can be held to olp without its tools: words, suffixes, settings, versions."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from olp.core.version import __version__
from olp.identification.timing_job import TimingJob
from olp.languages.vendor import find_vendor
from olp.servers.language.service import settings_of

HOST = Path(__file__).parent.parent / "hosts" / "vscode"
MANIFEST = json.loads((HOST / "package.json").read_text(encoding="utf-8"))
LANGUAGES = [each["id"] for each in MANIFEST["contributes"]["languages"]]


def test_the_colours_have_the_words_of_olps_grammars() -> None:
    command = [sys.executable, str(HOST / "colours.py"), "--check"]
    checked = subprocess.run(command, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, f"{checked.stdout}run python hosts/vscode/colours.py"


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_language_has_the_suffixes_that_olp_reads_and_a_grammar(language: str) -> None:
    (declared,) = [each for each in MANIFEST["contributes"]["languages"] if each["id"] == language]
    not_text = {".urp", ".pgf"}  # packed, and a list of modules
    assert set(find_vendor(language).suffixes) - not_text <= set(declared["extensions"])
    (grammar,) = [each for each in MANIFEST["contributes"]["grammars"] if each["language"] == language]
    for name in (declared["configuration"], grammar["path"]):
        assert json.loads((HOST / name).read_text(encoding="utf-8"))


def test_the_settings_of_the_editor_are_taken_by_the_server() -> None:
    given = {"robot": "yaskawa/gp25", "signature": "a.toml", "override": 80, "model": "linear"}
    declared = {name.removeprefix("olp.") for name in MANIFEST["contributes"]["configuration"]["properties"]}
    assert declared - {"command"} == set(given)
    taken = settings_of({"olp": given})
    assert taken.diagnostics == ()
    plain = {field.name: getattr(TimingJob(), field.name) for field in fields(TimingJob)}
    assert {name for name in plain if getattr(taken.job, name) != plain[name]} == set(given)


def test_settings_that_are_not_set_are_those_of_the_command_line() -> None:
    properties = MANIFEST["contributes"]["configuration"]["properties"]
    unset = {name.removeprefix("olp."): each["default"] for name, each in properties.items()}
    assert settings_of({"olp": unset}).diagnostics == ()


def test_the_extension_is_of_olps_version_and_locks_no_address_of_a_machine() -> None:
    assert MANIFEST["version"] == __version__
    lock = (HOST / "package-lock.json").read_text(encoding="utf-8")
    assert not re.search(r'"resolved": "(?!https://registry\.npmjs\.org/)', lock)
    assert json.loads(lock)["version"] == __version__


def converted(folder: Path, job: str, *options: str) -> subprocess.CompletedProcess[str]:
    """What the command "Convert to Another Robot" gets from olp, in the words of src/commands.ts."""
    path = HOST.parent.parent / "samples" / "inform" / "palletising" / job
    command = [sys.executable, "-m", "olp", "convert", str(path), "--to", "krl", "-o", str(folder)]
    return subprocess.run([*command, *options], capture_output=True, text=True, check=False)


def test_what_the_extension_looks_for_in_a_refusal_is_what_olp_says(tmp_path: Path) -> None:
    source = (HOST / "src" / "commands.ts").read_text(encoding="utf-8")
    (offer,) = re.findall(r'told\.includes\("(.+?)"\)', source)
    (loss,) = re.findall(r"told\.match\(/(.+?)/gm\)", source)
    refused = converted(tmp_path, "PICK.JBI", "--robot", "yaskawa/ar2010")
    assert refused.returncode == 2
    assert offer in refused.stderr
    lost = re.findall(loss, refused.stderr, re.M)
    receipt = tmp_path / "receipt.json"
    options = ("--robot", "yaskawa/ar2010", *offer.split(), "--receipt", str(receipt))
    written = converted(tmp_path / "krl", "PICK.JBI", *options)
    assert written.returncode < 2, written.stderr
    fates = [each["fate"] for each in json.loads(receipt.read_text())["losses"]]
    assert len(lost) == fates.count("commented") > 0


def test_the_receipt_begins_as_the_test_in_the_editor_takes_it_from_olp(tmp_path: Path) -> None:
    said = converted(tmp_path / "krl", "MAIN.JBI", "--robot", "yaskawa/ar2010", "--on-loss", "comment")
    assert re.match(r"\d+ statements: ", said.stdout.splitlines()[1])
    assert "MAIN.src" in {path.name for path in (tmp_path / "krl").iterdir()}
