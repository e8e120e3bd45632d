"""The signature as an object: what was learnt, from what, how sure, and where it holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from olp.identification.signature.coefficients import CorrectionPart
from olp.identification.signature.domain import Domain
from olp.identification.signature.errors import ErrorModel
from olp.identification.signature.estimator import LearntParameter
from olp.identification.signature.joint_moves import LearntArm
from olp.identification.signature.path_moves import LearntPaths

SCHEMA = "olp-signature"
# 2 holds `parts`, 3 the law of joint moves, which an older olp would leave out in silence: what is not there lowers the
# version that is written.
VERSION = 7


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
    parameters: Mapping[str, LearntParameter]
    errors: ErrorModel
    domain: Domain
    compared: Mapping[str, Score]
    olp: str
    parts: Mapping[str, CorrectionPart] = field(
        default_factory=dict
    )  # what was learnt beside straight moves, see coefficients.py
    arm: LearntArm | None = None  # what was learnt of joint moves
    paths: LearntPaths | None = None  # what was learnt of arcs and of paths with corners

    @property
    def knows_paths(self) -> bool:
        """Whether any line or arc was learnt; else olp's own model times them."""
        return not self.domain.empty or self.paths is not None

    @property
    def version(self) -> int:
        """Of the file: the oldest that holds all of it."""
        if self.arm is not None or self.paths is not None:
            return VERSION
        return 2 if self.parts else 1
