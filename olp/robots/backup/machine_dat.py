"""Robot file of an arm from KUKA's machine data ($MACHINE.DAT, in KRC/R1/Mada of an archive).

The controller's own chain: `$TIRORO` to axis 2, lengths A and B, `$TX3P3` to the wrist, whose three axes meet,
`$TFLWP` to the flange; `$AXIS_DIR` gives the direction of each axis. Other kinds of arms are rejected.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path
from typing import Final

from olp.core.diagnostic import OlpError, error, raise_errors
from olp.core.toml import ROBOT_NAME, plain, quoted, shown
from olp.robots.backup.controller_text import BackupFindings, BackupLine, read_rows

FILE: Final = "$machine.dat"
_FOLDERS: Final = ((), ("mada",), ("r1", "mada"), ("krc", "r1", "mada"))
_AXES: Final = range(1, 7)
_ROW: Final = re.compile(
    r"\s*(?:(?:DECL\s+)?\w+\s+)?(\$\w+(?:\[\d*\])?)\s*=\s*(\"[^\"]*\"|[^;]*)", re.IGNORECASE
)
_PART: Final = re.compile(r"(\w+)\s+([-+0-9.E]+)", re.IGNORECASE)
_MODEL: Final = re.compile(r"#?(KR\d+)(R\d+)?(?:_(\d))?\b", re.IGNORECASE)
# What the arm must be, by the machine data's own words: one of standard links whose wrist axes meet.
_KIND: Final = {"$KINCLASS": "#STANDARD", "$MAIN_AXIS": "#NR", "$WRIST_AXIS": "#ZEH", "$NUM_AX": "6"}
_NEVER: Final = {"$A4PAR": "0", "$SPINDLE": "0"}  # not in the machine data of every version
# Frames and wrist of that arm: part -> what it must be, None where any length is good.
_FRAMES: Final[Mapping[str, Mapping[str, float | None]]] = {
    "$TIRORO": {"X": 0, "Y": 0, "Z": None, "A": 0, "B": 0, "C": 0},
    "$TX3P3": {"X": None, "Y": 0, "Z": None, "A": 0, "B": 90, "C": 0},
    "$TFLWP": {"X": 0, "Y": 0, "Z": None, "A": 0, "B": 0, "C": 0},
    "$DH_4": {"DHART_A": 0, "DHART_D": 0, "DHART_ALPHA": 90},
    "$DH_5": {"DHART_A": 0, "DHART_D": 0, "DHART_ALPHA": -90},
}
# The sense of the standard axes (olp.robots.robot) against those of KUKA's chain.
_SENSES: Final = (1, 1, -1, -1, 1, -1)


@dataclass(frozen=True, slots=True)
class MachineData:
    """The assignments of one file: name in upper case -> its row and its text."""

    file: str
    rows: Mapping[str, tuple[BackupLine, str]]
    findings: BackupFindings


def find_machine_data(path: Path) -> Path | None:
    """Path of the machine data in an archive's folder or below it, whatever the case of the names; None if absent."""
    if path.name.lower() == FILE:
        return path
    for folders in _FOLDERS:
        place: Path | None = path
        for name in (*folders, FILE):
            place = _within(place, name) if place is not None else None
        if place is not None:
            return place
    return None


def read_machine_data(path: Path) -> MachineData:
    """The assignments of the file. Raises nothing: problems are added to `findings`."""
    findings = BackupFindings(str(path))
    rows: dict[str, tuple[BackupLine, str]] = {}
    for row in read_rows(path, findings, last="ENDDAT"):
        match = _ROW.match(row.text)
        if match is not None:
            rows[match[1].upper()] = (row, match[2].strip())
    return MachineData(str(path), rows, findings)


def machine_data_toml(data: MachineData, name: str = "") -> str:
    """The robot file, called `name` (maker/model) or after `$TRAFONAME`. Raises OlpError (B001, B006, B009, B010)."""
    _check_kind(data)
    maker, model = _identity(data, name)
    frames = {key: _parts(data, key, wanted) for key, wanted in _FRAMES.items()}
    lengths = {
        "a1_mm": _number(data, "$LENGTH_A"),
        "a2_mm": _number(data, "$LENGTH_B"),
        "a3_mm": frames["$TX3P3"]["Z"],
        "d4_mm": frames["$TX3P3"]["X"],
        "d6_mm": frames["$TFLWP"]["Z"],
    }
    senses = [_number(data, f"$AXIS_DIR[{n}]") * sense for n, sense in zip(_AXES, _SENSES, strict=True)]
    axes = [_axis(data, n) for n in _AXES]
    if "$TRP_A" in data.rows:
        _parts(data, "$TRP_A", {"TRPSP_AXIS": 0})
    if any(abs(sense) != 1.0 for sense in senses if isfinite(sense)):
        data.findings.error("B007", "$AXIS_DIR must be 1 or -1", _row(data, "$AXIS_DIR[1]"))
    if min(lengths["a2_mm"], lengths["d4_mm"]) <= 0.0:
        data.findings.error("B007", "an arm without length", _row(data, "$LENGTH_B"))
    raise_errors([d for d in data.findings.all() if d.is_error])
    _tell_root(data)
    version = re.search(r"KUKA ?(\d+\.\d+)", _text(data, "$V_R1MADA[]"))
    rows = [
        f"# {plain(_text(data, '$TRAFONAME[]'))}",
        "# Made by `olp robot import` from machine data ($MACHINE.DAT).",
        f"maker = {quoted(maker)}",
        f"model = {quoted(model)}",
        *([f'controllers = ["KSS {version[1]}"]'] if version else []),
        "pose_verified = false",
        "",
        "axes = [",
        *(f"  {axis}," for axis in axes),
        "]",
        "",
        "[links]",
        *(f"{key} = {shown(value)}" for key, value in lengths.items()),
        f"signs = [{', '.join(shown(sense) for sense in senses)}]",
        "zero_deg = [0, 90, 90, 0, 0, 180]",
        "base_height_mm = 0",
        f"origin_below_mm = {shown(frames['$TIRORO']['Z'])}",
        "",
        "[sources]",
        'limits = "$MACHINE.DAT: $SOFTN_END, $SOFTP_END"',
        'speed = "$MACHINE.DAT: $VEL_AXIS_MA over $RAT_MOT_AX"',
        'links = "$MACHINE.DAT: $TIRORO, $LENGTH_A, $LENGTH_B, $TX3P3, $TFLWP, $AXIS_DIR"',
        'base_height = "poses are counted from robroot, on the floor where the arm stands on it"',
        "",
    ]
    return "\n".join(rows)


def _check_kind(data: MachineData) -> None:
    if not data.rows:
        data.findings.error("B002", "nothing here is machine data", help="save the archive again")
    for key, wanted in (_KIND | _NEVER).items():
        row, text = data.rows.get(key, (None, ""))
        if key in _NEVER and row is None:
            continue
        if row is None:
            data.findings.error(
                "B009", f"{key} is missing", help="save the archive again, with its machine data"
            )
        elif text.upper() != wanted:
            says = "write this arm's file by hand (docs/robots.md)"
            message = f"{key} is {text[:40]}, not {wanted}: an arm of another kind"
            data.findings.error("B006", message, row, help=says)
    raise_errors([d for d in data.findings.all() if d.is_error])


def _tell_root(data: MachineData) -> None:
    row, text = data.rows.get("$ROBROOT", (None, ""))
    if any(_float(value) != 0.0 for _, value in _PART.findall(text)):
        message = "$ROBROOT is not zero: poses in $WORLD do not count from where the robot file's do"
        data.findings.info("B008", message, row)


def model_in(data: MachineData) -> str:
    """The controller's name of its arm; "" if the file has none."""
    row = _row(data, "$TRAFONAME[]")
    return "" if row is None else _text(data, "$TRAFONAME[]")


def _identity(data: MachineData, name: str) -> tuple[str, str]:
    if name:
        if not ROBOT_NAME.fullmatch(name.lower()):
            says = "maker/model, for example kuka/kr6-r900-sixx"
            raise OlpError(error("B010", f"{name[:60]!r} is not a robot name", help=says))
        maker, _, model = name.partition("/")
        return maker, model
    match = _MODEL.search(_text(data, "$TRAFONAME[]"))
    if match is None:
        data.findings.error(
            "B009", "the arm's model is not in $TRAFONAME", help="say --name kuka/kr6-r900-sixx"
        )
        return "KUKA", "arm"
    version = f"-{match[3]}" if match[3] else ""
    return "KUKA", " ".join(part for part in (match[1].upper(), (match[2] or "").upper()) if part) + version


def _axis(data: MachineData, n: int) -> str:
    lower, upper = _number(data, f"$SOFTN_END[{n}]"), _number(data, f"$SOFTP_END[{n}]")
    ratio = _parts(data, f"$RAT_MOT_AX[{n}]", {"N": None, "D": None})
    motor = _number(data, f"$VEL_AXIS_MA[{n}]")  # [1/min]
    if lower >= upper:
        data.findings.error("B007", f"axis {n} has its limits swapped", _row(data, f"$SOFTN_END[{n}]"))
    if 0.0 in (motor, ratio["N"], ratio["D"]):
        data.findings.error("B007", f"axis {n} has no speed", _row(data, f"$RAT_MOT_AX[{n}]"))
        return ""
    speed = abs(motor * 6.0 * ratio["D"] / ratio["N"])
    values = f"lower_deg = {shown(lower)}, upper_deg = {shown(upper)}, speed_deg_s = {shown(round(speed, 2))}"
    return f'{{ name = "A{n}", {values} }}'


def _parts(data: MachineData, key: str, wanted: Mapping[str, float | None]) -> dict[str, float]:
    """The named numbers of a value in braces; a wrong number is added to the findings."""
    row, text = data.rows.get(key, (None, ""))
    read = {part.upper(): _float(value) for part, value in _PART.findall(text)}
    found = {part: value for part, value in read.items() if isfinite(value)}
    missing = [part for part in wanted if part not in found]
    if missing:
        data.findings.error("B009", f"{key} lacks {', '.join(missing)}", row)
    for part, value in wanted.items():
        if value is not None and part in found and abs(found[part] - value) > 1e-6:
            message = f"{key} has {part} {shown(found[part])}, not {value:g}: an arm of another kind"
            data.findings.error("B006", message, row, help="write this arm's file by hand (docs/robots.md)")
    return {part: found.get(part, nan) for part in wanted}


def _number(data: MachineData, key: str) -> float:
    row, text = data.rows.get(key, (None, ""))
    if row is None:
        data.findings.error("B009", f"{key} is missing", help="save the archive again, with its machine data")
        return nan
    value = _float(text)
    if not isfinite(value):
        data.findings.error("B003", f"{key} must be a number, not {text[:40]!r}", row)
        return nan
    return value


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return nan


def _row(data: MachineData, key: str) -> BackupLine | None:
    return data.rows[key][0] if key in data.rows else None


def _text(data: MachineData, key: str) -> str:
    return data.rows.get(key, (None, ""))[1].strip('"')


def _within(folder: Path, name: str) -> Path | None:
    """The subfolder, or regular file, of `folder` whose name in lower case is `name`; None if absent."""
    try:
        named = sorted(entry for entry in folder.iterdir() if entry.name.lower() == name)
    except OSError:
        return None
    return next((entry for entry in named if (entry.is_file() if name == FILE else entry.is_dir())), None)
