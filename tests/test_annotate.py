"""Annotations tell the times, are valid for the controller, and leave no trace when they are removed."""

import re
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read, read_source
from olp.languages.vendor import find_vendor
from olp.reports.annotate import annotate, remove, room, seal
from olp.runtime.interpreter import run
from olp.timing.timing import time_plan

SAMPLES = Path(__file__).parent.parent / "samples"
JOBS = sorted(
    path for path in SAMPLES.rglob("*") if path.suffix.lower() == ".jbi" and path.parent.name != "broken"
)
OURS = re.compile(rb"^'olp .* ~[0-9A-Z]{3}\r?$", re.M)


def timing_of(program):
    return time_plan(run(program, max_steps=20_000))


@cache
def samples():
    """The samples that can be read and timed without an error, each with its annotated source."""
    found = []
    for path in JOBS:
        program = read(path)
        timing = timing_of(program)
        if not any(one.is_error for one in timing.diagnostics):
            found.append((program, annotate(program, timing).source))
    return found


def job(lines, end="\r\n", last=True, path="made.jbi"):
    """A job of two points in base coordinates with these instructions, timed without a robot file."""
    text = [
        "/JOB",
        "//NAME MADE",
        "//POS",
        "///NPOS 3,0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
        "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        "C00000=812.340,-120.500,433.120,178.4410,-12.0071,91.3300",
        "C00001=923.710,-87.250,433.870,178.4410,-12.0071,91.3300",
        "C00002=1001.460,205.330,402.910,178.4410,-12.0071,91.3300",
        "//INST",
        "///DATE 2026/03/02 14:07",
        "///ATTR SC,RW",
        "///GROUP1 RB1",
        "NOP",
        *lines,
        "END",
    ]
    return read_source(decode((end.join(text) + (end if last else "")).encode("cp1252"), path, "cp1252"))


def annotated(program, template=None):
    return annotate(program, timing_of(program), template).source


def comments_of(source):
    return [line for line in source.lines if line.startswith("'olp ")]


# --- what is written ------------------------------------------------------------------------------------


def test_each_move_has_its_time_and_acceleration_above_it():
    program = job(
        ["MOVL C00000 V=250.0", "MOVL C00001 V=187.0 PL=0", "TIMER T=0.50", "MOVL C00002 V=93.0 PL=0"]
    )
    timing = timing_of(program)
    lines = annotated(program).lines
    body = lines[lines.index("NOP") :]
    text = [line.rpartition(" ~")[0] if line.startswith("'olp") else line for line in body]
    move, second = timing.duration_s[1], timing.duration_s[3]
    accelerations = [f"{float(f'{timing.accel_mm_s2[step]:.3g}'):.0f}mm/s2" for step in (1, 3)]
    assert text == [
        "NOP",
        f"'olp total {timing.total_s:.3f}s",
        "'olp 0.000s",
        "MOVL C00000 V=250.0",
        f"'olp {move:.3f}s {accelerations[0]}",
        "MOVL C00001 V=187.0 PL=0",
        "TIMER T=0.50",
        f"'olp {second:.3f}s {accelerations[1]}",
        "MOVL C00002 V=93.0 PL=0",
        "END",
    ]


def test_a_line_in_a_loop_tells_how_often_and_how_long_on_average():
    program = job(
        [
            "MOVL C00000 V=250.0 PL=0",
            "SET B000 0",
            "*1",
            "MOVL C00001 V=187.0 PL=0",
            "MOVL C00000 V=187.0 PL=0",
            "INC B000",
            "JUMP *1 IF B000<12",
        ]
    )
    timing = timing_of(program)
    line = program.source.lines.index("MOVL C00001 V=187.0 PL=0") + 1
    mean = timing.duration_s[np.array(timing.plan.line) == line].mean()
    source = annotated(program)
    above = source.lines[source.lines.index("MOVL C00001 V=187.0 PL=0") - 1]
    assert above.startswith(f"'olp 12x {mean:.3f}s ")


def test_what_another_job_takes_is_told_at_the_line_that_calls_it(tmp_path):
    inner = job(["MOVL C00001 V=187.0 PL=0", "TIMER T=0.25"])
    (tmp_path / "INNER.JBI").write_bytes(inner.to_bytes().replace(b"NAME MADE", b"NAME INNER"))
    outer = job(["MOVL C00000 V=250.0 PL=0", "CALL JOB:INNER", "MOVL C00000 V=250.0 PL=0", "CALL JOB:INNER"])
    (tmp_path / "OUTER.JBI").write_bytes(outer.to_bytes().replace(b"NAME MADE", b"NAME OUTER"))
    program = read(tmp_path / "OUTER.JBI")
    timing = timing_of(program)
    inside = timing.duration_s[np.array(timing.plan.source) == 1]
    lines = annotated(program).lines
    above = [lines[at - 1].rpartition(" ~")[0] for at, line in enumerate(lines) if line == "CALL JOB:INNER"]
    assert len(inside) == 4
    assert above == [f"'olp call {inside[:2].sum():.3f}s", f"'olp call {inside[2:].sum():.3f}s"]
    total = next(line for line in lines if " total " in line)
    assert f" {timing.total_s:.3f}s " in total


def test_a_line_that_is_never_executed_has_no_comment():
    program = job(["MOVL C00000 V=250.0", "JUMP *9", "MOVL C00001 V=187.0", "*9", "MOVL C00002 V=93.0"])
    lines = annotated(program).lines
    assert lines[lines.index("MOVL C00001 V=187.0") - 1] == "JUMP *9"


# --- validity -------------------------------------------------------------------------------------------


def test_there_are_samples_to_try():
    assert len(samples()) > 20


def test_an_annotated_sample_is_valid_for_the_controller():
    for program, after in samples():
        before = program.source
        comments = comments_of(after)
        assert comments
        assert all(len(line) <= find_vendor("inform").comment_length and line.isascii() for line in comments)
        assert [line for line in after.lines if not line.startswith("'olp ")] == list(before.lines)
        assert after.encoding == before.encoding
        again = read_source(after)
        assert not [found.render() for found in again.diagnostics if found.is_error]
        for routine in again.routines:
            kinds = [type(statement).__name__ for statement in routine.body]
            assert kinds[0] == "Begin"
            assert kinds[-1] == "End"
        if before.raw.count(b"\n") == before.raw.count(b"\r\n") == before.raw.count(b"\r"):
            assert after.raw.count(b"\n") == after.raw.count(b"\r\n") == after.raw.count(b"\r")


def test_a_sample_annotated_and_cleaned_has_its_own_bytes():
    for program, source in samples():
        result = remove(source, "inform")
        assert result.source.raw == program.to_bytes()
        assert result.removed > 0


def test_annotating_twice_is_annotating_once():
    for _, once in samples():
        again = read_source(once)
        twice = annotate(again, timing_of(again))
        assert twice.source.raw == once.raw
        assert twice.written == twice.removed


def test_comments_do_not_change_the_times():
    path = SAMPLES / "inform/cam/FINISH.JBI"
    program = read(path)
    other = read_source(annotated(program))
    np.testing.assert_array_equal(timing_of(program).duration_s, timing_of(other).duration_s)


def test_a_new_time_replaces_the_old_comment():
    slow = annotated(job(["MOVL C00000 V=250.0", "MOVL C00001 V=50.0 PL=0"]))
    edited = decode(slow.raw.replace(b"V=50.0", b"V=187.0"), slow.path, slow.encoding)
    fresh = annotated(job(["MOVL C00000 V=250.0", "MOVL C00001 V=187.0 PL=0"]))
    assert slow.raw != fresh.raw
    assert annotated(read_source(edited)).raw == fresh.raw


# --- nothing is lost ------------------------------------------------------------------------------------

MOVES = ["MOVL C00000 V=250.0", "MOVL C00001 V=187.0 PL=1", "MOVL C00002 V=93.0 PL=0  //wall", "TIMER T=0.40"]
OWN_MARK = "'olp 0.533s 592mm/s2"  # as an annotation starts, but without its seal
printable = st.characters(min_codepoint=0x20, max_codepoint=0xFF, exclude_characters="\x7f\x81\x8d\x8f\x90\x9d\xa0",
                          exclude_categories=("Cc",))  # fmt: skip
foreign = st.one_of(
    st.text(printable, max_size=40).map(lambda text: f"'{text}"),
    st.text(st.sampled_from("0123456789.smx/ ~ABCK"), max_size=28).map(lambda text: f"'olp {text}"),
    st.sampled_from(
        [
            OWN_MARK,
            "'olp",
            "'olp ",
            "'olp total 12.345s",
            "'OLP 0.533s",
            "'olp ~",
            "'olp x ~000",
            " 'olp 1s ~ABC",
        ]
    ),
)
bodies = st.lists(st.one_of(st.sampled_from(MOVES), foreign, st.sampled_from(["", "   "])), max_size=12)
ends = st.sampled_from(["\r\n", "\n", "\r"])


def is_sealed(line):
    """By the definition in the documentation, written down a second time."""
    text = line.rstrip(" \t").removeprefix("'olp ")
    return line.startswith("'olp ") and len(text) > 4 and text[-5:-3] == " ~" and seal(text[:-5]) == text[-3:]


@settings(max_examples=100, deadline=None)
@given(
    bodies,
    st.lists(ends, min_size=40, max_size=40),
    st.booleans(),
    st.sampled_from(["", "\x1a", "\r\n\r\n", "  "]),
)
@example([OWN_MARK, MOVES[0]], ["\r\n"] * 40, False, "\x1a")
def test_removing_gives_the_original_back_to_the_last_byte(body, line_ends, last, tail):
    body = [line for line in body if not is_sealed(line)]
    program = job(body)
    lines = program.source.lines
    text = "".join(
        line + end
        for line, end in zip(
            lines, [*line_ends[: len(lines) - 1], line_ends[-1] if last else ""], strict=True
        )
    )
    # A line end before a tail of line ends belongs to it.
    program = read_source(decode((text + tail).encode("cp1252", "replace"), "made.jbi", "cp1252"))
    if any(found.is_error for found in program.diagnostics):
        return
    source = annotated(program)
    assert remove(source, "inform").source.raw == program.to_bytes()
    assert [line for line in source.lines if not is_sealed(line)] == list(program.source.lines)


def test_the_random_jobs_are_mostly_ones_that_can_be_timed():
    program = job([*MOVES, OWN_MARK, "'Tür"])
    assert not any(found.is_error for found in timing_of(program).diagnostics)


def test_a_comment_that_only_looks_like_an_annotation_is_kept_and_told():
    program = job([OWN_MARK, "MOVL C00000 V=250.0", "'olp 1.234s ~XYZ"])
    result = annotate(program, timing_of(program))
    assert [found.code for found in result.diagnostics] == ["A001"]
    assert result.removed == 0
    kept = remove(result.source, "inform")
    assert kept.source.raw == program.to_bytes()
    assert [found.code for found in kept.diagnostics] == ["A001"]


def test_an_annotation_that_somebody_changed_is_theirs():
    source = annotated(job(["MOVL C00000 V=250.0", "MOVL C00001 V=187.0 PL=0"]))
    line = comments_of(source)[-1]
    changed = source.raw.replace(line.encode(), line.replace("s ", "s! ", 1).encode())
    assert changed != source.raw
    result = remove(decode(changed, source.path, source.encoding), "inform")
    assert line.replace("s ", "s! ", 1) in result.source.lines
    assert result.removed == len(comments_of(source)) - 1


@pytest.mark.parametrize("end", ["\r\n", "\n", "\r"])
@pytest.mark.parametrize("last", [True, False])
def test_comments_end_as_the_lines_around_them(end, last):
    program = job(["MOVL C00000 V=250.0", "MOVL C00001 V=93.0"], end, last)
    source = annotated(program)
    assert source.raw == end.encode().join(line.encode() for line in source.lines) + (
        end.encode() if last else b""
    )
    assert len(source.lines) == len(program.source.lines) + 3


def test_blanks_that_a_controller_adds_do_not_hide_an_annotation():
    program = job(["MOVL C00000 V=250.0"])
    padded = re.sub(rb"('olp [^\r\n]*)", rb"\1   ", annotated(program).raw)
    assert remove(decode(padded, "made.jbi", "cp1252"), "inform").source.raw == program.to_bytes()


def test_the_seal_belongs_to_the_text():
    seals = {seal(f"{n / 1000:.3f}s") for n in range(2000)}
    assert len(seals) > 1900
    assert all(re.fullmatch("[0-9A-HJKMNP-TV-Z]{3}", one) for one in seals)
    assert seal("0.533s 592mm/s2") == seal("0.533s 592mm/s2")


@pytest.mark.parametrize("encoding", ["cp1252", "shift_jis", "utf-8", "utf-8-sig"])
def test_text_of_any_encoding_is_left_alone(encoding):
    text = "\r\n".join(job(["'door", "MOVL C00000 V=250.0", "MOVL C00001 V=93.0  //door"]).source.lines)
    word = {"cp1252": "Tür", "shift_jis": "溶接開始"}.get(encoding, "Tür 溶接")
    program = read_source(decode(text.replace("door", word).encode(encoding), "made.jbi", encoding))
    source = annotated(program)
    assert f"'{word}" in source.lines
    assert f"MOVL C00001 V=93.0  //{word}" in source.lines
    assert remove(source, "inform").source.raw == program.to_bytes()


def test_utf_16_is_refused():
    with pytest.raises(OlpError, match="A003"):
        remove(decode("NOP\r\n".encode("utf-16"), "wide.jbi"), "inform")


# --- templates ------------------------------------------------------------------------------------------


def test_a_users_template_decides_what_is_told(tmp_path):
    template = tmp_path / "mine.j2"
    template.write_text(
        "{% if row.kind == 'total' %}{{ row.motion_s|fixed(1) }}+{{ row.wait_s|fixed(1) }}"
        "{% elif row.kind == 'wait' %}wait {{ row.seconds|fixed(1) }}{% endif %}\n"
    )
    program = job(["MOVL C00000 V=250.0", "TIMER T=0.50", "TIMER T=0.30"])
    source = annotated(program, template)
    texts = [line[5:].rpartition(" ~")[0] for line in comments_of(source)]
    assert texts == ["0.0+0.8", "wait 0.5", "wait 0.3"]
    assert remove(source, "inform").source.raw == program.to_bytes()


def test_the_template_in_the_documentation_works(tmp_path):
    page = (SAMPLES.parent / "docs" / "annotate.md").read_text(encoding="utf-8")
    template = tmp_path / "mine.j2"
    template.write_text(re.search(r"```jinja\n(.*?)```", page, re.S)[1])
    program = job(["MOVL C00000 V=250.0", "MOVL C00001 V=1500.0 PL=0", "MOVL C00002 V=11.0 PL=0"])
    timing = timing_of(program)
    texts = [line[5:].rpartition(" ~")[0] for line in comments_of(annotated(program, template))]
    slow = [
        f"{reached:.0f} of 1500mm/s" for reached in timing.reached_mm_s if reached < 1485 and reached > 11
    ]
    assert texts == slow
    assert len(texts) == 1


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x" * 23, "23 characters long, 22 fit"),
        ("a\nb", "more than one line"),
        ("Grün", "printable ASCII"),
        (" padded", "blanks at its ends"),
    ],
)
def test_a_comment_that_the_controller_would_refuse_is_a_diagnostic(tmp_path, text, says):
    template = tmp_path / "mine.j2"
    template.write_text(text, encoding="utf-8")
    program = job(["MOVL C00000 V=250.0"])
    with pytest.raises(OlpError) as caught:
        annotate(program, timing_of(program), template)
    found = caught.value.diagnostics[0]
    assert found.code == "A002"
    assert says in found.message
    assert found.file == str(template)


def test_the_room_is_what_fits():
    vendor = find_vendor("inform")
    text = "x" * room(vendor)
    assert len(f"'olp {text} ~{seal(text)}") == vendor.comment_length


@pytest.mark.parametrize("seconds", [0.0, 0.0004, 99_999.9, 1e7])
@pytest.mark.parametrize("count", [1, 2, 99_999])
@pytest.mark.parametrize("accel", [float("nan"), 0.0, 0.37, 12_345.6])
def test_the_shipped_template_fits_for_any_number(seconds, count, accel):
    from olp.languages.templating import shipped
    from olp.reports.annotate import AnnotationRow

    template = shipped("inform_annotation")
    available = room(find_vendor("inform"))
    for kind in ("linear", "joint", "call", "total", "wait", "signal"):
        row = AnnotationRow(7, kind, "MOVL", count, seconds * count, seconds, accel_mm_s2=accel)
        assert len(template.render({"row": row, "room": available}).strip("\n")) <= available


# --- the command ----------------------------------------------------------------------------------------


def folder_of_jobs(tmp_path):
    folder = tmp_path / "jobs"
    (folder / "sub").mkdir(parents=True)
    (folder / "A.JBI").write_bytes(job(["MOVL C00000 V=250.0", "MOVL C00001 V=93.0"]).to_bytes())
    (folder / "sub" / "A.JBI").write_bytes(job(["MOVL C00002 V=250.0"]).to_bytes())
    return folder


def test_the_command_writes_beside_and_gives_the_bytes_back(tmp_path, capfd):
    source = folder_of_jobs(tmp_path) / "A.JBI"
    before, out, back = source.read_bytes(), tmp_path / "out.jbi", tmp_path / "back.jbi"
    assert main(["annotate", str(source), "-o", str(out)]) == 0
    assert OURS.search(out.read_bytes())
    assert main(["annotate", "--remove", str(out), "-o", str(back)]) == 0
    assert back.read_bytes() == before == source.read_bytes()
    assert "assumed" in capfd.readouterr().err


def test_without_an_output_the_command_prints_the_program(tmp_path, capfdbinary):
    source = folder_of_jobs(tmp_path) / "A.JBI"
    assert main(["annotate", str(source)]) == 0
    printed = capfdbinary.readouterr().out
    assert remove(decode(printed, "a.jbi"), "inform").source.raw == source.read_bytes()


def test_the_command_keeps_a_folders_shape(tmp_path):
    folder = folder_of_jobs(tmp_path)
    assert main(["annotate", str(folder), "-o", str(tmp_path / "new")]) == 0
    written = sorted(str(path.relative_to(tmp_path / "new")) for path in (tmp_path / "new").rglob("*.JBI"))
    assert written == ["A.JBI", str(Path("sub", "A.JBI"))]


def test_an_input_is_never_overwritten_unless_asked(tmp_path, capfd):
    source = folder_of_jobs(tmp_path) / "A.JBI"
    before = source.read_bytes()
    assert main(["annotate", str(source), "-o", str(source)]) == 2
    assert main(["annotate", str(source), "-o", str(source.parent)]) == 2
    assert source.read_bytes() == before
    assert "C006" in capfd.readouterr().err
    assert main(["annotate", str(source), "--in-place"]) == 0
    assert OURS.search(source.read_bytes())
    assert main(["annotate", str(source), "--in-place", "--remove"]) == 0
    assert source.read_bytes() == before


def test_what_cannot_be_read_or_timed_is_told_and_the_rest_is_written(tmp_path, capfd):
    folder = folder_of_jobs(tmp_path)
    shutil.copy(SAMPLES / "inform/broken/bad-tool.jbi", folder / "B.JBI")
    (folder / "C.JBI").write_bytes(job(["MOVL C00000", "MOVL C00001"]).to_bytes())
    assert main(["annotate", str(folder), "-o", str(tmp_path / "new")]) == 2
    told = capfd.readouterr().err
    assert "B.JBI" in told
    assert "Traceback" not in told
    assert (tmp_path / "new" / "A.JBI").exists()
    assert not (tmp_path / "new" / "B.JBI").exists()
    assert not list(tmp_path.rglob("*.part"))


def test_removing_works_on_a_broken_program_and_refuses_an_unknown_encoding(tmp_path, capfd):
    source = SAMPLES / "inform/broken/many.jbi"
    assert main(["annotate", "--remove", str(source), "-o", str(tmp_path / "o.jbi")]) == 0
    assert (tmp_path / "o.jbi").read_bytes() == source.read_bytes()
    assert (
        main(["annotate", "--remove", str(source), "-o", str(tmp_path / "p.jbi"), "--encoding", "klingon"])
        == 2
    )
    assert "P005" in capfd.readouterr().err


def test_several_programs_need_a_folder(tmp_path, capfd):
    folder = folder_of_jobs(tmp_path)
    assert main(["annotate", str(folder)]) == 2
    assert "C007" in capfd.readouterr().err


def test_a_broken_template_is_told_with_its_line(tmp_path, capfd):
    source = folder_of_jobs(tmp_path) / "A.JBI"
    (tmp_path / "bad.j2").write_text("fine\n{{ row.nothing }}")
    arguments = [
        "annotate",
        str(source),
        "-o",
        str(tmp_path / "o.jbi"),
        "--template",
        str(tmp_path / "bad.j2"),
    ]
    assert main(arguments) == 2
    assert "bad.j2:2" in capfd.readouterr().err
    assert not (tmp_path / "o.jbi").exists()


def test_the_export_command_writes_reads_and_refuses(tmp_path, capfd):
    source = SAMPLES / "inform/welding/SEAM-ST.JBI"
    out = tmp_path / "new.jbi"
    assert main(["export", str(source), "--to", "inform", "-o", str(out)]) == 0
    assert out.read_bytes() == source.read_bytes()
    assert main(["export", str(source), "--to", "basic", "-o", str(tmp_path / "x")]) == 2
    assert "X001" in capfd.readouterr().err
    assert main(["export", str(SAMPLES / "inform/broken/many.jbi"), "--to", "inform"]) == 2
    assert (
        main(["export", str(SAMPLES / "inform/welding"), "--to", "inform", "-o", str(tmp_path / "all")]) == 0
    )
    assert len(list((tmp_path / "all").glob("*.JBI"))) == len(
        list((SAMPLES / "inform/welding").glob("*.JBI"))
    )


def test_a_name_that_no_row_has_is_told_in_words_of_the_template(tmp_path, capsys):
    template, job = tmp_path / "mine.j2", SAMPLES / "inform" / "twins" / "base.jbi"
    template.write_text("{{ row.nope }}", encoding="utf-8")
    assert main(["annotate", str(job), "--template", str(template), "-o", str(tmp_path / "A.JBI")]) == 2
    told = capsys.readouterr().err
    assert "error[J002]: a row has no attribute 'nope'" in told
    assert "olp." not in told.split("-->")[0]
    assert not (tmp_path / "A.JBI").exists()
