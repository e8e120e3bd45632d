"""Declared texts: what a writer makes of programs, in the vendor's samples for its author to check once.

`samples/NAME/readings/*.written` holds parts as a declared reading does, each a file that olp wrote: of the contract
program, and of the programs with declared readings that have no error, which are written in their own language again.
What cannot be said stands as a comment in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from olp.contracts.events import robot_of
from olp.contracts.programs import BRANCHES, contract_program
from olp.contracts.promises import Difference
from olp.contracts.readings import differences, load_declared, programs_of, readings_of, save
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.ir.program import Program
from olp.languages.limits import limits_of
from olp.languages.vendor import Vendor
from olp.transpile import Context
from olp.transpile.convert import convert

SUFFIX: Final = ".written"
_DATE: Final = "2026/04/23 17:39"
_CONTRACT: Final = "contract"


def declare_texts(vendor: Vendor, folder: Path) -> None:
    """Writes what olp writes now into the `.written` files of a vendor's samples, for their author to check."""
    for stem, parts in _texts(vendor, folder):
        save(_path(folder, stem), parts)


def other_texts(vendor: Vendor, folder: Path) -> Iterator[Difference]:
    """Where a declared text and what is written differ."""
    for stem, found in _texts(vendor, folder):
        path = _path(folder, stem)
        declared = load_declared(path) if path.exists() else {}
        if list(declared) != list(found):
            yield path.name, f"declared: {', '.join(declared)}; written: {', '.join(found)}"
        for name in declared.keys() & found.keys():
            for at, one, other in differences(declared[name], found[name]):
                yield f"{path.name}, {name}, line {at}", f"declared: {one}; written: {other}"


def _path(folder: Path, stem: str) -> Path:
    return folder / "readings" / f"{stem}{SUFFIX}"


def _texts(vendor: Vendor, folder: Path) -> Iterator[tuple[str, dict[str, list[str]]]]:
    """The parts of each `.written` file as olp writes them now, by the stem of the file."""
    program = contract_program(BRANCHES[0]).program
    parts = dict(_written(vendor, "program", program))
    if limits_of(vendor.name, forms=True).forms:
        parts |= dict(_written(vendor, "program in forms", program, forms=True))
    yield _CONTRACT, parts
    for path in readings_of(folder):
        parts = {}
        for name, program in programs_of(vendor, load_declared(path)):
            if program.routines and not any(found.is_error for found in program.diagnostics):
                parts |= dict(_written(vendor, name, program))
        if parts:
            yield path.stem, parts


def _written(
    vendor: Vendor, source: str, program: Program, *, forms: bool = False
) -> Iterator[tuple[str, list[str]]]:
    """The files of a program: its name and theirs, and their lines. `forms`: moves as the pendant writes them."""
    context = Context(robot=robot_of(), on_loss="comment", forms=forms)
    try:
        made = convert(program, vendor.name, context, date=_DATE)
    except OlpError as refused:
        yield f"{source}: refused", [f"line {found.line}: {found.message}" for found in refused.diagnostics]
        return
    for name, data in made.files.items():
        yield f"{source}: {name}", [line.rstrip() for line in decode(data, name).lines]
