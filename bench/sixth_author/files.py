"""Recorders, and what is written of a case: the recording in one of many dresses, and its truth."""

import csv
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench.sixth_author.arm import RedrawError
from bench.sixth_author.effects import Cell, Hidden
from bench.sixth_author.programs import Move, Rng

_NEED_JOINTS = {"joint-acceleration-limit", "joint-speed-limit", "torque-speed", "payload-inertia"}
Columns = dict[str, list[Any]]


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


@dataclass(frozen=True)
class Effect:
    """A hidden cause, and what it adds to each move, seconds (n,)."""

    term: str
    hidden: Hidden
    condition: str | None
    seconds: np.ndarray


@dataclass
class Case:
    """A case before it is recorded; n moves."""

    family: str
    cell: Cell
    real: np.ndarray  # (n,) true durations [s]
    simulated: np.ndarray  # (n,) [s]
    effects: list[Effect]
    noise: float  # of the recorder [s]
    note: str = ""
    alike: list[list[str]] = field(default_factory=list)  # a hidden term and what it may be called as well
    tolerated: list[str] = field(default_factory=list)  # terms that are no mistake
    columns: dict[str, np.ndarray] = field(default_factory=dict)  # that show a law of no list
    acceleration: float | None = None  # a tuned one, of the simulation [mm/s^2]
    tuning: np.ndarray | None = None  # (n,) what that takes off each move [s]
    fudge: dict[str, float] | None = None
    shows: str = ""  # the column that a condition is of

    @property
    def terms(self) -> set[str]:
        """What is hidden, of the list; a wrong clock is the recorder's."""
        return {effect.term for effect in self.effects}


@dataclass(frozen=True)
class Recorded:
    """Durations (n,) [s] as they stand in the file, and how they came there."""

    seconds: np.ndarray
    resolution: float | None  # [s]
    kind: str
    outliers: list[int]
    decimals: int


def record(rng: Rng, case: Case, real: np.ndarray) -> Recorded:
    """Records true durations (n,) [s]."""
    kinds = ["white", "quant", "stamps", "two-digit", "heavy"]
    kind = str(rng.choice(kinds, p=[0.3, 0.25, 0.15, 0.15, 0.15]))
    if "cycle-quantisation" in case.terms:
        kind = str(rng.choice(["white", "stamps", "heavy"]))
    resolution = None
    if kind in ("quant", "two-digit"):
        resolution = _resolution(rng, kind, case.noise)
        if resolution is None:
            kind = "white"
        elif kind == "two-digit" and resolution != 0.010:
            kind = "quant"
    seconds = _noisy(rng, kind, real, case.noise, resolution)
    outliers: list[int] = []
    if rng.random() < 0.12 and case.family != "nothing" and len(real) > 40:
        outliers = sorted(rng.choice(len(real), max(1, len(real) // 90), replace=False).tolist())
        signs = rng.choice([-1, 1], len(outliers))
        seconds[outliers] += signs * rng.uniform(8, 20, len(outliers)) * case.noise
        seconds = np.maximum(seconds, 0.3 * real)
    seconds = np.maximum(seconds, 0.002)
    if kind == "two-digit":
        decimals = 2
    else:
        decimals = 3 if resolution else int(rng.choice([4, 5]))
    return Recorded(np.round(seconds, decimals), resolution, kind, outliers, decimals)


def _resolution(rng: Rng, kind: str, noise: float) -> float | None:
    """A step [s] whose rounding is no more than the noise."""
    steps = [step for step in (0.001, 0.004, 0.010, 0.012) if step / math.sqrt(12) <= noise * 1.02]
    if kind == "two-digit" and 0.010 / math.sqrt(12) <= noise:
        return 0.010
    if not steps:
        return None
    return float(steps[-1] if rng.random() < 0.7 else rng.choice(steps))


def _noisy(rng: Rng, kind: str, real: np.ndarray, noise: float, resolution: float | None) -> np.ndarray:
    """Durations (n,) [s] with the noise of a recorder."""
    count = len(real)
    if resolution:
        white = math.sqrt(max(noise**2 - resolution * resolution / 12, 0))
        return np.round((real + rng.normal(0, 1, count) * white) / resolution) * resolution
    if kind == "stamps":
        stamps = np.r_[0, np.cumsum(real)] + rng.normal(0, noise / math.sqrt(2), count + 1)
        return np.diff(stamps)
    if kind == "heavy":
        return real + rng.standard_t(3, count) * noise / math.sqrt(3)
    return real + rng.normal(0, 1, count) * noise


def write_case(rng: Rng, folder: Path, name: str, case: Case) -> None:
    """Writes FOLDER/cases/NAME with the recording and FOLDER/truth/NAME.json."""
    count, repeated = len(case.real), list[int]()
    if rng.random() < 0.2 and case.family != "two":
        repeated = sorted(rng.choice(count, rng.integers(2, 6), replace=False).tolist())
    order = np.repeat(np.arange(count), 1 + np.isin(np.arange(count), repeated))
    real, simulated = case.real[order], case.simulated[order]
    recorded = record(rng, case, real)
    if not np.all(np.isfinite(recorded.seconds)) or recorded.seconds.min() <= 0:
        raise RedrawError("bad duration")
    table = _Table(rng, case, order)
    columns = table.columns(real, simulated, recorded)
    path = folder / "cases" / name
    path.mkdir(parents=True, exist_ok=True)
    with (path / "moves.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    (path / "recording.toml").write_text(_head(rng, recorded))
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    truth = _truth(case, order, recorded, len(repeated))
    (folder / "truth" / f"{name}.json").write_text(json.dumps(truth, indent=1))


def _head(rng: Rng, recorded: Recorded) -> str:
    head = f'controller = "cell {"ABCDE"[rng.integers(5)]}"\n'
    if recorded.resolution:
        head += f"time_resolution_s = {recorded.resolution:g}\n"
    elif rng.random() < 0.5:
        head += f"time_resolution_s = {10.0**-recorded.decimals:g}\n"
    return head


class _Table:
    """The columns of a recording, in their order; what no cause needs may be missing."""

    def __init__(self, rng: Rng, case: Case, order: np.ndarray) -> None:
        self.rng, self.case, self.order = rng, case, order
        self.moves = case.cell.moves
        self.kinds = {move.kind for move in self.moves}
        self.found: Columns = {}

    def columns(self, real: np.ndarray, simulated: np.ndarray, recorded: Recorded) -> Columns:
        """All columns; durations (n,) [s]."""
        rounded = np.round(simulated, 5 if self.rng.random() < 0.5 else 4)
        digits = 5 if rounded[0] != round(rounded[0], 4) else 4
        begin = self._begin(real)
        self.found = {
            "move": list(range(len(real))),
            "duration_s": [f"{x:.{recorded.decimals}f}" for x in recorded.seconds],
            "sim_s": [f"{x:.{digits}f}" for x in rounded],
        }
        self._places()
        self._orders()
        self._loads()
        self._times(begin)
        self._surroundings(len(real))
        return self.found

    def _begin(self, real: np.ndarray) -> np.ndarray:
        """Clock times (n,) [s] at which moves begin; some wait before."""
        rng, gap = self.rng, np.zeros(len(real))
        if rng.random() < 0.4 and "warm-up" not in self.case.terms:
            gap = np.where(rng.random(len(real)) < 0.05, rng.uniform(0.5, 4, len(real)), 0)
        ends = np.r_[0, np.cumsum(real + gap)[:-1]]
        return np.asarray(ends * (1 + rng.normal(0, 3e-5)) + rng.uniform(0, 50))

    def _put(self, name: str, value: Callable[[Move], float | None], form: str) -> None:
        """A column of the program; a cell is empty where a move has no such number."""
        values = [value(self.moves[k]) for k in self.order]
        self.found[name] = ["" if x is None or math.isnan(x) else form % x for x in values]

    def _put_ends(self, name: str, field_name: str, scale: Callable[[float], float], form: str) -> None:
        """Columns of a vector at the start and the end: `name` has a place for its axis' name and the word."""
        for word in ("start", "end"):
            size = len(getattr(self.moves[0], f"{field_name}{word}"))
            for i in range(size):
                axis = "xyz"[i] if size == 3 else str(i + 1)

                def value(move: Move, vector: str = f"{field_name}{word}", i: int = i) -> float:
                    return scale(float(getattr(move, vector)[i]))

                self._put(name.format(axis, word), value, form)

    def _places(self) -> None:
        """Kinds of moves, points, orientations, joints."""
        rng, cell = self.rng, self.case.cell
        if self.kinds != {"linear"} or rng.random() < 0.8:
            self.found["type"] = [self.moves[k].kind for k in self.order]
        joints = (
            cell.by_joints
            or bool(_NEED_JOINTS & self.case.terms)
            or "joint" in self.kinds
            or "dress pack" in self.case.note
            or (rng.random() < 0.35 and not cell.gantry)
        )
        if not cell.by_joints or rng.random() < 0.3:
            self._put_ends("{}_{}_mm", "", float, "%.2f")
            if len({tuple(np.round(move.turn_end, 3)) for move in self.moves}) > 1:
                self._put_ends("r{}_{}_deg", "turn_", float, "%.3f")
            elif rng.random() < 0.5:
                for i, axis in enumerate("xyz"):
                    self._put(f"r{axis}_deg", lambda move, i=i: float(move.turn_start[i]), "%.1f")
        if "circular" in self.kinds:
            for i, axis in enumerate("xyz"):
                self._put(
                    f"{axis}_via_mm", lambda move, i=i: None if move.via is None else move.via[i], "%.2f"
                )
        if joints:
            self._put_ends("q{}_{}_deg", "joints_", np.degrees, "%.3f")

    def _orders(self) -> None:
        """Speeds, accelerations, corners."""
        case, along = self.case, self.kinds != {"joint"}
        if along:
            self._put("speed_mm_s", lambda move: None if move.kind == "joint" else move.speed, "%g")
        if "joint" in self.kinds:
            self._put("speed_pct", _written_percent, "%.4g")
        if along and not case.cell.gantry and (case.family == "fudged" or self.rng.random() < 0.7):
            told = case.acceleration or case.cell.base.acceleration
            self._put("accel_mm_s2", lambda move: None if move.kind == "joint" else told, "%.1f")
        if case.cell.rounded:
            self._put("blend_mm", lambda move: move.blend, "%g")

    def _loads(self) -> None:
        rng, terms = self.rng, self.case.terms
        shown = "payload" in terms or self.case.shows == "payload"
        if len({move.payload for move in self.moves}) > 1 and (shown or rng.random() < 0.7):
            self._put("payload_kg", lambda move: move.payload, "%g")
            if "payload" in terms and rng.random() < 0.3:
                self.found["sim_payload_kg"] = ["0"] * len(self.order)
        inertias = {move.inertia for move in self.moves}
        if len(inertias) > 1 and ("payload-inertia" in terms or rng.random() < 0.5):
            self._put("payload_inertia_kg_m2", lambda move: move.inertia, "%g")

    def _times(self, begin: np.ndarray) -> None:
        """Clock, cycles, lines of the program."""
        case, rng = self.case, self.rng
        shown = {"warm-up", "clock"} & case.terms or "spool" in case.note or "counterweight" in case.note
        if shown or rng.random() < 0.65:
            self.found["t_start_s"] = [f"{x:.3f}" for x in begin]
        if len({move.cycle for move in self.moves}) > 1 and rng.random() < 0.6:
            self._put("cycle", lambda move: move.cycle, "%d")
        waits = [str(e.hidden.sizes["where"]) for e in case.effects if e.term == "external-wait"]
        if case.shows == "job" or (waits and "line" in waits[0]) or rng.random() < 0.45:
            self.found["job"] = [self.moves[k].job for k in self.order]
            self._put("line", lambda move: move.line + 1, "%d")

    def _surroundings(self, count: int) -> None:
        """Temperatures and voltages, which mean nothing in most cases."""
        rng = self.rng
        for name, values in self.case.columns.items():
            self.found[name] = [f"{x:g}" for x in values[self.order]]
        if "temperature_c" not in self.found and rng.random() < 0.2:
            self.found["temperature_c"] = [f"{x:.1f}" for x in 24 + np.cumsum(rng.normal(0, 0.08, count))]
        if rng.random() < 0.15:
            self.found["supply_v"] = [f"{x:.1f}" for x in 400 + rng.normal(0, 2, count)]


def _written_percent(move: Move) -> float | None:
    """Speed of a joint move as the program says it, percent of rated."""
    if move.kind != "joint":
        return None
    return min(move.speed / 15.0, 100.0) if move.percent is None else move.percent


def _truth(case: Case, order: np.ndarray, recorded: Recorded, repeats: int) -> dict[str, object]:
    """What is sealed, in the form that `bench.third_author.scoring` judges by."""
    real, simulated = case.real[order], case.simulated[order]
    good = np.ones(len(real), bool)
    good[recorded.outliers] = False
    noise = rms((recorded.seconds - real)[good])
    late = any(recorded.seconds[k] > real[k] for k in recorded.outliers)
    tolerated = sorted({*case.tolerated, *(["external-wait"] if late else [])})
    hidden = [effect.term for effect in case.effects]
    off = recorded.seconds - simulated
    return {
        "family": case.family,
        "effects": [_effect_truth(effect, effect.seconds[order], noise) for effect in case.effects],
        "condition": next((effect.condition for effect in case.effects), None),
        "optional": [term for term in tolerated if term not in hidden],
        "equivalents": {term: _equivalents(term, case.alike) for term in hidden},
        "alike": case.alike, "tolerated": tolerated,
        "noise_s": round(noise, 6), "rmse_s": round(rms(off), 6), "bias_s": round(float(off.mean()), 6),
        "fudge": case.fudge, "program": case.cell.program, "machine": "gantry" if case.cell.gantry else "arm",
        "law": case.cell.base.law, "recorder": recorded.kind, "outliers": recorded.outliers,
        "repeats": repeats, "n": len(real), "note": case.note,
    }  # fmt: skip


def _equivalents(term: str, alike: list[list[str]]) -> list[str]:
    """What a hidden term may be called as well."""
    return sorted({name for pair in alike if term in pair for name in pair} - {term})


def _effect_truth(effect: Effect, seconds: np.ndarray, noise: float) -> dict[str, object]:
    """A cause: `numbers` are judged, `sizes` are told; the moves are those in which it acts."""
    size = np.abs(seconds)
    acts = np.flatnonzero(size > max(0.7 * noise, 0.1 * size.max()))
    return {
        "term": effect.term,
        "numbers": effect.hidden.told,
        "sizes": effect.hidden.sizes,
        "condition": effect.condition,
        "moves": acts.tolist(),
        "rms_s": round(rms(seconds), 6),
        "mean_s": round(float(seconds.mean()), 6),
    }
