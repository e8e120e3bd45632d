"""What people see of a translation: the receipt says first what matters, each thing once, in words that they know."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from translated_texts import VENDORS

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.fluent import read
from olp.ir.expressions import Store
from olp.ir.program import AccelerationUnit, BlendKind, SpeedUnit
from olp.ir.terminology import ACCELERATIONS, BLENDS, FUNCTIONS, SIGNALS, SPEEDS, STATEMENTS, STORES, VALUES
from olp.robots.robot import load_robot
from olp.transpile.context import Context, Fate, Mapping
from olp.transpile.convert import convert
from olp.transpile.support import kinds

SAMPLES = Path(__file__).resolve().parents[1] / "samples"
ROBOT = "yaskawa/gp25"


def receipt(tmp_path: Path, capsys: pytest.CaptureFixture[str], source: Path, target: str, *more: str):
    """The receipt as text and for scripts."""
    arguments = (
        "--to",
        target,
        "--robot",
        ROBOT,
        "-o",
        str(tmp_path / "out"),
        "--on-loss",
        "comment",
        "--force",
    )
    file = tmp_path / "receipt.json"
    assert main(["convert", str(source), *arguments, "--receipt", str(file), *more]) in (0, 1)
    return capsys.readouterr().out, json.loads(file.read_text())


def written(tmp_path: Path, name: str, text: str) -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


KRL = """DEF k()
;FOLD INI;%{PE}
BAS (#INITMOV,0 )
;ENDFOLD (INI)
;FOLD Pick the part
;FOLD PTP P1 CONT Vel=40 % PDAT1 Tool[1] Base[0];%{PE}%R 5.6.13,%MKUKATPBASIS,%CMOVE,%VPTP,%P 1:PTP
BAS (#VEL_PTP,40)
PTP {A1 5.5,A2 -90,A3 90,A4 3.5,A5 40,A6 21}
;ENDFOLD
;FOLD SPTP P2 Vel=60 % ;%{PE}
;FOLD Parameters ;%{h}
;Params IlfProvider=maker.forms.movement; Kuka.PointName=P2
;ENDFOLD
BAS (#VEL_PTP,60)
PTP {A1 15.5,A2 -90,A3 90,A4 3.5,A5 40,A6 21}
;ENDFOLD
;ENDFOLD
; slowly; the part is wet
$OUT[3]=TRUE
END
"""


def test_of_an_editors_folds_only_those_that_people_named_are_comments(tmp_path, capsys):
    receipt(tmp_path, capsys, written(tmp_path, "k.src", KRL), "urscript")
    comments = [line.strip() for line in (tmp_path / "out/k.script").read_text().splitlines() if "#" in line]
    assert comments == ["# Pick the part", "# slowly; the part is wet"]


def test_no_comment_or_message_of_a_listing_holds_what_ends_its_lines(tmp_path, capsys):
    module = written(
        tmp_path,
        "M.mod",
        "MODULE M\nPROC main()\n! close; then go\n"
        'TPWrite "one; two";\nPulseDO do1; ! a; b\nENDPROC\nENDMODULE\n',
    )
    text, found = receipt(tmp_path, capsys, module, "tp")
    listing = (tmp_path / "out/main.ls").read_text()
    body = listing[listing.index("/MN") : listing.index("/POS")].splitlines()[1:]
    assert body
    assert all(line.count(";") == 1 and line.endswith(";") for line in body)
    assert any("!close, then go" in line for line in body)
    assert any("MESSAGE[one, two]" in line for line in body)
    assert sum("';' ends a line" in note for note in found["notes"]) == 1
    assert "';' ends a line" in text


def test_what_is_told_of_several_lines_stands_there_once_and_in_the_json_for_each(tmp_path, capsys):
    text, found = receipt(tmp_path, capsys, SAMPLES / "krl/handling.src", "tp")
    says = "the acceleration is left out"
    rows = [
        loss
        for loss in found["losses"]
        if loss["says"].startswith(says) and loss["statement"] == "Move linear"
    ]
    assert len(rows) == 4
    told = [line for line in text.splitlines() if says in line and "move" in line]
    assert len(told) == 1
    count = len({loss["line"] for loss in found["losses"] if loss["says"].startswith(says)})
    assert f"({count} lines)" in told[0]
    assert "linear move" in told[0]
    assert all(str(row["line"]) in told[0] for row in rows)


def test_no_two_lines_of_a_receipt_say_the_same(tmp_path, capsys):
    for source in sorted((SAMPLES / "inform/welding").glob("*.JBI")):
        text, _ = receipt(tmp_path, capsys, source, "krl")
        details = [line for line in text.splitlines() if line.strip()]
        assert len(details) == len(set(details))


def test_every_kind_of_thing_has_words_of_its_own():
    assert set(STATEMENTS) == {*kinds(), "program"}
    assert len(set(STATEMENTS.values())) == len(STATEMENTS)
    for words, enum in (
        (SPEEDS, SpeedUnit),
        (ACCELERATIONS, AccelerationUnit),
        (BLENDS, BlendKind),
        (STORES, Store),
    ):
        assert set(words) == set(enum)


def test_a_statement_that_is_refused_is_told_once(tmp_path):
    job = SAMPLES / "inform/generations/dx100.jbi"
    program = read(job)
    with pytest.raises(OlpError) as refused:
        convert(program, "urscript", Context(robot=load_robot(ROBOT)))
    lines = [found.line for found in refused.value.diagnostics]
    assert len(lines) == len(set(lines))


def test_a_shift_that_ends_where_none_is_on_changes_nothing(tmp_path, capsys):
    text = (SAMPLES / "up20/DOWN-L.JBI").read_text(errors="replace")
    at = text.index("NOP")
    job = written(tmp_path, "S.JBI", text[:at] + "NOP\nSFTOF\n" + text[at:].removeprefix("NOP").lstrip())
    for target in ("krl", "tp", "rapid", "urscript"):
        told, found = receipt(tmp_path, capsys, job, target)
        assert found["totals"]["commented"] == found["totals"]["refused"] == 0
        assert not found["difference"]["says"]
        assert "no shift is on that could end here" in told


@pytest.mark.parametrize(
    ("source", "target", "asked"),
    [
        (
            "rapid/handling.mod",
            "inform",
            ["signals as they are called now: out do3 is 3, in di7 is 7", "loads"],
        ),
        (
            "krl/handling.src",
            "tp",
            ["tools 1-2 and frames 1-2: this one sets them", "wired as in the source"],
        ),
        (
            "inform/welding/WELD-MAIN.JBI",
            "krl",
            ["rewrite what is only a comment now", "TRACK-VAR.JBI:32-39"],
        ),
    ],
)
def test_what_is_to_be_done_before_it_runs_is_one_short_list(tmp_path, capsys, source, target, asked):
    text, found = receipt(tmp_path, capsys, SAMPLES / source, target)
    items = found["before_run"]
    assert 0 < len(items) <= 8
    assert all(any(words in item for item in items) for words in asked)
    assert all(f"- {item}" in text for item in items)
    assert text.index("before it runs:") < text.index("statement  ")


def test_a_routine_that_the_translation_does_not_hold_is_asked_for(tmp_path, capsys):
    module = "MODULE M\nPROC main()\nWaitTime 1;\nGoHome;\nENDPROC\nENDMODULE\n"
    _, found = receipt(tmp_path, capsys, written(tmp_path, "M.mod", module), "inform")
    assert any("load what it calls" in item and "GOHOME" in item.upper() for item in found["before_run"])


def test_the_receipt_begins_with_how_much_is_exact(tmp_path, capsys):
    text, _ = receipt(
        tmp_path, capsys, written(tmp_path, "k.src", "DEF k()\nWAIT SEC 1\n$OUT[3]=TRUE\nEND\n"), "tp"
    )
    assert text.splitlines()[1] == "2 statements: all exact"
    text, found = receipt(tmp_path, capsys, SAMPLES / "krl/handling.src", "tp")
    totals = found["totals"]
    assert text.splitlines()[1] == (
        f"{sum(totals.values())} statements: {totals['exact']} exact, {totals['approximated']} approximated"
    )
    worst = max((loss["size"] or 0.0) for loss in found["losses"] if loss["part"] == "blend")
    assert f"blend {worst:.3g} mm" in text


ROBOTS_OWN = "/PROG  GRIP\n/ATTR\n/MN\n   1:  RO[3]=ON ;\n   2:  WAIT RI[2]=ON ;\n/POS\n/END\n"


MAPPED = '[signals]\n"robot-out 3" = "out 12"\n"robot-in 2" = "in 7"\n'
NUMBERED = """/PROG  GRIP
/ATTR
/MN
   1:  RO[R[1]]=ON ;
   2:  IF RI[R[2]]=ON,JMP LBL[1] ;
   3:  RO[3]=ON ;
   4:  LBL[1] ;
/POS
/END
"""


def test_signals_of_the_robot_itself_are_mapped_by_the_file_that_the_message_names(tmp_path, capsys):
    listing = written(tmp_path, "GRIP.LS", ROBOTS_OWN)
    assert main(["convert", str(listing), "--to", "urscript", "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    advice = re.findall(r'map it under (\[signals\]) in the mapping file, as in (.*) = "(in|out) 12"', said)
    assert [(name, kind) for _, name, kind in advice] == [('"robot-out 3"', "out"), ('"robot-in 2"', "in")]
    mapped(tmp_path, capsys, listing, "urscript")


@pytest.mark.parametrize("target", ["inform", "krl"])
def test_signals_of_the_robot_itself_get_numbers_of_their_own(tmp_path, capsys, target):
    listing = written(tmp_path, "GRIP.LS", ROBOTS_OWN)
    text, found = receipt(tmp_path, capsys, listing, target)
    assert found["totals"]["exact"] == 2
    assert not found["difference"]["says"]
    assert "connect these signals with their new numbers" in text
    assert "robot-out 3 is out 2003, robot-in 2 is in 2002" in text
    (file,) = (tmp_path / "out").iterdir()
    assert "2003" in file.read_text()
    mapped(tmp_path, capsys, listing, target)


def mapped(tmp_path, capsys, listing: Path, target: str) -> None:
    """The mapping file puts the signals of ROBOTS_OWN elsewhere."""
    cell = written(tmp_path, "cell.toml", MAPPED)
    text, found = receipt(tmp_path, capsys, listing, target, "--map", str(cell))
    assert found["totals"]["exact"] == 2
    assert not found["difference"]["says"]
    assert "connect the signals as they are called now: robot-out 3 is out 12, robot-in 2 is in 7" in text
    (file,) = [f for f in (tmp_path / "out").iterdir() if f.suffix != ".json"]
    assert "12" in file.read_text()


def test_a_computed_number_counts_from_where_the_signals_of_the_robot_begin(tmp_path, capsys):
    listing = written(tmp_path, "GRIP.LS", NUMBERED)
    text, found = receipt(tmp_path, capsys, listing, "krl")
    assert found["agrees"], text
    assert "robot-in * is in 2000+*, robot-out 3 is out 2003" in text
    made = (tmp_path / "out" / "GRIP.src").read_text()
    assert "$OUT[2000+R1]=TRUE" in made
    assert "$IN[2000+R2]" in made
    beside = Context(mapping=Mapping(signals={"robot-in 2": "in 12"}))
    with pytest.raises(OlpError, match="a signal with a computed number"):
        convert(read(listing), "krl", beside)


def test_where_signals_have_names_those_of_the_robot_have_some_too(tmp_path, capsys):
    text, found = receipt(tmp_path, capsys, written(tmp_path, "GRIP.LS", ROBOTS_OWN), "rapid")
    assert found["totals"]["exact"] == 2
    assert not found["difference"]["says"]
    assert "configure the signals: robot-out 3 is ro3, robot-in 2 is ri2" in text
    assert len(found["before_run"]) == 1


def test_a_signal_with_a_computed_number_is_no_variable_where_signals_have_names(tmp_path):
    listing = written(tmp_path, "GRIP.LS", ROBOTS_OWN.replace("RI[2]", "RI[R[1]]"))
    made = convert(read(listing), "rapid")
    assert b'AliasIO "ri" + NumToStr(' in made.files["GRIP.mod"]
    assert made.translated.mapping["signal", "robot-in *"] == "ri*"
    beside = Context(mapping=Mapping(signals={"robot-in 2": "diShut"}))
    with pytest.raises(OlpError, match="a signal with a computed number"):
        convert(read(listing), "rapid", beside)


def messages(text: str, name: str, folder: Path) -> Iterator[str]:
    """Whatever the translations of a program into all other languages tell."""
    program = read(written(folder, name, text))
    for target in VENDORS:
        for on_loss in ("error", "comment"):
            try:
                made = convert(program, target, Context(robot=load_robot(ROBOT), on_loss=on_loss)).translated
            except OlpError as refused:
                yield from (found.message for found in refused.diagnostics)
            else:
                yield from (loss.says for loss in (*made.losses, *made.remarks))
                yield from (*made.notes, *made.asks)


FOREIGN = {
    "A.src": "DEF a()\nINT i\nSIGNAL s $CYCFLAG[1]\ni=3 B_AND 5\nWAIT FOR $CYCFLAG[2]\nWAIT FOR $TIMER_FLAG[1]\n"
    "$VEL.CP=0.5\nLIN {X 900,Y 0,Z 500,A 0,B 0,C 180} C_VEL\nPTP $POS_ACT\nHALT\nEND\n",
    "B.mod": 'MODULE B\nVAR string t;\nVAR num n;\nVAR socketdev k;\nPROC main()\nt:=NumToStr(n,2)+" ";\n'
    "n:=StrLen(t);\nt:=StrPart(t,1,2);\nWaitDI di1,1\\MaxTime:=2\\TimeFlag:=late;\nPulseDO do1;\nSocketClose k;\n"
    "ENDPROC\nENDMODULE\n",
    "C.ls": "/PROG  C\n/MN\n   1:  F[1]=(ON) ;\n   2:  WAIT UI[3]=ON TIMEOUT,LBL[1] ;\n   3:  R[1]=R[2] DIV 3 ;\n"
    "   4:  LBL[1] ;\n   5:  RUN C ;\n   6:  MESSAGE[a] ;\n   7:L P[1] WELD_SPEED FINE ;\n   8:  Arc Start[1] ;\n"
    "/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = 900 mm, Y = 0 mm, Z = 500 mm,\n"
    "\tW = 180 deg, P = 0 deg, R = 0 deg\n};\n/END\n",
    "D.script": "def d():\n  thread t():\n    sync()\n  end\n  run t()\n  if get_configurable_digital_in(2):\n"
    "    sleep(0.1)\n  end\n  q = pose_add(get_actual_tcp_pose(), p[0,0,0.1,0,0,0])\n  movel(q, a=1.2, v=0.25)\n"
    '  n = random()\n  popup(str_cat("a", "b"))\nend\nd()\n',
}


@pytest.mark.parametrize("name", FOREIGN)
def test_no_message_has_words_that_only_the_source_code_knows(tmp_path, name):
    inner = {*FUNCTIONS, *VALUES, *SIGNALS, *(store.value for store in Store)}
    inner = {word for word in inner if "-" in word} | {
        kind for kind in kinds() if kind not in STATEMENTS.values()
    }
    told = list(messages(FOREIGN[name], name, tmp_path))
    assert len(told) > 3
    for says in told:
        words = set(re.findall(r"[\w-]+", re.sub(r'"[^"]*"', "", says)))
        assert not words & inner, says


def test_what_takes_nothing_is_no_loss(tmp_path):
    made = convert(read(written(tmp_path, "k.src", "DEF k()\nWAIT SEC 0\nCONTINUE\nEND\n")), "rapid")
    assert {loss.fate for loss in made.translated.losses} == {Fate.EXACT}


def test_what_has_no_value_in_the_program_is_asked_for(tmp_path):
    made = convert(read(written(tmp_path, "C.ls", FOREIGN["C.ls"])), "rapid", Context(on_loss="comment"))
    assert made.translated.asks["set these variables, which have no values"] == ("weld_speed [mm/s]",)


FAR = """def far():
  movel(p[0.9, 0.2, 1.2, 2.2, 2.2, 0.1], a=1.2, v=0.25)
  movel(p[0.5, 0.2, 0.6, 2.2, 2.2, 0.1], a=1.2, v=0.25)
  movel(p[0.9, 0.1, 1.2, 2.2, 2.2, 0.1], a=1.2, v=0.25)
  movej([0, -1.57, 1.57, 0, 1.57, 6.0], a=1.4, v=1.05)
end
far()
"""


def test_what_the_other_arm_does_not_reach_is_first_on_the_list(tmp_path, capsys):
    source = written(tmp_path, "far.script", FAR)
    more = ("--robot", "universal-robots/ur20", "--target-robot", "universal-robots/ur5e")
    found = receipt(tmp_path, capsys, source, "urscript", *more)[1]
    lines = (tmp_path / "out" / "far.script").read_text().splitlines()
    far = [n for n, line in enumerate(lines, 1) if "movel" in line and "[0.9" in line]
    first = found["before_run"][0]
    assert first.startswith(
        "move the base, the frames or the points, as universal-robots/ur5e does not reach"
    )
    assert first.endswith(f"far.script:{far[0]}, {far[1]}")
    assert len(far) == 2
    reached = receipt(tmp_path, capsys, source, "urscript", *more[:2])[1]
    assert not any("does not reach" in item for item in reached["before_run"])


def test_joints_beyond_the_other_arms_limits_are_on_the_list(tmp_path, capsys):
    """Half a turn of S is one arm's, not the other's."""
    job = "def far():\n  movej([3.05, 0, 0, 0, -1.57, 0])\n  movej([0, 0, 0, 0, -1.57, 0])\nend\nfar()\n"
    source = written(tmp_path, "far.script", job)
    more = ("--robot", "fanuc/m-10ia", "--target-robot", "fanuc/lr-mate-200id")
    found = receipt(tmp_path, capsys, source, "tp", *more)[1]
    (item,) = [item for item in found["before_run"] if "does not have the joint range" in item]
    assert item.count(":") == 2


def test_times_that_nobody_knows_are_no_numbers(tmp_path, capsys):
    """The first line has no duration without a robot; JSON has no NaN."""
    axes = "A2 -90,A3 90,A4 0,A5 30,A6 0}"
    job = f"DEF a()\nPTP {{A1 0,{axes}\nPTP {{A1 10,{axes}\nWAIT SEC 1\nEND\n"
    file = tmp_path / "receipt.json"
    source = written(tmp_path, "a.src", job)
    assert main(
        ["convert", str(source), "--to", "tp", "-o", str(tmp_path / "out"), "--receipt", str(file)]
    ) in (0, 1)
    assert "at least 1.000 s before, at least 1.000 s after" in capsys.readouterr().out

    def refused(word: str) -> float:
        raise AssertionError(word)

    times = json.loads(file.read_text(), parse_constant=refused)["time"]
    assert times["source_s"] is None
    assert [row["source_s"] for row in times["segments"]][1:] == [None, 1.0]
