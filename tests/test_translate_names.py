"""Names that no file at hand declares: every written program declares what it uses, and the receipt tells each."""

import json
import re
from collections import Counter
from pathlib import Path

import pytest
from tp_listings import listing
from translate_programs import own_program
from translated_texts import (
    ROBOT,
    VENDORS,
    converted,
    inform,
    krl,
    module,
    read,
    run_elsewhere,
    script,
    tp,
    translated,
)

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.fluent import read as read_file
from olp.ir.expressions import Named
from olp.ir.program import Declare, For, Program
from olp.ir.transformer import expressions_of
from olp.languages.limits import limits_of
from olp.languages.vendors.krl.load import _IN_PLACE as KRL_IN_PLACE
from olp.languages.vendors.krl.load import _WORDS as KRL_WORDS
from olp.runtime.interpreter import run
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link
from olp.transpile.receipt import counts_of

SAMPLES = Path(olp.__file__).parent.parent / "samples"


def undeclared_in(program: Program) -> set[str]:
    """Names that a program uses and nothing in its own files declares. KRL's own variables begin with $."""
    shared = {d.name.casefold() for d in program.data}
    found = set()
    for routine in program.routines:
        known = shared | {d.name.casefold() for d in (*routine.data, *routine.parameters)}
        known |= {s.name.casefold() for s in routine.body if isinstance(s, Declare)}
        if program.vendor == "rapid":
            known |= {s.variable.name.casefold() for s in routine.body if isinstance(s, For)}
        used = {e.name for s in routine.body for e in expressions_of(s) if isinstance(e, Named)}
        found |= {name for name in used if name.casefold() not in known and not name.startswith("$")}
    return found


def twice_in(program: Program) -> set[str]:
    found = Counter(d.name.casefold() for d in program.data)
    for routine in program.routines:
        own = [d for d in routine.body if isinstance(d, Declare)]
        assert not [n for n, k in Counter(d.name.casefold() for d in own if not d.value).items() if k > 1]
    return {name for name, count in found.items() if count > 1}


def written_again(made, target, folder):
    """The main file of a translation, read from a folder with the files beside it."""
    for name, data in made.files.items():
        (folder / name).write_bytes(data)
    again = link(read_file(folder / made.main, vendor=target)).program
    assert not [d.render() for d in again.diagnostics if d.is_error]
    return again


def check(source, target, folder):
    """Signals are the controller's: the receipt names those that it has to have."""
    refused = ""
    try:
        made = convert(source, target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    except OlpError as problem:  # nothing is written
        refused = str(problem)
    assert "declared nowhere" not in refused
    if refused:
        return
    again = written_again(made, target, folder)
    signals = {to for (kind, _), to in made.translated.mapping.items() if kind == "signal"}
    assert undeclared_in(again) <= signals
    assert twice_in(again) == set()


OTHERS_KRL = krl(
    "  $TOOL = tlGrip",
    "  $BASE = bsTable[2]",
    "  BAS(#VEL_PTP, 30)",
    "  $VEL.CP = 0.4",
    "  PTP xHome",
    "  PTP axHome",
    "  IF axHome.A1 > 10 THEN",
    "    bParked = TRUE",
    "  ENDIF",
    "  FOR iStep = 1 TO 4",
    "    xRow[iStep].Z = xRow[iStep].Z + rLift",
    "    LIN xRow[iStep] C_DIS",
    "  ENDFOR",
    "  xInter = xRow[2]",
    "  LIN xInter",
    "  LIN xHome : {X 10, Y 0, Z 0, A 0, B 0, C 0}",
    "  WAIT FOR bParked",
    "  WAIT FOR $IN[4] AND bReady",
    "  SWITCH nKind",
    "  CASE 1",
    "    $OUT[2] = bParked",
    "  DEFAULT",
    "    doOther(nKind, rLift)",
    "  ENDSWITCH",
    "  nDone = nDone + 1",
    "  nLast = nKind",
)
OTHERS_RAPID = module(
    "MoveJ pHome, v200, fine, tGrip;",
    "MoveAbsJ jPark, v200, fine, tool0;",
    "FOR i FROM 1 TO 3 DO",
    "  MoveL Offs(pStart, i * 10, nGap, 0), vSlow, zNear, tGrip\\WObj:=wTable;",
    "  pRow{i}.trans.z := pRow{i}.trans.z + nGap;",
    "ENDFOR",
    "MoveL pRow{2}, v100, z10, tGrip\\WObj:=wTable;",
    "pKept := pRow{1};",
    "MoveL RelTool(pKept, 0, 0, 20), v100, fine, tGrip;",
    "IF bReady AND nParts > 3 THEN",
    "  nParts := nParts - 1;",
    "ENDIF",
    "TEST nKind",
    "CASE 1, 2:",
    "  SetGO goCode, nKind;",
    "DEFAULT:",
    "  doOther nKind, pKept;",
    "ENDTEST",
    "WHILE bReady DO",
    "  bReady := FALSE;",
    "ENDWHILE",
)
OTHERS_SCRIPT = script(
    "movej(q_home, a=1.2, v=0.8)",
    "movel(p_start, a=1.2, v=0.25)",
    "movel(pose_trans(feature, p_start), a=1.2, v=0.25)",
    "i = 0",
    "while i < parts:",
    "  movel(row[i], v=0.1)",
    "  i = i + 1",
    "end",
    "if ready:",
    "  set_digital_out(2, ready)",
    "  do_other(parts)",
    "end",
)
OTHERS_INFORM = inform(
    "MOVJ P010 VJ=20.00",
    "MOVL P[I003] V=100.0",
    "SET R004 R005",
    "CALL JOB:OTHER ARGFI003",
)
OTHERS_TP = tp("J PR[4] 20% FINE", "L PR[R[3]] 100mm/sec FINE", "R[7]=R[8]+1", "CALL OTHER(R[7])")
OTHERS = {
    "inform": OTHERS_INFORM, "krl": OTHERS_KRL, "rapid": OTHERS_RAPID, "tp": OTHERS_TP, "urscript": OTHERS_SCRIPT,
}  # fmt: skip
PAIRS = [(source, target) for source in VENDORS for target in VENDORS if source != target]


@pytest.mark.parametrize(("source", "target"), PAIRS)
def test_a_written_program_uses_no_name_that_nothing_declares(source, target, tmp_path):
    check(read(OTHERS[source], source), target, tmp_path)


def sample_files():
    suffixes = {".jbi", ".src", ".mod", ".prg", ".ls", ".script"}
    files = [f for f in sorted(SAMPLES.rglob("*")) if f.suffix.lower() in suffixes]
    return [f for f in files if "backup" not in f.parts and "broken" not in f.parts]


@pytest.mark.slow("FINISH")
@pytest.mark.parametrize("path", sample_files(), ids=lambda path: path.stem)
def test_no_sample_is_written_with_a_name_that_nothing_declares(path, tmp_path):
    program = link(read_file(path)).program
    if any(d.is_error for d in program.diagnostics):
        return
    for target in VENDORS:
        if target != program.vendor:
            (tmp_path / target).mkdir()
            check(program, target, tmp_path / target)


@pytest.mark.slow("1", "3")
@pytest.mark.parametrize("seed", range(4))
def test_no_random_program_is_written_with_a_name_that_nothing_declares(seed, tmp_path):
    for first in VENDORS:
        (tmp_path / first).mkdir()
        program = own_program(seed, first, tmp_path / first, ROBOT)
        for target in VENDORS:
            if target != first:
                (tmp_path / first / target).mkdir()
                check(program, target, tmp_path / first / target)


def loss_lines(made, part):
    return [(loss.line, loss.says) for loss in made.translated.losses if loss.part == part]


def test_uses_tell_what_a_name_is():
    text = translated(OTHERS_KRL, "krl", "rapid")
    declared = {
        line.split()[2].rstrip(";"): line.split()[:2] for line in text.splitlines() if "not declared" in line
    }
    assert declared == {
        "tlGrip": ["PERS", "tooldata"], "bsTable{2}": ["PERS", "wobjdata"], "xHome": ["PERS", "robtarget"],
        "axHome": ["PERS", "jointtarget"], "bParked": ["VAR", "bool"], "iStep": ["VAR", "num"],
        "xRow{4}": ["PERS", "robtarget"], "rLift": ["VAR", "num"], "xInter": ["PERS", "robtarget"],
        "bReady": ["VAR", "bool"], "nKind": ["VAR", "num"], "nDone": ["VAR", "num"], "nLast": ["VAR", "num"],
    }  # fmt: skip
    assert "MoveAbsJ axHome" in text
    assert "MoveJ xHome" in text


def test_a_type_spreads_over_what_is_assigned_and_compared():
    rows = ["$VEL.CP = 0.2", "iB = iC", "IF iA == iB THEN", "xRow[iC] = xKept", "ENDIF", "xRow[2] = xKept"]
    text = krl(*rows, "$OUT[3] = bA", "bB = bA", "LIN xNear : xKept")
    written = translated(text, "krl", "urscript")
    told = [line for line in written.splitlines() if "not declared" in line]
    zeros = {line.split("=")[0].split()[-1]: line.split("=")[1].split("#")[0].strip() for line in told}
    assert {zeros[name] for name in ("iA", "iB", "iC")} == {"0"}
    assert {zeros[name] for name in ("bA", "bB")} == {"False"}
    assert zeros["xNear"].startswith("p[")


def test_the_receipt_names_each_once_and_every_move_that_depends_on_one():
    source = read(OTHERS_RAPID, "rapid")
    made = convert(source, "krl", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    told = [says for _, says in loss_lines(made, "name")]
    names = [says.split()[0] for says in told if not says.startswith("it depends")]
    assert sorted(names) == sorted(set(names))
    assert {"pHome", "jPark", "pStart", "tGrip", "wTable", "vSlow_v_tcp", "zNear_pzone_tcp"} <= set(names)
    assert "i" not in names  # FOR declares it
    moves = [(kind, row) for kind, row in counts_of(source, made.translated.losses).items() if "Move" in kind]
    assert moves
    assert not [kind for kind, row in moves if row.get("exact")]
    assert "it depends on pRow, which is not declared here" in told


def test_a_position_that_is_handed_on_takes_its_doubt_along():
    text = krl("  DECL E6POS xMid", "  xMid = xHome", "  $VEL.CP = 0.2", "  LIN xMid",
               "  LIN {X 500, Y 0, Z 400, A 0, B 90, C 0}")  # fmt: skip
    made = converted(text, "krl", "rapid")
    assert [line for line, says in loss_lines(made, "name") if "xHome" in says] == [3, 5]


def test_doubt_goes_along_through_several_variables():
    text = krl(
        "  DECL E6POS xMid, xLast", "  xMid = xHome", "  xLast = xMid", "  $VEL.CP = 0.2", "  LIN xLast"
    )
    made = converted(text, "krl", "rapid")
    assert [line for line, says in loss_lines(made, "name") if "xHome" in says] == [3, 4, 6]


@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_a_routine_that_no_file_has_is_told_at_each_call(target):
    text = krl("  doOther(1)", "  doOther(2)", "  WAIT SEC 1")
    told = loss_lines(converted(text, "krl", target), "call")
    assert [line for line, _ in told] == [2, 3]
    assert all(says.startswith("doOther is in no file here") for _, says in told)


@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_what_only_the_controller_knows_has_to_be_told_there(target):
    rows = ("IF $PRO_STATE1 == #P_STOP THEN", "nMode = 1", "ENDIF", "WAIT FOR NOT $POWER_FAIL", "WAIT SEC 1")
    made = converted(krl("DECL INT nMode", *rows), "krl", target)
    assert {loss.fate for loss in made.translated.losses} == {Fate.APPROXIMATED}
    (asked,) = [names for says, names in made.translated.asks.items() if "controller tells" in says]
    assert asked == ("$PRO_STATE1", "$POWER_FAIL")


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "krl"])
@pytest.mark.parametrize("row", ["$OV_ROB=50", "$CMD_X=N", "PTP $POS_RET", "$ACT_EX_AX=2"])
def test_what_a_program_tells_its_controller_is_no_variable_elsewhere(row, target):
    made = converted(krl("DECL INT N", "N=3", row), "krl", target)
    assert [loss.line for loss in made.translated.losses if loss.leaves_out] == [4]


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "tp"])
def test_system_variables_of_fanuc_are_no_variables(target):
    rows = (
        "$MCR.$RUN_STATE=R[1]",
        "$WAITTMOUT=300",
        "R[2]=$WAITTMOUT",
        "IF $MCR.$GENOVERRIDE=50,JMP LBL[1]",
    )
    program = read(listing(*rows, "WAIT    .50(sec)", "LBL[1]"), "tp")
    first = program.source.lines.index("   1:  $MCR.$RUN_STATE=R[1] ;") + 1
    with pytest.raises(OlpError) as caught:
        convert(program, target)
    refused = {d.line for d in caught.value.diagnostics if "belongs to TP's controllers" in d.message}
    assert refused == {first, first + 1, first + 2}
    made = convert(program, target, Context(on_loss="comment"))
    assert {x.line for x in made.translated.losses if x.leaves_out} == refused
    assert [
        name for kind, name in made.translated.mapping if kind == "variable" and name.startswith("$")
    ] == [
        "$MCR.$GENOVERRIDE"  # which the condition asks, and which whoever runs it has to tell
    ]
    assert not [d for d in made.translated.program.data if "WAITTMOUT" in d.name or "RUN_STATE" in d.name]


@pytest.mark.parametrize(
    ("target", "says"), [("krl", "$OV_PRO=40"), ("rapid", "VelSet 40,5000;"), ("tp", "OVERRIDE=40%")]
)
def test_the_override_of_fanuc_is_one_whichever_way_it_is_set(target, says):
    made = convert(read(listing("$MCR.$GENOVERRIDE=40"), "tp"), target)
    assert says in b"".join(made.files.values()).decode()


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_the_limit_that_waits_of_the_program_have_is_a_variable(target):
    rows = ("$WAITTMOUT=30", "WAIT DI[3]=ON TIMEOUT,LBL[1]", "LBL[1]")
    made = convert(read(listing(*rows), "tp"), target)
    assert not [x for x in made.translated.losses if x.leaves_out]


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_an_index_beyond_an_array_is_no_other_variable(target):
    data = ["VAR num nPart{3};", "VAR num nOther;"]
    rows = ["nOther := 1;", "nPart{3} := 2;", "nPart{4} := 3;", "WaitTime nOther;"]
    made = converted(module(*rows, data=data), "rapid", target)
    assert [(line, says) for line, says in loss_lines(made, "statement") if "nPart" in says] == [
        (7, "nPart has 3 elements, and the index is 4")
    ]
    assert run_elsewhere(module(*rows, data=data), "rapid", target).durations.tolist() == [1.0]


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_an_array_of_unknown_size_takes_what_is_used_of_it(target):
    text = krl("  DECL INT nI", "  nFar[3] = 7", "  rOther = 2", "  WAIT SEC rOther", "  nI = 5", "  nFar[nI] = 9",
               "  WAIT SEC rOther")  # fmt: skip
    made = converted(text, "krl", target)
    says = "nothing here tells how many elements nFar has: 20 are kept, none may be used beyond"
    assert [row for row in loss_lines(made, "index") if "nFar" in row[1]] == [(7, says)]
    assert list(made.translated.asks)[-1].startswith("see that no index goes beyond")
    assert run_elsewhere(text, "krl", target).durations.tolist() == [2.0, 2.0]


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_an_array_that_may_be_declared_too_small_is_told(target):
    text = krl("  DECL INT nI", "  nI = 5", "  nFar[3] = 7", "  nFar[nI] = 9", "  WAIT SEC nFar[nI]")
    made = converted(text, "krl", target)
    told = "nothing here tells how many elements nFar has: its declaration has the largest index written out"
    assert [(line, says) for line, says in loss_lines(made, "index") if "nFar" in says] == [
        (5, told),
        (6, told),
    ]
    assert {loss.fate for loss in made.translated.losses if "nFar" in loss.says} == {Fate.APPROXIMATED}
    assert list(made.translated.asks["set how many elements those have that no file here declares"]) == [
        "nFar"
    ]


def test_a_constant_is_an_index_that_is_known():
    data = ["CONST num last:=5;", "VAR num sum;"]
    made = converted(module("sum:=nFar{last};", "sum:=nFar{last-1};", data=data), "rapid", "krl")
    assert [says for _, says in loss_lines(made, "index")] == []
    (says,) = [says for _, says in loss_lines(made, "name") if says.startswith("nFar")]
    assert "5 of them" in says


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_members_of_structures_that_nothing_declares_are_variables_of_their_own(target):
    """Members of elements and of members, too; `Bin_Height` is another variable of the program's own."""
    text = krl("  Bin_Height = 8", "  Bin[2].Height = 3", "  Job.Pause.Short = 2", "  WAIT SEC Bin[2].Height",
               "  WAIT SEC Job.Pause.Short", "  WAIT SEC Bin_Height")  # fmt: skip
    made = converted(text, "krl", target)
    assert {loss.fate for loss in made.translated.losses} == {Fate.APPROXIMATED}
    assert run_elsewhere(text, "krl", target).durations.tolist() == [3.0, 2.0, 8.0]


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_a_structure_that_is_copied_and_that_nothing_declares_is_copied_by_the_members_that_are_named(target):
    rows = ("Bin[1].Height = 3", "Bin[2] = Bin[1]", "Job.Pause = 2", "Other = Job", "Job.Pause = 5")
    text = krl(*rows, "WAIT SEC Bin[2].Height", "WAIT SEC Other.Pause")
    losses = converted(text, "krl", target).translated.losses
    assert {loss.fate for loss in losses} == {Fate.APPROXIMATED}
    assert run_elsewhere(text, "krl", target).durations.tolist() == [3.0, 2.0]


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_a_structure_that_nothing_declares_is_handed_by_its_members(target):
    """To routines that no file has, which may set them; what is compared as a whole stays refused."""
    rows = ("Job = GetJob(1)", "Job.Count = Job.Count + 1", "ShowJob(Job)", "WAIT SEC Job.Pause")
    made = converted(krl(*rows), "krl", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    if target == "rapid":
        assert b"GetJob 1,Job_Count,Job_Pause;" in b"".join(made.files.values())
    losses = converted(krl(*rows, "IF Job == Other THEN", "HALT", "ENDIF"), "krl", target).translated.losses
    assert {loss.line for loss in losses if loss.leaves_out} >= {6, 7, 8}


def test_a_table_of_positions_that_nothing_declares_is_no_list_of_lists():
    """A call may hand over a table that is nowhere as a whole: then nobody can tell how its rows would lie."""
    rows = ("  PTP Grid[1, 2]", "  Sums[1, 2] = 4", "  foreign (Grid)")
    made = converted(krl(*rows), "krl", "urscript")
    assert [loss.line for loss in made.translated.losses if loss.fate is Fate.COMMENTED] == [2, 4]


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_lists_keep_their_values_and_their_places(target):
    rows = ["first = 4", "a = [1, 2, 3]", "b = 2", "i = 2", "a[1] = b + a[2]", "sleep(a[i])", "sleep(a[1])",
            "while i > 0:", "  i = i - 1", "  sleep(a[i] + first)", "end"]  # fmt: skip
    waits = [3.0, 5.0, 9.0, 5.0]
    assert run_elsewhere(script(*rows), "urscript", target).durations.tolist() == waits


def told_of(text, vendor, target, tmp_path):
    """What the receipt says of both runs."""
    (tmp_path / f"part.{'src' if vendor == 'krl' else 'script'}").write_text(text)
    out = tmp_path / "out"
    (path,) = [p for p in tmp_path.iterdir() if p.is_file()]
    receipt = tmp_path / "receipt.json"
    assert main(["convert", str(path), "--to", target, "-o", str(out), "--robot", "yaskawa/gp25",
                 "--receipt", str(receipt)]) == 1  # fmt: skip
    return json.loads(receipt.read_text())


UNKNOWN = krl("  BAS(#VEL_PTP, 30)", "  $VEL.CP = 0.2", "  PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}",
              "  WAIT SEC 1", "  PTP xHome", "  LIN {X 900, Y 0, Z 900, A 0, B 90, C 0}")  # fmt: skip


def test_the_receipt_says_which_statements_neither_run_knows(tmp_path, capsys):
    found = told_of(UNKNOWN, "krl", "inform", tmp_path)
    assert found["unknown"] == f"{tmp_path / 'part.src'}:6"
    assert found["difference"]["until_line"] is None
    assert "left out of both runs, for their values are not known here" in capsys.readouterr().out


def test_the_receipt_says_until_where_both_runs_were_compared(tmp_path, capsys):
    found = told_of(UNKNOWN, "krl", "urscript", tmp_path)
    assert (found["difference"]["until_line"], found["difference"]["steps"]) == (6, 2)
    assert found["difference"]["says"] == []
    assert "part.src:6, where what runs depends on a value" in capsys.readouterr().out
    assert any(says.startswith("step through it slowly") for says in found["before_run"])


ROWS = "[[600,{0}0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
ARRAY = [
    f"CONST robtarget ps{{3}}:=[{','.join(ROWS.format(n) for n in (1, 2, 3))}];",
    "VAR num k:=1;",
    "VAR num half;",
]


def test_what_only_counts_is_an_integer_in_krl(tmp_path):
    rows = ["k := 1;", "WHILE k <= 3 DO", "MoveL ps{k}, v100, fine, tool0;", "k := k + 1;", "ENDWHILE",
            "FOR i FROM 1 TO k - 2 DO", "MoveL ps{i + 1}, v100, fine, tool0;", "ENDFOR", "half := k / 3;"]  # fmt: skip
    text = module(*rows, data=ARRAY)
    made = converted(text, "rapid", "krl")
    written = b"".join(made.files.values()).decode()
    assert "DECL INT k" in written
    assert "DECL INT i" in written
    assert "DECL REAL half" in written
    assert not [loss for loss in made.translated.losses if loss.part in ("index", "loop")]
    assert compare_plans(read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", "krl")).is_equal


def test_an_index_that_may_be_a_fraction_is_rounded_and_told(tmp_path):
    rows = ["half := 3.0 / 2;", "half := half * 2;", "MoveL ps{half}, v100, fine, tool0;",
            "FOR i FROM 1 TO half + 0.9 DO", "MoveL ps{i}, v100, fine, tool0;", "ENDFOR"]  # fmt: skip
    text = module(*rows, data=ARRAY)
    made = converted(text, "rapid", "krl")
    assert [(loss.line, loss.part) for loss in made.translated.losses if loss.part in ("index", "loop")] == [
        (8, "index"),
    ]  # fmt: skip
    assert compare_plans(read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", "krl")).is_equal


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_values_that_name_other_data_are_written_out_in_any_order(target):
    data = ["CONST num both:=far+1;", "CONST num far:=2;", "VAR num row{2}:=[both,far];"]
    rows = ["WaitTime both;", "FOR i FROM 1 TO 2 DO", "WaitTime row{i};", "ENDFOR", "row{1} := far;"]
    text = module(*rows, data=data)
    assert read(text, "rapid").plan(robot=ROBOT).durations.tolist() == [3.0, 3.0, 2.0]
    assert run_elsewhere(text, "rapid", target).durations.tolist() == [3.0, 3.0, 2.0]


@pytest.mark.parametrize("target", ["krl", "inform"])
def test_differences_of_constants_are_written_out(target):
    data = ("CONST num a:=7;", "CONST num pause:=a-2.5;")
    assert run_elsewhere(module("WaitTime pause;", data=data), "rapid", target).durations.tolist() == [4.5]


@pytest.mark.parametrize("handed", [False, True])
def test_an_index_that_others_give_a_fraction_is_rounded_and_told(handed):
    """An analogue input, or a number that a routine changes."""
    routine = ["PROC halve(INOUT num x)", "x:=x/2;", "ENDPROC"]
    data = ["VAR num n:=3;", "VAR num kept{9};", *(routine if handed else ())]
    if handed:  # data stand before routines
        text = module("halve n;", "kept{n}:=4;", data=data)
    else:
        text = module("n:=AInput(ai1);", "kept{n}:=4;", data=data)
    made = converted(text, "rapid", "krl")
    assert [loss.says for loss in made.translated.losses if loss.part == "index"] == [
        "an index that may be a fraction is rounded: KRL has INT"
    ]


@pytest.mark.parametrize("target", ["krl", "inform"])
def test_the_end_of_the_whole_program_is_the_return_of_its_main_routine(target):
    text = listing("WAIT 1.00(sec)", "IF DI[1]=ON,JMP LBL[1]", "ABORT", "LBL[1]", "WAIT 2.00(sec)")
    made = convert(read(text, "tp"), target)
    assert not [x for x in made.translated.losses if x.leaves_out]
    assert run_converted(made, target, None).durations.tolist() == [1.0]


def test_a_routine_that_ends_the_whole_program_is_not_one_that_returns():
    text = (
        "MODULE M\nPROC main()\nstop_all;\nWaitTime 1;\nENDPROC\nPROC stop_all()\nEXIT;\nENDPROC\nENDMODULE\n"
    )
    made = convert(read(text, "rapid"), "krl")
    assert [loss.line for loss in made.translated.losses if "ends no program from within" in loss.says] == [7]
    rows = [row.strip() for row in made.files[made.main].decode().splitlines()]
    at = rows.index("HALT")
    assert rows[at - 1 : at + 2] == ["LOOP", "HALT", "ENDLOOP"]


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_a_move_of_a_programmed_time_takes_longer_under_an_override(target):
    rows = ["OVERRIDE=50%", "L P[1] 200mm/sec FINE", "L P[2] 2.0sec FINE"]
    text = tp(*rows, positions=[(1, 0, 0, 900, 100, 400, 180, 0, 30), (2, 0, 0, 950, 200, 350, 170, 5, 20)])
    before = run(read(text, "tp")).moves
    assert before.duration[1] == 4.0
    after = run_converted(convert(read(text, "tp"), target), target, None).moves
    pace = [m.duration[1] if m.duration[1] > 0 else m.length[1] / m.travel[1] for m in (before, after)]
    assert pace[1] == pytest.approx(4.0, rel=1e-6)


def test_a_tool_that_is_declared_elsewhere_is_a_variable_whose_value_is_asked_for():
    """A script needs values; its moves are told as approximated, and none is left out."""
    place = "[[600,{},600],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    rows = [f"MoveL {place.format(y)},v500,fine,tGun\\WObj:=wCell;" for y in (0, 10)]
    made = converted(module(*rows), "rapid", "urscript", on_loss="error")
    text = b"\n".join(made.files.values()).decode()
    assert "global tGun = p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]" in text
    assert "set_tcp(tGun)" in text
    assert text.count("pose_trans(wCell, ") == 2
    told = [(loss.line, loss.says) for loss in made.translated.losses if loss.part in ("tool", "frame")]
    assert [line for line, _ in told] == [3, 3, 4, 4]
    assert sum("zeros are written" in says for _, says in told) == 2
    assert {"tool tGun", "frame wCell"} <= set(made.translated.asks["set these values, which are zeros now"])


TABLES = (
    "  DECL INT n, t",
    "  DECL POS P",
    "  n = 2",
    "  t = 3",
    "  P = offsets[2,12]",
    "  P.X = P.X + offsets[n,t].X",
    "  LIN P",
)


def test_a_table_of_positions_that_no_file_declares_is_one_row_where_lists_have_one_index():
    made = converted(krl(*TABLES), "krl", "urscript")
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert "offsets: 10 by 12 elements in one row, the last index runs first" in made.translated.notes
    text = translated(krl(*TABLES), "krl", "urscript")
    assert "= offsets[23]" in text
    assert "offsets[n * 12 + t - 12 - 1][0]" in text


def test_that_no_index_may_leave_such_a_row_is_told():
    made = converted(krl(*TABLES), "krl", "urscript")
    says = "nothing here tells how many elements offsets has: 120 are kept, none may be used beyond"
    assert [row for row in loss_lines(made, "index") if "offsets" in row[1]] == [(7, says)]
    asked = "see that no index goes beyond the numbers kept for what no file here declares"
    assert list(made.translated.asks[asked]) == ["offsets"]


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_tables_that_no_file_declares_are_as_long_as_all_of_them_fit(target):
    """Ten by ten by ten of each would be more registers than there are."""
    rows = (
        *("  DECL INT n, t, k", "  DECL POS P", "  n = 2", "  t = 3", "  k = 1"),
        *(
            "  a[n,t,k] = 1",
            "  b[n,t,k] = 2.5",
            "  c[n,t,k] = 3",
            "  WAIT SEC a[n,t,k] + b[n,t,k] + c[n,t,k]",
        ),
        *(
            "  P = offsets[n,t,k]",
            "  LIN P",
            "  P = others[n,t,k]",
            "  LIN P",
            "  P = thirds[n,t,k]",
            "  LIN P",
        ),
    )
    made = converted(krl(*rows), "krl", target)
    assert not [loss.says for loss in made.translated.losses if loss.leaves_out]
    shapes = [re.sub("^.*: ", "", note) for note in made.translated.notes if "in one row" in note]
    assert len(shapes) == 6
    assert len(set(shapes)) == 1
    assert "10 by 10 by 10" not in shapes[0]


def test_a_row_is_as_long_as_the_loop_that_counts_through_it():
    rows = ("  DECL INT n", "  FOR n = 1 TO 14", "  WAIT SEC times[2,n]", "  ENDFOR")
    made = converted(krl(*rows), "krl", "inform")
    assert "times: 2 by 14 elements in one row, the last index runs first" in made.translated.notes


STATES = (
    "  IF $T1 OR NOT $IN_HOME THEN",
    "  WAIT SEC 1",
    "  ELSE",
    "  WAIT SEC 3",
    "  ENDIF",
    "  IF $AUT THEN",
    "  WAIT SEC 2",
    "  ENDIF",
)


@pytest.mark.parametrize("target", ["inform", "urscript"])
def test_what_a_program_asks_its_controller_is_a_variable_where_no_word_and_no_signal_tells_it(target):
    made = converted(krl(*STATES), "krl", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    says = "whether the arm stands at home is asked of a variable, at_home, which something has to set"
    assert (2, says) in loss_lines(made, "condition")
    asked = made.translated.asks["set, all the time, what the source's controller tells of itself"]
    assert list(asked) == ["manual_reduced", "at_home", "manual_full"]


@pytest.mark.parametrize("target", ["inform", "tp", "rapid", "urscript"])
def test_where_no_mode_is_manual_it_is_automatic(target):
    assert run_elsewhere(krl(*STATES[5:]), "krl", target).durations.tolist() == pytest.approx([2.0])


RETURNED = """def ask():
  local f = ask_the_operator(1)
  while f <= 0:
    f = ask_the_operator(1)
  end
  return f
end
"""


@pytest.mark.parametrize(("target", "head"), [("krl", "DEFFCT REAL ask"), ("rapid", "FUNC num ask")])
def test_a_routine_that_returns_what_no_file_tells_the_type_of_is_a_function(target, head):
    assert head in translated(RETURNED, "urscript", target)


def test_words_and_functions_of_krl_are_no_names_of_routines():
    lines = ["stop;", "ENDPROC", "PROC stop()", "ENDPROC", "PROC StrLen()"]
    made = translated(module(*lines), "rapid", "krl")
    assert "DEF stop (" not in made
    assert "DEF StrLen (" not in made
    reserved = {word.casefold() for word in limits_of("krl").reserved}
    assert not {word for word in KRL_WORDS - KRL_IN_PLACE if len(word) > 2} - reserved


@pytest.mark.parametrize(("target", "most"), [("inform", 8), ("tp", 10)])
def test_more_arguments_than_controllers_pass_are_left_out_with_a_word(target, most):
    enough, more = (",".join(map(str, range(1, n + 1))) for n in (most, most + 1))
    made = converted(module(f"far {enough};", f"far {more};"), "rapid", target)
    says = f"a routine with more than {most} arguments (pass some of them in variables)"
    assert [(loss.line, loss.says) for loss in made.translated.losses if loss.leaves_out] == [(4, says)]


def test_a_job_does_not_take_more_arguments_than_controllers_pass():
    made = converted(tp("R[1]=AR[8]", "R[2]=AR[9]"), "tp", "inform")
    says = "a routine with more than 8 arguments (pass some of them in variables)"
    assert (7, says) in loss_lines(made, "statement")
    assert b"IARG#(9)" not in made.files["PART.JBI"]


def test_no_signal_has_a_number_below_zero():
    made = converted(krl("  DECL CONST INT N=33", "  $OUT[N]=TRUE", "  $OUT[-N]=TRUE"), "krl", "tp")
    says = "a signal with the number -33"
    assert [(loss.line, loss.says) for loss in made.translated.losses if loss.leaves_out] == [(4, says)]


def test_names_of_registers_that_become_a_table_are_comments():
    """An element of a table has no name: the name that the pendant shows beside its number was lost."""
    rows = (
        "R[2:slot]=GI[1]", "PR[5,4:CORNER]=0", "PR[5,5:CORNER]=0", "PR[5,6:CORNER]=90", "J PR[3:HOME POS] 30% FINE",
        "J PR[R[2:slot]] 30% FINE", "R[7:count]=1",
    )  # fmt: skip
    text = translated(tp(*rows), "tp", "rapid")
    assert re.search(r"MoveJ PV\{3\},.*; !HOME POS", text), text
    assert re.search(r"PV\{5\}\.rot:=OrientZYX\(90,0,0\); !CORNER\r?\n", text), text
    assert "!slot" not in text  # a variable of its own has the name itself
    assert "!count" not in text
