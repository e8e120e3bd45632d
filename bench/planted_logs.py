"""Logs with planted effects, by time steps, under three kinds of noise: how often exactly the planted names are told.

    python bench/planted_logs.py [FIRST:END]   seeds, default 2:5
    python bench/planted_logs.py --itself      how many of 20 logs of all kinds agree with their own copy
    python bench/planted_logs.py --intervals   how many 95 % intervals hold what was planted
    python bench/planted_logs.py --speed     CPU seconds of ten minutes at 4 ms, six axes with torques

white: 2e-5 rad. memory: an autoregression of 0.97 of the same size. dirty: that, a third of the white noise, a gear
ripple of 1e-5 rad, a burst, steps of 1.7e-6 rad, time stamps that jitter by 0.3 ms, 2 % of the samples lost, one gap.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from time import process_time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from test_diagnosis_logs import FINE, lagging, loose, program, swinging, torques  # noqa: E402

from olp.identification.diagnosis.logs import LogDiagnosis, diagnose_log  # noqa: E402
from olp.identification.recording import Log  # noqa: E402

Floats = NDArray[np.float64]
NOISES = ("white", "memory", "dirty")
LAG, RING, PLAY, CLOCK = "servo-lag", "joint-compliance", "backlash", "clock"
CASES: dict[str, tuple[tuple[str, ...], set[str]]] = {
    "nothing": ((), set()),
    "lag of 12 to 35 ms": (("lag",), {LAG}),
    "lag of 2 to 4 ms": (("short lag",), {LAG}),
    "one lag of 20 ms for all axes": (("one lag",), {LAG}),
    "oscillation of one axis, 9 Hz": (("ring",), {RING}),
    "play of one axis, 0.4 mrad": (("play",), {PLAY}),
    "channels 3 ms apart": (("late",), {CLOCK}),
    "recorder 20 ms late": (("offset",), {CLOCK}),
    "recorder at 1.0003": (("rate",), {CLOCK}),
    "lag and rate": (("lag", "rate"), {LAG, CLOCK}),
    "lag and 3 ms": (("lag", "late"), {LAG, CLOCK}),
    "lag and oscillation": (("lag", "ring"), {LAG, RING}),
    "lag and play": (("lag", "play"), {LAG, PLAY}),
    "3 ms and play": (("late", "play"), {CLOCK, PLAY}),
    "outside: ripple of 0.2 mrad": (("ripple",), set()),
    "outside: axes push each other": (("push",), set()),
}
CLOCKS_ONLY = ("offset", "rate")  # nothing to be seen against commands of the same log


def changed(ways: Floats, planted: tuple[str, ...]) -> Floats:
    for what in planted:
        if what == "lag":
            ways = lagging(ways, (0.02, 0.035, 0.012))
        elif what == "short lag":
            ways = lagging(ways, (0.003, 0.002, 0.004))
        elif what == "one lag":
            ways = lagging(ways, (0.02, 0.02, 0.02))
        elif what == "ring":
            ways = swinging(ways, 1, 9.0, 0.05)
        elif what == "play":
            ways = loose(ways, 0, 4e-4)
        elif what == "ripple":
            ways = ways + 2e-4 * np.sin(60 * ways)
        elif what == "push":
            rise = np.gradient(np.gradient(ways, FINE, axis=0), FINE, axis=0)
            ways = ways + 1e-4 * np.roll(rise, 1, axis=1)
    return ways


def noise(rng: np.random.Generator, q: Floats, kind: str) -> Floats:
    white = 2e-5 * rng.normal(size=q.shape)
    if kind == "white":
        return white
    memory = np.zeros_like(q)
    for i in range(1, len(q)):
        memory[i] = 0.97 * memory[i - 1] + white[i] * np.sqrt(1 - 0.97**2)
    if kind == "memory":
        return memory
    burst = np.zeros_like(q)
    burst[len(q) // 3 : len(q) // 3 + 20] = 3e-4
    return memory + 6e-6 * rng.normal(size=q.shape) + 1e-5 * np.sin(80 * q) + burst


def logs(seed: int, planted: tuple[str, ...], kind: str, simulated: bool) -> tuple[Log, Log | None]:
    rng = np.random.default_rng(1000 + seed)
    time, ways = program(seed, 12)
    moved = changed(ways, planted)
    at = time[::4]
    keep = np.ones(len(at), dtype=bool)
    if kind == "dirty":
        at = at + rng.uniform(-3e-4, 3e-4, len(at))
        keep = rng.random(len(at)) > 0.02
        keep[2000:2060] = False

    def seen(values: Floats, late: float = 0.0) -> Floats:
        return np.stack([np.interp(at - late, time, column) for column in values.T], axis=1)[keep]

    q = seen(moved, 0.003 if "late" in planted else 0.0)
    q = q + noise(rng, q, kind)
    if kind == "dirty":
        q = np.round(q / 1.7e-6) * 1.7e-6
    stamps = at[keep] * (1.0003 if "rate" in planted else 1.0) + (0.02 if "offset" in planted else 0.0)
    slides = (False,) * q.shape[1]
    if simulated:
        return Log(stamps, q, slides), Log(time[::4], ways[::4], slides)
    return Log(stamps, q, slides, command=seen(ways)), None


def main(seeds: range) -> None:
    print(f"seeds {seeds[0]} to {seeds[-1]}; exact: the planted names and no other\n")
    print(
        f"{'planted':<34}{'against':<12}"
        + "".join(f"{kind:>10}" for kind in NOISES)
        + f"{'CPU s':>8}  verdicts"
    )
    right = asked = false = 0
    for name, (planted, expected) in CASES.items():
        for simulated in (False, True):
            if not simulated and any(what in CLOCKS_ONLY for what in planted):
                continue
            cells, verdicts, began, runs = [], Counter[str](), process_time(), 0
            for kind in NOISES:
                exact = 0
                for seed in seeds:
                    found: LogDiagnosis = diagnose_log(*logs(seed, planted, kind, simulated))
                    told = {finding.term for finding in found.findings}
                    exact += told == expected
                    false += bool(told - expected)
                    verdicts[found.verdict] += 1
                    runs += 1
                cells.append(f"{exact}/{len(seeds)}")
                right, asked = right + exact, asked + len(seeds)
            against = "simulation" if simulated else "command"
            took = (process_time() - began) / runs
            counts = ", ".join(f"{verdict} {count}" for verdict, count in verdicts.items())
            print(
                f"{name:<34}{against:<12}" + "".join(f"{c:>10}" for c in cells) + f"{took:>8.1f}  {counts}",
                flush=True,
            )
    print(f"\nexact {right} of {asked}; with a name that was not planted: {false}")


def itself(count: int = 20) -> None:
    silent = 0
    for seed, (planted, _) in zip(range(700, 700 + count), 2 * list(CASES.values()), strict=False):
        log, _ = logs(seed, planted, NOISES[seed % len(NOISES)], True)
        found = diagnose_log(log, log)
        silent += found.verdict == "no-mismatch" and not found.findings
    print(f"silent {silent} of {count}")


def intervals(seeds: int = 12) -> None:
    held, asked = Counter[str](), Counter[str]()

    def count(found: LogDiagnosis, term: str, truth: dict[str, float]) -> None:
        finding = found.finding(term)
        for name, value in truth.items():
            if finding is not None and name in finding.parameters:
                kind = f"{term}: {name.partition(' of ')[0]}"
                p = finding.parameters[name]
                asked[kind] += 1
                held[kind] += p.low < value < p.high

    lags = {f"time constant of axis {a}": t for a, t in ((1, 0.02), (2, 0.035), (3, 0.012))}
    friction = {0: (25.0, 12.0), 2: (20.0, 10.0)}
    for seed in range(100, 100 + seeds):
        for kind in ("white", "memory"):
            count(diagnose_log(*logs(seed, ("lag",), kind, False)), LAG, lags)
            ring = {"frequency of axis 2": 9.0, "damping of axis 2": 0.05}
            count(diagnose_log(*logs(seed, ("ring",), kind, False)), RING, ring)
            count(diagnose_log(*logs(seed, ("late",), kind, False)), CLOCK, {"q behind q_cmd": 0.003})
        time, ways = program(seed, 18)
        rng = np.random.default_rng(seed)
        log = Log(time[::4], ways[::4] + 1e-6 * rng.normal(size=ways[::4].shape), (False,) * 3)
        found = diagnose_log(replace(log, torque=torques(log, friction, rng)))
        for axis, (viscous, coulomb) in friction.items():
            count(found, "viscous-friction", {f"viscous of axis {axis + 1}": viscous})
            count(found, "coulomb-friction", {f"coulomb of axis {axis + 1}": coulomb})
    for kind, number in asked.items():
        print(f"{kind:<36}{held[kind]:>4} of {number}")
    print(f"together {sum(held.values()) / sum(asked.values()):.1%}")


def speed() -> None:
    time, ways = program(5, 270, 6)
    rng = np.random.default_rng(5)
    at = time[::4] + rng.uniform(-2e-4, 2e-4, len(time[::4]))
    at = at[rng.random(len(at)) > 0.01]
    command = np.stack([np.interp(at, time, column) for column in ways.T], axis=1)
    rise = np.gradient(np.gradient(ways, FINE, axis=0), FINE, axis=0)
    torque = np.stack([np.interp(at, time, column) for column in 50 * rise.T], axis=1)
    q = np.stack([np.interp(at - 0.02, time, column) for column in ways.T], axis=1)
    log = Log(at, q + 2e-5 * rng.normal(size=q.shape), (False,) * 6, command=command, torque=torque)
    began = process_time()
    diagnose_log(log)
    print(f"{len(log)} samples, {at[-1] - at[0]:.0f} s: {process_time() - began:.1f} s CPU against commands")
    began = process_time()
    sim = Log(time[::4], ways[::4], log.slides, torque=50 * rise[::4])
    diagnose_log(Log(log.time, log.q, log.slides, torque=torque), sim)
    print(f"{process_time() - began:.1f} s CPU against a simulated log")


if __name__ == "__main__":
    if sys.argv[1:] == ["--speed"]:
        speed()
    elif sys.argv[1:] == ["--itself"]:
        itself()
    elif sys.argv[1:] == ["--intervals"]:
        intervals()
    else:
        first, _, end = (sys.argv[1] if len(sys.argv) > 1 else "2:5").partition(":")
        main(range(int(first), int(end)))
