"""Writes the synthetic log of dx200/: the job's own track, with noise, lost samples and a clock of its own.

python samples/recordings/make.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent.parent))

from olp.core.units import deg  # noqa: E402
from olp.reports.batch import Job, plan_and_time  # noqa: E402
from olp.timing.track import track  # noqa: E402

JOB = HERE.parent / "inform/generations/dx200.jbi"
PERIOD = 0.012  # [s]
OFFSET, RATE = 5241.7, 1.0003  # of the recorder's clock
NOISE = 1e-5  # [rad] about what an encoder of 19 bits resolves
LOST = 0.02


def main() -> None:
    """Writes dx200/log.csv."""
    rng = np.random.default_rng(26)
    way = track(plan_and_time(str(JOB), Job()), PERIOD)
    rest = round(0.6 / PERIOD)
    time = np.concatenate(
        [-PERIOD * np.arange(rest, 0, -1), way.time, way.time[-1] + PERIOD * np.arange(1, rest)]
    )
    q = np.concatenate([np.repeat(way.axes[:1], rest, 0), way.axes, np.repeat(way.axes[-1:], rest - 1, 0)])
    q = q + NOISE * rng.normal(size=q.shape)
    kept = rng.random(len(time)) >= LOST
    rows = ["t_s," + ",".join(f"q{i}_deg" for i in range(1, 7))]
    for t, axes in zip((OFFSET + RATE * time)[kept].tolist(), (q / deg)[kept].tolist(), strict=True):
        rows.append(f"{t:.4f}," + ",".join(f"{a:.4f}" for a in axes))
    (HERE / "dx200/log.csv").write_text("".join(f"{row}\n" for row in rows), encoding="utf-8")


if __name__ == "__main__":
    main()
