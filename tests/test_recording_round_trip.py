"""Whatever is written is read again: moves, settings and logs of any content."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from olp.identification.recording import (
    KINDS,
    Log,
    RecordedMoves,
    RecordingSettings,
    read_recording,
    write_recording,
)

FIELDS = (
    "move", "kind", "duration", "sim", "start", "end", "via", "start_angles", "end_angles",
    "joints_start", "joints_end", "speed", "speed_fraction", "acceleration", "acceleration_fraction",
    "blend", "level", "t_start", "cycle", "line", "payload", "payload_inertia",
    "sim_payload", "sim_payload_inertia", "override", "sim_override",
)  # fmt: skip
# Values that decimal units can hold; a column of nothing but empty cells is not written.
numbers = st.floats(-1e4, 1e4, allow_nan=False).map(lambda x: round(x, 6))
positive = st.floats(1e-3, 1e4).map(lambda x: round(x, 6))
words = st.text(st.characters(blacklist_categories=("Cs", "Cc")), max_size=12).map(lambda w: w.strip())


@st.composite
def recorded(draw):
    count = draw(st.integers(1, 5))
    axes = draw(st.integers(0, 7))

    def column(values, missing):
        cells = [draw(st.one_of(values, st.just(missing))) for _ in range(count)]
        return np.array(cells, dtype=float)

    def vectors(width, whole=False):
        rows = [
            draw(st.lists(numbers, min_size=width, max_size=width))
            if whole or draw(st.booleans())
            else [np.nan] * width
            for _ in range(count)
        ]
        return np.array(rows, dtype=float).reshape(count, width)

    level = column(st.integers(0, 8), -1).astype(np.int8)
    blend = column(positive, 0.0)
    return RecordedMoves(
        move=np.array(draw(st.lists(st.integers(0, 10**6), min_size=count, max_size=count, unique=True))),
        kind=np.array(
            draw(st.lists(st.integers(0, len(KINDS) - 1), min_size=count, max_size=count)), dtype=np.int8
        ),
        duration=column(positive, np.nan),
        sim=column(positive, np.nan),
        start=vectors(3, True),
        end=vectors(3, True),
        via=vectors(3, True),
        start_angles=vectors(3),
        end_angles=vectors(3),
        joints_start=vectors(axes),
        joints_end=vectors(axes),
        slides=tuple(draw(st.lists(st.booleans(), min_size=axes, max_size=axes))),
        speed=column(positive, np.nan),
        speed_fraction=column(positive, np.nan),
        acceleration=column(positive, np.nan),
        acceleration_fraction=column(positive, np.nan),
        blend=np.where((blend == 0) & (level > 0), np.nan, blend),
        level=level,
        t_start=column(st.floats(0, 2e9).map(lambda x: round(x, 4)), np.nan),
        cycle=column(st.integers(0, 99), -1).astype(np.int64),
        line=column(st.integers(1, 9999), 0).astype(np.int64),
        job=tuple(draw(words) for _ in range(count)),
        payload=column(positive, np.nan),
        payload_inertia=column(positive, np.nan),
        covariates={"humidity": column(numbers, 1.5)},
        sim_payload=column(positive, np.nan),
        sim_payload_inertia=column(positive, np.nan),
        override=column(positive, np.nan),
        sim_override=column(positive, np.nan),
        texts={"shift": tuple("x" + draw(words) for _ in range(count))},
    )


def again(moves, **more):
    with tempfile.TemporaryDirectory() as folder:
        write_recording(Path(folder), moves, **more)
        return read_recording(folder)


@settings(max_examples=40, deadline=None)
@given(recorded())
def test_moves_are_read_as_they_were_written(moves):
    found = again(moves).moves
    for field in FIELDS:
        wanted, got = getattr(moves, field), getattr(found, field)
        if wanted.size and not np.isnan(wanted.astype(float)).all():
            np.testing.assert_allclose(got, wanted, rtol=1e-12, atol=1e-12, err_msg=field)
    assert (found.job, found.texts, found.slides if found.slides else moves.slides) == (
        moves.job,
        moves.texts,
        moves.slides,
    )
    np.testing.assert_allclose(found.covariates["humidity"], moves.covariates["humidity"], rtol=1e-14)


@settings(max_examples=12, deadline=None)
@given(recorded())
def test_writing_what_was_read_changes_nothing_that_is_hashed(moves):
    once = again(moves)
    assert again(once.moves).sha256 == once.sha256


@settings(max_examples=40, deadline=None)
@given(
    st.text(st.characters(blacklist_categories=("Cs",), blacklist_characters="\0"), max_size=20),
    st.one_of(st.none(), st.floats(1e-6, 1e3)),
    st.one_of(st.none(), st.lists(numbers, min_size=6, max_size=6).map(tuple)),
)
def test_settings_are_read_as_they_were_written(controller, resolution, tool):
    one = plain(1)
    found = again(one, settings=RecordingSettings("", controller, resolution, tool)).settings
    assert (found.controller, found.time_resolution) == (controller, resolution)
    assert (found.tool is None) == (tool is None)
    if tool:
        np.testing.assert_allclose(found.tool, tool, atol=1e-9)


def plain(count):
    """Plain moves of one axis."""
    nothing, vectors = np.full(count, np.nan), np.full((count, 3), np.nan)
    axis = np.arange(count, dtype=float)[:, None]
    return RecordedMoves(
        np.arange(count), np.zeros(count, np.int8), nothing + 1, nothing, vectors, vectors, vectors, vectors, vectors,
        axis, axis + 1, (False,), nothing, nothing, nothing, nothing, np.zeros(count), np.full(count, -1, np.int8),
        nothing, np.full(count, -1), np.zeros(count, np.int64), ("",) * count, nothing, nothing,
    )  # fmt: skip


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1e6), numbers, numbers, st.integers(-1, 0)), min_size=1, max_size=20))
def test_logs_are_read_as_they_were_written(samples):
    table = np.array(sorted(samples))
    log = Log(table[:, 0], table[:, 1:2], (False,), speed=table[:, 2:3], move=table[:, 3].astype(np.int64))
    moves = plain(1)
    with tempfile.TemporaryDirectory() as folder:
        write_recording(folder, moves, log=log)
        from olp.identification.recording.log_reader import read_log

        found, told, _ = read_log(Path(folder) / "log.csv")
    np.testing.assert_array_equal(found.time, log.time)
    np.testing.assert_allclose(found.q, log.q, atol=1e-10)
    np.testing.assert_allclose(found.speed, log.speed, atol=1e-10)
    np.testing.assert_array_equal(found.move, log.move)
    assert told == []
