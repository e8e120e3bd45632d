"""What FANUC TP can say: an R-30iA or later controller (programs of up to 36 characters, IF … THEN, FOR … ENDFOR)."""

from __future__ import annotations

from typing import Final

from olp.core.units import deg, mm, percent
from olp.ir.expressions import Store
from olp.ir.program import AccelerationUnit, BlendKind, Path, SpeedUnit
from olp.languages.limits import Limits, PathTriggerForms, Registers

COMMENT_LENGTH: Final = 32  # of a line of its own
NAME_LENGTH: Final = 16  # of the comment in R[1:…], P[1:…], LBL[1:…]
ROUTINE_LENGTH: Final = 36  # R-30iA and later; the R-J3 and before take 8
LARGEST_LABEL: Final = 32766
MOST_ARGUMENTS: Final = 10  # of a CALL, AR[1] to AR[10]

# SELECT jumps or calls and holds no blocks: for a translation that is no switch. Labels are numbers whose comment is
# the label's name, so their length has no bound.
LIMITS: Final = Limits(
    longest_text=254,  # of a string register (R-30iB, string register instructions; from memory)
    dimensions="one",
    untaught_points=True,  # ********
    speeds_needed=True,
    routine_name=ROUTINE_LENGTH,
    variable_name=NAME_LENGTH,
    label_name=0,
    line=254,
    comment=COMMENT_LENGTH,
    points=32766,
    statements=9999,
    joint_speeds=frozenset({SpeedUnit.FRACTION, SpeedUnit.TIME}),
    path_speeds=frozenset({SpeedUnit.TRAVEL, SpeedUnit.TURN, SpeedUnit.TIME}),
    blends=frozenset({BlendKind.SPEED, BlendKind.RADIUS}),
    accelerations=frozenset({AccelerationUnit.FRACTION}),
    tool_and_frame="modal",
    names=r"[A-Za-z][A-Za-z0-9_]*",
    # $WAITTMOUT takes 0 to 32767 hundredths (industrialmonitordirect.com, wait timeout), WAIT as much (from memory)
    longest_wait=327.67,
    wait_step=0.01,  # as pendants write it in published listings: WAIT    .50(sec)
    # DO[1]=PULSE,0.1sec to 25.5sec (operator's manual, I/O instructions; from memory, no page at hand)
    shortest_pulse=0.1,
    longest_pulse=25.5,
    numbered={Store.REAL: 200, Store.ROBOT: 100, Store.STRING: 25},
    # At controlled start (Program Limits Setup): position registers up to 2000 for one group, numbers up to 1500 of an
    # R-30iB (the numbers from memory, no page at hand); texts: no bound told.
    enlarged={Store.REAL: 1500, Store.ROBOT: 2000, Store.STRING: 1000},
    spare_signals=200,  # of 512 digital inputs and outputs (from memory, no page at hand)
    own_signals=frozenset({"robot-in", "robot-out"}),
    has_goto=True,
    has_while=False,
    has_repeat=False,
    # From memory, no page at hand; FOR has the same ten (blog.csdn.net/weixin_31022521/article/details/112104526).
    deepest_if=10,
    has_for=True,
    has_break=False,
    has_switch=False,
    one_routine_per_file=True,
    timed_out="jump",
    wait_setting="$WAITTMOUT",
    program_end="ABORT",
    # TB, TA and DB (R-30iB, operator's manual, time before and distance before)
    path_triggers=PathTriggerForms(
        most=1,
        paths=frozenset({Path.JOINT, Path.LINEAR, Path.CIRCULAR}),
        metres_on=frozenset({Path.LINEAR, Path.CIRCULAR}),
        seconds_at_start=(0.0, -1.0),
        seconds_at_end=(-30.0, 0.5),
        metres_at_start=(0.0, -1.0),
        metres_at_end=(-0.9999, 0.0),
        delayed=False,
    ),
    reserved=frozenset({"CON", "PRN", "AUX", "NUL"}),
    external_axes=3,
    has_elseif=False,
    for_step_is_one=True,
    # "INTP-672 Value type is not integer", also where a division or 2.0 gave a whole number (R-30iB, operator's manual,
    # FOR/ENDFOR instructions)
    for_bounds_whole=True,
    speed_steps={SpeedUnit.FRACTION: percent},
    acceleration_step=percent,
    joint_blends=frozenset({BlendKind.SPEED}),  # CR and CD are for lines and arcs
    speed_ranges={
        SpeedUnit.FRACTION: (percent, 1.0),
        SpeedUnit.TRAVEL: (1.0 * mm, 2000.0 * mm),
        SpeedUnit.TURN: (1.0 * deg, 272.0 * deg),
        SpeedUnit.TIME: (0.1, 3200.0),
    },
    acceleration_range=(percent, 1.5),
    blend_ranges={BlendKind.SPEED: (0.0, 1.0), BlendKind.RADIUS: (0.0, 1.0)},
    radius_step=1.0 * mm,
    comment_swaps={";": ","},  # it ends a line, wherever it stands
    ordered_arguments=True,
    registers=Registers(
        stores={
            "integer": Store.REAL,
            "real": Store.REAL,
            "boolean": Store.REAL,
            "string": Store.STRING,
            "position": Store.ROBOT,
            "joints": Store.ROBOT,
        },
        letters={Store.REAL: "R", Store.STRING: "SR", Store.ROBOT: "PR"},
        variable="{letter}[{number}]",
        point="P[{number}]",
        first_point=1,
    ),
    native_offsets=frozenset({"relative", "offset"}),
    external_units=3,
    no_external_axes="external axes: the program does not say which of them slide [mm] and which turn [deg]",
    joint_values_note=(
        "FANUC's controllers read J3 against the horizontal, this robot's does not: joint values are as written"
    ),
    named_frames=False,
    frame_numbers={"tool": 10, "user": 9},
    first_signal=1,
    manual_signal=("system-out", 8),  # TPENBL: in T1 and T2 programs run with the teach pendant enabled alone
    has_exclusive_or=False,
    # "The maximum number of items (data or operators) is approximately 20", less for some data (R-30iB, operator's
    # manual, mixed logic instructions).
    most_items=20,
    clocks=10,
    clock_form="TIMER[{}]",
    state_signals={
        "at-home": (
            "system-out",
            7,
            "set reference position 1 to the home position, at which UO[7] is on",
        ),  # ATPERCH
        "motors-on": ("system-out", 2, "see that UO[2] SYSRDY is on while the motors are"),
        "running": ("system-out", 3, "see that UO[3] PROGRUN is on while a program runs"),
        "faulted": ("system-out", 6, "see that UO[6] FAULT is on while an error stands"),
        "no-emergency-stop": ("system-in", 1, "see that UI[1] *IMSTP is off at an emergency stop"),
        "guard-closed": ("system-in", 3, "see that UI[3] *SFSPD is off while the guard is open"),
        "may-move": ("system-in", 8, "see that UI[8] ENBL is on while the arm may move"),
    },
    position_read_in="move",
    register_arguments=True,
    lone_functions=frozenset(
        {
            "joined-text",
            "length-of-text",
            "match-in-text",
            "part-of-text",
            "position-in-text",
            "text-of-value",
        }
    ),
    message=24,
    fixed_messages=True,
    multiplies_poses=False,
    lacks=frozenset({"power", "max", "min", "floor", "ceil", "and", "or", "xor"}),
    text_quote="'",
    refuses=frozenset(
        {
            "Clear",
            "DefineFrame",
            "ExternalTool",
            "Opaque",
            "Process",
            "Reference",
            "Synchronise",
            "WaitTask",
            "the tool or frame is computed",
            "data of the type",
        }
    ),
)
