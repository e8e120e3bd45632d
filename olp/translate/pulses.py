"""Pulses of outputs: how long one lasts that names no time, and which way it switches."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.expression import Number, Quantity
from olp.program import Program, PulseOutput, Statement
from olp.translate.limits import limits_of
from olp.translate.work import Fate, Work

_LOW: Final = "FALSE"  # KRL's pulse that switches an output off
_SET_ELSEWHERE: Final = (
    "a pulse that names no time lasts as long as $DEFPULSE says: as delivered, 0.4 s, is written"
)
_INVERTS: Final = "PulseDO without \\High inverts the output: a pulse that switches it on is written"


def pulses(program: Program, work: Work) -> Program:
    """Every pulse with its time, as each language takes another one where none is named; those to off are refused."""
    if not any(isinstance(s, PulseOutput) for s in program.statements()):
        return program
    usual = limits_of(program.vendor).pulse

    def pulse(s: Statement) -> Statement:
        if not isinstance(s, PulseOutput):
            return s
        if program.vendor == "krl" and s.spelling == _LOW:
            work.lose(s, Fate.REFUSED, "statement", "a pulse that switches an output off, or may do so")
        if program.vendor == "rapid" and s.spelling != "High":
            work.note_at(s, _INVERTS)
        if s.duration is not None or not usual:
            return s
        if program.vendor == "tp":
            work.lose(s, Fate.APPROXIMATED, "duration", _SET_ELSEWHERE)
        return replace(s, duration=Quantity(Number(usual), 1.0))

    return replace(
        program,
        routines=tuple([replace(r, body=tuple([pulse(s) for s in r.body])) for r in program.routines]),
    )
