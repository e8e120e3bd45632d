"""Pulses of outputs: how long one lasts that names no time, and which way it switches."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.ir.expressions import Number, Quantity
from olp.ir.program import Program, PulseOutput, Statement
from olp.languages.limits import limits_of
from olp.transpile.context import Fate, TranslationContext

_INVERTS: Final = "a pulse that switches it on is written"


def pulses(program: Program, work: TranslationContext) -> Program:
    """Every pulse with its time, as each language takes another one where none is named; those to off are refused."""
    if not any(isinstance(s, PulseOutput) for s in program.statements()):
        return program
    usual, own = limits_of(program.vendor).pulse, work.conventions

    def pulse(s: Statement) -> Statement:
        if not isinstance(s, PulseOutput):
            return s
        if own.off_pulse and s.spelling == own.off_pulse:
            work.lose(s, Fate.REFUSED, "statement", "a pulse that switches an output off, or may do so")
        if own.on_pulse and s.spelling != own.on_pulse:
            work.note_at(s, f"{own.inverting_pulse}: {_INVERTS}")
        lasts = s.duration.literal if s.duration is not None else usual or None
        longest = work.limits.longest_pulse
        if longest and lasts is not None and lasts > longest:
            says = f"a pulse of {lasts:g} s: {longest:g} s is the longest one"
            help = "set the output, wait and reset it, or --on-loss comment writes it as a comment"
            work.lose(s, Fate.REFUSED, "statement", says, help=help)
        elif longest and lasts is None:
            work.note_at(s, f"a pulse that is computed must not last longer than {longest:g} s")
        if s.duration is not None or not usual:
            return s
        if own.pulse_setting:
            work.lose(s, Fate.APPROXIMATED, "duration", own.pulse_setting)
        return replace(s, duration=Quantity(Number(usual), 1.0))

    return replace(
        program,
        routines=tuple([replace(r, body=tuple([pulse(s) for s in r.body])) for r in program.routines]),
    )
