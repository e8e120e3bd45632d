"""The signature file: JSON that a person can read, checked when it is read.

Codes: H006 not a signature, H007 a newer version, H008 a field that is missing or cannot be.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from olp.core.diagnostic import OlpError, error
from olp.core.files import parse_json, read_input, write_output
from olp.core.units import deg, mm
from olp.identification.signature.coefficients import KINDS, CorrectionPart, LearntParameter
from olp.identification.signature.document import SCHEMA, VERSION, Learnt, LearntPaths, Score, Signature
from olp.identification.signature.domain import Domain
from olp.identification.signature.errors import ErrorModel, Spread
from olp.identification.signature.joint_moves import LearntArm

_MOST_BYTES = 50_000_000


def write_signature(signature: Signature, path: str | Path | None) -> None:
    """Writes the file, whole or not at all; None or "-" is standard output. Raises OSError."""
    write_output(path, to_text(signature))


def read_signature(path: str | Path) -> Signature:
    """Raises OlpError: H006, H007, H008."""
    file = str(path)
    try:
        data = read_input(path, _MOST_BYTES)
    except OSError as problem:
        raise OlpError(error("H006", problem.strerror or "cannot be read", file=file)) from None
    try:
        content = parse_json(data)
    except ValueError as problem:
        raise OlpError(error("H006", f"not JSON: {problem}", file=file)) from None
    return from_json(content, file)


def to_text(signature: Signature) -> str:
    """The file's text; numbers are rounded to what matters (12 digits)."""
    return json.dumps(_rounded(to_json(signature)), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def to_json(signature: Signature) -> dict[str, Any]:
    """The file's content, units in the names."""
    learnt, domain, errors = signature.recording, signature.domain, signature.errors
    content = {
        "schema": SCHEMA,
        "version": signature.version,
        "robot": signature.robot,
        "controller": signature.controller,
        "tool_mm_deg": None
        if signature.tool is None
        else [*(v / mm for v in signature.tool[:3]), *(v / deg for v in signature.tool[3:])],
        "payload_kg": signature.payload,
        "recording": {
            "name": learnt.name,
            "sha256": learnt.sha256,
            "moves": learnt.moves,
            "time_resolution_s": learnt.resolution,
        },
        "method": signature.method,
        "parameters": _told(signature.parameters),
        "errors_s2_per_m": {"near": errors.near._asdict(), "far": errors.far._asdict()},
        "domain": {
            "speed_mm_s": [v / mm for v in domain.speed],
            "length_mm": [v / mm for v in domain.length],
            "payload_kg": None if domain.payload is None else list(domain.payload),
            "near_mm": domain.near / mm,
            "far_mm": domain.far / mm,
            "moves_mm_deg": np.concatenate([domain.moves / mm, domain.angles / deg], axis=1).tolist(),
        },
        "held_out_percent": {name: s._asdict() for name, s in signature.compared.items()},
        "olp": signature.olp,
    }
    if signature.parts:
        content["parts"] = {name: _part_json(part) for name, part in signature.parts.items()}
    if signature.arm is not None:
        content["joint_moves"] = signature.arm.to_json()
    if signature.paths is not None:
        content["paths"] = signature.paths.to_json()
    return content


def _told(quantities: Mapping[str, LearntParameter]) -> dict[str, Any]:
    return {name: {"value": p.value, "unit": p.unit, "sd": p.sd} for name, p in quantities.items()}


def _part_json(part: CorrectionPart) -> dict[str, Any]:
    return {
        "quantities": _told(part.quantities),
        "errors_s": {**part.spread._asdict(), "row_half": part.row_half},
        "rows": part.rows,
        "longest_s": part.longest,
        "held_out_percent": {"unlearnt": part.unlearnt, "learnt": part.learnt},
        "law": part.law,
    }


# The first versions of the file with the numbers of today's laws.
_LAWS = (("joint_moves", "joint moves", 6), ("paths", "lines and arcs", 7))


def from_json(content: Any, file: str = "") -> Signature:
    """Raises OlpError: H006 another file, H007 a newer version, H008 wrong fields."""
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise OlpError(error("H006", f'no signature: "schema" is not "{SCHEMA}"', file=file))
    version = content.get("version")
    if not isinstance(version, int) or version > VERSION:
        says = f"version {version!r} of the signature file is newer than this olp reads ({VERSION})"
        raise OlpError(error("H007", says, file=file, help="install a newer olp"))
    for key, what, since in _LAWS:
        if version < since and key in content:
            says = f"the law of {what} has other numbers since this signature was learnt"
            raise OlpError(error("H008", says, file=file, help="calibrate again with the same recording"))
    try:
        return _signature(content)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as problem:
        what = f"{type(problem).__name__}: {problem}"
        raise OlpError(error("H008", f"a field is missing or invalid ({what})", file=file)) from None


def _signature(content: dict[str, Any]) -> Signature:
    learnt, domain, errors = content["recording"], content["domain"], content["errors_s2_per_m"]
    tool = content["tool_mm_deg"]
    parameters = _parameters(content["parameters"])
    kept = np.array(domain["moves_mm_deg"], dtype=np.float64).reshape(-1, 9)
    places, angles = kept[:, :6] * mm, kept[:, 6:] * deg
    arm = None if "joint_moves" not in content else LearntArm.from_json(content["joint_moves"])
    paths = None if "paths" not in content else LearntPaths.from_json(content["paths"])
    if (not len(places) and arm is None and paths is None) or not np.isfinite(places).all():
        raise ValueError("domain without moves")
    return Signature(
        robot=str(content["robot"]),
        controller=str(content["controller"]),
        tool=None
        if tool is None
        else (*(float(v) * mm for v in tool[:3]), *(float(v) * deg for v in tool[3:])),
        payload=_optional(content["payload_kg"]),
        recording=Learnt(
            str(learnt["name"]),
            str(learnt["sha256"]),
            int(learnt["moves"]),
            _optional(learnt["time_resolution_s"]),
        ),
        method=str(content["method"]),
        parameters=parameters,
        errors=ErrorModel(_spread(errors["near"]), _spread(errors["far"])),
        domain=Domain(
            _pair(domain["speed_mm_s"], mm),
            _pair(domain["length_mm"], mm),
            None if domain["payload_kg"] is None else _pair(domain["payload_kg"], 1.0),
            places,
            angles,
            float(domain["near_mm"]) * mm,
            float(domain["far_mm"]) * mm,
        ),
        compared={
            str(name): Score(*(math.nan if s.get(k) is None else float(s[k]) for k in Score._fields))
            for name, s in content["held_out_percent"].items()
        },
        olp=str(content["olp"]),
        parts={name: _part(name, entry) for name, entry in content.get("parts", {}).items()},
        arm=arm,
        paths=paths,
    )


def _parameters(content: dict[str, Any]) -> dict[str, LearntParameter]:
    return {
        str(name): LearntParameter(p["value"], str(p["unit"]), p.get("sd")) for name, p in content.items()
    }


def _part(name: str, entry: dict[str, Any]) -> CorrectionPart:
    quantities = _parameters(entry["quantities"])
    for known in KINDS[name].quantities:
        value = float(quantities[known.name].value)
        if not (math.isfinite(value) and value >= known.lowest):
            raise ValueError(f"{known.name} {value}")
    row_half = entry["errors_s"]["row_half"]
    longest = float(entry["longest_s"])
    if not longest > 0:
        raise ValueError(f"longest_s {longest}")
    held = entry["held_out_percent"]
    return CorrectionPart(
        quantities,
        _spread(entry["errors_s"]),
        math.inf if row_half is None else float(row_half),
        int(entry["rows"]),
        longest,
        float(held["unlearnt"]),
        float(held["learnt"]),
        str(entry["law"]),
    )


def _spread(entry: dict[str, Any]) -> Spread:
    sizes = [math.inf if entry[k] is None else float(entry[k]) for k in ("half", "shared", "own")]
    if min(sizes) < 0 or any(math.isnan(s) for s in sizes):
        raise ValueError("negative spread")
    return Spread(sizes[0], sizes[1], sizes[2], int(entry["groups"]))


def _pair(values: Any, factor: float) -> tuple[float, float]:
    low, high = (float(v) * factor for v in values)
    if not 0 <= low <= high < math.inf:
        raise ValueError(f"range {values}")
    return low, high


def _optional(value: Any) -> float | None:
    return None if value is None else float(value)


def _rounded(value: Any) -> Any:
    """Twelve digits, and None for what is no finite number: JSON has none."""
    if isinstance(value, dict):
        return {k: _rounded(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(v) for v in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.12g}") if math.isfinite(value) else None
    return value
