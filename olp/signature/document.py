"""The signature as an object: what was learnt, from what, how sure, and where it holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from olp.signature.domain import Domain
from olp.signature.errors import ErrorModel
from olp.signature.estimator import Parameter
from olp.signature.parts import Part

SCHEMA = "olp-signature"
# 2 holds `parts`, which an olp that reads 1 would leave out in silence; without them 1 is written.
VERSION = 2


class Learnt(NamedTuple):
    """The recording behind a signature. `moves`: those that were used; `resolution` [s] of their times, or None."""

    name: str
    sha256: str
    moves: int
    resolution: float | None


class Score(NamedTuple):
    """Held-out mean absolute percentage errors [%] inside the recording; nan where it could not be held out."""

    moves: float  # every tenth move at a time
    starts: float  # whole start points
    directions: float = float("nan")  # all moves towards the base, away from it, down, up


@dataclass(frozen=True, slots=True)
class Signature:
    """`tool` (6,) [m, rad] on the flange and `payload` [kg]: None where the recording does not say."""

    robot: str
    controller: str
    tool: tuple[float, ...] | None
    payload: float | None
    recording: Learnt
    method: str
    parameters: Mapping[str, Parameter]
    errors: ErrorModel
    domain: Domain
    compared: Mapping[str, Score]
    olp: str
    parts: Mapping[str, Part] = field(
        default_factory=dict
    )  # what was learnt beside straight moves, see parts.py
