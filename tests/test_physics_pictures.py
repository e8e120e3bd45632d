"""The pictures of the physics page are those of the terms, and show the column that the trace hangs on."""

import numpy as np

from bench.physics_page import PAGE
from bench.physics_pictures import FOLDER, Trace, columns, ordered, parted, pictures, trace_of
from olp.contracts.terms import rich_case
from olp.timing.physics import load_term

CASE = rich_case(moves=160, speeds=tuple(np.linspace(0.05, 0.9, 86)))


def test_the_pictures_are_those_of_the_terms() -> None:
    drawn = pictures()
    kept = {file.stem: file.read_text(encoding="utf-8") for file in FOLDER.glob("*.svg")}
    assert kept == drawn, "python bench/physics_pictures.py draws them anew"


def test_the_page_shows_every_picture() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert [file.name for file in FOLDER.glob("*.svg") if f"(images/physics/{file.name})" not in page] == []


def test_the_column_is_the_one_that_the_effect_hangs_on() -> None:
    over = {
        name: trace_of(load_term(name), CASE).label for name in ("payload", "gravity", "warm-up", "clock")
    }  # type: ignore[arg-type, union-attr]
    assert over == {
        "payload": "load, kg",
        "gravity": "incline, degrees (up is positive)",
        "warm-up": "running time, s",
        "clock": "simulated duration, s",
    }


def test_noise_orders_nothing_and_a_step_does() -> None:
    random = np.random.default_rng(1)
    column, noise = np.arange(400.0), random.normal(size=400)
    assert ordered(column, noise) < 0.1
    assert ordered(column, np.where(column > 200, 1.0, 0.0) + 0.1 * noise) > 0.9


def test_what_a_second_column_parts_is_seen() -> None:
    random = np.random.default_rng(2)
    first, second = random.uniform(size=400), random.uniform(size=400)
    trace = Trace("first", first, first + np.where(second > np.median(second), 1.0, 0.0))
    assert parted(trace, second) > 0.9
    assert parted(trace, random.uniform(size=400)) < 0.1


def test_every_column_has_a_value_for_every_straight_move() -> None:
    straight = CASE.moving & ~CASE.joint
    assert [label for label, column in columns(CASE).items() if not np.isfinite(column[straight]).all()] == []
