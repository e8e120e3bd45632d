"""Named terms as the parameters of a signature: what a diagnosis found, and the simulation it was found beside.

A term that is written here is rebuilt without the recording: its form by name, the values that do nothing (`nulls`),
and the numbers of the learnt moves that a form refers to (see `Case.number`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.signature.estimator import LearntParameter, Parameters
from olp.timing.physics import Form, MoveTerm, TermParameter, load_term

_FREE = math.inf  # a term in a file is applied, not fitted: it has no bounds
_NUMBER = "learnt moves: "
_PAYLOAD, _INERTIA = "payload", "payload inertia"
_LINEAR, _RAMP, _LAW, _OVERLAP, _SPLIT = (
    "simulation: linear acceleration",
    "simulation: joint ramp",
    "simulation: corner law",
    "simulation: corner overlap",
    "simulation: corner split",
)


class NamedModel(NamedTuple):
    """A model and the judged simulation's own motion.

    `linear` [m/s²] where a move does not say, `ramp` [s] of every axis to its rated speed, 0: as the robot's file says:
    how the simulation accelerates; nan for kinds of moves that were not learnt, of which the terms say nothing.
    `law`, `overlap`, `split`: how it passes rounded corners. `payload` [kg], `inertia` [kg m²]: of the load where a
    move does not say, nan where nothing does. `numbers`: see `Case.number`.
    """

    model: DurationModel
    linear: float
    ramp: float
    law: str = "stop"
    overlap: float = 1.0
    split: float = 0.5
    payload: float = math.nan
    inertia: float = math.nan
    numbers: Mapping[str, float] = {}


def to_parameters(named: NamedModel, sd: Mapping[tuple[str, str], float]) -> dict[str, LearntParameter]:
    """`sd`: standard deviations by the labels of part and parameter."""
    parts = named.model.parts
    found = {
        "terms": LearntParameter([part.term.name for part in parts], ""),
        "forms": LearntParameter([part.form.key for part in parts], ""),
        "axes": LearntParameter([part.form.axis for part in parts], ""),
        "nulls": LearntParameter([[_written(p.null) for p in part.form.parameters] for part in parts], ""),
    }
    for part in parts:
        for parameter, value in zip(part.form.parameters, part.values.tolist(), strict=True):
            key = _key(part.term.name, part.form.axis, parameter.name)
            found[key] = LearntParameter(value, parameter.unit, sd.get((part.label, parameter.name)))
    found[_LINEAR] = LearntParameter(_written(named.linear), "m/s²")
    found[_RAMP] = LearntParameter(_written(named.ramp), "s")
    found[_LAW] = LearntParameter(named.law, "")
    found[_OVERLAP], found[_SPLIT] = LearntParameter(named.overlap, "1"), LearntParameter(named.split, "1")
    for name, value, unit in ((_PAYLOAD, named.payload, "kg"), (_INERTIA, named.inertia, "kg m²")):
        if math.isfinite(value):
            found[name] = LearntParameter(value, unit)
    found.update({f"{_NUMBER}{name}": LearntParameter(value, "SI") for name, value in named.numbers.items()})
    return found


def from_parameters(parameters: Parameters) -> NamedModel:
    """What `to_parameters` wrote. Raises KeyError, TypeError, ValueError for anything else; OlpError N001."""
    lists = [parameters[name].value for name in ("terms", "forms", "axes", "nulls")]
    parts = tuple(
        _part(parameters, str(name), str(key), int(axis), nulls)
        for name, key, axis, nulls in zip(*lists, strict=True)
    )
    return NamedModel(
        DurationModel(parts),
        _read(parameters[_LINEAR].value),
        _read(parameters[_RAMP].value),
        str(parameters[_LAW].value),
        float(parameters[_OVERLAP].value),
        float(parameters[_SPLIT].value),
        _optional(parameters, _PAYLOAD),
        _optional(parameters, _INERTIA),
        {
            name.removeprefix(_NUMBER): float(p.value)
            for name, p in parameters.items()
            if name.startswith(_NUMBER)
        },
    )


def _part(parameters: Parameters, name: str, key: str, axis: int, nulls: list[float | None]) -> ModelPart:
    term = load_term(name)
    if not isinstance(term, MoveTerm):
        raise ValueError(f"{name} is no term of moves")
    prefix = _key(name, axis, "")
    own = [(k.removeprefix(prefix), p) for k, p in parameters.items() if k.startswith(prefix)]
    values = np.array([float(p.value) for _, p in own])
    if not len(values) or not np.isfinite(values).all():
        raise ValueError(f"{name} without values")
    known = tuple(
        TermParameter(label, p.unit, -_FREE, _FREE, math.inf if null is None else float(null))
        for (label, p), null in zip(own, nulls, strict=True)
    )
    return ModelPart(term, Form(key, known, "", axis), values)


def _optional(parameters: Parameters, name: str) -> float:
    return float(parameters[name].value) if name in parameters else math.nan


def _key(term: str, axis: int, parameter: str) -> str:
    return f"{term}: {parameter}" if axis < 0 else f"{term} {axis}: {parameter}"


def _written(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _read(value: float | None) -> float:
    return math.nan if value is None else float(value)
