"""What olp says, as objects of Blender: a root in the robot's base, the path, and the tool that moves along it."""

from __future__ import annotations

import csv
import math
from bisect import bisect_left, bisect_right
from io import StringIO
from itertools import pairwise
from pathlib import Path

import bpy
from mathutils import Euler, Quaternion, Vector

from .ask import told

# Viridis, sRGB, as matplotlib has it at 0, 1/8, …, 1: readable without colour vision and on paper.
VIRIDIS = ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725"]
COLOURS = 32
COLOUR_ITEMS = [
    ("SPEED", "Speed", "Mean speed of each segment: yellow fast, violet slow"),
    ("TIME", "Time", "When it runs: violet first, yellow last"),
    ("DURATION", "Duration", "How long it takes: yellow long, violet short"),
]
CONSTANT, LINEAR = 0, 1  # keyframe_points' numbers of the interpolations


def frame_rate(scene: bpy.types.Scene) -> float:
    return scene.render.fps / scene.render.fps_base


def build(
    context: bpy.types.Context,
    program: Path,
    answer: dict,
    rows: list[dict[str, str]],
    per_frame: int,
    colour: str,
    markers: bool,
) -> bpy.types.Object:
    """The root of a new collection; the first frame is the scene's current start."""
    scene = context.scene
    scale = 1 / scene.unit_settings.scale_length  # of the scene's unit, per metre
    mm = 0.001 * scale
    start, fps = scene.frame_start, frame_rate(scene)
    times = [float(row["t_s"]) for row in rows]
    points = [Vector([float(row[f"{axis}_mm"]) * mm for axis in "xyz"]) for row in rows]

    collection = bpy.data.collections.new(program.name)
    context.scene.collection.children.link(collection)
    root = bpy.data.objects.new(program.name, None)
    root.empty_display_type = "PLAIN_AXES"
    root["olp_program"] = str(program)
    root["olp_total_s"] = answer["total_s"]
    root["olp_motion_s"], root["olp_wait_s"] = answer["motion_s"], answer["wait_s"]
    root["olp_robot"], root["olp_model"] = answer["robot"] or "", answer["model"] or ""
    if answer["low_s"] is not None:
        root["olp_low_s"], root["olp_high_s"] = answer["low_s"], answer["high_s"]
    root["olp_start_frame"], root["olp_frames_per_s"] = start, fps
    root["olp_segments"] = [
        {key: value for key, value in segment.items() if value is not None} for segment in answer["segments"]
    ]
    jumps = _jumps(rows)
    path = _path(program, answer["segments"], times, points, jumps)
    size = max((max(p[i] for p in points) - min(p[i] for p in points) for i in range(3)), default=0.0)
    size = size or 100 * mm
    path.data.bevel_depth = size / 200
    tool = bpy.data.objects.new(f"{program.name} tool", None)
    tool.empty_display_type = "ARROWS"
    tool.empty_display_size = size / 6
    _animate(tool, rows, times, points, jumps, start, fps, per_frame)
    arrow = _arrow(f"{program.name} arrow", size / 6)
    for thing, parent in ((root, None), (path, root), (tool, root), (arrow, tool)):
        collection.objects.link(thing)
        thing.parent = parent
    _texts(program, answer, [(rows[i], rows[i + 1], (points[i + 1] - points[i]).length / mm) for i in jumps])
    if markers:
        for segment in answer["segments"]:
            begin_s = (segment["end_s"] or 0.0) - (segment["duration_s"] or 0.0)
            scene.timeline_markers.new(_label(segment, program), frame=start + round(begin_s * fps))
    root.olp_colour = colour
    recolour(root)
    return root


def last_frame(root: bpy.types.Object) -> int:
    """The frame at which the program has ended."""
    return root["olp_start_frame"] + math.ceil(root["olp_total_s"] * root["olp_frames_per_s"] - 1e-6)


def root_of(thing: bpy.types.Object | None) -> bpy.types.Object | None:
    """The root of the program that an object belongs to."""
    while thing and "olp_total_s" not in thing:
        thing = thing.parent
    return thing


def segment_at(root: bpy.types.Object, frame: float) -> dict | None:
    """The segment that runs at a frame; None before the first and after the last one."""
    t_s = (frame - root["olp_start_frame"]) / root["olp_frames_per_s"]
    segments = root["olp_segments"]
    at = bisect_left([segment.get("end_s", 0.0) for segment in segments], t_s)
    return segments[at].to_dict() if t_s >= 0 and at < len(segments) else None


def recolour(root: bpy.types.Object) -> None:
    """Gives every segment of the path the colour of its number, and tells the ends of the scale."""
    segments = root["olp_segments"]
    for path in root.children:
        if "olp_segment_of_spline" not in path:
            continue
        numbers = [_number(segments[at], root.olp_colour) for at in path["olp_segment_of_spline"]]
        low, high = min(numbers, default=0.0), max(numbers, default=0.0)
        for spline, number in zip(path.data.splines, numbers, strict=True):
            share = (number - low) / (high - low) if high > low else 0.5
            spline.material_index = min(int(share * COLOURS), COLOURS - 1)
        root["olp_scale_low"], root["olp_scale_high"] = low, high
        root["olp_scale_unit"] = "mm/s" if root.olp_colour == "SPEED" else "s"


def _number(segment: dict, colour: str) -> float:
    if colour == "TIME":
        return segment["end_s"]
    if colour == "DURATION":
        return segment["duration_s"]
    return segment.get("distance_mm", 0.0) / segment["duration_s"]


def _label(segment: dict, program: Path) -> str:
    name = Path(segment["file"]).name
    job = "" if name == program.name else f"{name}:"
    return f"{job}{segment['line']} {segment['statement']}"[:48]


def _jumps(rows: list[dict]) -> list[int]:
    """The rows after which another tool begins: the point that olp follows is another one, and nothing has moved."""
    return [i for i, (a, b) in enumerate(pairwise(rows)) if a["tool_changes"] != b["tool_changes"]]


def _path(
    program: Path, segments: list[dict], times: list[float], points: list[Vector], jumps: list[int]
) -> bpy.types.Object:
    """One spline for each segment that moves the tool, two where it jumps."""
    ends, now = [], 0.0
    for segment in segments:
        now = now if segment["end_s"] is None else segment["end_s"]
        ends.append(now)
    curve = bpy.data.curves.new(f"{program.name} path", "CURVE")
    curve.dimensions = "3D"
    curve.bevel_resolution = 2
    curve.use_fill_caps = True
    for at in range(COLOURS):
        curve.materials.append(_material(at))
    owners: list[int] = []
    run: list[Vector] = []
    owner, broken = -1, set(jumps)
    for i in range(len(points) - 1):
        # The one that runs in the middle; where a move ends beside a wait, the move has the rest of its way.
        around = [
            min(bisect_left(ends, t), len(ends) - 1)
            for t in ((times[i] + times[i + 1]) / 2, times[i], times[i + 1])
        ]
        here = next((at for at in around if segments[at]["distance_mm"]), around[0])
        if here != owner:
            _spline(curve, run, owner, owners)
            run, owner = [points[i]], here
        if i in broken:
            _spline(curve, run, owner, owners)
            run = [points[i + 1]]
        elif (points[i + 1] - run[-1]).length > 1e-7:
            run.append(points[i + 1])
    _spline(curve, run, owner, owners)
    path = bpy.data.objects.new(f"{program.name} path", curve)
    path["olp_segment_of_spline"] = owners
    return path


def _spline(curve: bpy.types.Curve, run: list[Vector], owner: int, owners: list[int]) -> None:
    if len(run) < 2:
        return
    spline = curve.splines.new("POLY")
    spline.points.add(len(run) - 1)
    spline.points.foreach_set("co", [value for point in run for value in (*point, 1.0)])
    owners.append(owner)


def _animate(
    tool: bpy.types.Object,
    rows: list[dict[str, str]],
    times: list[float],
    points: list[Vector],
    jumps: list[int],
    start: int,
    fps: float,
    per_frame: int,
) -> None:
    """A key at every frame, and one where the program ends, which may be between two frames."""
    keys = sorted({*range(0, len(rows), per_frame), len(rows) - 1})
    turns: list[Quaternion] = []
    for at in keys:
        # R = Rz Ry Rx, which is Blender's Euler order XYZ
        turn = Euler([math.radians(float(rows[at][f"r{axis}_deg"])) for axis in "xyz"], "XYZ").to_quaternion()
        if turns and turn.dot(turns[-1]) < 0:
            turn.negate()
        turns.append(turn)
    frames = [start + times[at] * fps for at in keys]
    frames = [round(frame) if abs(frame - round(frame)) < 1e-3 else frame for frame in frames]
    interpolations = [LINEAR] * len(keys)
    for jump in jumps:
        interpolations[bisect_right(keys, jump) - 1] = CONSTANT
    tool.rotation_mode = "QUATERNION"
    action = bpy.data.actions.new(tool.name)
    tool.animation_data_create().action = action
    channels = [("location", i, [points[at][i] for at in keys]) for i in range(3)]
    channels += [("rotation_quaternion", i, [turn[i] for turn in turns]) for i in range(4)]
    for name, index, values in channels:
        curve = action.fcurve_ensure_for_datablock(tool, name, index=index)
        curve.keyframe_points.add(len(keys))
        pairs = zip(frames, values, strict=True)
        curve.keyframe_points.foreach_set("co", [number for pair in pairs for number in pair])
        curve.keyframe_points.foreach_set("interpolation", interpolations)
        curve.update()


def _arrow(name: str, length: float) -> bpy.types.Object:
    """A solid arrow along the tool's Z with its tip at the tool's point, as an empty is not rendered."""
    sides = 24
    profile = [(0.0, 0.0), (0.14, -0.35), (0.05, -0.35), (0.05, -1.0), (0.0, -1.0)]
    vertices = [
        (length * r * math.cos(a), length * r * math.sin(a), length * z)
        for r, z in profile
        for a in (2 * math.pi * k / sides for k in range(sides))
    ]
    faces = [
        (i * sides + k, i * sides + (k + 1) % sides, (i + 1) * sides + (k + 1) % sides, (i + 1) * sides + k)
        for i in range(len(profile) - 1)
        for k in range(sides)
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.validate()
    mesh.materials.append(_plain("olp tool", (0.8, 0.12, 0.03)))
    return bpy.data.objects.new(name, mesh)


def _material(at: int) -> bpy.types.Material:
    place = at / (COLOURS - 1) * (len(VIRIDIS) - 1)
    low = min(int(place), len(VIRIDIS) - 2)
    ends = [[int(code[i : i + 2], 16) / 255 for i in (0, 2, 4)] for code in VIRIDIS[low : low + 2]]
    srgb = [a + (b - a) * (place - low) for a, b in zip(*ends, strict=True)]
    return _plain(
        f"olp {at:02d}", [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in srgb]
    )


def _plain(name: str, colour: list[float] | tuple[float, float, float]) -> bpy.types.Material:
    """The material of a name, made where there is none; the user may have changed it."""
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    material = bpy.data.materials.new(name)
    material.diffuse_color = (*colour, 1.0)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = 0.6
    shader.inputs["Emission Color"].default_value = (*colour, 1.0)
    shader.inputs["Emission Strength"].default_value = 0.3
    return material


def _texts(program: Path, answer: dict, jumps: list[tuple[dict, dict, float]]) -> None:
    """The table, and what was assumed and found, as texts of the text editor."""
    table = StringIO()
    if answer["segments"]:
        writer = csv.DictWriter(table, answer["segments"][0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(answer["segments"])
    bpy.data.texts.new(f"{program.name} segments.csv").write(table.getvalue())
    notes = [f"assumed: {_place(note)}{note['says']}" for note in answer["assumptions"]]
    notes += [f"{diagnostic['severity']} {told(diagnostic)}" for diagnostic in answer["diagnostics"]]
    notes += [
        f"jump: {Path(after['file']).name}:{after['line']}: at {float(before['t_s']):.3f} s another tool is taken:"
        f" its point is {way_mm:.1f} mm away"
        for before, after, way_mm in jumps
    ]
    bpy.data.texts.new(f"{program.name} notes").write("\n".join([*notes, ""]))


def _place(note: dict) -> str:
    return f"{Path(note['file']).name}:{note['line']}: " if note["line"] else ""
