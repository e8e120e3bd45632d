"""FANUC TP, the teach pendant's language: `.ls` listings of the R-J2 to the R-30iB Plus generation."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from olp.core.source import Source
from olp.ir.program import Program, Routine, Statement
from olp.languages.vendor import ArmFlags, Conventions, CornerSpelling, MoveOptions, Vendor, Weld, statements

_COMMENT: Final = re.compile(rb"\s*\d*\s*:\s*!(.*?)\s*;?\s*", re.DOTALL)
WELDS: Final = (Weld("Arc Start", form="[{}]"), Weld("Arc End", form="[{}]"))


class Tp(Vendor):
    """FANUC TP. Speeds %, mm/sec, cm/min, inch/min and deg/sec; lengths mm; angles deg; all converted while reading."""

    name = "tp"
    title = "FANUC TP"
    suffixes = (".ls",)
    reads = statements(
        "Move_spline PulseOutput Label Jump For Next Switch Case Default EndSwitch Pause StartTask "
        "Declare SetTool SetFrame SetOverride Process Disabled Opaque"
    )
    # A line without a number: controllers count anew when they load a listing.
    comment_prefix = " : !"
    comment_suffix = " ;"
    trailing_comment_prefix = ""
    comment_length = 32
    blending = "fanuc"
    conventions = Conventions(
        longest_text=254,
        own_sign="$",
        on_from_one=True,  # "less than 1 and greater than -1" is off (R-30iB, mixed logic instructions)
        analog_values="the counts of its module",
        usual_pulse=0.4,  # $DEFPULSE as delivered
        for_keeps_last=True,  # ENDFOR counts on only where the counter is not at the target value yet
        arguments_are_values=True,
        surplus_arguments=True,
        sums_of_positions=True,
        sums_of_texts=True,
        zeroed_clock="a running timer that is reset is taken to go on, which no manual confirmed",
        arm_flags=ArmFlags.COUNTED,
        frame_spelling={"tool": "UTOOL[{}]", "user": "UFRAME[{}]"},
        wrist_target_axes=True,
        points_of_groups=True,
        records_in_statements=False,
        wait_limit_prefix="$",
        move_options=MoveOptions(
            manner=frozenset({"mrot", "pth", "wjnt"}),
            together=frozenset({"coord", "ev"}),
            processes={"arc": "arc welding"},
            process_options=frozenset({"mrot", "pth", "wjnt"}),
        ),
        manner_processes={
            "payload": "what load is carried",
            "rsr": "which programs a cell's controller may start",
            **dict.fromkeys(("col detect", "col guard adjust"), "when a collision is detected"),
            **dict.fromkeys(("lock preg", "unlock preg"), "how far ahead position registers are read"),
        },
        idle_processes={"diag_rec": "recording for a diagnosis"},
        silent_processes={
            "continue": "what a move does on its way",
            "offset condition": "a condition of offsets, which moves name themselves,",
            "tool_offset condition": "a condition of offsets, which moves name themselves,",
        },
        share_zones=True,
        welds=WELDS,
        pulse_setting="a pulse that names no time lasts as long as $DEFPULSE says: as delivered, 0.4 s, is written",
    )
    # CNT is a percentage.
    joint_moves = (
        (r"^(\s*\d*:\s*)L(\s+P\[.*?\]\s+)[\d.]+(?:mm/sec|cm/min|inch/min)", r"\g<1>J\g<2>{percent:.0f}%"),
    )
    corners = CornerSpelling(r"!|//", (r"\bFINE\b", "CNT10"), r"\bCNT(\d+)\b", (5, 10, 25, 50, 75, 100))
    editor_names = ("fanuc",)
    numbered_lines = True

    def comment_of(self, line: bytes) -> bytes | None:
        """Also of lines that a controller has numbered."""
        match = _COMMENT.fullmatch(line)
        return match[1] if match else None

    def spelled_out(
        self, body: tuple[Statement, ...], find: Callable[[str], Routine | None]
    ) -> tuple[Statement, ...]:
        from olp.languages.vendors.tp.instructions import with_deeds

        return with_deeds(body)

    def as_called(self, program: Program) -> Program:
        from olp.languages.vendors.tp.instructions import with_alarms

        return with_alarms(program)

    def sniff(self, source: Source) -> bool:
        return any(line.lstrip().upper().startswith("/PROG") for line in source.lines[:50])

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.tp.reader import read_program

        return read_program(source)


VENDOR = Tp()
