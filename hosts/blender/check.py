"""Drives the real Blender; started by `test`, with the zip of the add-on and the picture to write."""

from __future__ import annotations

import csv
import doctest
import io
import itertools
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
from mathutils import Matrix, Vector

ZIP, PICTURE = map(Path, sys.argv[1:])
OLP = os.environ["OLP"]
MODULE = "bl_ext.user_default.olp_robot_programs"
SAMPLES = {
    "samples/inform/generations/dx200.jbi": "",  # names its robot itself
    "samples/inform/handling/HANDLING.JBI": "",
    "samples/inform/palletising/MAIN.JBI": "",
    "samples/krl/handling.src": "yaskawa/gp25",
    "samples/rapid/handling.mod": "yaskawa/gp25",
    "samples/tp/handling.ls": "yaskawa/gp25",
    "samples/urscript/polyscope.script": "universal-robots/ur10e",
}
BAD = {
    "samples/inform/broken/many.jbi": ["P020", "',' is not expected here", "many.jbi:15"],
    "samples/inform/broken/empty.jbi": ["P006", "the file is empty"],
    "samples/krl/handling.src": ["I001", "this robot is not known"],
    "samples/inform/pitfalls/no-motion.jbi": ["T202", "moves nothing"],
    "samples/inform/pitfalls/stations.jbi": ["no place of a tool"],
    "nowhere.jbi": ["C003", "no such file"],
}


def olp(*words: str) -> str:
    done = subprocess.run([OLP, *words], capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return done.stdout


def empty_scene() -> bpy.types.Scene:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if MODULE not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module=MODULE)
    bpy.context.preferences.addons[MODULE].preferences.command = OLP
    return bpy.context.scene


def import_(path: str, **options: object) -> bpy.types.Object:
    before = set(bpy.data.objects)
    assert bpy.ops.import_scene.robot_program(filepath=str(Path(path).resolve()), **options) == {"FINISHED"}
    (root,) = (thing for thing in bpy.data.objects if thing not in before and "olp_total_s" in thing)
    return root


def refusal(**options: object) -> str:
    """The error report, which Blender hands to Python as an exception."""
    try:
        bpy.ops.import_scene.robot_program(**options)
    except RuntimeError as problem:
        return str(problem)
    raise AssertionError(f"imported: {options}")


def part(root: bpy.types.Object, name: str) -> bpy.types.Object:
    (found,) = (thing for thing in root.children_recursive if thing.name.endswith(f" {name}"))
    return found


def at_frame(scene: bpy.types.Scene, thing: bpy.types.Object, frame: float) -> Matrix:
    scene.frame_set(math.floor(frame), subframe=frame % 1)
    return thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world


def pose(row: dict[str, str]) -> Matrix:
    """Of a row of olp track, by rotations about fixed axes one after the other."""
    turned = Matrix.Identity(3)
    for axis in "XYZ":
        turned = Matrix.Rotation(math.radians(float(row[f"r{axis.lower()}_deg"])), 3, axis) @ turned
    return Matrix.Translation([float(row[f"{axis}_mm"]) / 1000 for axis in "xyz"]) @ turned.to_4x4()


def farthest(
    scene: bpy.types.Scene, tool: bpy.types.Object, rows: list[dict[str, str]]
) -> tuple[float, float]:
    """How far the tool is from these rows at their times, in mm and degrees."""
    worst_mm = worst_deg = 0.0
    keys = tool.animation_data.action.layers[0].strips[0].channelbags[0].fcurves[0].keyframe_points
    held = {round(key.co.x) for key in keys if key.interpolation == "CONSTANT"}
    for row in rows:
        frame = scene.frame_start + float(row["t_s"]) * scene.render.fps
        if frame % 1 > 0.01 and math.floor(frame) in held:
            continue  # the tool stands still until the next frame, where it has jumped to
        found, asked = at_frame(scene, tool, frame), pose(row)
        worst_mm = max(worst_mm, (found.translation - asked.translation).length * 1000)
        turned = (found.to_3x3().inverted() @ asked.to_3x3()).to_quaternion().angle
        worst_deg = max(worst_deg, math.degrees(min(turned, 2 * math.pi - turned)))
    return worst_mm, worst_deg


def check_program(path: str, robot: str, fps: int) -> None:
    scene = empty_scene()
    scene.render.fps = fps
    root = import_(path, robot=robot)
    options = ["--robot", robot] if robot else []
    (answer,) = json.loads(olp("time", path, "--format", "json", *options))
    total = answer["total_s"]
    tool, line = part(root, "tool"), part(root, "path")

    first, last = tool.animation_data.action.frame_range
    assert first == scene.frame_start
    assert abs((last - first) / fps - total) < 1e-3, (path, (last - first) / fps, total)
    assert 0 <= scene.frame_end - last < 1
    assert root["olp_total_s"] == total

    # The places of the frames are those of olp track at these times, asked for anew; between frames a line.
    rows = list(csv.DictReader(io.StringIO(olp("track", path, "--dt", f"{0.5 / fps:.12f}", *options))))
    step = max(1, len(rows) // 300)
    at_frames = farthest(scene, tool, rows[:: 2 * step] + rows[-1:])
    between = farthest(scene, tool, rows[1 :: 2 * step])
    assert at_frames[0] < 0.01, (path, at_frames)
    assert at_frames[1] < 0.1, (path, at_frames)
    assert between[0] < 5, (path, between)
    assert between[1] < 2, (path, between)

    # Where another tool begins olp follows another point: nothing is drawn from the one to the other.
    fine = csv.DictReader(io.StringIO(olp("track", path, "--dt", "0.001", *options)))
    places = [Vector([float(row[f"{axis}_mm"]) for axis in "xyz"]) for row in fine]
    jumps = sum((b - a).length > 20 for a, b in itertools.pairwise(places))
    assert jumps == bpy.data.texts[f"{Path(path).name} notes"].as_string().count("jump: "), (path, jumps)
    longest = max(
        (b.co - a.co).length * 1000
        for spline in line.data.splines
        for a, b in itertools.pairwise(spline.points)
    )
    assert longest < 30, (path, longest)

    # Every segment has its marker, its row and, where it moves, its spline.
    segments = answer["segments"]
    markers = sorted(marker.frame for marker in scene.timeline_markers)
    starts = sorted(scene.frame_start + round((s["end_s"] - s["duration_s"]) * fps) for s in segments)
    assert markers == starts
    assert [s["line"] for s in root["olp_segments"]] == [s["line"] for s in segments]
    table = bpy.data.texts[f"{Path(path).name} segments.csv"].as_string()
    assert [float(r["end_s"]) for r in csv.DictReader(io.StringIO(table))] == [s["end_s"] for s in segments]
    shown = set(line["olp_segment_of_spline"])
    moving = {i for i, s in enumerate(segments) if (s["distance_mm"] or 0) > 1 and s["duration_s"] > 2 / fps}
    assert moving <= shown
    assert all(segments[i]["kind"] not in ("wait", "signal") for i in shown)
    assert len(line.data.splines) == len(line["olp_segment_of_spline"])
    for colour in ("TIME", "DURATION", "SPEED"):
        root.olp_colour = colour
        used = [spline.material_index for spline in line.data.splines]
        assert (min(used), max(used)) == (0, 31), (path, colour, used)
    print(f"{path}: {total:.3f} s, {last - first:.2f} frames at {fps}/s")
    print(f"  {jumps} changes of tool, longest straight piece of the path {longest:.1f} mm")
    print("  from olp track: {:.5f} mm and {:.4f}° at frames".format(*at_frames), end=", ")
    print("{:.3f} mm and {:.3f}° between them".format(*between))


def check_bad() -> None:
    scene = empty_scene()
    before = len(bpy.data.objects), len(bpy.data.texts), scene.frame_end
    for path, words in BAD.items():
        told = refusal(filepath=str(Path(path).resolve()))
        assert all(word in told for word in words), (path, told)
    preferences = bpy.context.preferences.addons[MODULE].preferences
    preferences.command = "/nowhere/olp"
    told = refusal(filepath=str(Path("samples/inform/generations/dx200.jbi").resolve()))
    assert "cannot start olp as '/nowhere/olp'" in told
    assert "Preferences" in told
    assert before == (len(bpy.data.objects), len(bpy.data.texts), scene.frame_end)
    print(f"{len(BAD) + 1} refusals with olp's words, and nothing left behind")


def check_several_at_once_with_one_that_is_bad() -> None:
    scene = empty_scene()
    folder = Path("samples/inform").resolve()
    names = [{"name": name} for name in ("generations/dx200.jbi", "broken/empty.jbi", "up20/none.jbi")]
    told = refusal(filepath="", directory=str(folder), files=names, markers=False)
    assert "P006" in told
    assert "C003" in told
    assert [thing.name for thing in bpy.data.objects if "olp_total_s" in thing] == ["dx200.jbi"]
    assert not scene.timeline_markers


def check_signature_and_scale(folder: Path) -> None:
    signature = folder / "up20.signature.json"
    subprocess.run([OLP, "calibrate", "samples/up20", "-o", signature], check=True, capture_output=True)
    scene = empty_scene()
    scene.unit_settings.scale_length = 0.001  # a scene in millimetres
    path = "samples/up20/APPR-1.JBI"
    root = import_(path, signature=str(signature))
    (answer,) = json.loads(olp("time", path, "--format", "json", "--signature", str(signature)))
    (without,) = json.loads(olp("time", path, "--format", "json"))
    assert root["olp_total_s"] == answer["total_s"] != without["total_s"]
    assert root["olp_low_s"] == answer["low_s"] < answer["total_s"] < answer["high_s"]
    row = next(csv.DictReader(io.StringIO(olp("track", path, "--signature", str(signature)))))
    place = at_frame(scene, part(root, "tool"), scene.frame_start).translation
    assert (place - Vector([float(row[f"{axis}_mm"]) for axis in "xyz"])).length < 0.01
    print(f"{path} with its signature: {without['total_s']:.3f} s became {answer['total_s']:.3f} s")


def check_saved_file_is_whole(folder: Path) -> None:
    empty_scene()
    import_("samples/inform/generations/dx200.jbi")
    file = str(folder / "dx200.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=file)
    root = bpy.data.objects["dx200.jbi"]
    from bl_ext.user_default.olp_robot_programs import scene as addon

    assert [addon.segment_at(root, 1 + 24 * t)["line"] for t in (0.1, 0.3, 1.5, 2.5)] == [27, 30, 34, 31]
    assert addon.segment_at(root, 0) is None
    assert addon.segment_at(root, 1000) is None
    assert addon.root_of(part(root, "arrow")) == root


def check_the_page_shows_a_real_run() -> None:
    empty_scene()
    page = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    (run,) = re.findall(r"```text\n(>>> .*?)```", page, re.S)
    failed, tried = doctest.DocTestRunner().run(
        doctest.DocTestParser().get_doctest(run, {}, "README.md", "README.md", 0)
    )
    assert tried > 5
    assert not failed


def check_what_is_drawn() -> None:
    """Without a window nothing is drawn: the panel writes its labels into a list instead."""
    import bl_ext.user_default.olp_robot_programs as addon

    scene = empty_scene()
    root = import_("samples/inform/generations/dx200.jbi")
    scene.frame_set(scene.frame_start + round(1.5 * 24))
    assert bpy.context.view_layer.objects.active == root
    assert addon.RobotProgramPanel.poll(bpy.context)
    layout = MagicMock()
    addon.RobotProgramPanel.draw(SimpleNamespace(layout=layout), bpy.context)
    labels = [call.kwargs["text"] for call in layout.label.call_args_list]
    assert "dx200.jbi: 3.560 s, yaskawa/ma2010" in labels
    assert "34  TIMER T=0.22" in labels
    scene.render.fps = 25
    addon.RobotProgramPanel.draw(SimpleNamespace(layout=layout), bpy.context)
    assert "Made for 24 frames/s" in str(layout.label.call_args_list)
    addon.menu(SimpleNamespace(layout=layout), bpy.context)
    assert addon.menu in bpy.types.TOPBAR_MT_file_import.draw._draw_funcs
    assert "yaskawa/gp25" in addon.known_robots(None, bpy.context, "GP2")
    assert bpy.types.IMPORT_SCENE_FH_robot_program.bl_file_extensions == ".jbi;.src;.mod;.prg;.ls;.script"


def render() -> None:
    scene = empty_scene()
    root = import_("samples/inform/palletising/MAIN.JBI")
    line = part(root, "path")
    places = [point.co.to_3d() for spline in line.data.splines for point in spline.points]
    low, high = (Vector([end(place[i] for place in places) for i in range(3)]) for end in (min, max))
    middle, size = (low + high) / 2, (high - low).length / 2
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = middle + 3.4 * size * Vector((0.7, -0.6, 0.4)).normalized()
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 2
    sun.rotation_euler = (0.5, 0.3, 0.6)
    for thing in (camera, sun):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.85, 0.87, 0.9, 1.0)
    scene.view_settings.view_transform = "Standard"
    bpy.ops.preferences.addon_enable(module="cycles")
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 16
    scene.cycles.use_denoising = False
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 640, 480, 100
    scene.render.filepath = str(PICTURE)
    scene.frame_set(round(scene.frame_end * 0.65))
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(str(PICTURE))
    assert tuple(picture.size) == (640, 480)
    seen = list(picture.pixels)
    colours = {tuple(round(v * 8) for v in seen[i : i + 3]) for i in range(0, len(seen), 4)}
    assert len(colours) > 10, "the picture is empty"


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.extensions.package_install_files(filepath=str(ZIP), repo="user_default", enable_on_install=True)
assert MODULE in bpy.context.preferences.addons
empty_scene()
for number, (sample, its_robot) in enumerate(SAMPLES.items()):
    check_program(sample, its_robot, (24, 30, 60)[number % 3])
check_bad()
check_several_at_once_with_one_that_is_bad()
check_signature_and_scale(ZIP.parent)
check_saved_file_is_whole(ZIP.parent)
check_what_is_drawn()
check_the_page_shows_a_real_run()
render()
bpy.ops.preferences.addon_disable(module=MODULE)
assert not hasattr(bpy.types.Object, "olp_colour")
print("held")
