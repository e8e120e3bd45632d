"""RAPID, the language of ABB robots: modules `.mod`, `.modx`, `.prg`, `.sys`, and the list `.pgf` of a program."""

from __future__ import annotations

import re

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import (
    ArmFlags,
    Conventions,
    CornerSpelling,
    ErrorHandling,
    MoveOptions,
    Vendor,
    statements,
)
from olp.languages.vendors.rapid.known_routines import REPLACEABLE, RESULT_TYPES, with_outside_calls
from olp.languages.vendors.rapid.predefined_data import TYPES

_PROCESSES = {
    **dict.fromkeys(
        [
            f"arc{path}{number}{end}"
            for path in "lc"
            for number in ("", "1", "2")
            for end in ("", "start", "end")
        ],
        "the weld",
    ),
    **dict.fromkeys(("spotl", "spotj", "spotml", "spotmj"), "the spot weld"),
    **dict.fromkeys(("paintl", "paintc"), "the paint"),
    **dict.fromkeys(("displ", "dispc"), "what is dispensed"),
    **dict.fromkeys(("laserl", "laserc", "cutl", "cutc", "capl", "capc"), "the cut"),
    **dict.fromkeys(("nutl", "nutj"), "the nut"),
}
_PROCESS_OPTIONS = frozenset(
    (
        *("on", "off", "conc", "weave", "track", "seamname", "retract", "opentool"),
        *("e1", "e2", "e3", "e4", "g1", "g2", "g3", "g4"),
    )
)
_MODULE = re.compile(r"\s*MODULE\s+\w+\s*(?:\(|!|$)", re.IGNORECASE)
_HEADER = re.compile(r"\s*%%%")
_LISTED = re.compile(r"\s*<Program\b")


class Rapid(Vendor):
    """ABB RAPID. Speeds mm/s and deg/s, lengths mm, turns as quaternions; all converted while reading."""

    name = "rapid"
    title = "ABB RAPID"
    suffixes = (".mod", ".modx", ".prg", ".sys", ".pgf")
    shared_suffixes = (".sys",)  # SYSTEM.SYS stands in other makers' backups
    reads = statements(
        "Update PulseOutput Label Jump ElseIf While EndWhile For Next Switch Case Default EndSwitch "
        "Pause Declare SetAcceleration SetOverride ObeyFlags ShiftOn ShiftOff Process Disabled Opaque"
    )
    folders_beside = ("../PROGMOD", "../SYSMOD")  # of a task in a backup
    comment_prefix = "!"
    trailing_comment_prefix = " !"
    comment_length = 80
    blending = "abb"
    conventions = Conventions(
        longest_text=80,  # kernel manual
        analog_values="the unit of the signal's configuration",
        usual_pulse=0.2,
        arm_flags=ArmFlags.QUARTERS,
        whole_turns=True,  # quaternions
        actions_at_ends=True,
        data_begin_anew=True,
        wide_numbers=frozenset({"dnum"}),
        override_begins_anew=True,
        systems_stay=True,  # CRobT()
        stops_early=True,  # "RAPID kernel" (3HAC050946), order of evaluation
        joint_target_word="moveabsj",
        move_options=MoveOptions(
            # Offsets of external axes, the number of a synchronized move, and the load of the tool.
            harmless=frozenset({"noeoffs", "id", "tload"}),
            # How exactly a stop is reached; other data of stop points wait there, or follow a conveyor.
            harmless_values={"inpos": frozenset({"inpos20", "inpos50", "inpos100"})},
            processes=_PROCESSES,
            process_options=_PROCESS_OPTIONS,
        ),
        own_names=re.compile(r"(?i:errno|intno|errdomain|err_\w+)"),
        idle_processes={
            "tperase": "clearing the pendant's window",
            "tpshow": "what the pendant shows",
            "errlog": "an entry in the event log",
            "skipwarn": "a missing entry in the event log",
            "bookerrno": "a number for an error of the program's own",
            "checkprogref": "looking for missing names",
            **dict.fromkeys(("spystart", "spystop"), "recording what runs"),
            **dict.fromkeys(("testsigndefine", "testsignreset"), "measuring a signal of the drives"),
        },
        standing_processes=frozenset({"waitrob"}),
        halting_process="stopmove",
        starting_process="startmove",
        manner_processes={
            "singarea": "how the arm passes singularities",
            "cirpathmode": "how the tool turns on arcs",
            "cornerpathwarning": "whether missed corners are told",
            "robconf": "which of its configurations the arm takes",
            **dict.fromkeys(("gripload", "mechunitload"), "what load is carried"),
            "motionsup": "when a collision is detected",
            **dict.fromkeys(("pathacclim", "worldacclim"), "how fast the tool may accelerate"),
            **dict.fromkeys(("speedlimaxis", "speedlimcheckpoint"), "how fast axes and their ends may move"),
            **dict.fromkeys(("tuneservo", "tunereset"), "how the drives are tuned"),
            **dict.fromkeys(("softact", "softdeact"), "how stiff the axes are"),
            **dict.fromkeys(
                [
                    *("wzboxdef", "wzcyldef", "wzsphdef", "wzhomejointdef", "wzlimjointdef"),
                    *("wzlimsup", "wzfree", "wzenable", "wzdisable"),
                ],
                "where the arm may not go",
            ),
            **dict.fromkeys(("ioenable", "iodisable"), "which units of the bus are active"),
            "procerrrecovery": "how errors of a process are answered",
            "hollowwristreset": "where the count of the wrist's turns begins",
            "pathresol": "in which steps paths are computed",
            "motionprocessmodeset": "for which process moves are tuned",
            **dict.fromkeys(("actunit", "deactunit"), "which mechanical units are active"),
        },
        controller_names=True,
        numeric_booleans=True,
        names_read_frames=True,
        errors=ErrorHandling(
            "errno",
            re.compile(r"err_\w+"),
            "err_wait_maxtime",
            "RETRY",
            "TRYNEXT",
            "RAISE",
            # Sockets, message queues, files, raw bytes, modules that are loaded.
            re.compile(
                "err_(?:sock_\\w+|rmq_\\w+|file(?:acc|exist|open|size)|filnotfnd|dev_maxtime|rcvdata|ranybin_(?:chk|eof)"
                "|loaded|loadno_(?:inuse|nouse)|prgmemfull|unload)"
            ),
        ),
        for_declares=True,
        for_turns=True,
        rounds_to_decimals=True,
        on_pulse="High",
        inverting_pulse=r"PulseDO without \High inverts the output",
        whole_numbers=False,
        replaceable_routines=REPLACEABLE,
        result_types=RESULT_TYPES,
        member_types={word.upper(): kind for word, kind in TYPES.items()},
        answers={
            "issyncmoveon": (
                False,
                "IsSyncMoveOn is FALSE there: robots of several tasks never move together",
            ),
        },
    )
    joint_moves = ((r"^(\s*)MoveL\b", r"\1MoveJ"),)
    corners = CornerSpelling(
        r"!", (r"\bfine\b", "z1"), r"\bz(\d+)\b", (1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)
    )
    editor_names = ("abb",)

    def sniff(self, source: Source) -> bool:
        if source.path.lower().endswith(".pgf"):
            return any(_LISTED.match(line) for line in source.lines[:5])
        head = source.lines[:400]
        if any(_MODULE.match(line) for line in head):
            return True
        return any(_HEADER.match(line) for line in head[:5]) and any("VERSION" in line for line in head[:6])

    def as_called(self, program: Program) -> Program:
        from olp.languages.vendors.rapid.interrupts import with_watches

        return with_watches(with_outside_calls(program))

    def read(self, source: Source) -> Program:
        from olp.languages.vendors.rapid.reader import read_program

        return read_program(source)


VENDOR = Rapid()
