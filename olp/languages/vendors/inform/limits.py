"""What INFORM can express: DX200 and later (survey of published jobs; controller manuals)."""

from __future__ import annotations

from typing import Final

from olp.core.units import deg, mm, percent
from olp.ir.expressions import Store
from olp.ir.program import AccelerationUnit, BlendKind, SpeedUnit
from olp.languages.limits import Limits, Registers

MOST_ARGUMENTS: Final = 8  # of a CALL, IARG#(1) to IARG#(8)

LONGEST_TEXT: Final = 32  # [characters], of a YRC1000's S000; a DX200 has 16 (from memory: no page at hand)

LIMITS: Final = Limits(
    longest_text=LONGEST_TEXT,
    dimensions="one",
    routine_name=32,
    variable_name=16,
    label_name=8,
    line=0,
    comment=32,
    points=9999,
    statements=9999,
    joint_speeds=frozenset({SpeedUnit.FRACTION}),
    path_speeds=frozenset({SpeedUnit.TRAVEL, SpeedUnit.TURN}),
    blends=frozenset({BlendKind.LEVEL, BlendKind.RADIUS}),
    joint_blends=frozenset({BlendKind.LEVEL}),
    accelerations=frozenset({AccelerationUnit.FRACTION}),
    tool_and_frame="point",
    names=r"[A-Za-z0-9_\-]+",
    wait_step=0.01,  # as DX100 to YRC1000 write it in published jobs; YRC1000micro has 0.001 s
    longest_wait=655.35,  # TIMER and T= of WAIT: 0.01 to 655.35 s (INFORM manual, from memory: no page at hand)
    case_sensitive=True,
    numbered={
        Store.BYTE: 100,
        Store.INTEGER: 100,
        Store.DOUBLE: 100,
        Store.REAL: 100,
        Store.STRING: 100,
        Store.ROBOT: 128,
    },
    # More are an option, as many as a parameter says (DX100, instructions for the high-speed Ethernet server,
    # HW1480958, 3.3.32): `///SHARE 2000,2000,2000,2000,2000,10000,10000,10000` is what a cell's list of names has for
    # its YRC1000 (R. Iglesias-Flores, parser of variable names, 2021). No page at hand tells of more.
    enlarged={
        **dict.fromkeys((Store.BYTE, Store.INTEGER, Store.DOUBLE, Store.REAL, Store.STRING), 2000),
        Store.ROBOT: 10_000,
    },
    has_repeat=False,
    has_break=False,
    for_counts_whole=True,
    one_routine_per_file=True,
    external_axes=6,
    has_override=False,
    speed_steps={SpeedUnit.FRACTION: 0.01 * percent, SpeedUnit.TRAVEL: 0.1 * mm, SpeedUnit.TURN: 0.1 * deg},
    speed_ranges={
        SpeedUnit.FRACTION: (0.01 * percent, 1.0),
        SpeedUnit.TRAVEL: (0.1 * mm, 1500.0 * mm),
        SpeedUnit.TURN: (0.1 * deg, 180.0 * deg),
    },
    acceleration_range=(0.2, 1.0),
    acceleration_step=percent,
    blend_ranges={BlendKind.RADIUS: (1.0 * mm, 6553.5 * mm)},
    radius_step=0.1 * mm,
    has_endless=False,
    nested_logic=False,
    # Jobs seen: DIN B010 IG#(30), DOUT OG#(2) B003; no SET … EXPRESS has a signal, no DOUT another variable.
    signal_variables={"in-group": "byte", "out-group": "byte"},
    timed_out="",
    ordered_arguments=True,
    registers=Registers(
        stores={
            "integer": Store.DOUBLE,
            "real": Store.REAL,
            "boolean": Store.BYTE,
            "byte": Store.BYTE,
            "string": Store.STRING,
            "position": Store.ROBOT,
            "joints": Store.ROBOT,
        },
        letters={
            Store.DOUBLE: "D",
            Store.REAL: "R",
            Store.BYTE: "B",
            Store.STRING: "S",
            Store.ROBOT: "P",
            Store.INTEGER: "I",
        },
        variable="{letter}{number:03d}",
        point="C{number:05d}",
        first_point=0,
        steps=True,
        comments=True,
        joint_elements="one axis of joint values: INFORM counts it in pulses",
        routines_own=frozenset(
            {Store.BYTE, Store.INTEGER, Store.DOUBLE, Store.REAL}
        ),  # LB, LI, LD, LR: ///LVARS
        real_index=False,
        elements=True,
        framed=True,
    ),
    separate_deceleration=True,
    chained_arcs=True,
    native_offsets=frozenset({"relative", "relative-tool"}),
    joint_offsets=False,  # IMOV is a straight move (INFORM manual, from memory: no page at hand)
    computed_turns=False,
    no_external_axes="external axes: in INFORM a track or a station has points of its own",
    named_frames=False,
    frame_numbers={"tool": 63, "user": 63},
    frame_functions=True,
    first_signal=1,
    spare_signals=2000,  # of 4096 inputs and outputs
    position_read_in="base",
    # A variable counts in finer units than a literal: 0.1 mm/s, 0.01 %, 0.1 deg/s, 0.01 s.
    variable_scales={0.001: 0.0001, 0.01: 0.0001, round(deg, 12): 0.1 * deg, 1.0: 0.01},
    conditional_statements=True,
    has_integers=True,
    tasks=15,  # of the larger controllers; smaller ones have five
    task_name="SUB{}",
    message=32,
    lacks=frozenset({"power", "max", "min", "floor", "ceil", "trunc", "and", "or", "xor"}),
    text_quote='"',
    refuses=frozenset(
        {
            "Clear",
            "Opaque",
            "Process",
            "Reference",
            "the tool or frame is computed",
            "a frame that is computed",
            "data of the type",
        }
    ),
)
