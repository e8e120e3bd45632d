"""What RAPID can say and how long its words may be (ABB, RAPID overview and kernel manuals, RobotWare 6)."""

from __future__ import annotations

from math import inf
from typing import Final

from olp.ir.program import AccelerationUnit, BlendKind, Path, SpeedUnit
from olp.languages.limits import Limits, PathTriggerForms, TrapWords, ValueTypes

# Words of the language, and data and routines that every controller has: a declaration of the same name is refused.
_WORDS: Final = """
    ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE ENDPROC
    ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOSTEPIN NOT
    NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP TRUE TRYNEXT UNDO
    VAR VIEWONLY WHILE WITH XOR
    NUM DNUM BOOL STRING BYTE POS ORIENT POSE ROBTARGET JOINTTARGET ROBJOINT EXTJOINT CONFDATA TOOLDATA WOBJDATA
    LOADDATA SPEEDDATA ZONEDATA SWITCH CLOCK INTNUM TOOL0 WOBJ0 LOAD0 FINE VMAX PI HIGH LOW EDGE
    ABS ACOS ASIN ATAN ATAN2 COS SIN SQRT TAN EXP POW ROUND TRUNC OFFS RELTOOL POSEMULT POSEINV CROBT CJOINTT DISTANCE
    MOVEJ MOVEL MOVEC MOVEABSJ SET RESET SETDO SETGO SETAO PULSEDO WAITTIME WAITDI WAITDO WAITUNTIL STOP BREAK CLEAR
    INCR DECR ADD ACCSET VELSET TPWRITE TPERASE DIM PRESENT"""
RESERVED: Final = frozenset(_WORDS.split())
LONGEST_TEXT: Final = 80  # [characters], of a string (kernel manual)

LIMITS = Limits(
    longest_text=LONGEST_TEXT,
    joint_lines=False,
    started="main",
    speeds_needed=True,
    angles_together=True,
    routine_name=32,
    variable_name=32,
    label_name=32,
    line=0,
    comment=0,
    points=0,
    statements=0,
    joint_speeds=frozenset({SpeedUnit.TRAVEL, SpeedUnit.TIME}),
    path_speeds=frozenset({SpeedUnit.TRAVEL, SpeedUnit.TIME}),
    blends=frozenset({BlendKind.RADIUS}),
    zero_blend_passes=True,  # z10\Z:=0 is a fly-by point as z10 is; what stops is finep (Technical reference manual)
    accelerations=frozenset({AccelerationUnit.FRACTION}),
    tool_and_frame="move",
    has_data_files=True,
    keeps_data=True,
    names=r"[A-Za-z][A-Za-z0-9_]*",
    has_xor=True,
    divides_whole=True,  # DIV and MOD of others are the error ERR_INT_NOTVAL
    # TriggIO and TriggEquip (ABB, technical reference manual, RobotWare 6)
    path_triggers=PathTriggerForms(
        most=8,
        paths=frozenset({Path.LINEAR, Path.CIRCULAR}),  # TriggJ takes no axis positions
        metres_on=frozenset({Path.LINEAR, Path.CIRCULAR}),
        seconds_at_start=(0.0, 0.0),
        seconds_at_end=(-0.5, 0.0),
        metres_at_start=(0.0, inf),
        metres_at_end=(-inf, 0.0),
        delayed=True,
    ),
    has_repeat=False,
    has_break=False,
    has_continue=False,
    bounds_turning=True,
    acceleration_range=(0.2, 1.0),  # AccSet takes less for 20 %
    reserved=RESERVED,
    watches_flags=True,
    computed_axes=True,
    value_types=ValueTypes(signals_are_states=False, persistent_systems=True),
    clocks=1000,  # as many as are declared
    states=frozenset({"manual-reduced", "manual-full"}),  # OpMode()
    state_signals={
        "at-home": (
            "out",
            "doAtHome",
            "configure doAtHome, on while the arm stands at the home position (WZHomeJointDef and WZDOSet)",
        ),
        "motors-on": ("out", "doMotorsOn", "configure doMotorsOn with the system output Motors On State"),
        "running": ("out", "doCycleOn", "configure doCycleOn with the system output Cycle On"),
        "faulted": ("out", "doExecError", "configure doExecError with the system output Execution Error"),
        "may-move": ("out", "doRunChainOk", "configure doRunChainOk with the system output Run Chain OK"),
        "guard-closed": ("out", "doRunChainOk", "configure doRunChainOk with the system output Run Chain OK"),
        "no-emergency-stop": (
            "out",
            "doRunChainOk",
            "configure doRunChainOk with the system output Run Chain OK",
        ),
    },
    ordered_arguments=True,  # they may be left out, but have no defaults
    reference_parameters=True,  # moves take tools that are persistent only
    array_literals=True,
    pose_sums=True,
    has_power=True,
    program_end="EXIT",
    stand="WaitRob",
    # BitAnd, BitOr and BitXOr take bytes.
    lacks=frozenset({"floor", "ceil", "and", "or", "xor", "number-of-condition"}),
    traps=TrapWords(
        data_type="intnum",
        connect="CONNECT",
        signals={"in": "ISignalDI", "out": "ISignalDO", "flag": "ISignalDO"},
        on="IWatch",
        off="ISleep",
        end="IDelete",
        stop="StopMove",
        keep="StorePath",
        restore="RestoPath",
        start="StartMove",
    ),
    refuses=frozenset(
        {
            "Clear",
            "DefineFrame",
            "ExternalTool",
            "Move spline",
            "Opaque",
            "Process",
            "Reference",
            "StartTask",
            "Synchronise",
            "WaitTask",
            "a variable whose type nothing tells",
            "a signal with a computed number",
            "data of the type",
        }
    ),
)
