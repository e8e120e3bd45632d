"""KRL, the language of KUKA robots: `.src` and `.sub` programs with the `.dat` lists beside them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

from olp.core.source import Source
from olp.ir.program import Program, Routine, Statement
from olp.languages.vendor import ArmFlags, Conventions, CornerSpelling, MoveOptions, Vendor, statements
from olp.languages.vendors.krl.known_routines import REPLACEABLE
from olp.languages.vendors.krl.scope import NEUTRAL_TYPES

_SIGNS = re.compile(
    r"\s*(?:&ACCESS|&REL\s|&PARAM\s|(?:GLOBAL\s+)?DEF(?:FCT|DAT)?\s+[\w$](?!.*:\s*$)|;FOLD\s)", re.IGNORECASE
)
_LOOKED_AT = 60  # lines
_OF_EACH_AXIS = ("$acc_axis", "$gear_jerk", "$collmon_tol_pro")


class Krl(Vendor):
    """KUKA KRL. Lengths mm, angles deg, path speeds m/s, joint speeds %; all converted while reading.

    A `.dat` is known by its text, because other makers use that suffix for other things.
    """

    name = "krl"
    title = "KUKA KRL"
    suffixes = (".src", ".sub")
    reads = statements(
        "Move_spline SetSpeed PulseOutput Label Jump ElseIf While EndWhile For Next Switch Case Default "
        "EndSwitch Pause Repeat Until Break Declare SetAcceleration SetBlend SetTool SetFrame "
        "SetOverride ExternalTool Process Opaque"
    )
    list_suffixes = (".dat",)
    comment_prefix = ";"
    trailing_comment_prefix = " ;"
    comment_length = 200
    blending = "kuka"
    advance_stops = True
    conventions = Conventions(
        own_sign="$",
        analog_values="a share of 10 V",
        arm_flags=ArmFlags.SIGNS,
        frame_spelling={"tool": "TOOL_DATA[{}]", "user": "BASE_DATA[{}]"},
        frame_files={"tool": "$config.dat", "user": "$config.dat"},
        partial_targets=True,
        text_arrays=True,
        data_last=True,
        operator_sets={"$OV_PRO": "the speed that the operator has chosen is taken for 100 % at the start"},
        records_in_statements=False,
        frame_records=True,
        member_types=NEUTRAL_TYPES,
        numbered_frame_values=True,
        waits_before_reading=True,
        # The advance run goes on past the next statement, and every program of KUKA's editor declares a stop handler.
        idle_routines={
            "set_cd_params": "the setting of the collision detection",
            "delete_backward_buffer": "clearing what moving backward has recorded",
        },
        silent_processes={"continue": "CONTINUE", "stop-handler": "the stop handler"},
        # Without an advance run no move is blended; with any, its length moves nothing.
        idle_processes={
            "option-start": "the start of an option package",
            "cyclic-condition": "a condition that stands where its flag is read",
        },
        idle_settings={
            "$advance": ("the length of the advance run", 1.0),
            "$ov_jog": ("the speed of moving by hand", 0.0),
            "$act_tool": ("the number of the tool that is shown", 0.0),
            "$act_base": ("the number of the frame that is shown", 0.0),
            "$loop_cont": ("whether the operator may skip what is waited for", 0.0),
        },
        manner_settings={
            "$load": "the load that the arm carries",
            "$load_a3": "the load on the arm",
            "$jerk": "the rate of acceleration",
            "$gear_jerk": "the rate of acceleration",
            "$acc": "the acceleration with which the tool turns",
            "$vel": "the speed with which the tool turns about its own axis",
            "$vel_axis": "the speed of single axes",
            "$acc_axis": "the acceleration of single axes",
            "$vel_extax": "the speed of external axes",
            "$acc_extax": "the acceleration of external axes",
            "$ori_type": "how the tool turns along a line",
            "$circ_type": "how the tool turns along an arc",
            "$spl_ori_joint_auto": "how the tool turns along a line",
            "$target_status": "which arm flags a line may leave",
            "$softn_end": "the limits of the axes",
            "$softp_end": "the limits of the axes",
            "$torqmon_def": "the collision detection",
            "$torqmon_com": "the collision detection",
            "$torqmon_com_def": "the collision detection",
            "$torqmon_time": "the collision detection",
            "$pal_mode": "how a palletizing arm keeps its tool level",
        },
        idle_words=frozenset({"ext", "extfct", "extp", "extfctp"}),
        manner_processes={
            "message-detail": "how a message looks, who may clear it and how long it stands",
            "on_error_proceed": "whether the next statement may fail",
            "confirm": "acknowledging a message",
            "brake": "how the arm stops while the routine of an interrupt runs",
            **dict.fromkeys(("spline", "ptp_spline", "endspline"), "how a spline block passes its points"),
            "time_block": "how long the parts of a spline take",
            "const_vel": "where the speed along a spline stays the same",
        },
        window_process="message-window",
        replaceable_routines=REPLACEABLE,
        answers={"exists_krlmsg": (False, "no message stands there: its text is shown once")},
        off_pulse="FALSE",
        move_options=MoveOptions(
            manner=frozenset(
                {
                    "$acc",
                    "$acc.ori1",
                    "$acc.ori2",
                    "$apo",
                    "$circ_type",
                    "$jerk",
                    "$load",
                    "$ori_type",
                    "$vel.ori2",
                }
                | {f"{name}[{axis}]" for name in _OF_EACH_AXIS for axis in range(1, 13)}
                | {f"$vel_axis[{axis}]" for axis in range(2, 13)}
            ),
            silent="$",  # set by inline forms
            ends_elsewhere=frozenset({"#CONSTANT"}),  # of $ORI_TYPE: the tool is not turned as the point says
        ),
        # What inline forms hand to BAS.
        halting_process="brake",
        leaving_process="resume",
        interrupted_places={"$pos_int": "current-pose", "$axis_int": "current-joints"},
        returning_places=frozenset({"$pos_ret", "$axis_ret"}),
        assumed_codes=frozenset({"P413"}),
        file_points=re.compile(r"X(?!HOME$)\w+", re.IGNORECASE),  # of inline forms
        resolved_variables=frozenset({"FDAT_ACT", "PDAT_ACT", "LDAT_ACT", "$BWDSTART", "$H_POS"}),
        told_settings={
            "$H_POS": "the controller's home position ($H_POS, of its signal $IN_HOME) is not set"
        },
    )
    joint_moves = (
        (r"^(\s*)LIN\b(?!\s*\{[^}]*$)(.*\S)\s+C_(?:DIS|VEL|ORI)\b", r"\1PTP\2 C_PTP"),
        (r"^(\s*)LIN\b", r"\1PTP"),
    )
    corners = CornerSpelling(r";", (r"\b(LIN|CIRC)(?:_REL)?\b.*\S(?=\s*$)", r"\g<0> C_DIS"), r"(?!)")
    editor_names = ("kuka",)
    library_files = frozenset(
        {
            *("bas", "braketestreq", "braketestselftest", "collmonlib", "h50", "ir_stopm"),
            *("masref_main", "msglib", "tm_bib", "user_grp", "userspot"),
        }
    )

    def folders_with(self, folder: Path) -> list[Path]:
        from olp.languages.vendors.krl.companions import tree_of

        return [folder, *(one for one in tree_of(folder) if one != folder)]

    def spelled_out(
        self, body: tuple[Statement, ...], find: Callable[[str], Routine | None]
    ) -> tuple[Statement, ...]:
        from olp.languages.vendors.krl.library import with_modes, without_library
        from olp.languages.vendors.krl.triggers import with_triggers

        return with_modes(without_library(with_triggers(body, find), find))

    def without_editor_comments(self, body: tuple[Statement, ...]) -> Sequence[Statement]:
        from olp.languages.vendors.krl.folds import without_folds

        return without_folds(body)

    def as_called(self, program: Program) -> Program:
        from olp.languages.vendors.krl.controller import (
            reading_of,
            with_channel_calls,
            with_kept_settings,
            with_numbered_clocks,
            with_own_layouts,
            with_plain_functions,
        )
        from olp.languages.vendors.krl.library import (
            with_cyclic_flags,
            with_given_parameters,
            with_record_messages,
            with_status_members,
            without_unknown_types,
        )

        program = with_record_messages(with_given_parameters(with_numbered_clocks(program)))
        program = with_plain_functions(with_status_members(with_cyclic_flags(program)))
        program = with_channel_calls(program)
        reading = reading_of(program)
        kept = with_kept_settings(program, reading)
        return without_unknown_types(with_own_layouts(kept, reading if kept is program else reading_of(kept)))

    def sniff(self, source: Source) -> bool:
        return any(_SIGNS.match(line) for line in source.lines[:_LOOKED_AT])

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.krl.reader import read_program

        return read_program(source)


VENDOR = Krl()
