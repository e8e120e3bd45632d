"""What KRL can say, and how long its words may be (KUKA System Software 5 to 8, system integrator's manuals)."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Final

from olp.core.units import deg, percent
from olp.ir import terminology
from olp.ir.program import AccelerationUnit, BlendKind, Path, SpeedUnit
from olp.languages.limits import Limits, PathTriggerForms, ValueTypes
from olp.languages.vendors.krl.known_routines import FUNCTIONS
from olp.languages.vendors.krl.texts import HELPERS

_WORDS: Final = """
    AND ANIN ANOUT AXIS BAS BOOL BRAKE BRAKE_F B_AND B_EXOR B_NOT B_OR CA CASE CAST_FROM CAST_TO CCLOSE CHANNEL CHAR
    CHOPEN CIOCTL CIRC CIRC_REL CONDSTOP CONFIRM CONST CONTINUE COPEN COUTPUT CREAD CWRITE C_DIS C_ORI C_PTP C_SPL
    C_VEL DECL DEF DEFAULT DEFDAT DEFFCT DELAY DIGIN DISTANCE DO E6AXIS E6POS ELSE END ENDDAT ENDFCT ENDFOR ENDIF
    ENDLOOP ENDSPLINE ENDSWITCH ENDWHILE END_SPLINE ENUM EXIT EXOR EXT EXTFCT EXTFCTP EXTP FALSE FOR FRAME GLOBAL
    GOTO HALT IF IMPORT INT INTERRUPT IR_OFFSET IS LIN LIN_REL LOOP MAXIMUM MINIMUM NOT OFF ON ONSTART
    ON_ERROR_PROCEED OR OUT PATH POS PRIO PRIVATE PROCESS_SYNC PTP PTP_REL PTP_SPLINE PUBLIC PULSE REAL REPEAT
    RESUME RETURN SCIRC SCIRC_REL SEC SIG SIGNAL SLIN SLIN_REL SPL SPLINE SPTP SPTP_REL SREAD SSPL STEP STOP STRUC
    SWITCH SWRITE TECH_OFF THEN TIMEBLOCK TIME_BLOCK TO TRIGGER TRUE UNTIL VAR WAIT WHEN WHILE WITH X Y Z A B C S T
    E1 E2 E3 E4 E5 E6 A1 A2 A3 A4 A5 A6
"""
RESERVED: Final = frozenset(_WORDS.split()) | {name.upper() for name in FUNCTIONS}

LIMITS: Final = Limits(
    products_forget_flags=True,  # POS:FRAME is a FRAME
    joint_lines=False,
    routine_name=24,
    variable_name=24,
    label_name=24,
    line=471,
    comment=0,
    points=0,
    statements=0,
    joint_speeds=frozenset({SpeedUnit.FRACTION}),
    path_speeds=frozenset({SpeedUnit.TRAVEL, SpeedUnit.TURN}),
    blends=frozenset({BlendKind.RADIUS, BlendKind.SHARE, BlendKind.SPEED, BlendKind.TURN}),
    accelerations=frozenset({AccelerationUnit.FRACTION, AccelerationUnit.TRAVEL}),
    tool_and_frame="modal",
    has_continue=False,
    has_data_files=True,
    keeps_data=True,
    bounds_turning=True,
    speed_steps={SpeedUnit.FRACTION: percent},
    # $VEL_MA and $ACC_MA of the machine data, as arms with KR C4 are delivered.
    speed_ranges={
        SpeedUnit.FRACTION: (percent, 1.0),
        SpeedUnit.TRAVEL: (0.0, 3.0),
        SpeedUnit.TURN: (0.0, 400.0 * deg),
    },
    largest_turning=400.0 * deg,
    acceleration_range=(percent, 1.0),
    largest_rates={AccelerationUnit.TRAVEL: 10.0},
    blend_ranges={BlendKind.SHARE: (percent, 1.0), BlendKind.SPEED: (percent, 1.0)},
    acceleration_step=percent,
    unprogrammed_acceleration=(
        "paths accelerate and turn as INITMOV sets it where nothing is programmed: as delivered 2.3 m/s², 200 deg/s"
    ),
    has_elseif=False,
    joint_blends=frozenset({BlendKind.RADIUS, BlendKind.SHARE}),
    message=80,  # Msg_txt[] ("User messages", KSS 8)
    shortest_pulse=0.1,
    longest_pulse=3.0,  # PULSE, as its inline form, takes 0.1 to 3 s
    reserved=RESERVED | {"TEXT_WHOLE", *HELPERS},
    arcs_by_angle=True,
    # TRIGGER (KSS 8, programming instructions for system integrators)
    path_triggers=PathTriggerForms(
        most=8,
        paths=frozenset({Path.JOINT, Path.LINEAR, Path.CIRCULAR}),
        metres_on=frozenset({Path.LINEAR, Path.CIRCULAR}),
        seconds_at_start=(0.0, inf),
        seconds_at_end=(-inf, 0.0),
        metres_at_start=(0.0, inf),
        metres_at_end=(-inf, 0.0),
        delayed=True,
    ),
    native_offsets=frozenset({"relative", "relative-tool"}),
    frame_numbers={"tool": 16, "user": 32},
    first_signal=1,
    spare_signals=2000,  # of 4096 inputs and outputs
    declared_groups=True,
    has_xor=True,
    watches=True,
    position_read_in="move",
    integer_type="INT",
    for_counts_whole=True,
    has_integers=True,
    unset_variables=True,
    value_types=ValueTypes(signals_are_states=True),
    ordered_arguments=True,
    texts_by_statement=True,
    reference_parameters=True,  # arrays are handed over in no other way
    wait_poll=0.012,
    data_beside=True,
    states=frozenset({"manual-reduced", "manual-full", *terminology.STATES}),  # $T1, $IN_HOME …
    clocks=20,
    clock_form="$TIMER[{}]",
    clock_unit=0.001,
    zeroing_stops=False,
    form_points="X",
    lacks=frozenset({"power", "max", "min", "floor", "ceil", "number-of-state"}),
    text_quote='"',
    refuses=frozenset(
        {
            "Clear",
            "DefineFrame",
            "Move spline",
            "Opaque",
            "Process",
            "Reference",
            "StartTask",
            "Synchronise",
            "WaitTask",
            "data of the type",
        }
    ),
)

# Inline forms name tools and frames by number, and 100 % of their acceleration is what $config.dat says.
FORMS: Final = replace(
    LIMITS,
    forms=True,
    unprogrammed_acceleration=(
        "moves accelerate and turn as inline forms do with ACC 100 where nothing is programmed: as delivered 50 % of "
        "what the axes can (--plain writes 100 %), 2.3 m/s², 200 deg/s"
    ),
)
