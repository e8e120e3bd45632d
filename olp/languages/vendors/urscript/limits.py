"""What URScript can say (the script manual of e-Series; names and nesting as its controllers take them)."""

from __future__ import annotations

from typing import Final

from olp.ir.program import AccelerationUnit, BlendKind, SpeedUnit
from olp.languages.limits import Limits, ValueTypes
from olp.languages.vendors.urscript.builtins import JOINT_DEFAULTS, KNOWN, PATH_DEFAULTS
from olp.languages.vendors.urscript.helpers import COUNTER, TEXTS

_WORDS: Final = frozenset((
    "AND", "BREAK", "CONTINUE", "DEF", "ELIF", "ELSE", "END", "ENTER_CRITICAL", "EXIT_CRITICAL", "FALSE",
    "GLOBAL", "HALT", "IF", "JOIN", "KILL", "LOCAL", "NOT", "OR", "P", "RETURN", "RUN", "SEC", "STRUCT",
    "THREAD", "TRUE", "WHILE", "XOR",
))  # fmt: skip
# Other languages' numbers: 8 standard digital signals and 8 configurable ones of the box, two of the tool.
_LAST_SIGNALS: Final = {
    **dict.fromkeys(("in", "out"), 17),
    **dict.fromkeys(("configurable-in", "configurable-out"), 7),
    **dict.fromkeys(("tool-in", "tool-out", "analog-in", "analog-out"), 1),
}
_FURTHER_SIGNALS: Final = {way: ((16, f"tool-{way}"), (8, f"configurable-{way}")) for way in ("in", "out")}
# A name that the controller has for a function of its own would hide that function.
LIMITS: Final = Limits(
    text_decimals=False,
    dimensions="numbers",
    speeds_needed=True,
    angles_together=True,
    routine_name=0,
    variable_name=0,
    label_name=0,
    line=0,
    comment=0,
    points=0,
    statements=0,
    joint_speeds=frozenset({SpeedUnit.AXIS, SpeedUnit.FRACTION, SpeedUnit.TIME}),
    path_speeds=frozenset({SpeedUnit.TRAVEL, SpeedUnit.TIME}),
    blends=frozenset({BlendKind.RADIUS}),
    accelerations=frozenset({AccelerationUnit.TRAVEL, AccelerationUnit.AXIS}),
    tool_and_frame="modal",
    names=r"[A-Za-z_][A-Za-z0-9_]*",
    case_sensitive=True,
    has_goto=False,
    has_repeat=False,
    has_for=False,
    has_continue=True,
    has_xor=True,
    has_switch=False,
    reserved=_WORDS | frozenset(name.upper() for name in (*KNOWN, *TEXTS, COUNTER)),
    external_axes=0,
    has_override=False,
    has_configuration=False,
    blends_may_overlap=False,
    unprogrammed_acceleration=(
        "moves accelerate as URScript does where nothing is programmed: "
        f"paths at {PATH_DEFAULTS[0]} m/s², joint moves at {JOINT_DEFAULTS[0]} rad/s² of the leading axis"
    ),
    near_joints=True,
    no_external_axes="external axes: UR arms have none",
    array_literals=True,
    pose_functions=True,
    last_signals=_LAST_SIGNALS,
    further_signals=_FURTHER_SIGNALS,
    value_types=ValueTypes(signals_are_states=True, results_are_used=False),
    returned_parameters=True,
    has_power=True,
    shares_programs=False,
    program_end="halt",
    lacks=frozenset({"and", "or", "xor", "number-of-state"}),
    pulse_note="a thread of the program makes the pulse, and ends with it: keep the program going as long; "
    "a second pulse of the output before the first has ended ends with the first",
    text_quote='"',
    refuses=frozenset(
        {
            "Clear",
            "DefineFrame",
            "ExternalTool",
            "Move spline",
            "Opaque",
            "Process",
            "ReadInput",
            "Reference",
            "Synchronise",
            "data of the type",
        }
    ),
)
