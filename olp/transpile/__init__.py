"""From one language to another: what the target cannot say is brought into what it can, and told in a receipt.

`canonical` brings a program of any language into the form that the writers take. In this form

- every move carries its speed, blend, tool and frame where one value reaches it: an exact stop is
  `Blend(RADIUS, 0)`; a joint move has a speed of a kind in `Limits.joint_speeds`, the others one in `path_speeds`;
- modal statements are gone, or assign to an ordinary variable that the moves name where several values reach them;
- a language with names (KRL, RAPID, URScript) gets every point, variable, tool and frame as a `Named` that is
  declared in `Program.data` (or in the routine, where it was local), with names that the language takes; a tool's
  value is the `PositionLiteral` of its centre point on the flange, a frame's its pose in the base;
- a language with numbers gets them: INFORM `Taught` points whose `PointState` names the user frame and tool, and
  numbered `Variable`s; TP `Taught` points, R[], PR[], SR[], and on each move `FrameRef("tool", n)` and
  `FrameRef("user", n)`;
- URScript, which knows the base only, gets `pose-product(frame, target)` as the target and `FrameRef("base")`;
- GOTO languages get `Label` and `Jump` for what they have no block for; URScript gets blocks for labels;
- what belongs to the other language alone (`Opaque`, `Process`, `Disabled`) is a comment or an error, as the user
  asked.

`Program.vendor` stays that of the language it was read from.
"""

from olp.transpile.context import Context, Loss, Mapping, Translated
from olp.transpile.pipeline import canonical

__all__ = ["Context", "Loss", "Mapping", "Translated", "canonical"]
