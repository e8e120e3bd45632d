"""What is remembered of earlier texts never shows: after any edits all is as if the text were read anew."""

from __future__ import annotations

import random
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest

from olp.core.result_cache import TextCache, remembered, remembering, shelf
from olp.servers.language.document import OpenDocument, Place, TextChange
from olp.servers.language.service import EditorSettings, ProgramService, analyse, marks

SAMPLES = Path(__file__).parent.parent / "samples"
PROGRAMS = [
    "inform/handling/HANDLING.JBI",
    "inform/generations/dx200.jbi",
    "krl/handling.src",
    "rapid/handling.mod",
    "rapid/pallet.prg",
    "tp/handling.ls",
    "urscript/handling.script",
    "pdl2/handling.pdl",
    "as/handling.as",
]


def same(first, second) -> bool:
    """Whether two results are equal in every part, nan equal to nan."""
    if isinstance(first, np.ndarray):
        return (
            first.dtype == second.dtype
            and first.shape == second.shape
            and first.tobytes() == second.tobytes()
        )
    if type(first) is not type(second):
        return False
    if isinstance(first, (list, tuple)):
        return len(first) == len(second) and all(map(same, first, second))
    if isinstance(first, dict):
        return list(first) == list(second) and all(same(first[key], second[key]) for key in first)
    if is_dataclass(first):
        return all(same(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))
    if type(first).__eq__ is object.__eq__ and hasattr(first, "__dict__"):
        return same(vars(first), vars(second))
    return first == second or first != first


@pytest.mark.slow("rapid/pallet.prg")
@pytest.mark.parametrize("name", PROGRAMS)
def test_after_any_edits_the_analysis_is_that_of_the_whole_text(name: str) -> None:
    chance = random.Random(name)
    path = str(SAMPLES / name)
    service = ProgramService()
    document = service.open(path, Path(path).read_bytes().decode())
    try:
        for version in range(16):
            known = service.current(path)
            fresh = analyse(OpenDocument(path, document.text), EditorSettings())
            assert known is not None
            assert same(known.program, fresh.program), version
            assert same(known.timing, fresh.timing), version
            assert marks(known) == marks(fresh)
            service.change(path, [edit(document, chance)], version + 2)
    finally:
        service.close(path)


def edit(document: OpenDocument, chance: random.Random) -> TextChange:
    """What people do: a letter more or less, a line twice, a line gone, a line from elsewhere, a number changed."""
    line = chance.randrange(1, len(document) + 1)
    text = document.line(line)
    column = chance.randrange(len(text) + 1) + 1
    here, end = Place(line, column), Place(line, len(text) + 1)
    other = document.line(chance.randrange(1, len(document) + 1))
    digits = [n for n, letter in enumerate(text, 1) if letter.isdigit()]
    number = Place(line, chance.choice(digits)) if digits else here
    return chance.choice(
        [
            TextChange(here, here, chance.choice("0159,. =;()[]{}'!#AXZ\n")),
            TextChange(here, Place(line, column + 1), ""),
            TextChange(end, end, f"\r\n{text}"),
            TextChange(Place(line, 1), Place(line + 1, 1), ""),
            TextChange(end, end, f"\r\n{other}"),
            TextChange(number, Place(line, number.column + 1), chance.choice("123456789")),
            TextChange(number, Place(line, number.column + 1), chance.choice("123456789")),
        ]
    )


RETYPED = {
    "A.src": ("DEF A ( )\nDECL FRAME x\nx.a = 5\nEND\n", "FRAME", "E6AXIS"),
    "B.src": ("DEF B ( )\nSIGNAL grip $OUT[4]\ngrip = TRUE\nEND\n", "SIGNAL grip $OUT[4]", "DECL BOOL grip"),
    "D.pdl": ("PROGRAM d\nVAR\n  Part : INTEGER\nBEGIN\n  part := 1\nEND d\n", "Part :", "PART :"),
    "C.mod": ("MODULE C\nVAR num x;\nPROC main()\nx:=[1,2,3];\nENDPROC\nENDMODULE\n", "num x", "pos x"),
}


@pytest.mark.parametrize("name", RETYPED)
def test_a_line_means_something_else_when_what_it_names_is_declared_otherwise(name: str) -> None:
    text, before, after = RETYPED[name]
    service = ProgramService()
    service.open(name, text)
    assert service.current(name) is not None
    service.change(name, [text.replace(before, after)], 2)
    known, fresh = (
        service.current(name),
        analyse(OpenDocument(name, text.replace(before, after)), EditorSettings()),
    )
    service.close(name)
    assert known is not None
    assert known.program is not None
    assert same(known.program, fresh.program)
    first = analyse(OpenDocument(name, text), EditorSettings()).program
    assert not same([r.body for r in known.program.routines], [r.body for r in first.routines])


class Asked:
    """Answers from a table that can change, and counts in what it is told."""

    def __init__(self) -> None:
        self.table = {"a": 1}
        self.told: list[str] = []
        self.word = "x"
        self.names = {"n": 1}

    def answer(self, key: str) -> int:
        self.told.append(key)
        return self.table[key]

    def all(self) -> list[int]:
        return list(self.table.values())


def test_a_result_is_remembered_only_while_every_answer_is_the_same() -> None:
    asked, memory, done = Asked(), TextCache(), []

    def work(it) -> int:
        done.append(1)
        return it.answer("a") + len(it.word) + len(it.names)

    def ask() -> int:
        with remembering(memory):
            return remembered(shelf("test"), "key", asked, work)

    assert (ask(), ask(), len(done)) == (3, 3, 1)
    assert asked.told == ["a", "a"]  # what asking changes is changed each time
    asked.table["a"] = 5
    assert (ask(), len(done)) == (7, 2)
    asked.word = "xyz"
    assert (ask(), len(done)) == (9, 3)
    asked.names["m"] = 2
    assert (ask(), ask(), len(done)) == (10, 10, 4)


def test_work_whose_answers_can_change_in_place_is_done_each_time() -> None:
    asked, memory, done = Asked(), TextCache(), []

    def listed(it) -> int:
        done.append(1)
        return len(it.all())

    def changing(it) -> int:
        done.append(1)
        it.names[f"new {len(it.names)}"] = 1
        return len(it.names)

    with remembering(memory):
        for work in (listed, listed, changing, changing):
            remembered(shelf("test"), work.__name__, asked, work)
    assert len(done) == 4
    assert len(asked.names) == 3


def test_nothing_is_remembered_where_nobody_asks_for_it() -> None:
    asked, done = Asked(), []
    for _ in range(2):
        remembered(shelf("test"), "key", asked, lambda it: done.append(it.answer("a")))
    assert len(done) == 2
