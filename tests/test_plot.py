"""Pictures hold what they say, in both formats, and nothing that a program's text could smuggle in."""

from __future__ import annotations

import io
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.fluent import read
from olp.reports.explain import explain
from olp.reports.plot import PICTURES, Figure, picture
from olp.reports.plot.figure import TONES, Axes, Box, Dot, Polyline, TextLabel, room, thinned, ticks
from olp.reports.plot.motion import motion_figure
from olp.reports.plot.program import program_figure
from olp.timing.timing import time_plan

ROOT = Path(__file__).parent.parent
SEAM = "samples/inform/welding/SEAM-LH.JBI"
SPACE = "{http://www.w3.org/2000/svg}"


def texts(data: bytes) -> list[str]:
    return [node.text or "" for node in ElementTree.fromstring(data).iter(f"{SPACE}text")]


STATION = """/JOB
//NAME STATION
//POS
///NPOS 0,0,2,0,0,0
///TOOL 0
///POSTYPE PULSE
///PULSE
EC00000=-30000,250000
EC00001=30000,250000
//INST
///DATE 2026/01/01 00:00
///ATTR SC,RW
///GROUP1 ST1
NOP
MOVJ EC00000 VJ=10.0
MOVJ EC00001 VJ=10.0
END
"""


@pytest.fixture(scope="module")
def timing():
    return time_plan(read(SEAM).plan())


def test_the_picture_of_a_line_names_it_and_labels_its_axes(timing):
    words = texts(picture(motion_figure(explain(timing, "51")), "a.svg"))
    assert any(word.startswith("line 51: MOVL C00002") for word in words)
    assert {"mm/s", "mm/s²", "% of rated", "programmed"} <= set(words)
    assert any("time since the line began, s" in word for word in words)
    assert sum(bool(re.fullmatch(r"[SLURBT] [\d.]+ %", word)) for word in words) == 6


def test_the_phases_are_shaded_where_they_are(timing):
    told = explain(timing, "51")
    figure = motion_figure(told)
    bands = [s for s in figure.shapes if isinstance(s, Box) and s.opacity < 0.2 and s.height > 100]
    widths = [band.width for band in bands if band.y == bands[0].y]
    shares = np.array([p.end - p.begin for p in told.phases])
    assert len(bands) == 3 * len(told.phases)
    assert np.array(widths) / sum(widths) == pytest.approx(shares / shares.sum(), abs=0.01)


@pytest.mark.slow(".png-51", ".png-54", ".png-57", ".png-63")
@pytest.mark.parametrize("line", [50, 51, 54, 57, 63, 65])
@pytest.mark.parametrize("suffix", PICTURES)
def test_every_kind_of_move_can_be_drawn(timing, line, suffix):
    data = picture(motion_figure(explain(timing, str(line))), f"a{suffix}")
    assert len(data) > 3_000


def test_nothing_is_drawn_outside_the_picture(timing):
    for figure in (motion_figure(explain(timing, "51")), program_figure(timing)):
        for shape in figure.shapes:
            places = shape.points if isinstance(shape, Polyline) else [(shape.x, shape.y)]
            for x, y in places:
                assert -1 <= x <= figure.width + 1
                assert -1 <= y <= figure.height + 1


def test_a_line_without_motion_has_no_picture(timing):
    with pytest.raises(OlpError) as caught:
        motion_figure(explain(timing, "62"))
    assert caught.value.diagnostics[0].code == "E005"


@pytest.mark.parametrize(
    "job",
    [SEAM, "samples/inform/palletising/MAIN.JBI", "samples/inform/cam/FINISH.JBI", "samples/up20/APPR-1.JBI"],
)
def test_the_picture_of_a_program_shows_three_views_and_the_speed(job):
    data = picture(program_figure(time_plan(read(job).plan())), "a.svg")
    words = texts(data)
    assert {"from above", "from the side", "in space", "x, mm", "y, mm", "z, mm", "time, s", "mm/s"} <= set(
        words
    )
    assert Path(job).name in words
    assert len(data) < 400_000


def test_views_have_one_scale_in_both_directions():
    fan = time_plan(read("samples/up20/APPR-1.JBI").plan())
    figure = program_figure(fan)
    reach = np.ptp(fan.plan.positions.position[:, :2], axis=0)
    drawn = np.array(
        [
            p
            for s in figure.shapes
            if isinstance(s, Polyline) and s.width == 1.7
            for p in s.points
            if p[0] <= 341
        ]
    )
    size = drawn.max(axis=0) - drawn.min(axis=0)
    assert size[0] / size[1] == pytest.approx(reach[0] / reach[1], rel=0.02)


def test_svg_is_the_same_every_time_and_fits_dark_screens(timing):
    one, two = (picture(program_figure(timing), "a.svg") for _ in range(2))
    assert one == two
    assert b"prefers-color-scheme: dark" in one
    assert b"<script" not in one
    assert b"http" not in one.replace(b"http://www.w3.org/2000/svg", b"")


def test_every_colour_can_be_read_on_its_paper():
    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    def contrast(one: str, two: str) -> float:
        low, high = sorted((luminance(one), luminance(two)))
        return (high + 0.05) / (low + 0.05)

    for role in set(TONES) - {"paper", "grid", "frame"}:
        assert contrast(TONES[role].light, TONES["paper"].light) >= 4.5, role
        assert contrast(TONES[role].dark, TONES["paper"].dark) >= 4.5, role


@given(st.text(max_size=60))
def test_any_text_of_a_program_gives_sound_xml(text):
    figure = Figure(100, 50, text)
    figure.add(TextLabel(5, 20, text))
    data = picture(figure, "a.svg")
    assert len(texts(data)) == 1
    assert not re.search(rb"<(?!/?(svg|title|style|rect|text|polyline|circle)\b)", data)


def test_png_has_the_figures_colours_where_they_were_put():
    figure = Figure(60, 40, "shapes")
    figure.add(Box(10, 10, 10, 10, "blue"), Box(30, 10, 10, 10, "red", 0.5), Dot(50, 15, 4, "green"))
    figure.add(
        Polyline(((5, 30), (55, 30)), "ink", 3.0), Polyline(((5, 36), (55, 36)), "orange", 2.0, (4, 4))
    )
    image = Image.open(io.BytesIO(picture(figure, "a.png"))).convert("RGB")
    assert image.size == (120, 80)

    def tone(role: str) -> tuple[int, ...]:
        return tuple(int(TONES[role].light[i : i + 2], 16) for i in (1, 3, 5))

    assert image.getpixel((30, 30)) == tone("blue")
    assert image.getpixel((100, 30)) == tone("green")
    assert image.getpixel((60, 60)) == tone("ink")
    assert image.getpixel((2, 2)) == tone("paper")
    half = tuple((a + 255) / 2 for a in tone("red"))
    assert image.getpixel((70, 30)) == pytest.approx(half, abs=1)
    dashed = [image.getpixel((x, 72)) for x in range(10, 110)]
    assert 15 < sum(pixel == tone("paper") for pixel in dashed) < 70


def test_png_writes_text_in_both_directions():
    for upright in (False, True):
        figure = Figure(80, 80, "text")
        figure.add(TextLabel(40, 40, "−12.5 mm/s² → x", anchor="middle", upright=upright, bold=True))
        image = np.asarray(Image.open(io.BytesIO(picture(figure, "a.png"))).convert("L"))
        rows, columns = np.nonzero(image < 128)
        wide, high = np.ptp(columns), np.ptp(rows)
        assert (high > 3 * wide) if upright else (wide > 3 * high)
        assert abs((rows if upright else columns).mean() - 80) < 8


def test_upright_text_begins_where_it_is_put_and_goes_up():
    figure = Figure(80, 80, "text")
    figure.add(TextLabel(40, 70, "mmmmmm", upright=True))
    rows = np.nonzero(np.asarray(Image.open(io.BytesIO(picture(figure, "a.png"))).convert("L")) < 128)[0]
    assert 130 < rows.max() <= 142
    assert rows.min() < 70


@given(
    st.floats(-1e6, 1e6), st.floats(1e-6, 1e6), st.integers(1, 12)
)  # fmt: skip
def test_ticks_are_round_inside_the_range_and_not_too_many(low, size, most):
    span = (low, low + max(size, abs(low) * 1e-9))
    found = ticks(span, most)
    assert len(found) <= most + 1
    assert all(span[0] - 1e-6 * size <= value <= span[1] + 1e-6 * size for value in found)


def test_a_range_holds_its_data_and_never_has_no_size():
    assert room([5.0, 5.0]) == (0.0, pytest.approx(5.4))
    assert room([np.nan]) == (0.0, pytest.approx(1.08))
    assert room([]) == (0.0, pytest.approx(1.08))
    low, high = room([-3.0, 7.0])
    assert low < -3
    assert high > 7


def test_a_thinned_line_goes_where_the_line_went():
    generator = np.random.default_rng(7)
    points = np.cumsum(generator.normal(0, 0.4, (800, 2)), axis=0)
    kept = np.array(thinned([tuple(p) for p in points]))
    assert len(kept) < 700
    ends = np.array([kept[:-1], kept[1:]])
    for point in points[::7]:
        along = ends[1] - ends[0]
        share = np.clip(
            np.sum((point - ends[0]) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-12), 0, 1
        )
        assert np.linalg.norm(ends[0] + along * share[:, None] - point, axis=1).min() < 0.21


def test_unknown_values_leave_a_gap_and_far_ones_stay_inside():
    figure = Figure(100, 100, "line")
    axes = Axes(figure, 0, 0, 100, 100, (0.0, 10.0), (0.0, 1.0))
    axes.line(range(6), [0.1, 0.2, np.nan, 0.4, 99.0, 0.5], "blue")
    assert [len(s.points) for s in figure.shapes if isinstance(s, Polyline)] == [2, 3]
    assert min(y for s in figure.shapes if isinstance(s, Polyline) for _, y in s.points) == 0.0


def test_the_command_draws_into_a_file(tmp_path, capsys):
    for suffix in PICTURES:
        out = tmp_path / f"seam{suffix}"
        assert main(["plot", SEAM, "-o", str(out)]) == 0
        assert out.stat().st_size > 5_000
    assert "Traceback" not in capsys.readouterr().err


def test_explaining_prints_words_and_draws_what_is_asked_for(tmp_path, capsysbinary):
    out = tmp_path / "line.svg"
    assert main(["time", SEAM, "--explain", "51", "-o", str(out)]) == 0
    assert b"line 51: MOVL" in capsysbinary.readouterr().out
    assert ElementTree.parse(out)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["plot", SEAM, "-o", "picture.jpg"], "E003"),
        (["plot", SEAM], "C002"),
        (["plot", SEAM, "-o", SEAM], "E003"),
        (["time", SEAM, "--explain", "51", "-o", "words.txt"], "E003"),
        (["time", SEAM, "--explain", "62", "-o", "wait.svg"], "E005"),
        (["time", SEAM, FAN := "samples/up20/APPR-1.JBI", "--explain", "51"], "C002"),
        (["time", FAN, "--explain", "9999"], "E002"),
    ],
)
def test_what_cannot_be_drawn_is_told_and_nothing_is_written(arguments, code, capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    assert main(arguments) == 2
    assert f"error[{code}]" in capsys.readouterr().err
    assert not any(Path(name).exists() for name in ("picture.jpg", "words.txt", "wait.svg"))


def test_a_program_that_cannot_be_timed_is_not_drawn(timing):
    plan = timing.plan
    with pytest.raises(OlpError):
        program_figure(time_plan(replace(plan, moves=replace(plan.moves, travel=plan.moves.travel * np.nan))))


def test_a_job_of_a_station_has_no_path_to_draw(tmp_path, capsys):
    job = tmp_path / "STATION.JBI"
    job.write_text(STATION, newline="\r\n")
    assert main(["plot", str(job), "-o", str(tmp_path / "p.svg"), "--robot", "yaskawa/gp25"]) == 2
    assert "error[E005]" in capsys.readouterr().err


def test_png_without_its_library_says_what_to_install():
    code = (
        "import sys; sys.modules['PIL'] = None\n"
        "from olp.reports.plot import Figure, picture\n"
        "from olp.core.diagnostic import OlpError\n"
        "try: picture(Figure(9, 9, 'x'), 'a.png')\n"
        "except OlpError as problem: print(problem.diagnostics[0].code, problem.diagnostics[0].help)\n"
        "assert picture(Figure(9, 9, 'x'), 'a.svg')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.startswith('E004 install it: pip install "olp[plot]"')


def test_commands_without_pictures_load_nothing_of_them():
    code = (
        "import sys\nfrom olp.__main__ import main\n"
        f"main(['time', {SEAM!r}])\n"
        "rooms = ('olp.reports.plot', 'olp.reports.explain', 'olp.servers.controller', 'PIL')\n"
        "loaded = [m for m in sys.modules if m.startswith(rooms)]\n"
        "assert not loaded, loaded\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
