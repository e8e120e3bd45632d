"""Annotations in listings: comments that controllers take, found again when a controller has numbered them."""

from __future__ import annotations

import re
from pathlib import Path

from olp.fluent import read, read_source
from olp.languages.vendor import find_vendor
from olp.reports.annotate import annotate, remove
from olp.timing.timing import time_plan

SAMPLE = Path(__file__).parent.parent / "samples" / "tp" / "handling.ls"


def annotated(program):
    return annotate(program, time_plan(program.plan(robot="yaskawa/gp25")))


def test_annotations_are_comments_of_the_language_and_go_away_again():
    program = read(SAMPLE)
    result = annotated(program)
    added = [line for line in result.source.lines if "olp" in line]
    assert len(added) == result.written > 5
    assert all(re.fullmatch(r" : !olp [\x20-\x7e]{1,28} ;", line) for line in added)
    again = read_source(result.source)
    assert not [one.render() for one in again.diagnostics if one.is_error]
    assert annotated(again).source.raw == result.source.raw
    assert remove(result.source, "tp").source.raw == SAMPLE.read_bytes()


def test_annotations_that_a_controller_has_numbered_are_found():
    result = annotated(read(SAMPLE))
    numbered = re.sub(rb"(?m)^ : !olp (.*) ;", rb"  12:  !olp \1 ;", result.source.raw)
    assert numbered != result.source.raw
    stripped = remove(
        type(result.source)("", numbered, "ascii", tuple(numbered.decode().split("\r\n"))), "tp"
    )
    assert stripped.removed == result.written
    assert stripped.source.raw == SAMPLE.read_bytes()


def test_comments_of_others_are_none_of_ours():
    vendor = find_vendor("tp")
    assert vendor.comment_of(b"   4:  !olp is a tool ;\r\n") == b"olp is a tool"
    assert vendor.comment_of(b"   4:  DO[1]=ON ;\r\n") is None
