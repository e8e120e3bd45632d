"""Reads the lists that belong to a program: the .dat of its name, and what it needs of $config.dat."""

from __future__ import annotations

import re
from collections.abc import Set
from dataclasses import replace
from pathlib import PurePath, PureWindowsPath
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic, Span
from olp.core.source import Source
from olp.ir.expressions import Number, RecordLiteral, Text
from olp.ir.program import Declare
from olp.languages.findings import Findings
from olp.languages.vendors.krl import checks, companions, parsing
from olp.languages.vendors.krl.lists import ListReader
from olp.languages.vendors.krl.parsing import KrlLineReader
from olp.languages.vendors.krl.scope import CONFIG_MARK, Scope

HEAD: Final = re.compile(r"(?:GLOBAL\s+)?DEF(?:FCT|DAT)?\s", re.IGNORECASE)
TAIL: Final = re.compile(r"(?:END|ENDFCT|ENDDAT)\s*", re.IGNORECASE)
NAME: Final = re.compile(r"[$A-Za-z_][\w$]*")
_LAYOUT: Final = re.compile(r"\b(?:STRUC|ENUM)\b", re.IGNORECASE)
_BY_NUMBER = frozenset({"FDAT_ACT", "BAS", "TOOL_DATA", "BASE_DATA", "STOOL2", "SBASE"})

# The public copies of $config.dat agree in these.
_PUBLIC: Final[dict[str, tuple[str, tuple[tuple[str, float | str], ...]]]] = {
    "PDEFAULT": ("PDAT", (("VEL", 100.0), ("ACC", 100.0), ("APO_DIST", 100.0))),
    "LDEFAULT": ("LDAT", (("VEL", 2.0), ("ACC", 100.0), ("APO_DIST", 100.0))),
    "FHOME": ("FDAT", (("TOOL_NO", 1), ("BASE_NO", 0), ("IPO_FRAME", "#BASE"))),
}
# The caption of a form: its last point, tool and base, which may have names: `Tool[1]:gripper`.
_FORM: Final = re.compile(
    r"\s*;\s*FOLD\s+S?(?:(?:PTP|LIN)|CIRC\s+\w+)\s+(?P<point>[A-Za-z_]\w*)\b(?!.*%\{h).*?"
    r"\bTool\[(?P<tool>\d+)\](?::\S*)?\s+Base\[(?P<base>\d+)\]",
    re.IGNORECASE,
)


class Neighbours(NamedTuple):
    """`data`: rows of the .dat; `config`: rows of $config.dat that the program names.

    `details`: the other lines of the .dat, for KRL's own writer.
    """

    files: tuple[Source, ...]
    data: tuple[Declare, ...]
    config: tuple[Declare, ...]
    diagnostics: tuple[Diagnostic, ...]
    details: dict[str, str]


def stem(path: str) -> str:
    """A file's name without its folder and suffix, in capitals."""
    return PurePath(PureWindowsPath(path).name).stem.upper()


def read_neighbours(
    source: Source, scope: Scope, findings: Findings, given: tuple[Source, ...] | None
) -> Neighbours:
    """The lists of `given`, else those on the disk, with what is wrong with them; in both cases with shared lists.

    A program that is on the disk and is read again with other texts has the same shared lists.
    """
    beside, config = companions.find(source.path) if given is None else _sorted(given)
    files = tuple(one for one in (beside, config) if one is not None)
    used = _used(source, beside, _PUBLIC.keys() | {"DEFDAT"} if config is None else None)
    rows = () if config is None else _config(config, scope, findings, used)
    rows = (*rows, *_shared(source, beside, scope))
    data: tuple[Declare, ...] = ()
    told: tuple[Diagnostic, ...] = ()
    details: dict[str, str] = {}
    if beside is not None:
        found = Findings(beside)
        if checks.check_readable(found):
            data = _list(found, scope, None)
            details = _details(beside)
        told = found.result()
    if not source.path.lower().endswith(".dat"):
        rows = (*rows, *_defaults(scope, findings, used), *_captions(source, scope, findings))
    own = {one.name.upper() for one in data}  # which hide what the controller's list has under their names
    rows = tuple(one for one in rows if one.name.upper() not in own)
    return Neighbours(files, data, rows, told, details)


def _sorted(given: tuple[Source, ...]) -> tuple[Source | None, Source | None]:
    config = next((one for one in given if "CONFIG" in stem(one.path)), None)
    return next((one for one in given if one is not config), None), config


def _used(source: Source, beside: Source | None, asked: Set[str] | None) -> frozenset[str]:
    """The names in the code of both files, in capitals; `asked`: only these are asked for."""
    used: set[str] = set()
    for one in (source, beside):
        text = "\n".join(one.lines).upper() if one is not None else ""
        if asked is not None and not any(name in text for name in asked):
            continue
        if ";" in text:
            text = "\n".join([parsing.split(line)[0] for line in text.split("\n")])
        used.update(NAME.findall(text))
    return frozenset(used | {"TOOL_DATA", "BASE_DATA"} if used & _BY_NUMBER else used)


def _config(config: Source, scope: Scope, findings: Findings, used: frozenset[str]) -> tuple[Declare, ...]:
    told = Findings(config)
    if not checks.check_readable(told):
        return ()
    rows = _list(told, scope, used)
    broken = [one for one in told.result() if one.is_error]
    if broken:
        message = (
            f"{len(broken)} lines of {config.path} were not understood, the first is line {broken[0].line}"
        )
        findings.warning("P419", message, Span(1, 1, 2), "olp takes what it needs from the others")
    return tuple(replace(one, native=one.native + CONFIG_MARK, comment="", shared=True) for one in rows)


def _shared(source: Source, beside: Source | None, scope: Scope) -> tuple[Declare, ...]:
    """What the other lists of the tree share tells the types of names, and which of them are signals.

    Without it whole numbers would be divided like others, and a signal would be a variable. Only signals and
    enumerations are rows of the program: other data are found when they are asked for.
    """
    lists = [rows for path in companions.lists_around(source.path) if (rows := companions.shared_rows(path))]
    if not any(numbers for _, numbers in lists):
        return ()
    used = frozenset(name for name in _used(source, beside, None) if not scope.known(name))
    found: list[Declare] = []
    layouts: list[Declare] = []
    for shared, numbers in lists:
        told = Findings(shared)
        reader = ListReader(told, scope, KrlLineReader(told, scope, shared=True), used, placed=False)
        for number in numbers:
            code, _ = parsing.split(shared.lines[number - 1])
            if not used.isdisjoint(NAME.findall(code.upper())) or _LAYOUT.search(code):
                reader.row(code, number)
        found += reader.finish()
        layouts += [it for it in reader.declared.values() if it.type == "enumeration"]
    kinds = used | {scope.type_of_name(name) for name in used}
    found = [it for it in found if it.type == "signal"] + [it for it in layouts if it.name.upper() in kinds]
    return tuple(replace(it, native=it.native + CONFIG_MARK, shared=True) for it in found)


def _defaults(scope: Scope, findings: Findings, used: frozenset[str]) -> tuple[Declare, ...]:
    """Motion data that every controller has, where no list gives them."""
    rows = []
    for name, (kind, values) in _PUBLIC.items():
        if name not in used or scope.known(name):
            continue
        members = tuple(
            (scope.spell(key), Text(one) if isinstance(one, str) else Number(one)) for key, one in values
        )
        value = RecordLiteral(kind, members)
        scope.declare(name, kind)
        scope.values[name] = value
        rows.append(Declare(0, scope.spell(name), kind, value, shared=True, native=kind + CONFIG_MARK))
    if rows:
        names = ", ".join(one.name for one in rows)
        message = f"{names}: taken as in the public $config.dat, which is not beside the program"
        findings.info("P420", message, Span(1, 1, 2), "put the controller's $config.dat beside it")
    return tuple(rows)


def _captions(source: Source, scope: Scope, findings: Findings) -> tuple[Declare, ...]:
    """Tool and base of points that no list gives, as the captions of forms have them: `PTP P1 … Tool[1] Base[2]`."""
    rows: dict[str, Declare] = {}
    for line in source.lines:
        form = _FORM.match(line) if "ool[" in line else None
        if form is None:
            continue
        point, tool, base = form["point"], form["tool"], form["base"]
        key = f"F{point.upper()}"
        if key in rows or scope.known(key):
            continue
        numbers = ((scope.spell("TOOL_NO"), Number(int(tool))), (scope.spell("BASE_NO"), Number(int(base))))
        value = RecordLiteral("FDAT", (*numbers, (scope.spell("IPO_FRAME"), Text("#BASE"))))
        scope.declare(key, "FDAT")
        scope.values[key] = value
        rows[key] = Declare(0, scope.spell(f"F{point}"), "FDAT", value, native="FDAT" + CONFIG_MARK)
    if rows:
        named = [one.name for one in rows.values()]
        which = ", ".join(named[:3]) + (f" and {len(named) - 3} more" if len(named) > 3 else "")
        message = f"{which}: tool and base as the captions of the forms have them, no list gives them"
        findings.info("P420", message, Span(1, 1, 2), "put the program's .dat beside it")
    return tuple(rows.values())


def _list(findings: Findings, scope: Scope, only: frozenset[str] | None) -> tuple[Declare, ...]:
    reader = ListReader(
        findings, scope, KrlLineReader(findings, scope, shared=only is not None), only, placed=False
    )
    for number, line in enumerate(findings.source.lines, 1):
        code, comment = parsing.split(line)
        plain = code.startswith("DECL ")
        if plain or (code and code[0] != "&" and not HEAD.match(code) and not TAIL.fullmatch(code)):
            reader.row(code, number, comment or "")
        elif comment and only is None and not parsing.FOLD.match(comment):
            reader.comment(comment)
    return reader.finish()


def _details(source: Source) -> dict[str, str]:
    """The lines above DEFDAT, that line itself, and comments and kept lines below it."""
    above: list[str] = []
    rows: list[str] = []
    head = ""
    for line in source.lines:
        if line.startswith("DECL "):
            continue
        code, comment = parsing.split(line)
        if code.startswith("DECL "):
            continue
        if HEAD.match(code):
            head = code
        elif (not code and comment is not None) or (
            code and (code[0] == "&" or parsing.kept(code) is not None)
        ):
            (rows if head else above).append(code or f";{comment}")
    found = {"data above": "\n".join(above), "data head": head, "data rows": "\n".join(rows)}
    return {key: text for key, text in found.items() if text}
