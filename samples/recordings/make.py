"""Writes the synthetic log of dx200/: the job's own track, with noise, lost samples and a clock of its own.

And trace/: what a controller's oscilloscope would have saved of three motions that are made up.

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


CYCLE = 0.012  # [s] of the interpolation
MOTIONS = (  # type, line, first and last cycle, axes at the end [deg], speed
    (
        "PTP",
        12,
        2,
        27,
        (20.5, -80.25, 95.75, 3.5, 40.25, -12.5),
        "a1 60.0, a2 60.0, a3 60.0, a4 60.0, a5 60.0, a6 60.0",
    ),
    ("LIN", 13, 32, 61, (26.25, -74.5, 90.5, 4.75, 38.0, -15.25), "cp 350.0, ori1 200.0, ori2 200.0"),
    ("LIN", 15, 66, 83, (20.5, -80.25, 95.75, 3.5, 40.25, -12.5), "cp 700.0, ori1 200.0, ori2 200.0"),
)
CHANNELS = ("X_Act", "Y_Act", "Z_Act", "A_Act", "B_Act", "C_Act", *(f"AxisPos_Act{n}" for n in range(1, 7)))


def trace() -> None:
    """Writes trace/: the motions, the header of the samples, and the samples."""
    axes = np.tile(np.array([0.0, -90.0, 100.0, 0.0, 30.0, 0.0]), (90, 1))
    for _, _, first, last, end, _ in MOTIONS:
        share = np.clip((np.arange(90) - first) / (last - first), 0, 1)[:, None]
        smooth = share**3 * (10 - 15 * share + 6 * share**2)
        axes = np.where(
            np.arange(90)[:, None] >= first, axes[first] + smooth * (np.array(end) - axes[first]), axes
        )
    place = np.zeros((90, 6))
    place[:, :3] = np.array([400.0, 0.0, 500.0]) + 2.5 * (axes[:, :3] - axes[0, :3])
    place[:, 3:] = np.deg2rad(0.5 * axes[:, 3:])
    rows = np.hstack([place, np.deg2rad(axes)])
    folder = HERE / "trace"
    folder.mkdir(exist_ok=True)
    rows.astype("<f8").tofile(folder / "PALLET_KRCIpo.r64")
    head = 'DIAEXTENDED\r\n\r\n#BEGINGLOBALHEADER\r\n102,rob "#KR3R540 C4SR"\r\n#ENDGLOBALHEADER\r\n\r\n'
    parts = [f"200,Zeit\r\n202,sec\r\n210,IMPLIZIT  \r\n220,{len(rows)}\r\n240,0.00000\r\n241,{CYCLE:.8e}"]
    for place_, name in enumerate(CHANNELS):
        unit, factor = ("mm", 1.0) if place_ < 3 else ("\xb0", 1 / deg)
        parts.append(
            f"200,{name}\r\n202,{unit}\r\n210,EXPLIZIT\r\n211,PALLET_KRCIpo.r64\r\n213,BLOCK\r\n214,REAL64\r\n"
            f"220,{len(rows)}\r\n221,{place_ + 1}\r\n240,0\r\n241,{factor:.8e}"
        )
    text = head + "".join(f"#BEGINCHANNELHEADER\r\n{p}\r\n#ENDCHANNELHEADER\r\n\r\n" for p in parts)
    (folder / "PALLET_KRCIpo.dat").write_bytes(text.encode("latin-1"))
    said = "#BEGINHEADER\r\nROBOT TYPE: #KR3R540 C4SR\r\nTRACEHELPER NAME: KRCIpo\r\n#ENDHEADER\r\n\r\n"
    for kind, line, first, last, _, speed in MOTIONS:
        rate = (
            "cp 2300.0, ori1 100.0, ori2 100.0"
            if kind == "LIN"
            else ", ".join(f"a{n} 100.0" for n in range(1, 7))
        )
        for signal, cycle in (("START", first), ("END", last)):
            said += (
                f"#BEGINMOTIONINFO\r\nTIME: {cycle * CYCLE:.6f}\r\nMODULE: PALLET\r\nTYPE: {kind}\r\n"
                f"SIGNAL: {signal}\r\nLINE: {line}\r\nBLENDING: NONE\r\nVELOCITIES: {{ {speed} }}\r\n"
                f"ACCELERATIONS: {{ {rate} }}\r\nBASE: {{ x 0.0, y 0.0, z 0.0, a 0.0, b 0.0, c 0.0 }}\r\n"
                "TOOL: { x 10.5, y -20.25, z 110.0, a 0.0, b -60.0, c 2.5 }\r\n"
                "LOAD: { m 1.250000, cm { x 0.0, y 0.0, z 50.0, a 0.0, b 0.0, c 0.0 }, "
                "j { x 0.003000, y 0.002000, z 0.001000 } }\r\n#ENDMOTIONINFO\r\n\r\n"
            )
    (folder / "PALLET_PROG.TXT").write_bytes(said.encode("ascii"))


if __name__ == "__main__":
    main()
    trace()
