"""What was changed in the document, and how it gets into the program: only those lines of the file are written."""

from __future__ import annotations

import json
import os

from olp_freecad.ask import OlpError, ask
from olp_freecad.places import differ, place_of
from olp_freecad.program import options, refresh


def move_point(program: object, name: str, place: object) -> None:
    """Puts a point of the program at `place` in the robot's base. Raises OlpError for a name that is none."""
    for point in program.Points:
        if point.PointName == name:
            point.Placement = place
            return
    known = ", ".join(one.PointName for one in program.Points) or "none"
    raise OlpError([f"no point {name}; points that can be moved: {known}"])


def set_speed(program: object, line: int, value: float) -> None:
    """The speed of a line, in the unit that the property Line_N names. Raises OlpError for a line without one."""
    name = f"Line_{line}"
    if name not in program.PropertiesList:
        known = ", ".join(json.loads(program.Written)) or "none"
        raise OlpError([f"line {line} has no speed of its own; lines that have one: {known}"])
    setattr(program, name, value)


def pending(program: object) -> dict:
    """The changes that are not in the file yet."""
    points = [
        {"name": one.PointName, "place": place_of(one.Placement)}
        for one in program.Points
        if differ(one.Placement, one.Written)
    ]
    speeds = [
        {"line": int(line), "value": getattr(program, f"Line_{line}"), "scale": one["scale"]}
        for line, one in json.loads(program.Written).items()
        if abs(getattr(program, f"Line_{line}") - one["value"]) > 1e-9 * max(1.0, abs(one["value"]))
    ]
    return {"points": points, "speeds": speeds}


def write_back(program: object, output: str = "") -> list:
    """Writes the program with the pending changes to `output` (empty: over its file), and reads it anew from there.

    Returns (file, line) of all lines that changed. Raises OlpError with all that stands against it; then no file
    and no object has changed. A KUKA list goes beside `output` under its name.
    """
    changes = pending(program)
    if not changes["points"] and not changes["speeds"]:
        return []
    outputs = _outputs(program.File, output) if output else {}
    request = {"do": "edit", "path": program.File, "options": options(program), "outputs": outputs, **changes}
    answer = ask(request)
    if output:
        program.File = output
    refresh(program)
    program.Messages = [*program.Messages, *(f"{one['severity']}: {one['text']}" for one in answer["notes"])]
    return [(outputs.get(file, file), line) for file, line in answer["lines"]]


def _outputs(path: str, output: str) -> dict:
    folder, name = os.path.split(os.path.abspath(output))
    found = {path: os.path.join(folder, name)}
    stem, suffix = os.path.splitext(path)
    if suffix.lower() in (".src", ".sub"):
        for one in os.listdir(os.path.dirname(path) or "."):
            own, kind = os.path.splitext(one)
            if own.lower() == os.path.basename(stem).lower() and kind.lower() == ".dat":
                other = os.path.splitext(name)[0] + kind
                found[os.path.join(os.path.dirname(path), one)] = os.path.join(folder, other)
    return found
