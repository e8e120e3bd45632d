"""Runs inside freecadcmd: what the workbench promises without a screen. Prints a line per promise, and `held: N`."""

import json
import os
import shutil
import sys
import tempfile
import traceback

import FreeCAD
import olp_freecad
from FreeCAD import Placement, Rotation, Vector
from olp_freecad import ask
from olp_freecad.trajectory import acceleration_for

SAMPLES = os.environ["OLP_SAMPLES"]
ROBOT = "yaskawa/gp25"
# Each language's program, and of INFORM those with arcs, many points, loops and calls as well.
PROGRAMS = (
    "inform/handling/HANDLING.JBI",
    "inform/generations/dx200.jbi",
    "inform/palletising/MAIN.JBI",
    "inform/cam/FINISH.JBI",
    "krl/handling.src",
    "rapid/handling.mod",
    "tp/handling.ls",
    "tp/drop.ls",
    "urscript/handling.script",
    "urscript/polyscope.script",
)
EDITED = tuple(one for one in PROGRAMS if "handling." in one.lower())
failed = []


def promise(says, is_held, more=""):
    # FreeCAD's bars of progress leave the line open.
    print(f"\n{'held' if is_held else 'FAILED'}: {says}{'  ' + str(more) if more else ''}")
    if not is_held:
        failed.append(says)


def copied(name):
    """A copy of the sample's folder, and the file in it."""
    folder = os.path.join(tempfile.mkdtemp(prefix="olp-"), "cell")
    shutil.copytree(os.path.dirname(os.path.join(SAMPLES, name)), folder)
    return folder, os.path.join(folder, os.path.basename(name))


def lines_of(folder):
    found = {}
    for name in os.listdir(folder):
        with open(os.path.join(folder, name), "rb") as file:
            found[name] = file.read().split(b"\n")
    return found


def close():
    for name in list(FreeCAD.listDocuments()):
        FreeCAD.closeDocument(name)


def the_law():
    """FreeCAD's own Robot.Trajectory, asked for a time and answering it."""
    import Robot

    for length, speed, seconds in (
        (300.0, 1000.0, 0.5),
        (300.0, 250.0, 1.3),
        (5.0, 500.0, 0.4),
        (80.0, 100.0, 0.7),
    ):
        v, a = acceleration_for(length, seconds, speed)
        points = [Robot.Waypoint(Placement(Vector(x, 0, 0), Rotation()), vel=v, acc=a) for x in (0.0, length)]
        took = Robot.Trajectory(points).Duration
        promise(
            f"{length:g} mm at {speed:g} mm/s in {seconds:g} s",
            abs(took / seconds - 1.0) < 1e-6,
            f"{took:.6f} s",
        )
    promise(
        "300 mm at 1000 mm/s in 0.500 s is 5000 mm/s²", abs(acceleration_for(300, 0.5, 1000)[1] - 5000) < 1e-6
    )


def the_duration(name):
    robot = "universal-robots/ur10e" if "polyscope" in name else ROBOT
    program = olp_freecad.open(os.path.join(SAMPLES, name), robot=robot)
    own = program.Trajectory.Trajectory
    wanted, took = program.TotalSeconds, own.Duration
    apart = abs(took / wanted - 1.0)
    says = f"{name}: FreeCAD {took:.3f} s, olp {wanted:.3f} s"
    promise(says, apart < 0.01 and wanted > 0.5, f"{apart:.1e}")
    told = json.loads(ask.command("time", program.File, "--robot", robot, "--format", "json"))
    promise(f"{name}: olp time says the same", abs(told[0]["total_s"] - wanted) < 1e-9)
    # Not the sum alone: after each wait FreeCAD's tool stands where olp's does.
    rows = olp_freecad.segments(program)
    for row in rows:
        if row.get("target") and row["kind"] != "wait" and row["end_s"] > 0.0 and row["limited_by"] != "":
            place = own.position(row["end_s"])
            wanted_place = Vector(*row["target"]["position"])
            if (place.Base - wanted_place).Length > 0.5:
                promise(
                    f"{name}: line {row['line']} ends at its target",
                    False,
                    (place.Base - wanted_place).Length,
                )
                break
    else:
        promise(f"{name}: every move ends where and when it should", True)
    promise(f"{name}: an edge per piece, a row each", set(program.Path.Segment) <= set(range(len(rows))))
    promise(f"{name}: the sheet holds the rows", program.Sheet.get("A2") == float(rows[0]["line"]))
    olp_freecad.show_at(program, 0.0)
    first = Placement(program.Tool.Placement)
    olp_freecad.show_at(program, wanted / 2.0)
    promise(f"{name}: the tool moves", (program.Tool.Placement.Base - first.Base).Length > 0.01)
    close()


def the_edit(name):
    folder, path = copied(name)
    before = lines_of(folder)
    program = olp_freecad.open(path, robot=ROBOT)
    promise(f"{name}: nothing to write at first", olp_freecad.write_back(program) == [])
    point = next(one for one in program.Points if not one.Via)
    wanted = point.Placement.multiply(Placement(Vector(12.0, -7.5, 20.25), Rotation(4.0, 3.0, -2.0)))
    olp_freecad.move_point(program, point.PointName, wanted)
    # The longest move whose speed its own line says.
    rows = [one for one in olp_freecad.segments(program) if f"Line_{one['line']}" in program.PropertiesList]
    line = max(rows, key=lambda one: one["duration_s"])["line"]
    speed = getattr(program, f"Line_{line}") / 2.0
    olp_freecad.set_speed(program, line, speed)
    total, moved = program.TotalSeconds, point.PointName
    told = olp_freecad.write_back(program)
    after = lines_of(folder)
    different = {
        (file, number)
        for file in before
        for number, (old, new) in enumerate(zip(before[file], after[file], strict=True), 1)
        if old != new
    }
    told = {(os.path.basename(file), number) for file, number in told}
    promise(f"{name}: the lines that changed are those told", different == told, different)
    promise(f"{name}: and few", 2 <= len(different) <= 5 and set(after) == set(before))
    again = next(one for one in program.Points if one.PointName == moved)
    apart = (again.Placement.Base - wanted.Base).Length
    promise(f"{name}: {moved} is where it was put", apart < 0.05, f"{apart:.4f} mm")
    promise(
        f"{name}: line {line} has its new speed", abs(getattr(program, f"Line_{line}") / speed - 1.0) < 0.02
    )
    promise(f"{name}: it takes longer", program.TotalSeconds > total)
    took = program.Trajectory.Trajectory.Duration
    promise(f"{name}: FreeCAD's time follows", abs(took / program.TotalSeconds - 1.0) < 0.01)
    other = os.path.join(os.path.dirname(folder), "out" + os.path.splitext(path)[1])
    olp_freecad.set_speed(program, line, speed / 2.0)
    told = olp_freecad.write_back(program, other)
    promise(
        f"{name}: and tells which",
        told and {os.path.dirname(file) for file, _ in told} == {os.path.dirname(other)},
    )
    promise(f"{name}: elsewhere, the file itself stays", lines_of(folder) == after and os.path.isfile(other))
    close()


def refusals():
    for says, act in (
        ("no such file", lambda: olp_freecad.open("/nowhere/x.jbi")),
        ("no program", lambda: olp_freecad.open(__file__)),
        ("no such robot", lambda: olp_freecad.open(os.path.join(SAMPLES, PROGRAMS[0]), robot="acme/one")),
    ):
        try:
            act()
            promise(f"{says}: refused", False)
        except olp_freecad.OlpError as problem:
            promise(f"{says}: refused", True, problem.problems[0][:90])
    program = olp_freecad.open(os.path.join(SAMPLES, EDITED[0]), robot=ROBOT)
    far = program.Points[0].PointName
    for says, act in (
        ("a point that is none", lambda: olp_freecad.move_point(program, "C77777", Placement())),
        ("a line without speed", lambda: olp_freecad.set_speed(program, 1, 5.0)),
    ):
        try:
            act()
            promise(f"{says}: refused", False)
        except olp_freecad.OlpError as problem:
            promise(f"{says}: refused", True, problem.problems[0][:90])
    olp_freecad.move_point(program, far, Placement(Vector(9000.0, 0.0, 0.0), Rotation()))
    try:
        olp_freecad.write_back(program, os.path.join(tempfile.mkdtemp(), "x.jbi"))
        promise("out of reach: refused", False)
    except olp_freecad.OlpError as problem:
        promise(
            "out of reach: refused",
            len(olp_freecad.pending(program)["points"]) == 1,
            problem.problems[0][:90],
        )
    close()


def without_a_robot():
    program = olp_freecad.open(os.path.join(SAMPLES, "krl/handling.src"))
    promise("no robot: what is known is drawn", len(program.Path.Segment) > 3)
    promise(
        "no robot: it is said",
        any("robot is not known" in one for one in program.Messages),
        program.Messages[0][:80],
    )
    program.Robot = ROBOT
    olp_freecad.refresh(program)
    promise("the robot named, and all is there", len(program.Path.Segment) > 50 and not program.Messages)
    close()


def the_track():
    program = olp_freecad.open(os.path.join(SAMPLES, EDITED[1]), robot=ROBOT)
    rows = olp_freecad.track(program, 0.05)
    apart = []
    for seconds, place, _ in rows:
        olp_freecad.show_at(program, seconds)
        apart.append((program.Tool.Placement.Base - place.Base).Length)
    # Where the tool changes the tip jumps, at an instant that each may round its own way.
    apart = sorted(apart)[:-4]
    promise(
        "the tool is where olp track says", len(rows) > 100 and apart[-1] < 5.0, f"{apart[-1]:.2f} mm apart"
    )
    order = [row for _, _, row in rows]
    last = len(olp_freecad.segments(program)) - 1
    promise("and its rows are in order", order == sorted(order) and order[-1] == last)
    close()


def another_python():
    """Whatever FreeCAD's own Python is told must not reach the one that runs olp."""
    kept = dict(os.environ)
    os.environ.update({"PYTHONHOME": "/nowhere", "PYTHONPATH": "/nowhere", "PYTHONEXECUTABLE": "/nowhere"})
    program = olp_freecad.open(os.path.join(SAMPLES, EDITED[0]), robot=ROBOT)
    promise("FreeCAD's Python settings stay here", program.TotalSeconds > 1.0)
    os.environ["OLP_PYTHON"] = "/bin/false"
    try:
        olp_freecad.refresh(program)
        promise("a Python without olp: refused", False)
    except olp_freecad.OlpError as problem:
        promise("a Python without olp: refused", "OLP_PYTHON" in str(problem), str(problem)[:90])
    os.environ.clear()
    os.environ.update(kept)
    os.environ.pop("OLP_PYTHON")
    promise(
        "without a setting a Python is found",
        bool(ask.command("--version").strip()),
        ask.python_with_olp()[0],
    )
    os.environ.update(kept)
    close()


def the_rest():
    folder, path = copied(EDITED[0])
    document = FreeCAD.newDocument("mine")
    program = olp_freecad.open(path, robot=ROBOT, document=document)
    promise("opens into a document that is there", program.Document.Name == "mine")
    out = os.path.join(folder, "krl")
    said = olp_freecad.convert(program, "krl", out)
    promise("convert", any(one.endswith(".src") for one in os.listdir(out)), said.strip().splitlines()[-1])
    page = os.path.join(folder, "page.html")
    olp_freecad.report(program, page)
    promise("report", os.path.getsize(page) > 10_000)
    saved = os.path.join(folder, "saved.FCStd")
    total = program.Trajectory.Trajectory.Duration
    olp_freecad.move_point(program, "C00002", Placement(Vector(900, 0, 500), Rotation()))
    document.saveAs(saved)
    close()
    again = FreeCAD.openDocument(saved).getObject("Program")
    promise("saved and opened: the pending change is there", len(olp_freecad.pending(again)["points"]) == 1)
    promise("and the table", len(olp_freecad.segments(again)) > 5 and again.Sheet.get("B2"))
    promise("and the tool follows the time line", _follows(again))
    promise("and the trajectory", abs(again.Trajectory.Trajectory.Duration - total) < 1e-6)
    close()
    known = FreeCAD.getImportType("jbi")
    promise("File → Open knows .jbi", "olp_freecad.importer" in known, known)
    for suffix in ("src", "mod", "ls", "script"):
        promise(f"File → Open knows .{suffix}", "olp_freecad.importer" in FreeCAD.getImportType(suffix))


def _follows(program):
    before = Placement(program.Tool.Placement)
    program.Instant = 1.5
    return (program.Tool.Placement.Base - before.Base).Length > 1.0


def main():
    the_law()
    for name in PROGRAMS:
        the_duration(name)
    for name in EDITED:
        the_edit(name)
    without_a_robot()
    the_track()
    refusals()
    another_python()
    the_rest()


try:
    main()
except Exception:
    failed.append(traceback.format_exc())
for one in failed:
    print("FAILED:", one, file=sys.stderr)
print("all held" if not failed else f"{len(failed)} failed")
with open(os.environ["OLP_RESULT"], "w") as file:
    file.write("\n".join(failed) or "held")
