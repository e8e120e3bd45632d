"""What comes from outside runs nothing, hangs nothing, and kills no run: the attacks that once gave way."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from olp.__main__ import main

SAMPLES = Path(__file__).parent.parent / "samples"
JOB = SAMPLES / "inform" / "palletising" / "PICK.JBI"
needs_git = pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")


def repository(folder: Path, config: str = "", attributes: str = "*.JBI filter=x diff=x text\n") -> Path:
    """Two commits of one job; afterwards the repository's own configuration becomes hostile."""

    def git(*words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b.example", "-c", "core.autocrlf=false")
        subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)

    git("init", "-q", "-b", "main")
    (folder / ".gitattributes").write_text(attributes, encoding="utf-8")
    text = JOB.read_bytes()
    for name in ("VAR.DAT", "TOOL.CND", "UFRAME.CND", "olp.toml"):
        shutil.copy(JOB.with_name(name), folder)
    (folder / "PICK.JBI").write_bytes(text)
    git("add", "-A")
    git("commit", "-qm", "one")
    (folder / "PICK.JBI").write_bytes(text.replace(b"V=", b"V=1"))
    git("add", "-A")
    git("commit", "-qm", "two")
    with (folder / ".git" / "config").open("a", encoding="utf-8") as file:
        file.write(config)
    return folder


ATTACKS = {
    "a filter": '[filter "x"]\n\tsmudge = {0}\n\tclean = {0}\n\tprocess = {0}\n\trequired = true\n',
    "a text conversion": '[diff "x"]\n\ttextconv = {0}\n\tcommand = {0}\n[diff]\n\texternal = {0}\n',
    "an archiver": '[tar "tar"]\n\tcommand = {0}\n[tar "umask"]\n\tcommand = {0}\n',
    "a monitor": "[core]\n\tfsmonitor = {0}\n\tpager = {0}\n\teditor = {0}\n\tsshCommand = {0}\n\tgitProxy = {0}\n",
    "hooks": "[core]\n\thooksPath = hooks\n",
    "an alias": "[alias]\n\trev-parse = !{0}\n\tls-tree = !{0}\n\tcat-file = !{0}\n",
}


@needs_git
@pytest.mark.parametrize("attack", ATTACKS)
def test_no_program_that_a_repository_names_is_run(attack, tmp_path, monkeypatch, capsys):
    proof = tmp_path / "proof"
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\necho ran >> '{proof}'\ncat\n", encoding="utf-8")
    program.chmod(0o755)
    home = tmp_path / "cell"
    (home / "hooks").mkdir(parents=True)
    for hook in ("post-checkout", "post-index-change", "reference-transaction", "fsmonitor-watchman"):
        shutil.copy(program, home / "hooks" / hook)
    repository(home, ATTACKS[attack].format(program))
    monkeypatch.chdir(home)
    assert main(["diff", "HEAD~1", "HEAD"]) in (0, 1)
    assert "PICK.JBI" in capsys.readouterr().out
    assert not proof.exists()


@needs_git
def test_an_object_that_is_missing_is_not_fetched_from_where_the_repository_says(
    tmp_path, monkeypatch, capsys
):
    proof = tmp_path / "proof"
    config = (
        f"[remote \"origin\"]\n\turl = ext::sh -c 'echo% ran% >% {proof}'\n\tpromisor = true\n"
        "\tpartialclonefilter = blob:none\n[extensions]\n\tpartialclone = origin\n"
        '[protocol "ext"]\n\tallow = always\n[core]\n\trepositoryformatversion = 1\n'
    )
    home = tmp_path / "cell"
    home.mkdir()
    repository(home, config)
    blob = subprocess.run(
        ["git", "rev-parse", "HEAD:PICK.JBI"], cwd=home, check=True, capture_output=True, text=True
    ).stdout.strip()
    os.remove(home / ".git" / "objects" / blob[:2] / blob[2:])
    monkeypatch.chdir(home)
    assert main(["diff", "HEAD~1", "HEAD"]) == 2
    assert "U002" in capsys.readouterr().err
    assert not proof.exists()


@needs_git
def test_links_of_a_revision_are_read_as_the_file_they_lead_to_within_it(tmp_path, monkeypatch, capsys):
    home = tmp_path / "cell"
    home.mkdir()
    (tmp_path / "secret.JBI").write_bytes(JOB.read_bytes())
    (home / "OUT.JBI").symlink_to(tmp_path / "secret.JBI")
    (home / "IN.JBI").symlink_to("PICK.JBI")
    repository(home)
    monkeypatch.chdir(home)
    assert main(["diff", "HEAD~1", "HEAD"]) in (0, 1)
    said = capsys.readouterr().out
    assert "IN.JBI" in said
    assert "OUT.JBI" not in said
