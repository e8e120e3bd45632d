"""`olp completion`: the shells themselves say what they would complete."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from olp import cli
from olp.__main__ import main

CASES = [
    (("re",), {"recording", "report"}),
    (("recording", ""), {"check", "from-log", "import"}),
    (("time", "--robot", "universal-robots/ur10"), {"universal-robots/ur10", "universal-robots/ur10e"}),
    (("time", "--mod"), {"--model"}),
    (("check", "--format", "ju"), {"junit"}),
    (("help", "tim"), {"time"}),
    (("time", "PART"), {"PARTS.JBI"}),
    (("convert", "A.JBI", "-o", "PART"), {"PARTS.JBI"}),
]


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shell")
    (folder / "PARTS.JBI").touch()
    for shell in ("bash", "zsh", "fish"):
        with (folder / shell).open("w", encoding="utf-8") as file, pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys, "stdout", file)
            assert main(["completion", shell]) == 0
    return folder


def answer(shell: str, program: str, folder: Path) -> str:
    found = shutil.which(shell)
    if found is None or os.name == "nt":
        pytest.skip(f"{shell} is not here: apt-get install {shell}")
    done = subprocess.run(
        [found, "-c", program], cwd=folder, capture_output=True, encoding="utf-8", timeout=60
    )
    assert done.stderr == ""
    return done.stdout


def test_bash_completes_commands_options_robots_and_files(scripts: Path) -> None:
    asked = ["source ./bash; complete -p olp"]
    for words, _ in CASES:
        line = " ".join(f"'{word}'" for word in ("olp", *words))
        asked.append(
            f'COMP_WORDS=({line}) COMP_CWORD={len(words)} COMPREPLY=(); _shtab_olp; echo "${{COMPREPLY[@]}}"'
        )
    function, *lines = answer("bash", "\n".join(asked), scripts).splitlines()
    assert "-F _shtab_olp olp" in function
    assert [set(line.split()) for line in lines] == [expected for _, expected in CASES]


def test_fish_completes_the_same(scripts: Path) -> None:
    asked = ["source ./fish", *(f"complete -C 'olp {' '.join(words)}'; echo =" for words, _ in CASES)]
    told = answer("fish", "\n".join(asked), scripts).split("=\n")
    for (words, expected), found in zip(CASES, told[:-1], strict=True):
        assert expected <= {line.partition("\t")[0] for line in found.splitlines()}, words


def test_zsh_takes_the_script(scripts: Path) -> None:
    (scripts / "_olp").write_bytes((scripts / "zsh").read_bytes())
    asked = (
        "fpath=($PWD $fpath); autoload -Uz compinit; compinit -u -d ./dump; echo $_comps[olp]; zsh -n ./_olp"
    )
    assert answer("zsh", asked, scripts) == "_olp\n"


def test_every_command_is_in_the_script(scripts: Path) -> None:
    text = (scripts / "fish").read_text("utf-8")
    for name in cli.names():
        assert name.split()[-1] in text


def test_without_the_library_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 2
    assert 'pip install "olp[completion]"' in capsys.readouterr().err
