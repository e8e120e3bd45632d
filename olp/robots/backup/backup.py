"""A controller's backup as one value.

Every file is optional; nothing is raised, everything wrong is a finding.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

from olp.core.diagnostic import Diagnostic, error
from olp.robots.backup.cnd_files import ToolData, UserFrame, read_tool_cnd, read_uframe_cnd
from olp.robots.backup.controller_text import BackupFindings, BackupLine, blocks, read_rows, record
from olp.robots.backup.parameters import (
    LAYOUTS,
    GroupParameters,
    ParameterFile,
    ParameterLayout,
    SystemInfo,
    read_parameters,
    read_system_sys,
)
from olp.robots.backup.var_dat import Variables, read_var_dat

T = TypeVar("T")

CONDITION_FILES: Final = ("TOOL.CND", "UFRAME.CND", "VAR.DAT", "MACRO.DAT", "SYSTEM.SYS")
# In this order: where ALL.PRM differs from the other two, they win and the difference is reported.
PARAMETER_FILES: Final = ("RC.PRM", "SC.PRM", "ALL.PRM")


@dataclass(frozen=True, slots=True, eq=False)
class Backup:
    """Content of a controller's backup files in one folder, in SI.

    Compared by identity, so that it can be a cache's key.
    """

    folder: str
    files: tuple[str, ...] = ()  # names as found, sorted
    system: SystemInfo | None = None
    tools: dict[int, ToolData] = field(default_factory=dict)
    user_frames: dict[int, UserFrame] = field(default_factory=dict)
    variables: Variables | None = None  # None without a VAR.DAT
    macros: dict[int, str] = field(default_factory=dict)  # MJ#(n) -> job
    groups: dict[int, GroupParameters] = field(default_factory=dict)  # n of ///RCnG -> robot data
    zones: dict[int, tuple[float, ...]] = field(default_factory=dict)  # n of ///S1CnG -> [m] for PL = 1..8
    diagnostics: tuple[Diagnostic, ...] = ()

    def __bool__(self) -> bool:
        """Whether the folder has any controller file."""
        return bool(self.files)

    def path(self, name: str) -> str:
        """Path of the file called `name` (RC.PRM), with the upper and lower case of its name on disk."""
        return str(Path(self.folder, next((file for file in self.files if file.upper() == name), name)))


def read_backup(folder: str | Path, encoding: str = "cp1252") -> Backup:
    """Read the controller files directly in `folder`, whatever the case of their names.

    Raises nothing: problems are in `diagnostics`.
    """
    collected: list[Diagnostic] = []
    paths = _find(Path(folder), collected)

    def read(name: str, reader: Callable[[tuple[BackupLine, ...], BackupFindings], T], absent: T) -> T:
        if name not in paths:
            return absent
        findings = BackupFindings(str(paths[name]))
        result = reader(read_rows(paths[name], findings, encoding), findings)
        collected.extend(findings.all())
        return result

    system = read("SYSTEM.SYS", read_system_sys, None)
    parameters = ParameterFile({}, {})
    for name in PARAMETER_FILES:
        merge = partial(_read_parameters, name=name, hint=_hint(system), before=parameters)
        parameters = read(name, merge, parameters)
    return Backup(
        folder=str(folder),
        files=tuple(sorted(path.name for path in paths.values())),
        system=system,
        tools=read("TOOL.CND", read_tool_cnd, {}),
        user_frames=read("UFRAME.CND", read_uframe_cnd, {}),
        variables=read("VAR.DAT", read_var_dat, None),
        macros=read("MACRO.DAT", read_macro_dat, {}),
        groups=parameters.groups,
        zones=parameters.zones,
        diagnostics=tuple(collected),
    )


def _find(folder: Path, collected: list[Diagnostic]) -> dict[str, Path]:
    """The controller files by their standard name. Only regular files: reading a pipe would never end."""
    wanted = {*CONDITION_FILES, *PARAMETER_FILES}
    found: dict[str, Path] = {}
    try:
        with os.scandir(folder) as entries:
            named = sorted((e.name, e.is_file()) for e in entries if e.name.upper() in wanted)
    except OSError as problem:
        reason = problem.strerror or "cannot be read"
        help_text = "name the folder that holds the controller's files, such as RC.PRM and TOOL.CND"
        collected.append(error("B001", f"backup folder: {reason}", file=str(folder), help=help_text))
        return {}
    for name, regular in named:
        path = folder / name
        if not regular:
            collected.append(error("B001", "this is not a regular file and was not read", file=str(path)))
        elif name.upper() in found:
            kept = found[name.upper()].name
            message = f"this file has the same name as {kept} except for case; {kept} is used"
            collected.append(error("B005", message, file=str(path), help="keep one of the two"))
        else:
            found[name.upper()] = path
    return found


def _hint(system: SystemInfo | None) -> ParameterLayout | None:
    """The parameter layout that belongs to the controller in SYSTEM.SYS; None if unknown."""
    if system is None or not system.controller:
        return None
    return next((lay for lay in LAYOUTS if system.controller in lay.controllers.split(", ")), None)


def _read_parameters(
    rows: tuple[BackupLine, ...],
    findings: BackupFindings,
    *,
    name: str,
    hint: ParameterLayout | None,
    before: ParameterFile,
) -> ParameterFile:
    """A parameter file merged into `before`, which takes precedence where both have a group; differences are
    reported.
    """
    found = read_parameters(rows, name, hint, findings)
    for number, parameters in found.groups.items():
        known = before.groups.get(number)
        if known is not None and _numbers(known) != _numbers(parameters):
            message = f"///RC{number}G differs from that in {known.file}; {known.file} is used"
            findings.warning("B005", message, BackupLine(parameters.line, f"///RC{number}G"))
    for number, zones in found.zones.items():
        if before.zones.get(number, zones) != zones:
            findings.warning(
                "B005", f"the zones of group {number} differ from those in SC.PRM; SC.PRM is used"
            )
    return ParameterFile({**found.groups, **before.groups}, {**found.zones, **before.zones})


def _numbers(parameters: GroupParameters) -> tuple[object, ...]:
    return (
        parameters.links,
        parameters.denominators,
        parameters.numerators,
        parameters.upper,
        parameters.lower,
        parameters.speeds,
        parameters.acceleration_times,
    )


# --- Macro dat ---
# MACRO.DAT: which job a macro number calls.
#
# Layout, as seen in backups: `//MACRO1 n`, `///JOB1 name`, arguments.


def read_macro_dat(rows: tuple[BackupLine, ...], findings: BackupFindings) -> dict[int, str]:
    """Job names by macro number, the n of `MACRO1 MJ#(n)`; without the numbers that have no job."""
    jobs: dict[int, str] = {}
    for block in blocks(rows, "MACRO1", findings):
        named = [(row, rest) for row in block.rows for _, keyword, rest in [record(row)] if keyword == "JOB1"]
        for row, job in named:
            if not job:
                continue
            if block.number in jobs:
                findings.warning("B005", f"macro {block.number} is given twice; the last one is used", row)
            jobs[block.number] = job
        if not named and block.rows:
            findings.warning("B002", f"macro {block.number} has no ///JOB1 row", block.head)
    return jobs
