"""Traces of KSS 8: `NAME_PROG.TXT` has the motions, `NAME_KRCIpo.dat` names the channels of `NAME_KRCIpo.r64`.

A motion begins at its START and ends at its END signal, both in whole interpolation cycles. The samples are rows of
doubles. Files of the drives (`NextGenDrive#n`) hold one axis each at another rate: they and `.trc` are not needed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, warning
from olp.core.files import read_input
from olp.languages.recorders import ControllerMotion, ControllerRecorder, ControllerRun

Floats = NDArray[np.float64]
_NAME = re.compile(
    r"(?P<stem>.+?)(?:_PROG\.TXT|_(?:KRCIpo|NextGenDrive#\d+)\.(?:dat|r64|trc))", re.IGNORECASE
)
_KINDS: Final = {
    "PTP": "joint", "SPTP": "joint", "LIN": "linear", "SLIN": "linear", "CIRC": "circular", "SCIRC": "circular",
}  # fmt: skip
_MOST_CYCLES = 1e-6  # [s] that an instant may lie off a sample
_TOOL = ("X_Act", "Y_Act", "Z_Act", "C_Act", "B_Act", "A_Act")  # A turns about z
_FIELD = re.compile(r"([A-Za-z]\w*) (-?\d+(?:\.\d+)?)")


class TraceRecorder(ControllerRecorder):
    files = "NAME_PROG.TXT, NAME_KRCIpo.dat and NAME_KRCIpo.r64 of a trace"

    def set_of(self, path: Path) -> Path | None:
        match = _NAME.fullmatch(path.name)
        return None if match is None else path.with_name(match["stem"])

    def read(self, stem: Path) -> ControllerRun:
        header, samples = _file(stem, "_KRCIpo.dat"), _file(stem, "_KRCIpo.r64")
        channels = _channels(_text(header), header)
        period = _number(channels, "Zeit", "Time", code="241", file=header)
        table = _samples(channels, samples)
        program = _file(stem, "_PROG.TXT")
        blocks = list(_blocks(_text(program)))
        time: Floats = np.arange(len(next(iter(table.values()))), dtype=np.float64) * period
        motions, told = _motions(blocks, program, float(time[-1]))
        joints = [table[name] for n in range(1, 7) if (name := f"AxisPos_Act{n}") in table]
        if len(joints) < 6:
            says = f"{len(joints)} of 6 axes are recorded: AxisPos_Act1 to AxisPos_Act6 are needed"
            raise OlpError(error("D051", says, file=str(header), help="configure the trace with all axes"))
        in_base = all(not any(_fields(block.get("BASE", "")).values()) for _, block in blocks)
        tool = np.stack([table[n] for n in _TOOL], axis=1) if in_base and set(_TOOL) <= set(table) else None
        tools = {block.get("TOOL", "") for _, block in blocks}
        one = _fields(tools.pop()) if len(tools) == 1 else {}
        flange = tuple(one[n] for n in "xyzcba") if set("xyzabc") <= set(one) else None
        robot = re.search(r"ROBOT TYPE: *#?(.*)", _text(program))
        return ControllerRun(
            stem.name,
            robot[1].strip() if robot else "",
            period,
            motions,
            time,
            np.stack(joints, axis=1),
            tool,
            flange,
            "KR C",
            tuple(told),
        )


RECORDER: Final = TraceRecorder()


def _file(stem: Path, end: str) -> Path:
    """The file of the set with this end, in whatever case. Raises OlpError (D050)."""
    wanted = (stem.name + end).casefold()
    found = next((path for path in stem.parent.iterdir() if path.name.casefold() == wanted), None)
    if found is None:
        raise OlpError(
            error(
                "D050",
                f"{stem.name}{end} is missing",
                file=str(stem),
                help=f"needed are {TraceRecorder.files}",
            )
        )
    return found


def _text(path: Path) -> str:
    return read_input(path).decode("latin-1")


def _channels(text: str, file: Path) -> list[Mapping[str, str]]:
    """The numbered lines of each channel's header."""
    found: list[Mapping[str, str]] = [
        dict(line.split(",", 1) for line in part.strip().splitlines() if re.match(r"\s*\d+,", line))
        for part in re.findall(r"#BEGINCHANNELHEADER(.*?)#ENDCHANNELHEADER", text, re.DOTALL)
    ]
    if not found:
        says = "this is no header of a trace: it names no channel"
        raise OlpError(error("D051", says, file=str(file), help="BEGINCHANNELHEADER begins one"))
    return found


def _number(channels: list[Mapping[str, str]], *names: str, code: str, file: Path) -> float:
    for channel in channels:
        if channel.get("200") in names:
            try:
                value = float(channel.get(code, ""))
            except ValueError:
                break
            if value > 0:
                return value
    raise OlpError(error("D051", "the header does not say how often it was recorded", file=str(file)))


def _samples(channels: list[Mapping[str, str]], file: Path) -> dict[str, Floats]:
    """Each channel's samples in its unit: the factor of the header times what is stored."""
    stored = [c for c in channels if c.get("210", "").strip() == "EXPLIZIT"]
    raw = read_input(file)
    values = np.frombuffer(raw[: len(raw) // 8 * 8], dtype="<f8")
    width = len(stored)
    counts = {int(c["220"]) for c in stored if c.get("220", "").isdecimal()}
    if not width or len(counts) != 1 or len(raw) != 8 * width * min(counts) or not len(values):
        says = f"{len(raw)} bytes are not {width} channels of {' or '.join(map(str, sorted(counts)))} samples"
        raise OlpError(error("D051", says, file=str(file), help="copy the .dat and .r64 of one trace again"))
    rows = values.reshape(-1, width)
    if not np.isfinite(rows).all():
        row, column = (int(i[0]) for i in np.nonzero(~np.isfinite(rows)))
        says = f"sample {row} of {stored[column].get('200', '?')} is no number"
        raise OlpError(error("D051", says, file=str(file), help="record the trace again"))
    try:
        places = [(c["200"], int(c["221"]) - 1, float(c.get("241", "1"))) for c in stored]
        return {name: rows[:, place] * factor for name, place, factor in places if 0 <= place < width}
    except (KeyError, ValueError):
        raise OlpError(error("D051", "a channel has no name, place or factor", file=str(file))) from None


Block = Mapping[str, str]


def _blocks(text: str) -> Iterator[tuple[int, Block]]:
    """Line and fields of each block of motion information."""
    for match in re.finditer(r"#BEGINMOTIONINFO(.*?)#ENDMOTIONINFO", text, re.DOTALL):
        fields = (line.split(":", 1) for line in match[1].strip().splitlines() if ":" in line)
        yield text.count("\n", 0, match.start()) + 1, {key.strip(): value.strip() for key, value in fields}


def _fields(text: str) -> dict[str, float]:
    return {name: float(value) for name, value in _FIELD.findall(text)}


def _motions(
    blocks: list[tuple[int, Block]], file: Path, last: float
) -> tuple[tuple[ControllerMotion, ...], list[Diagnostic]]:
    """Each START with the END that follows it for the same line."""
    found: list[ControllerMotion] = []
    told: list[Diagnostic] = []
    begun: tuple[int, Block] | None = None
    for line, block in blocks:
        if block.get("SIGNAL") == "START":
            if begun is not None:
                told.append(_left_out(file, begun, "it has no end: it was blended, or the trace ended"))
            begun = line, block
        elif begun is not None and block.get("LINE") == begun[1].get("LINE"):
            made = _motion(begun[1], block, last)
            if isinstance(made, str):
                told.append(_left_out(file, begun, made))
            else:
                found.append(made)
            begun = None
    if begun is not None:
        told.append(_left_out(file, begun, "it has no end: the trace was over before"))
    if not found:
        says = "no motion begins and ends in this trace"
        raise OlpError(
            error("D051", says, file=str(file), help="let it run until the program has ended"), *told
        )
    return tuple(found), told


def _left_out(file: Path, begun: tuple[int, Block], why: str) -> Diagnostic:
    line, block = begun
    says = f"the motion of line {block.get('LINE', '?')} of {block.get('MODULE', '?')} is left out: {why}"
    return warning("D052", says, Span(line), file=str(file))


def _motion(start: Block, end: Block, last: float) -> ControllerMotion | str:
    """The motion, or why it is none."""
    kind = _KINDS.get(start.get("TYPE", ""))
    if kind is None:
        return f"nothing is known of the type {start.get('TYPE', '')}"
    try:
        begin, until, line = float(start["TIME"]), float(end["TIME"]), int(start["LINE"])
    except (KeyError, ValueError):
        return "its time or line is no number"
    if not 0 <= begin < until <= last + _MOST_CYCLES:
        return f"it lasts from {begin:g} to {until:g} s, and the samples from 0 to {last:g} s"
    return ControllerMotion(kind, f"{start.get('MODULE', '')}.src", line, begin, until, _says(kind, start))


def _says(kind: str, block: Block) -> dict[str, float]:
    speeds, rates = _fields(block.get("VELOCITIES", "")), _fields(block.get("ACCELERATIONS", ""))
    found: dict[str, float] = {}
    if kind == "joint" and speeds and rates:
        found = {"speed_pct": min(speeds.values()), "accel_pct": min(rates.values())}
    elif "cp" in speeds and "cp" in rates:
        found = {"speed_mm_s": speeds["cp"], "accel_mm_s2": rates["cp"]}
    load = re.search(r"m (-?[\d.]+).*?j \{ x ([\d.]+), y ([\d.]+), z ([\d.]+) \}", block.get("LOAD", ""))
    if load is not None and float(load[1]) >= 0:
        found["payload_kg"] = float(load[1])
        found["payload_inertia_kg_m2"] = max(float(load[n]) for n in (2, 3, 4))
    return found
