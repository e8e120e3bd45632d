"""Small recordings for the tests, written cell by cell."""

from __future__ import annotations

from pathlib import Path

import pytest

from olp.core.diagnostic import Diagnostic, OlpError
from olp.identification.recording import Recording, read_recording

# Every column of the contract, with a value that is none of its defaults.
LINEAR = {
    "move": "1", "duration_s": "2.64", "sim_s": "2.9", "type": "linear",
    "x_start_mm": "1350.5", "y_start_mm": "700.25", "z_start_mm": "-100.125",
    "x_end_mm": "710.75", "y_end_mm": "-650.5", "z_end_mm": "90.0625",
    "rx_start_deg": "179.5", "ry_start_deg": "-89.25", "rz_start_deg": "1.5",
    "rx_end_deg": "170.5", "ry_end_deg": "-80.25", "rz_end_deg": "11.5",
    "q1_start_deg": "11.5", "q2_start_deg": "-22.5", "q1_end_deg": "-33.5", "q2_end_deg": "44.5",
    "x_via_mm": "1000.5", "y_via_mm": "33.25", "z_via_mm": "7.5",
    "speed_mm_s": "300.5", "speed_pct": "12.5", "accel_mm_s2": "400.5", "accel_pct": "62.5",
    "blend_mm": "12.5", "pl": "3", "t_start_s": "1000.25", "cycle": "4", "job": "FAN.JBI", "line": "48",
    "payload_kg": "6.5", "payload_inertia_kg_m2": "0.125",
    "sim_payload_kg": "6", "sim_payload_inertia_kg_m2": "0.12", "override_pct": "85", "sim_override_pct": "100",
    "temperature_c": "31.5", "humidity": "55.5",
    "operator": "night",
}  # fmt: skip
POINTS = ("move", "duration_s", "x_start_mm", "y_start_mm", "z_start_mm", "x_end_mm", "y_end_mm", "z_end_mm")


def table(*rows: dict[str, str], names: tuple[str, ...] = ()) -> str:
    """CSV of the rows; `names`: the columns, else those of the first row."""
    names = names or tuple(rows[0])
    lines = [",".join(names), *(",".join(row.get(name, "") for name in names) for row in rows)]
    return "".join(f"{line}\n" for line in lines)


def moves(count: int, **cells: str) -> list[dict[str, str]]:
    """Plain moves 1 to `count` with tool points, 5 mm apart, and a speed."""
    names = dict.fromkeys(POINTS, "")
    rows = []
    for i in range(1, count + 1):
        place = {name: f"{100 * i + k}.5" for k, name in enumerate(POINTS[2:])}
        rows.append(names | {"move": str(i), "duration_s": f"{i}.25", **place, "speed_mm_s": "5", **cells})
    return rows


def write(folder: Path, text: str, name: str = "moves.csv") -> Path:
    """The folder, with the text in it."""
    (folder / name).write_text(text, encoding="utf-8", newline="")
    return folder


def read(folder: Path, text: str) -> Recording:
    return read_recording(write(folder, text))


def refused(path: Path) -> tuple[Diagnostic, ...]:
    """What is wrong with the recording at `path`, which must be something."""
    with pytest.raises(OlpError) as problem:
        read_recording(path)
    assert all(d.message and d.code.startswith("D") for d in problem.value.diagnostics)
    return problem.value.diagnostics


def places(found: tuple[Diagnostic, ...]) -> list[tuple[str, int, int]]:
    """(code, line, column) of the errors."""
    return [(d.code, d.line, d.column) for d in found if d.is_error]
