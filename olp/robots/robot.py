"""Everything about robots that other modules need: the types, the reader, and the library of robot files.

The library: names of the robots that ship with olp, one by name or path, those whose limits fit given pulses.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.robots.model import Axis, Body, Drive, Dynamics, Geometry, Joint, Links, PulseFit, Robot
from olp.robots.reader import read_robot

_FOLDER = Path(__file__).parent

# Soft limits are set in whole pulses and a taught point may stand on one: 0.1 deg of slack per axis.
_LIMIT_SLACK = 0.00175  # [rad | m]


@cache
def robot_names() -> tuple[str, ...]:
    """All library names, "maker/model", sorted."""
    return tuple(sorted(f"{path.parent.name}/{path.stem}" for path in _FOLDER.glob("*/*.toml")))


def library_name(called: str) -> str:
    """The library's name of what a controller calls its robot: the longest one that begins it, letters and digits."""
    said = re.sub(r"[^a-z0-9]", "", called.lower())
    models = {name: re.sub(r"[^a-z0-9]", "", name.partition("/")[2]) for name in robot_names()}
    fitting = [name for name, model in models.items() if model and said.startswith(model)]
    return max(fitting, key=lambda name: len(models[name]), default="")


def load_robot(name_or_path: str | Path) -> Robot:
    """The robot of that library name ("yaskawa/gp25", or "gp25" when only one maker has it) or file.

    Raises OlpError: R001 no such robot or file, R002 to R006 the file's problems, all at once.

    Example:
        >>> import olp
        >>> olp.load_robot("yaskawa/gp25")
        <Robot yaskawa/gp25: arm, axes S L U R B T>
    """
    text = str(name_or_path)
    if text.lower().endswith(".toml") or isinstance(name_or_path, Path):
        return read_robot(Path(name_or_path))
    return _library_robot(_full_name(text))


def candidates_for_pulses(min_pulses: Sequence[float], max_pulses: Sequence[float]) -> list[PulseFit]:
    """Library robots that could have been at all of the pulses, those that use most of their range first.

    `min_pulses` and `max_pulses` hold the smallest and largest pulse of each axis of one control group.
    """
    low, high = np.asarray(min_pulses, dtype=np.float64), np.asarray(max_pulses, dtype=np.float64)
    fits = []
    for name in _with_pulses():
        robot = _library_robot(name)
        if len(robot.axes) != len(low) or not robot.knows_pulses:
            continue
        start, end = low / robot.pulses_per_unit, high / robot.pulses_per_unit
        if np.all(start >= robot.lower - _LIMIT_SLACK) and np.all(end <= robot.upper + _LIMIT_SLACK):
            used = float(np.mean((end - start) / (robot.upper - robot.lower)))
            fits.append(PulseFit(robot, used))
    return sorted(fits, key=lambda fit: (-fit.used, fit.robot.name))


@cache
def _with_pulses() -> tuple[str, ...]:
    """Names of the robots whose files state pulses: reading all of them would cost a small job more than its run."""
    return tuple(name for name in robot_names() if b"pulses_per_" in (_FOLDER / f"{name}.toml").read_bytes())


@lru_cache(maxsize=256)
def _library_robot(name: str) -> Robot:
    return read_robot(_FOLDER / f"{name}.toml", name)


def _full_name(text: str) -> str:
    wanted = text.strip().lower()
    names = robot_names()
    if wanted in names:
        return wanted
    same_model = [name for name in names if name.split("/")[1] == wanted]
    if len(same_model) == 1:
        return same_model[0]
    raise OlpError(_unknown(text, wanted, names))


def _unknown(text: str, wanted: str, names: Sequence[str]) -> Diagnostic:
    maker, _, model = wanted.rpartition("/")
    known = [name for name in names if name.startswith(f"{maker}/")]
    close = [] if maker and not known else _alike(model, known or names)
    if close:
        advice = f"did you mean {', '.join(close)}? "
    elif known:
        advice = f"known of {maker}: {', '.join(known)}; "
    else:
        advice = (
            f"no robot of {maker} is known yet, but you can describe any (docs/robots.md); " if maker else ""
        )
        advice += f"known makers: {', '.join(sorted({name.split('/')[0] for name in names}))}; "
    return error(
        "R001",
        f"no robot is called {text!r}",
        help=f"{advice}olp robots lists all; a file of your own is given as a path ending in .toml",
    )


def _alike(model: str, names: Sequence[str]) -> list[str]:
    """Robots of which a model's name is the beginning, else those with a similar one."""
    models = {name.split("/")[1]: name for name in names}
    longer = [name for it, name in models.items() if model and it.startswith(model)]
    return longer[:8] or [models[it] for it in difflib.get_close_matches(model, models, n=3, cutoff=0.5)]


__all__ = [
    "Axis",
    "Body",
    "Drive",
    "Dynamics",
    "Geometry",
    "Joint",
    "Links",
    "PulseFit",
    "Robot",
    "candidates_for_pulses",
    "load_robot",
    "read_robot",
    "robot_names",
]
