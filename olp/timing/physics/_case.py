"""Input of the terms of moves: the judged simulation's motion, and every property of a move that a cause may depend
on.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from olp.timing.physics._motion import Motion

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SHARED = 0.5  # of the moves that one acceleration is that of, where the simulation had it and not each move its own
_DIGITS = 1e-3  # [s] that the digits of simulated times may hide


@dataclass(frozen=True, slots=True, eq=False)
class Rates:
    """Turn of k axes per unit of path length, from kinematics (or from joint points alone, then constant along the
    move).

    `path`: signed, at m places spread evenly along the path; 0 for waits and for moves whose axes are unknown.
    """

    path: Floats  # (n, m, k) [rad/m | rad/rad | m/m]
    known: Mask  # (n,) rows whose rates are known
    exact: bool  # from the robot's kinematics along the way
    names: tuple[str, ...]  # (k,) of the axes
    rated: Floats | None = None  # (k,) [rad/s | m/s] rated speeds, where a robot file tells them
    rated_acceleration: Floats | None = None  # (k,) [rad/s² | m/s²]
    bodies: Floats | None = None  # (n, m, 2, 3) [m] elbow and wrist centre along the way, nan where not known
    lifts: Floats | None = (
        None  # (n, m, 2, k) [m/rad] rise of elbow and wrist centre by each axis, nan likewise
    )
    climb: Floats | None = (
        None  # (n, m) [1] sine of the incline of the tool's way in joint moves, nan likewise
    )

    @property
    def start(self) -> Floats:
        """Rates at the start of each move (n, k)."""
        return np.asarray(self.path[:, 0, :])

    @property
    def end(self) -> Floats:
        """Rates at the end of each move (n, k)."""
        return np.asarray(self.path[:, -1, :])


class Rivals(NamedTuple):
    """Axes that may take over from the leading one of joint moves when something slows them: each as a move of its
    own that it leads, with the limits that the judged simulation has for it.
    """

    moves: MeasuredMoves  # r rows: `base` and `rates` are per turn of the rival axis, `leader` is that axis
    of: NDArray[np.intp]  # (r,) rows of the moves, ascending
    together: tuple[
        NDArray[np.intp], ...
    ]  # (m, g) the rivals of each move that has some, the last of fewer than m again; (g,) that move's row

    @classmethod
    def of_moves(cls, moves: MeasuredMoves, of: NDArray[np.intp]) -> Rivals:
        """Those that are rivals in the rows `of` (r,), ascending."""
        first = np.flatnonzero(np.diff(of, prepend=-1))
        count = np.diff(first, append=len(of))
        places = first + np.minimum(np.arange(count.max(initial=0))[:, None], count - 1)
        return cls(moves, of, (places, of[first]))

    def take(self, rows: NDArray[np.int64]) -> Rivals | None:
        """Those of these moves; None where these have none."""
        first, last = np.searchsorted(self.of, rows, "left"), np.searchsorted(self.of, rows, "right")
        count = last - first
        if not count.any():
            return None
        of = np.repeat(np.arange(len(rows)), count)
        mine = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
        return Rivals.of_moves(self.moves.take(mine), of)


class CornerPartners(NamedTuple):
    """Rows of the moves that others meet at rounded corners; a move's own row where there is none, or none is known."""

    before: NDArray[np.int64]  # (n,) of the move that ends where this one begins
    after: NDArray[np.int64]  # (n,) of the move that begins where this one ends

    @classmethod
    def of_rows(cls, before: NDArray[np.int64]) -> CornerPartners:
        """`before` (n,): of the move before, below 0 where a move begins at an exact stop or nobody knows."""
        own = np.arange(len(before), dtype=np.int64)
        after, meets = own.copy(), before >= 0
        after[before[meets]] = own[meets]
        return cls(np.where(meets, before, own), after)

    def take(self, rows: NDArray[np.int64]) -> CornerPartners:
        """Of some of the moves, by their rows among these."""
        place = np.full(len(self.before), -1, dtype=np.int64)
        place[rows] = own = np.arange(len(rows))
        return CornerPartners(
            *(np.where(place[of[rows]] >= 0, place[of[rows]], own).astype(np.int64) for of in self)
        )

    def beyond(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """The rows of moves that those of `rows` meet and that are none of them, ascending."""
        return np.setdiff1d(np.concatenate([self.before[rows], self.after[rows]]), rows)

    def repeated(self, count: int) -> CornerPartners:
        """Of the moves `count` times, one set below the other."""
        steps = len(self.before) * np.arange(count)[:, None]
        return CornerPartners(*((of + steps).ravel() for of in self))


class _NumbersOf(Mapping[str, float]):
    """The numbers that forms refer to in other moves, also those that are worked out later."""

    def __init__(self, moves: MeasuredMoves) -> None:
        self.moves = moves

    def __getitem__(self, name: str) -> float:
        if name in self.moves.numbers:
            return self.moves.numbers[name]
        return float(self.moves.derived[f"{_NUMBER}{name}"][0])

    def __iter__(self) -> Iterator[str]:
        return iter(self.moves.numbers_used)

    def __len__(self) -> int:
        return len(self.moves.numbers_used)


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredMoves:
    """n executed moves with a measured duration, in order of execution. Columns that were not recorded are nan.

    `base`: the motion that the judged simulation seems to have used; `simulated`: its durations. The prediction of
    a model is `simulated` plus the change that its terms make to `base`.
    """

    move: NDArray[np.int64]  # the recording's own numbers
    measured: Floats  # [s]
    simulated: Floats  # [s]
    base: Motion
    moving: Mask  # not a wait
    joint: Mask  # joint moves: their ways are angles
    start: Floats  # (n, 3) [m]
    end: Floats  # (n, 3) [m]
    turn: Floats  # [rad] of the tool, nan where not known
    stop_start: Mask  # begins at an exact stop
    stop_end: Mask  # ends with one
    blend: Floats  # [m] rounding at the move's end, 0: exact stop
    blend_start: Floats  # [m] rounding at the move's start
    corner: Floats  # [rad] change of direction at the move's end, nan where not known
    payload: Floats  # [kg], nan where not known
    payload_inertia: Floats  # [kg m²], nan where not known
    t_start: Floats  # [s]
    cycle: NDArray[np.int64]  # -1: none
    job: tuple[str, ...]
    line: NDArray[np.int64]  # 0: none
    rates: Rates | None = None
    resolution: float = 0.0  # [s] of `measured`
    polled: float = 0.0  # [s] a resolution that nobody states and that is no decimal digit: a cycle
    covariates: Mapping[str, Floats] = field(default_factory=dict)
    repeats: NDArray[np.int64] = field(
        default_factory=lambda: np.zeros(0, np.int64)
    )  # (n,) equal: programmed alike
    place: NDArray[np.int64] = field(
        default_factory=lambda: np.zeros(0, np.int64)
    )  # (n,) of the moves in the order of execution, where some are left out
    sim_payload: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [kg] that the simulation was told
    sim_payload_inertia: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [kg m²] likewise
    override: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [1] real over simulated
    stretch: float = 1.0  # of the simulated durations over what the written speeds and accelerations take
    began: float = float("nan")  # [s] when the recording did, on the clock of `t_start`
    leader: NDArray[np.int64] = field(
        default_factory=lambda: np.zeros(0, np.int64)
    )  # (n,) axes that lead the moves, from 0, where rated speeds alone do not tell
    rivals: Rivals | None = None  # None: no axis takes over
    partners: CornerPartners | None = None  # None: corners are passed as if both of their moves were alike
    wider: MeasuredMoves | None = None  # these and, behind them, the others that they meet at rounded corners
    slowest: bool = (
        False  # joint moves take as long as their slowest axis would alone; else all limits hold at once
    )
    derived: dict[str, Floats] = field(default_factory=dict)  # what terms work out once per case
    numbers: Mapping[str, float] = field(
        default_factory=dict
    )  # of the moves a model was fitted to, see `number`
    acted: dict[Hashable, tuple[Motion, Motion]] = field(
        default_factory=dict, init=False
    )  # what terms made of a motion lately, with that motion
    copies: dict[int, RepeatedMoves] = field(default_factory=dict, init=False)  # see `repeated`
    folds: dict[bytes, MeasuredMoves] = field(default_factory=dict, init=False)  # see `fold`
    fits: dict[Hashable, object] = field(default_factory=dict, init=False)  # see `keep`

    def __post_init__(self) -> None:
        if self.rivals is not None:
            moves = replace(self.rivals.moves, numbers=_NumbersOf(self), derived={})
            object.__setattr__(self, "rivals", self.rivals._replace(moves=moves))
        if self.wider is not None:
            object.__setattr__(self, "wider", replace(self.wider, numbers=_NumbersOf(self), derived={}))

    def __len__(self) -> int:
        return len(self.move)

    @property
    def residual(self) -> Floats:
        """Measured minus simulated duration (n,) [s]."""
        return self.measured - self.simulated

    @property
    def follows(self) -> Mask:
        """Moves that were executed directly after the move in the row before (n,)."""
        if len(self.place) != len(self):
            return np.arange(len(self)) > 0
        return np.concatenate([[False], np.diff(self.place) == 1])

    @property
    def leading(self) -> tuple[str, ...]:
        """Leading axis of each move (n,): the one that takes longest at rated speeds, or turns farthest where these
        are unknown; "" where the axes are unknown.
        """
        rates = self.rates
        if rates is None:
            return ("",) * len(self)
        most = self.leads.tolist()
        return tuple(
            rates.names[k] if known else "" for k, known in zip(most, rates.known.tolist(), strict=True)
        )

    @property
    def leads(self) -> NDArray[np.int64]:
        """Number (n,) of the leading axis of each move, from 0; of any axis where `rates` do not know the axes."""
        rates = self.rates
        if len(self.leader) == len(self) or rates is None:
            return self.leader
        turned = np.abs(rates.path).mean(axis=1) / (1.0 if rates.rated is None else rates.rated)
        return np.asarray(np.argmax(turned, axis=1), dtype=np.int64)

    def led(self, axis: int) -> Mask:
        """Moves (n,) whose `leading` axis is number `axis` (from 0); none where axes are unknown."""
        if self.rates is None:
            return np.zeros(len(self), dtype=bool)
        name = self.rates.names[axis]
        led = self.once(f"led by {axis}", lambda: np.array([float(n == name) for n in self.leading]))
        return np.asarray(led > 0)

    @property
    def leaders(self) -> tuple[tuple[int, str], ...]:
        """Number and name of each axis that leads enough joint moves, but not all, for a parameter of its own."""
        if self.rates is None:
            return ()
        turned = self.joint & self.moving
        counts = [(k, name, int((self.led(k) & turned).sum())) for k, name in enumerate(self.rates.names)]
        return tuple((k, name) for k, name, count in counts if _LED <= count < turned.sum())

    @property
    def length(self) -> Floats:
        """Distance from start to end (n,) [m], nan without points."""
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))

    @property
    def rise(self) -> Floats:
        """Sine of the incline (n,), positive upwards; 0 where unknown."""
        length = self.length
        up = self.end[:, 2] - self.start[:, 2]
        return np.asarray(np.nan_to_num(up / np.where(length > 0, length, np.nan)))

    @property
    def bodies_known(self) -> bool:
        """Whether the positions of elbow and wrist are known along every straight move, also of those that were not
        taken: forms stay what they are."""
        if self.rates is None or self.rates.bodies is None:
            return False
        along = self.rates.bodies[self.moving & ~self.joint]
        return self.number("bodies known", lambda: float(np.isfinite(along).all())) > 0

    def once(self, name: str, make: Callable[[], Floats]) -> Floats:
        """A column derived from this case, computed by `make` on the first call and then kept under `name`."""
        if name not in self.derived:
            self.derived[name] = make()
        return self.derived[name]

    def idle(self, where: Mask) -> float:
        """Largest time [s] by which the simulated duration of moves `where` (n,) exceeds that of their motion: only
        this part can get shorter by a fixed time.

        inf where the accelerations were fitted to each duration, which hides this part.
        """
        if not where.any():
            return np.inf
        _, count = np.unique(np.round(np.log(self.base.accelerate[where]), 6), return_counts=True)
        if count.max() < _SHARED * where.sum():
            return np.inf
        beyond = self.simulated - self.once("base", self.base.duration) + self.base.added
        return max(float(beyond[where].max()), _DIGITS)

    def number(self, name: str, make: Callable[[], float]) -> float:
        """A number over all moves that a form refers to (a median, a minimum), computed by `make`.

        Other moves, or some of these, are predicted with the number of the moves a model was fitted to, `numbers`.
        """
        if name in self.numbers:
            return self.numbers[name]
        return float(self.once(f"{_NUMBER}{name}", lambda: np.array([make()]))[0])

    @property
    def numbers_used(self) -> dict[str, float]:
        """The numbers that the terms have asked for so far, by name."""
        own = {
            key.removeprefix(_NUMBER): float(value[0])
            for key, value in self.derived.items()
            if key.startswith(_NUMBER)
        }
        return {**self.numbers, **own}

    @property
    def unit(self) -> str:
        """Unit of path lengths: "m", or "rad" when all moves are joint moves."""
        return "rad" if bool((self.joint | ~self.moving).all()) else "m"

    @property
    def ratio(self) -> Floats:
        """Factor (n,) that converts a number in `unit` for each move: joint moves beside straight ones are scaled
        by accelerations.
        """
        return self.once("ratio", self._ratio)

    def _ratio(self) -> Floats:
        return np.where(self.joint & self.moving, self.number("ratio", self._angular), 1.0)

    def _angular(self) -> float:
        """Scale [rad/m] of joint moves beside straight ones; 1 where all are of one kind."""
        angular, straight = self.joint & self.moving, ~self.joint & self.moving
        if not angular.any() or not straight.any():
            return 1.0
        pace = self.base.accelerate
        return float(np.median(pace[angular]) / np.median(pace[straight]))

    @property
    def pace(self) -> float:
        """Median [unit/s²] of the simulation's accelerations."""
        of = self.moving & np.isfinite(self.base.accelerate)
        return float(np.median((self.base.accelerate / self.ratio)[of])) if of.any() else 1.0

    def repeated(self, count: int) -> MeasuredMoves:
        """The moves `count` times, one set below the other: what a term does to as many motions of them in one go. No
        term looks from one move to another, so the sets do not touch."""
        if count == 1:
            return self
        if count not in self.copies:
            if len(self.copies) >= _COPIES:
                del self.copies[next(iter(self.copies))]
            self.copies[count] = RepeatedMoves(self, count)
        return self.copies[count]

    def keep(self, key: Hashable, found: object) -> None:
        """Hold in `fits` what models came to lately."""
        if len(self.fits) >= _KEPT:
            del self.fits[next(iter(self.fits))]
        self.fits[key] = found

    def fold(self, rows: NDArray[np.int64]) -> MeasuredMoves:
        """`take`, kept: models are fitted to the same rows again and again."""
        key = rows.tobytes()
        if key not in self.folds:
            if len(self.folds) >= _FOLDS:
                del self.folds[next(iter(self.folds))]
            self.folds[key] = self.take(rows)
        return self.folds[key]

    def take(self, rows: NDArray[np.int64]) -> MeasuredMoves:
        """Some of the moves; their neighbours' properties, and the numbers that forms refer to, stay unchanged."""
        whole, numbers = self.wider or self, self.numbers_used
        some = whole._some(rows, numbers)
        if whole.partners is None or not len(beyond := whole.partners.beyond(rows)):
            return some
        return replace(some, wider=whole._some(np.concatenate([rows, beyond]), numbers))

    def _some(self, rows: NDArray[np.int64], numbers: Mapping[str, float]) -> MeasuredMoves:
        """Some of the moves, without others that they meet."""
        columns = {
            name: getattr(self, name)[rows] for name in _COLUMNS if len(getattr(self, name)) == len(self)
        }
        rates = self.rates
        if rates is not None:
            bodies = None if rates.bodies is None else rates.bodies[rows]
            lifts = None if rates.lifts is None else rates.lifts[rows]
            climb = None if rates.climb is None else rates.climb[rows]
            path, known = rates.path[rows], rates.known[rows]
            rates = replace(rates, path=path, known=known, bodies=bodies, lifts=lifts, climb=climb)
        return replace(
            self,
            base=self.base.take(rows),
            job=tuple(self.job[i] for i in rows.tolist()),
            rates=rates,
            derived={},
            numbers=numbers,
            covariates={name: values[rows] for name, values in self.covariates.items()},
            rivals=None if self.rivals is None else self.rivals.take(rows),
            partners=None if self.partners is None else self.partners.take(rows),
            wider=None,
            **columns,
        )


_NUMBER = "number "
_LED = 6  # joint moves that an axis leads
_COLUMNS = (
    *("move", "measured", "simulated", "moving", "joint", "start", "end", "turn", "stop_start", "stop_end"),
    *("blend", "blend_start", "corner", "payload", "payload_inertia", "t_start", "cycle", "line", "repeats"),
    *("place", "sim_payload", "sim_payload_inertia", "override", "leader"),
)
_KEPT = 1024  # fits that a case keeps
_FOLDS = 64  # sets of rows that a case keeps
_COPIES = 16  # sizes of repeated moves that a case keeps


class _RepeatedRates(Rates):
    """Of moves several times over; a column is repeated when it is asked for."""

    origin: Rates
    count: int
    rows: int

    def __init__(self, origin: Rates, count: int, rows: int) -> None:
        for name, value in (("origin", origin), ("count", count), ("rows", rows)):
            object.__setattr__(self, name, value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = getattr(self.origin, name)
        if name in ("path", "known", "bodies", "lifts", "climb"):
            value = _repeated(value, self.count, self.rows)
        object.__setattr__(self, name, value)
        return value


class RepeatedMoves(MeasuredMoves):
    """Moves several times over. A column is repeated when it is asked for: few are."""

    origin: MeasuredMoves
    count: int

    def __init__(self, origin: MeasuredMoves, count: int) -> None:
        own = {
            "origin": origin,
            "count": count,
            "derived": {},
            "acted": {},
            "copies": {},
            "folds": {},
            "fits": {},
        }
        for name, value in own.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "numbers", _NumbersOf(origin))

    def __getattr__(self, name: str) -> Any:
        """A field that was not asked for before."""
        if name.startswith("__"):
            raise AttributeError(name)
        value = _repeated(getattr(self.origin, name), self.count, len(self.origin))
        object.__setattr__(self, name, value)
        return value

    def __len__(self) -> int:
        return len(self.origin) * self.count

    def led(self, axis: int) -> Mask:
        return np.tile(self.origin.led(axis), self.count)

    @property
    def bodies_known(self) -> bool:
        return self.origin.bodies_known

    def once(self, name: str, make: Callable[[], Floats]) -> Floats:
        """Rows that were worked out for the moves themselves are repeated."""
        if name not in self.derived:
            known = self.origin.derived.get(name)
            rows = known is not None and len(known) == len(self.origin) > _LAYERS
            self.derived[name] = _repeated(known, self.count, len(self.origin)) if rows else make()
        return self.derived[name]


_LAYERS = 3  # that a derived array may have instead of rows: more rows are taken for moves


def _repeated(value: Any, count: int, rows: int) -> Any:
    """A field of `rows` moves for `count` times as many; what has no rows stays as it is."""
    if isinstance(value, np.ndarray):
        return np.tile(value, (count, *(1,) * (value.ndim - 1))) if len(value) == rows else value
    if isinstance(value, tuple) and type(value) is tuple:
        return value * count
    if isinstance(value, Rivals):
        steps, (places, of) = np.arange(count)[:, None], value.together
        each = (places[:, None] + len(value.of) * steps).reshape(len(places), -1)
        return Rivals(
            value.moves.repeated(count),
            (value.of + rows * steps).ravel(),
            (each, (of + rows * steps).ravel()),
        )
    if isinstance(value, Rates):
        return _RepeatedRates(value, count, rows)
    if isinstance(value, Mapping):
        return {name: _repeated(column, count, rows) for name, column in value.items()}
    return value.repeated(count) if hasattr(value, "repeated") else value
