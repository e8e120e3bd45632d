"""A robot program as a group of a FreeCAD document: path, frames, tool, points, table and trajectory."""

from __future__ import annotations

import json
import os

import FreeCAD

from olp_freecad import shapes
from olp_freecad.ask import ask
from olp_freecad.places import placement
from olp_freecad.trajectory import trajectory

COLOURS = ["speed", "time"]
_COLUMNS = {
    "line": "Line",
    "statement": "Statement",
    "distance_mm": "mm",
    "speed_mm_s": "V mm/s",
    "reached_mm_s": "top mm/s",
    "accel_mm_s2": "mm/s²",
    "limited_by": "Limited by",
    "duration_s": "s",
    "end_s": "End s",
}
_MOST_ROWS = 2000  # of the sheet; the table beside the 3D view shows all
_MOST_POINTS = 500  # as objects of their own; a CAM path has 100,000


class OlpProgram:
    """Behaviour of the group. What it knows of the program is kept in its property `Data`, so that it is saved."""

    def __init__(self, obj: object) -> None:
        obj.Proxy = self
        add = obj.addProperty
        add("App::PropertyFile", "File", "Program", "the robot program")
        add("App::PropertyString", "Robot", "Timing", "a robot of `olp robots`, or a robot file")
        add("App::PropertyString", "Model", "Timing", "motion model; empty: olp's usual one")
        add("App::PropertyFile", "Signature", "Timing", "the robot's timing signature, from olp calibrate")
        add("App::PropertyString", "Language", "Program", "the language it is written in")
        for name, says in (
            ("TotalSeconds", "predicted cycle time in s"),
            ("MotionSeconds", "of it motion"),
            ("WaitSeconds", "of it waits"),
            ("SignalSeconds", "of it signals"),
            ("LowSeconds", "with a signature: the lower end of the 95 % interval of the total"),
            ("HighSeconds", "and the upper end"),
        ):
            add("App::PropertyFloat", name, "Timing", says)
        add("App::PropertyEnumeration", "Colour", "View", "what the colour of the path shows")
        add("App::PropertyFloat", "Instant", "View", "the tool stands where it is after so many seconds")
        add("App::PropertyStringList", "Assumptions", "Timing", "what olp took for granted")
        add("App::PropertyStringList", "Messages", "Program", "what olp says of the program")
        add("App::PropertyString", "Data", "Program", "the answer of olp", 4)
        add("App::PropertyString", "Written", "Program", "speeds as they stand in the file", 4)
        for name in ("Path", "Tool", "Sheet", "Trajectory"):
            add("App::PropertyLink", name, "Parts", "")
        for name in ("Points", "Frames"):
            add("App::PropertyLinkList", name, "Parts", "")
        obj.Colour = COLOURS
        for name in (
            "Language",
            "TotalSeconds",
            "MotionSeconds",
            "WaitSeconds",
            "SignalSeconds",
            "LowSeconds",
            "HighSeconds",
        ):
            obj.setEditorMode(name, 1)

    def onChanged(self, obj: object, name: str) -> None:  # noqa: N802
        if name == "Instant" and getattr(obj, "Data", "") and getattr(obj, "Tool", None):
            show_at(obj, obj.Instant)
        elif name == "Colour" and getattr(obj, "Data", "") and getattr(obj, "Path", None):
            shapes.colour_path(obj.Path, json.loads(obj.Data)["segments"], obj.Colour)

    def execute(self, obj: object) -> None:
        """Nothing is computed again by itself: olp is asked by `open` and `refresh`."""

    def __getstate__(self) -> None:
        return None

    def __setstate__(self, state: None) -> None:
        return None

    dumps, loads = __getstate__, __setstate__


def open(path: str, robot: str = "", model: str = "", signature: str = "", document: object = None) -> object:
    """The program in `path` as a group of `document` (None: a new one). Raises OlpError."""
    path = os.path.abspath(path)
    options = {"robot": robot, "model": model, "signature": signature}
    data = ask({"do": "open", "path": path, "options": options})
    stem = os.path.splitext(os.path.basename(path))[0]
    if document is None:
        document = FreeCAD.newDocument(stem)
    group = document.addObject("App::DocumentObjectGroupPython", "Program")
    OlpProgram(group)
    group.Label = os.path.basename(path)
    group.File, group.Robot, group.Model, group.Signature = path, robot or data["robot"], model, signature
    _fill(group, data)
    return group


def refresh(group: object) -> object:
    """Reads and times the file again and builds all parts anew. Raises OlpError; then nothing has changed."""
    data = ask({"do": "open", "path": group.File, "options": options(group)})
    _empty(group)
    for name in [one for one in group.PropertiesList if one.startswith("Line_")]:
        group.removeProperty(name)
    _fill(group, data)
    return group


def segments(group: object) -> list:
    """The rows of `olp time`, with the way of each move."""
    return json.loads(group.Data)["segments"]


def track(group: object, dt: float = 0.02) -> list:
    """(seconds, Placement, row of the segment table) every `dt` seconds, as `olp track` has it. Raises OlpError."""
    request = {"do": "track", "path": group.File, "options": options(group), "dt": dt}
    found = ask(request)
    return [
        (seconds, placement(found["places"][i]), found["segments"][i])
        for i, seconds in enumerate(found["times"])
    ]


def show_at(group: object, seconds: float) -> None:
    """Puts the tool where it is after `seconds`, by olp's own motion."""
    place = place_at(json.loads(group.Data)["segments"], seconds)
    if place is not None:
        group.Tool.Placement = place


def place_at(rows: list, seconds: float) -> object | None:
    """Between two instants of a move the tool is taken to run straight and evenly; between moves it stands."""
    last = None
    for row in rows:
        way = row.get("way") or ()
        for i, (instant, place) in enumerate(way):
            if instant >= seconds:
                if i == 0:
                    return placement(place if last is None or instant <= seconds else last)
                start, end = placement(way[i - 1][1]), placement(place)
                share = (seconds - way[i - 1][0]) / (instant - way[i - 1][0])
                rotation = start.Rotation.slerp(end.Rotation, max(0.0, min(1.0, share)))
                return FreeCAD.Placement(start.Base + (end.Base - start.Base) * share, rotation)
            last = place
    return None if last is None else placement(last)


def options(group: object) -> dict:
    """How the program is timed."""
    return {"robot": group.Robot, "model": group.Model, "signature": group.Signature}


def _empty(group: object) -> None:
    """Takes all parts out of the document, except what somebody else put into the group."""
    folders = [one for one in group.Group if hasattr(one, "Group")]
    parts = [group.Path, group.Tool, group.Sheet, group.Trajectory, *group.Points, *group.Frames]
    names = [one.Name for one in parts if one is not None]
    group.Group = [one for one in group.Group if one not in folders and one.Name not in names]
    for folder in folders:
        others = [one for one in folder.Group if one.Name not in names]
        folder.Group = others
        if others:
            group.Group = [*group.Group, folder]
        else:
            names.append(folder.Name)
    group.Points = group.Frames = []
    group.Path = group.Tool = group.Sheet = group.Trajectory = None
    for name in names:
        group.Document.removeObject(name)


def _fill(group: object, data: dict) -> None:
    document, rows = group.Document, data["segments"]
    group.Language = data["language"]
    group.TotalSeconds, group.MotionSeconds = data["total_s"], data["motion_s"]
    group.WaitSeconds, group.SignalSeconds = data["wait_s"], data["io_s"]
    group.Assumptions = data["assumptions"]
    group.LowSeconds, group.HighSeconds = data["low_s"] or 0.0, data["high_s"] or 0.0
    group.Messages = [f"{one['severity']}: {one['text']}" for one in data["diagnostics"]]
    if not data["is_followed"]:
        note = (
            "note: not all times are known (see the errors): the path is drawn straight from point to point"
        )
        group.Messages = [*group.Messages, note]
    size = shapes.size_of(rows)
    path, tool = shapes.add_path(document, rows), shapes.add_tool(document, data["tools"], size)
    frames = [
        shapes.add_frame(document, one["name"], placement(one["place"]), size) for one in data["frames"]
    ]
    points = [shapes.add_point(document, one, size) for one in data["points"][:_MOST_POINTS]]
    if len(data["points"]) > _MOST_POINTS:
        note = f"note: of {len(data['points'])} points the first {_MOST_POINTS} are objects of the document"
        group.Messages = [*group.Messages, note]
    sheet = _sheet(document, rows)
    own = _trajectory(document, rows)
    _speeds(group, data["speeds"])
    folders = [_folder(document, "Frames", frames), _folder(document, "Points", points)]
    group.Group = [*group.Group, *(one for one in (path, tool, *folders, sheet, own) if one is not None)]
    group.Path, group.Tool, group.Sheet, group.Trajectory = path, tool, sheet, own
    group.Points, group.Frames = points, frames
    group.Data = json.dumps(data)
    shapes.colour_path(path, rows, group.Colour)
    show_at(group, 0.0)
    document.recompute()


def _folder(document: object, name: str, parts: list) -> object | None:
    if not parts:
        return None
    folder = document.addObject("App::DocumentObjectGroup", name)
    folder.Group = parts
    return folder


def _trajectory(document: object, rows: list) -> object | None:
    made = trajectory(rows)
    if made is None:
        return None
    own = document.addObject("Robot::TrajectoryObject", "Trajectory")
    own.Trajectory = made
    own.Visibility = False  # the path shows the same, rounded as the robot rounds it
    return own


def _sheet(document: object, rows: list) -> object:
    sheet = document.addObject("Spreadsheet::Sheet", "Segments")
    for column, title in enumerate(_COLUMNS.values()):
        sheet.set(f"{chr(65 + column)}1", title)
    for number, row in enumerate(rows[:_MOST_ROWS], 2):
        for column, name in enumerate(_COLUMNS):
            value = row[name]
            if value is None or value == "":
                continue
            # An apostrophe makes it text, whatever a statement looks like.
            text = f"'{value}" if isinstance(value, str) else f"{value:.6g}"
            sheet.set(f"{chr(65 + column)}{number}", text)
    return sheet


def _speeds(group: object, speeds: list) -> None:
    """One property per line whose speed can be changed."""
    for one in speeds:
        name = f"Line_{one['line']}"
        group.addProperty("App::PropertyFloat", name, "Speeds", f"{one['statement']}  [{one['unit']}]")
        setattr(group, name, one["value"])
    group.Written = json.dumps({str(one["line"]): one for one in speeds})
