"""Robot programs in FreeCAD, timed by olp.

    import olp_freecad

    program = olp_freecad.open("job.jbi", robot="yaskawa/ma2010")
    program.TotalSeconds, program.Trajectory.Trajectory.Duration
    olp_freecad.move_point(program, "C00002", FreeCAD.Placement(...))
    olp_freecad.set_speed(program, 30, 120.0)
    olp_freecad.write_back(program, "changed.jbi")

Works in freecadcmd as in the graphical program.
"""

from olp_freecad.ask import OlpError
from olp_freecad.changes import move_point, pending, set_speed, write_back
from olp_freecad.commands import convert, report
from olp_freecad.program import open, refresh, segments, show_at, track

__all__ = [
    "OlpError",
    "convert",
    "move_point",
    "open",
    "pending",
    "refresh",
    "report",
    "segments",
    "set_speed",
    "show_at",
    "track",
    "write_back",
]
