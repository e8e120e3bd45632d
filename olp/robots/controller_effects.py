"""Controller effects: interpolation cycle, dispatch time, servo lag, override.

A table per controller generation holds the known values with their sources. Everything else is zero.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

from olp.core.diagnostic import OlpError, error
from olp.core.units import percent

if TYPE_CHECKING:
    from olp.robots.model import Robot

HIGHEST_OVERRIDE: Final = 1.5  # [1] Yaskawa's playback speed override ends at 150 %


@dataclass(frozen=True, slots=True)
class Effects:
    """Effects that add to the motion; every default but the settling time is "no effect".

    `cycle` [s]: interpolation cycle; the motion from stop to stop lasts whole cycles (0: not counted). `dispatch`
    [s]: per instruction that begins at a standstill; during a move the next one is prepared ahead. `settling` [s]:
    per exact stop (None: the robot's, else the controller generation's, else zero and reported). `servo_lag` [s]:
    time constant of the servos, by which the arm trails its command and every stop comes later. `override` [1]:
    factor on programmed speeds.
    """

    cycle: float = 0.0
    dispatch: float = 0.0
    settling: float | None = None
    servo_lag: float = 0.0
    override: float = 1.0

    @property
    def told(self) -> list[str]:
        """The settings that differ from the defaults, as sentences; results that depend on them report these."""
        words = []
        if self.override != 1.0:
            words.append(f"speed override {self.override / percent:g} %")
        if self.cycle:
            words.append(f"the motion between stops takes whole cycles of {self.cycle:g} s")
        if self.dispatch:
            words.append(f"an instruction at a standstill takes {self.dispatch:g} s to begin")
        if self.servo_lag:
            words.append(f"the servos trail by {self.servo_lag:g} s at every stop")
        return words

    @property
    def not_counted(self) -> str:
        """Sentence on the effects that count as zero ("" for none); shown where a user asks why a line takes its
        time.
        """
        names = [
            words
            for value, words in (
                (self.cycle, "interpolation cycle (cycle_s)"),
                (self.dispatch, "dispatch time (dispatch_s)"),
                (self.servo_lag, "servo lag (servo_lag_s)"),
            )
            if not value
        ]
        return f"not counted, as olp.toml does not set them: {', '.join(names)}" if names else ""


class KnownEffect(NamedTuple):
    """A measured or published number [s] of a controller generation."""

    value: float
    source: str


@dataclass(frozen=True, slots=True)
class Generation:
    """Known effects of one controller generation; None where unpublished."""

    cycle: KnownEffect | None = None
    dispatch: KnownEffect | None = None
    settling: KnownEffect | None = None
    servo_lag: KnownEffect | None = None
    percent_exponent: KnownEffect | None = (
        None  # [1] what a programmed share of speed does to ramps, olp/timing/arm.py
    )
    override_exponent: KnownEffect | None = None  # [1] what the program override does to them, the same page
    joint_acceleration: KnownEffect | None = None  # [rad/s²] of joint moves that do not say theirs
    linear_acceleration: KnownEffect | None = None  # [m/s²] of lines and arcs that do not say theirs
    joint_stop: KnownEffect | None = None  # [s] of a joint move from rest to rest beyond its profile


_OWN_PERCENT = KnownEffect(0.0, "the percent of acceleration is a setting of its own, beside that of speed")
_KRC_STOP = KnownEffect(
    0.03, "recordings of a KR 3 on KSS 8.5: planned time in whole cycles of 12 ms, and two cycles more"
)
_KRC = Generation(
    percent_exponent=_OWN_PERCENT,
    override_exponent=KnownEffect(
        2.0, "recordings of a KR 3 on KSS 8.5: planned motions are stretched in time by the program override"
    ),
    linear_acceleration=KnownEffect(2.3, "DEF_ACC_CP of controllers as delivered"),
    settling=_KRC_STOP,
    joint_stop=_KRC_STOP,
)
_POLYSCOPE = Generation(
    percent_exponent=_OWN_PERCENT,
    override_exponent=KnownEffect(2.0, "URScript manual: the speed slider scales the time of the trajectory"),
    joint_acceleration=KnownEffect(1.4, "URScript manual: default of movej"),
    linear_acceleration=KnownEffect(1.2, "URScript manual: default of movel"),
)
_RRS = KnownEffect(0.004, "step of Yaskawa's server for realistic robot simulation")
_NOT_KNOWN = Generation(cycle=_RRS)

# Only `settling` is used unasked. The cycle is for those who set `cycle_s`: nobody has shown that the program's time
# is a multiple of it.
GENERATIONS: Final[Mapping[str, Generation]] = MappingProxyType(
    {
        "ERC": Generation(),
        "MRC": Generation(),
        "XRC": Generation(),
        "NX100": _NOT_KNOWN,
        "DX100": _NOT_KNOWN,
        "DX200": Generation(
            cycle=_RRS,
            settling=KnownEffect(
                0.166,
                "published recordings of an MA2010 at 10 mm/s, from rest to rest: 0.1655 s per exact stop",
            ),
        ),
        "FS100": _NOT_KNOWN,
        "YRC1000": _NOT_KNOWN,
        "YRC1000micro": _NOT_KNOWN,
        "KR C2": _KRC,
        "KR C4": _KRC,
        "KR C4 compact": _KRC,
        "KR C5": _KRC,
        "CB3": _POLYSCOPE,
        "e-Series": _POLYSCOPE,
    }
)

# Keys of [motion] in olp.toml, the field of Effects each sets, and the SI value of 1 in it.
SETTINGS: Final[Mapping[str, tuple[str, float]]] = MappingProxyType(
    {
        "cycle_s": ("cycle", 1.0),
        "dispatch_s": ("dispatch", 1.0),
        "settling_s": ("settling", 1.0),
        "servo_lag_s": ("servo_lag", 1.0),
        "override_pct": ("override", percent),
    }
)


def effects_of(settings: Mapping[str, str | float], override: float | None = None) -> Effects:
    """The effects that [motion] of an olp.toml sets; `override` [1] takes precedence over the file's.

    Raises OlpError (T006) for an override that no controller has.
    """
    given = {name: float(settings[key]) * unit for key, (name, unit) in SETTINGS.items() if key in settings}
    effects = replace(Effects(), **given)
    if override is not None:
        effects = replace(effects, override=override)
    if not 0.0 < effects.override <= HIGHEST_OVERRIDE:
        says = f"a speed override of {effects.override / percent:g} % is not possible"
        raise OlpError(error("T006", says, help=f"above 0, at most {HIGHEST_OVERRIDE / percent:g} %"))
    return effects


def generations_in(text: str) -> tuple[str, ...]:
    """The controller generations that a text names ("KR C4, KSS 8.5"); of overlapping names the longest."""
    found = [name for name in GENERATIONS if name.lower() in text.lower()]
    return tuple(name for name in found if not any(name != other and name in other for other in found))


def generation_of(controllers: Iterable[str]) -> Generation:
    """The values that all known generations among these names share; empty where none is known."""
    known = [GENERATIONS[name] for name in controllers if name in GENERATIONS]
    if not known:
        return Generation()
    agreed = {
        field.name: getattr(known[0], field.name)
        for field in fields(Generation)
        if all(getattr(other, field.name) == getattr(known[0], field.name) for other in known)
    }
    return Generation(**agreed)


def settling_of(effects: Effects, robot: Robot | None) -> tuple[float, str]:
    """Time [s] per exact stop, and the assumption behind it as a sentence ("": none)."""
    if effects.settling is not None:
        return effects.settling, ""
    if robot is not None and robot.settling_time is not None:
        return robot.settling_time, ""
    known = {
        GENERATIONS[name].settling for name in (robot.controllers if robot else ()) if name in GENERATIONS
    }
    if len(known) == 1 and (settling := known.pop()) is not None:
        return settling.value, f"an exact stop settles for {settling.value:g} s ({settling.source})"
    return 0.0, "the settling time of an exact stop is not known: taken as 0 s"
