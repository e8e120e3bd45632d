"""URScript, the language of Universal Robots: `.script` files, PolyScope's exports among them, and `.urp` programs."""

from __future__ import annotations

import re
import zlib

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import Conventions, CornerSpelling, MoveOptions, Vendor, statements
from olp.languages.vendors.urscript.builtins import NO_TIME
from olp.languages.vendors.urscript.known_routines import (
    FILLING,
    REPLACEABLE,
    RESULT_TYPES,
    SETTINGS,
    with_outside_calls,
)
from olp.languages.vendors.urscript.list_values import with_arrays

_DEFINITION = re.compile(r"\s*(?:def|thread|sec)\s+\w+\s*\([^)]*\)\s*:")
_MOVE = re.compile(r"\s*(?:move[jlpc]|set_tcp|set_payload|set_(?:standard_)?digital_out)\s*\(")
_GZIP = b"\x1f\x8b"
# What PolyScope writes at the head of each program: the load, gravity, and what the plugs of arm and box are.
_SETTINGS = (
    "set_analog_outputdomain",
    "set_gravity",
    "set_input_actions_to_default",
    "set_payload",
    "set_payload_cog",
    "set_payload_mass",
    "set_safety_mode_transition_hardness",
    "set_standard_analog_input_domain",
    "set_target_payload",
    "set_tool_analog_input_domain",
    "set_tool_communication",
    "set_tool_digital_output_mode",
    "set_tool_output_mode",
    "set_tool_voltage",
    *sorted(SETTINGS),
)


class UrScript(Vendor):
    """Lengths m, angles rad, orientations as rotation vectors: all as olp holds them, but for the orientations."""

    name = "urscript"
    title = "Universal Robots URScript"
    suffixes = (".script", ".urp", ".urscript")
    packed_suffixes = (".urp",)
    reads = statements(
        "ElseIf While EndWhile Pause StartTask WaitTask Break Continue Declare SetTool PulseOutput Process Opaque"
    )
    comment_prefix = "#"
    trailing_comment_prefix = "  # "
    comment_length = 120
    newline = "\n"
    blending = "ur"
    conventions = Conventions(
        first_element=0,
        ramps_in_time=True,
        counted_signals={
            f"counted-{way}": ((16, f"tool-{way}"), (8, f"configurable-{way}"), (0, way))
            for way in ("in", "out")
        },
        analog_values="a share of the output's range",
        pose_lists=True,
        whole_turns=True,  # rotation vectors
        move_options=MoveOptions(
            harmless=frozenset({NO_TIME}), manner=frozenset({"mode", "process", "v"})
        ),  # v beside a time, which counts
        arguments_are_values=True,
        opened_by=frozenset({"interpreter_mode"}),
        data_set_by_run=True,
        window_process="popup",
        manner_processes={
            "sync": "how long a step of the controller is",
            "enter_critical": "whether other threads run meanwhile",
            "exit_critical": "whether other threads run meanwhile",
        },
        idle_processes=dict.fromkeys(_SETTINGS, "a setting of the controller"),
        replaceable_routines=REPLACEABLE,
        filling_routines=FILLING,
        result_types=RESULT_TYPES,
    )
    joint_moves = (  # at the speed and acceleration that movej has by itself
        (r"^(\s*)movel\((.*?),\s*a\s*=\s*[\d.]+\s*,\s*v\s*=\s*[\d.]+", r"\1movej(\2, a=1.4, v=1.05"),
    )
    corners = CornerSpelling(r"#", (r"\)(?=\s*$)", ", r=0.001)"), r"\br=(0?\.\d+)\b")  # r in metres
    editor_names = ("ur",)
    case_sensitive = True

    def sniff(self, source: Source) -> bool:
        if source.raw.startswith(_GZIP):
            return _is_polyscope(source.raw)
        if source.raw.startswith((b"<", b"\xef\xbb\xbf<")):
            return source.raw.startswith(b"<URProgram")
        lines = (*source.lines[:2000], *source.lines[2000:][-100:])  # a long program ends far below
        defines = any(_DEFINITION.match(line) for line in lines)
        ends = any(line.strip() == "end" for line in lines)
        return (defines and ends) or any(_MOVE.match(line) for line in lines)

    def as_called(self, program: Program) -> Program:
        return with_outside_calls(with_arrays(program))

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.urscript.reader import read_program

        return read_program(source)


def _is_polyscope(raw: bytes) -> bool:
    """Whether the compressed text begins as PolyScope's programs do."""
    try:
        return b"<URProgram" in zlib.decompressobj(31).decompress(raw[:4096], 1024)
    except zlib.error:
        return False


VENDOR = UrScript()
