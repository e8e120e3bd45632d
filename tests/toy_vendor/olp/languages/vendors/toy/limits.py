"""What TOY can say."""

from __future__ import annotations

from typing import Final

from olp.core.units import percent
from olp.ir.program import BlendKind, SpeedUnit
from olp.languages.limits import Limits

_WORDS: Final = """
    JOINT LINE ARC SPEED BLEND TOOL FRAME OUT PAUSE WAIT IF THEN ELSEIF ELSE ENDIF WHILE DO ENDWHILE FOR TO STEP ENDFOR
    BREAK LABEL GOTO CALL FLANGE WORLD RETURN SAY STOP ON OFF IN OFFSET AND OR NOT POSE AXES NUM TOYPROGRAM ROUTINE"""

# Kinds of statements, and words of the refusals of other things.
_REFUSED: Final = frozenset({
    "Move spline", "ShiftOn", "ShiftOff", "ExternalTool", "DefineFrame", "Reference", "Clear", "PulseOutput",
    "ReadInput", "StartTask", "WaitTask", "Synchronise", "Process", "Opaque", "data of the type", "a value of a kind",
    "the function", "a pose seen in another",
})  # fmt: skip
LIMITS: Final = Limits(
    routine_name=24,
    variable_name=24,
    label_name=24,
    line=0,
    comment=0,
    points=0,
    statements=0,
    joint_speeds=frozenset({SpeedUnit.FRACTION}),
    path_speeds=frozenset({SpeedUnit.TRAVEL}),
    blends=frozenset({BlendKind.RADIUS}),
    accelerations=frozenset(),
    tool_and_frame="move",
    has_repeat=False,
    has_switch=False,
    external_axes=0,
    has_override=False,
    has_configuration=False,
    speed_steps={SpeedUnit.FRACTION: percent},
    refuses=_REFUSED,
    reserved=frozenset(_WORDS.split()),
)
