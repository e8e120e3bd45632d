"""What is written as RAPID keeps to the syntax that ABB publishes (`rapid_kernel.lark`), which olp does not read by."""

from __future__ import annotations

from pathlib import Path

import pytest
from rapid_kernel import refused
from translate_programs import Maker

import olp
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read_source
from olp.languages.vendor import find_vendor, vendor_names
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.convert import convert
from olp.transpile.link import link

SAMPLES = Path(__file__).parent.parent / "samples"
LISTING = "/PROG  {}\n/ATTR\nDEFAULT_GROUP = 1,*,*,*,*;\n/MN\n   1:  {} ;\n/POS\n/END\n"


def written(program: olp.Program) -> list[str]:
    context = Context(robot=load_robot("yaskawa/gp25"), on_loss="comment")
    files = convert(program, "rapid", context, date="2026/01/01 00:00").files
    return [data.decode("latin-1") for data in files.values()]


def as_rapid(statement: str, name: str = "A") -> str:
    listing = LISTING.format(name, statement).encode()
    return "\n".join(written(read_source(decode(listing, f"{name}.ls"))))


def samples(vendor: str) -> list[Path]:
    ends = find_vendor(vendor).suffixes
    found = sorted((SAMPLES / vendor).rglob("*"))
    return [path for path in found if path.suffix.lower() in ends and "broken" not in path.parts]


@pytest.mark.parametrize(
    "line",
    [
        "x:=y * -1;",
        "x:=y - -z;",
        "b:=c AND NOT d;",
        "x:=a{1}{2};",
        "x:=1; VAR num y;",
        f'TPWrite "{"a" * 81}";',
        "MoveJ p1 v100,fine,tool0;",
        "IF a=1 THEN x:=1;",
    ],
)
def test_the_oracle_refuses_what_the_syntax_does_not_have(line: str) -> None:
    assert refused(f"MODULE M\nPROC A()\n{line}\nENDPROC\nENDMODULE")


@pytest.mark.slow("inform")
@pytest.mark.parametrize("vendor", [name for name in vendor_names() if name != "rapid"])
def test_all_samples_are_written_in_the_published_syntax(vendor: str) -> None:
    paths = samples(vendor)
    wrong, texts = [], 0
    for path in paths:
        try:
            made = written(link(olp.read(path)).program)
        except OlpError:
            continue  # which says what cannot be translated
        texts += len(made)
        wrong += [(path.name, line) for text in made if (line := refused(text))]
    assert wrong == []
    assert texts > len(paths) / 3


@pytest.mark.parametrize("seed", range(12))
def test_random_programs_are_written_in_the_published_syntax(seed: int) -> None:
    assert [refused(text) for text in written(Maker(seed).program())] == [""]


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        ("R[1]=R[2]*(-1)", "R1:=R2 * (-1);"),
        ("R[1]=R[2]-(-R[3])", "R1:=R2 - (-R3);"),
        ("IF (!DI[1] AND !DI[2] OR R[1]>(-R[2])),R[1]=(2)", "IF di1=0 AND di2=0 OR R1>-R2 THEN"),
        ("R[1]=PR[AR[1],AR[2]]", "! not translated: "),
        ("MESSAGE[" + "abcd " * 20 + "]", 'TPWrite "abcd abcd abcd abcd";'),
    ],
)
def test_a_statement_is_written_as_the_syntax_wants_it(statement: str, says: str) -> None:
    text = as_rapid(statement)
    assert says in text
    assert not refused(text)


def test_a_module_is_not_called_like_a_word_of_the_language() -> None:
    assert "MODULE M_TEST" in as_rapid("R[1]=2", "TEST")


@pytest.mark.parametrize(
    "line",
    ["PERS wobjdata w:=wobj0;", "PERS num n:=1 + 2;", "PROC A()\nPERS wobjdata w;\nENDPROC"],
)
def test_the_oracle_refuses_persistents_that_are_computed_or_a_routines_own(line: str) -> None:
    assert refused(f"MODULE M\n{line}\nENDMODULE")
