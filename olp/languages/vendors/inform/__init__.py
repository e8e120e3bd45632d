"""INFORM, the language of Yaskawa (Motoman) jobs: `.JBI` files of the ERC to the YRC1000 generation."""

from __future__ import annotations

from typing import Final

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import ArmFlags, Conventions, CornerSpelling, Vendor, Weld, statements

WELDS: Final = (Weld("ARCON", "ASF#"), Weld("ARCOF", "AEF#"))


class Inform(Vendor):
    """Yaskawa INFORM. Speeds mm/s, % and deg/s; lengths mm; angles deg; all converted while reading."""

    name = "inform"
    title = "Yaskawa INFORM"
    suffixes = (".jbi",)
    reads = statements(
        "Move_spline Reference SetSpeed Update Clear PulseOutput ReadInput Label Jump ElseIf While "
        "EndWhile For Next Switch Case Default EndSwitch Pause StartTask WaitTask Synchronise ShiftOn "
        "ShiftOff DefineFrame ExternalTool Process Begin End Disabled Opaque"
    )
    comment_prefix = "'"
    trailing_comment_prefix = "  //"
    comment_length = 32
    shares_names = False
    blending = "yaskawa"
    written_suffix = ".JBI"
    conventions = Conventions(
        longest_text=32,
        own_sign="$",
        analog_values="volts",
        usual_pulse=0.3,
        group_sizes={"in-group": 8, "out-group": 8, "in-half-group": 4, "out-half-group": 4},
        arguments_are_values=True,
        arm_flags=ArmFlags.FLAGS,
        frame_spelling={"tool": "TL#({})", "user": "UF#({})"},
        frame_files={"tool": "TOOL.CND", "user": "UFRAME.CND"},
        first_variable=0,
        taught_frames=True,
        speed_persists=True,
        waits_before_reading=True,
        sets_tool_zero=True,
        blend_levels=True,
        has_records=False,
        saved_variables=True,
        sums_of_positions=True,
        surplus_arguments=True,
        returns_by_register=True,
        known_functions=True,
        idle_processes={"memof": "ending a memory of passes", "clear": "clearing a memory of passes"},
        welds=WELDS,
    )
    # PL as the manual counts it.
    joint_moves = ((r"^(\s*)MOVL\b(.*?)\bV=[\d.]+", r"\1MOVJ\2VJ={percent:.2f}"),)
    corners = CornerSpelling(
        r"//|^\s*'", (r"\bPL=0\b", "PL=1"), r"\bPL=(\d)\b", (1, 2, 3, 4, 5, 6, 7, 8), exact_is_zone=True
    )
    editor_names = ("yaskawa", "motoman")
    indented_comments = False
    call_mark = "JOB:"
    call_words = r"(?:CALL|JUMP|PSTART)\s*$"
    writes_probes = True

    def sniff(self, source: Source) -> bool:
        head = source.lines[:50]
        return any(line.startswith(("/JOB", "//NAME ", "//INST")) for line in head)

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.inform.reader import read_program

        return read_program(source)


VENDOR = Inform()
