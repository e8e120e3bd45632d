"""Numbers of moves that a target cannot take: the nearest one is written, and the receipt says by how much it is off.

The ranges are stated here once more, as the makers' manuals tell them, and looked for in the text that is written.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from test_arm_branch import GP25
from translate_programs import STOP, Maker
from translated_texts import VENDORS

from olp.ir.expressions import FrameRef, Number, Quantity
from olp.ir.program import Acceleration, AccelerationUnit, Blend, BlendKind, Path, Speed, SpeedUnit
from olp.transpile import Context
from olp.transpile.convert import convert

MM, PERCENT, DEG = 0.001, 0.01, math.pi / 180
RANGES = {
    "inform": {
        r" VJ=([\d.]+)": (0.01, 100),
        r" V=([\d.]+)": (0.1, 1500),
        r" VR=([\d.]+)": (0.1, 180),
        r" (?:ACC|DEC)=([\d.]+)": (20, 100),
        r" CR=([\d.]+)": (1, 6553.5),
        r" PL=(\d+)": (0, 8),
    },
    "krl": {
        r"#VEL_PTP,([\d.]+)": (1, 100),
        r"#VEL_CP,([\d.eE-]+)": (0, 3),
        r"\$VEL\.CP=([\d.eE-]+)": (0, 3),
        r"\$VEL\.ORI[12]=([\d.]+)": (0, 400),
        r"\$ACC_AXIS\[\d\]=([\d.]+)": (1, 100),
        r"\$ACC\.CP=([\d.]+)": (0, 10),
        r"\$APO\.C(?:PTP|VEL)=([\d.]+)": (0, 100),
    },
    "rapid": {r"AccSet ([\d.]+),": (20, 100), r"AccSet [\d.]+,([\d.]+)": (10, 100)},
    "tp": {
        r"J P\[\d+\] ([\d.]+)%": (1, 100),
        r" ([\d.]+)mm/sec": (1, 2000),
        r" ([\d.]+)deg/sec": (1, 272),
        r" ([\d.]+)sec": (0.1, 3200),
        r" ([\d.]+)msec": (100, 3200000),
        r" CNT([\d.]+)": (0, 100),
        r" CR([\d.]+)": (0, 1000),
        r" ACC([\d.]+)": (1, 150),
    },
    "urscript": {},
}


def of(value, scale):
    return Quantity(Number(value), scale)


class Extremes(Maker):
    """A program of moves, each far out in one of its numbers."""

    def __init__(self):
        super().__init__(3)

    def program(self):
        program = super().program()
        self.data = [d for d in program.data if d.name in ("tl1", "tl2", "fr1", "fr2")]
        moves = list(self.moved())
        routine = self.routine("MAINJOB", moves, 1)
        return replace(program, routines=(routine,), data=tuple(self.data))

    def moved(self):
        straight = self.move(Path.LINEAR, self.point())
        straight = replace(straight, blend=STOP, speed=Speed(SpeedUnit.TRAVEL, of(250, MM)))
        joint = replace(self.move(Path.JOINT, self.point()), speed=Speed(SpeedUnit.FRACTION, of(40, PERCENT)))

        def at(move, **changes):
            return replace(
                move, targets=(self.point(),), tool=self.tools[0], frame=FrameRef("base"), **changes
            )

        yield at(joint)
        for travel in (0.004, 0.25, 1800, 2500, 8000):
            yield at(straight, speed=Speed(SpeedUnit.TRAVEL, of(travel, MM)))
        for share in (0.002, 0.4, 100):
            yield at(joint, speed=Speed(SpeedUnit.FRACTION, of(share, PERCENT)))
        for seconds in (0.02, 5000):
            yield at(straight, speed=Speed(SpeedUnit.TIME, of(seconds, 1.0)))
            yield at(joint, speed=Speed(SpeedUnit.TIME, of(seconds, 1.0)))
        for share in (0.3, 12, 100, 130, 250):
            yield at(straight, acceleration=of(share, PERCENT))
            yield at(joint, acceleration=of(share, PERCENT), deceleration=of(share / 2, PERCENT))
        for rate in (0.05, 4, 30):
            yield at(straight, rate=Acceleration(AccelerationUnit.TRAVEL, of(rate, 1.0)))
        for radius in (0.3, 40, 1200):
            yield at(straight, blend=Blend(BlendKind.RADIUS, of(radius, MM)))
        for turn in (90, 800):
            yield at(straight, turn=of(turn, DEG))
            yield at(straight, turn=of(turn, DEG), speed=Speed(SpeedUnit.TRAVEL, of(1400, MM)))
        yield at(straight)


def made_for(target):
    source = Extremes().program()
    made = convert(source, target, Context(robot=GP25, on_loss="comment"), date="2026/01/01 00:00")
    return source, made, "".join(data.decode("latin-1") for data in made.files.values())


@pytest.mark.parametrize("target", VENDORS)
def test_every_number_that_is_written_is_one_that_the_controller_takes(target):
    _, _, text = made_for(target)
    found = 0
    for pattern, (low, high) in RANGES[target].items():
        for written in re.findall(pattern, text):
            found += 1
            assert low <= float(written) <= high, (pattern, written)
    assert found >= 10 or target in ("rapid", "urscript")


# Of each target: a number of the program, the part that the receipt names, and by how much it is off.
OFF = {
    "inform": [
        ("speed", "TRAVEL", 2500 * MM, 1000.0),
        ("speed", "TRAVEL", 0.004 * MM, 0.096),
        ("acceleration", "share", 0.12, 8.0),
        ("acceleration", "share", 1.3, 30.0),
        ("blend", "radius", 0.3 * MM, 0.7),
    ],
    "krl": [
        ("speed", "TRAVEL", 8000 * MM, 5000.0),
        ("speed", "FRACTION", 0.004, 0.6),
        ("acceleration", "share", 1.3, 30.0),
        ("acceleration", "rate", 30.0, 20.0),
    ],
    "rapid": [("acceleration", "share", 0.12, 8.0), ("acceleration", "share", 2.5, 150.0)],
    "tp": [
        ("speed", "TRAVEL", 2500 * MM, 500.0),
        ("speed", "TRAVEL", 0.25 * MM, 0.75),
        ("speed", "TIME", 5000.0, 1800.0),
        ("speed", "TIME", 0.02, 0.08),
        ("acceleration", "share", 2.5, 100.0),
        ("blend", "radius", 1200 * MM, 200.0),
    ],
}


def number_of(s, kind):
    if kind == "share":
        return None if s.acceleration is None else s.acceleration.literal
    if kind == "rate":
        return None if s.rate is None else s.rate.value.literal
    if kind == "radius":
        return s.blend.value.literal
    return s.speed.value.literal if s.speed.unit is SpeedUnit[kind] else None


@pytest.mark.parametrize(
    ("target", "case"), [(target, case) for target, cases in OFF.items() for case in cases]
)
def test_the_receipt_names_it_with_its_size(target, case):
    part, kind, value, size = case
    source, made, _ = made_for(target)
    lines = [s.line for s in source.statements() if number_of(s, kind) == pytest.approx(value, rel=1e-9)]
    assert lines
    told = {(loss.line, round(loss.size, 6)) for loss in made.translated.losses if loss.part == part}
    for line in lines:
        assert (line, pytest.approx(size)) in [(at, off) for at, off in told]


def test_a_bound_on_turning_that_kuka_does_not_take_is_lowered_and_named_where_it_slows():
    """RAPID's own speeds bound the turning to 500 deg/s; $VEL_MA.ORI is 400."""
    source, made, text = made_for("krl")
    assert "$VEL.ORI1=400" in text
    told = {loss.line: loss for loss in made.translated.losses if "400 deg/s" in loss.says}
    turning = [s.line for s in source.statements() if s.turn is not None and s.turn.literal > 400 * DEG]
    assert set(told) <= set(turning)
    assert all(loss.unit == "%" and loss.size > 0 for loss in told.values())


@pytest.mark.parametrize("target", VENDORS)
def test_numbers_within_their_ranges_are_written_as_they_are(target):
    made = convert(Maker(5).program(), target, Context(robot=GP25), date="2026/01/01 00:00")
    assert not [loss for loss in made.translated.losses if "can be said" in loss.says]
