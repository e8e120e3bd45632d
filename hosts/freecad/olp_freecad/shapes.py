"""The parts of a program that are seen: the path with its colours, frames, points and the tool."""

from __future__ import annotations

from collections.abc import Iterator

import FreeCAD
import Part
from FreeCAD import Vector

from olp_freecad.places import placement

_AXES = ((0.85, 0.15, 0.15), (0.15, 0.65, 0.15), (0.15, 0.3, 0.9))
_INK = (0.25, 0.25, 0.3)
_SMALLEST = 1e-4  # mm: the geometry kernel has no shorter edges
# From quick to slow: a scale that people who see no red or no green can read, too (viridis).
_SCALE = ((0.99, 0.91, 0.14), (0.48, 0.82, 0.32), (0.13, 0.57, 0.55), (0.23, 0.32, 0.55), (0.27, 0.0, 0.33))


def size_of(rows: list) -> float:
    """mm: how long the marks of frames and points are, by the size of the path."""
    box = FreeCAD.BoundBox()
    for row in rows:
        for _, place in row.get("way") or ():
            box.add(Vector(*place["position"]))
    return max(5.0, 0.06 * box.DiagonalLength) if box.isValid() else 20.0


def add_path(document: object, rows: list) -> object:
    """One edge per piece; `Segment` says of each edge, in order, which row of the table it belongs to."""
    path = document.addObject("Part::Feature", "Path")
    path.addProperty("App::PropertyIntegerList", "Segment", "Program", "row of the segment table, per edge")
    edges, owners = [], []
    for number, row in enumerate(rows):
        for start, end, _, _ in _pieces(row):
            edges.append(Part.makeLine(start, end))
            owners.append(number)
    if edges:
        path.Shape = Part.makeCompound(edges)
    path.Segment = owners
    if path.ViewObject is not None:
        path.ViewObject.LineWidth = 4.0
        path.ViewObject.PointSize = 1.0
        path.ViewObject.PointColor = _INK
    return path


def _pieces(row: dict) -> Iterator[tuple]:
    """Start, end, seconds and instant of the end of all pieces of a move that are drawn."""
    way = row.get("way") or []
    for i in range(1, len(way)):
        start, end = (Vector(*way[j][1]["position"]) for j in (i - 1, i))
        # Where another tool is taken its tip is at once elsewhere: that is no way.
        if (end - start).Length > _SMALLEST and i != row.get("jump"):
            yield start, end, max(1e-9, way[i][0] - way[i - 1][0]), way[i][0]


def colour_path(path: object, rows: list, kind: str) -> None:
    """Paints every edge; nothing to do without a screen."""
    if path.ViewObject is None or not path.Segment:
        return
    values = edge_values(rows, kind)
    highest = max(values) or 1.0
    path.ViewObject.LineColorArray = [(*colour_of(1.0 - one / highest), 0.0) for one in values]


def edge_values(rows: list, kind: str) -> list:
    """Per edge of the path: mm/s there, or for "time" the seconds from the program's start, last first."""
    last = max((row["end_s"] for row in rows), default=0.0)
    return [
        (end - start).Length / seconds if kind == "speed" else last - instant
        for row in rows
        for start, end, seconds, instant in _pieces(row)
    ]


def colour_of(share: float) -> tuple:
    """Of the scale, 0 to 1."""
    place = max(0.0, min(1.0, share)) * (len(_SCALE) - 1)
    index = min(int(place), len(_SCALE) - 2)
    rest = place - index
    return tuple(a + (_SCALE[index + 1][i] - a) * rest for i, a in enumerate(_SCALE[index]))


def add_frame(document: object, name: str, place: object, size: float) -> object:
    frame = document.addObject("Part::Feature", "Frame")
    frame.Label = name
    frame.Shape = Part.makeCompound(_triad(2.0 * size))
    frame.Placement = place
    _paint(frame, [*_AXES], 3.0)
    return frame


def add_point(document: object, told: dict, size: float) -> object:
    """A point that can be moved: by its placement, and then it is no longer as `Written`."""
    point = document.addObject("Part::FeaturePython", "Point")
    point.addProperty("App::PropertyString", "PointName", "Program", "as the program calls it")
    point.addProperty("App::PropertyInteger", "Line", "Program", "where it is written")
    point.addProperty(
        "App::PropertyIntegerList", "Segment", "Program", "rows of the segment table that go there"
    )
    point.addProperty("App::PropertyBool", "Via", "Program", "on the way of an arc")
    point.addProperty("App::PropertyPlacement", "Written", "Program", "where the file says that it is")
    point.Label = told["name"] + (" (via)" if told["via"] else "")
    point.PointName, point.Line, point.Via = told["name"], told["line"], told["via"]
    point.Segment = told["segments"]
    point.Shape = Part.makeCompound(_triad(0.7 * size))
    point.Placement = point.Written = placement(told["place"])
    for name in ("PointName", "Line", "Segment", "Via", "Written"):
        point.setEditorMode(name, 1)
    if point.ViewObject is not None:
        point.ViewObject.Proxy = 0
    _paint(point, [*_AXES], 2.0)
    return point


def add_tool(document: object, tools: list, size: float) -> object:
    """The tool: its tip is the tool centre point; a stem runs to the flange where the robot is known."""
    tool = document.addObject("Part::Feature", "Tool")
    parts = [Part.makeCone(0.0, 0.3 * size, size, Vector(), Vector(0.0, 0.0, -1.0))]
    if tools:
        flange = placement(tools[0]["place"]).inverse()
        tool.addProperty(
            "App::PropertyPlacement", "Offset", "Program", "the tool centre point, from the flange"
        )
        tool.Offset = placement(tools[0]["place"])
        end = flange.Base
        if (end - Vector(0.0, 0.0, -size)).Length > 1.0:
            parts.append(Part.makeLine(Vector(0.0, 0.0, -size), end))
        axis = flange.Rotation.multVec(Vector(0.0, 0.0, 1.0))
        parts.append(Part.makeCylinder(0.45 * size, 0.2 * size, end - axis * (0.2 * size), axis))
    tool.Shape = Part.makeCompound(parts)
    if tool.ViewObject is not None:
        tool.ViewObject.ShapeColor = (0.9, 0.45, 0.1)
        tool.ViewObject.Transparency = 25
    return tool


def _triad(length: float) -> list:
    return [Part.makeLine(Vector(), axis * length) for axis in (Vector(1), Vector(0, 1), Vector(0, 0, 1))]


def _paint(part: object, colours: list, width: float) -> None:
    if part.ViewObject is not None:
        part.ViewObject.LineColorArray = [(*one, 0.0) for one in colours]
        part.ViewObject.LineWidth = width
        part.ViewObject.PointSize = 1.0
        part.ViewObject.PointColor = _INK
