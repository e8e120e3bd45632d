"""Variables: widths, rounding, arithmetic, texts, where first values come from."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interpreter_jobs import errors, findings, job_text, plan_of, program, said, visited, waits, write_jobs

from olp.core.source import decode
from olp.fluent import read, read_source
from olp.ir.expressions import Store
from olp.runtime.assumptions import Assumptions
from olp.runtime.interpreter import run

NOTHING = Assumptions()


def shown(body: str, variable: str = "D000") -> float:
    """The value of an integer variable at the end of a job, shown as hundredths of a wait (negative ones by 1000)."""
    plan = plan_of(f"{body}\nADD {variable} 1000\nTIMER T={variable}")
    return round(waits(plan)[-1] * 100 - 1000, 6)


def test_a_divisor_without_a_value_is_no_alarm_of_the_program() -> None:
    """It is 0 here because no file says it: the line is left out, and the total says that something is unknown."""
    plan = plan_of("SET D000 7\nDIV D000 D001\nSET D002  EXPRESS D000 / D003\nMOVL C00001 V=50.0")
    found = [(d.code, d.message) for d in plan.diagnostics if d.code == "I203"]
    assert [message.partition(",")[0] for _, message in found] == ["D001 has no value", "D003 has no value"]
    assert not errors(plan)
    assert visited(plan) == [1]
    with_value = plan_of("SET D000 7\nSET D001 0\nDIV D000 D001\nMOVL C00001 V=50.0")
    assert [code for code, _ in errors(with_value)] == ["I207"]


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("SET B000 256", "I205"),
        ("SET B000 -1", "I205"),
        ("SET B000 255\nINC B000", "I205"),
        ("SET B000 0\nDEC B000", "I205"),
        ("SET I000 32768", "I205"),
        ("SET I000 -32769", "I205"),
        ("SET D000 2147483647\nADD D000 1", "I205"),
        ("SET D000 70000\nMUL D000 70000", "I205"),
        ("SET D000 5\nDIV D000 0", "I207"),
        ("SET R000 1.5\nDIV R000 0", "I207"),
        ("SET D000  EXPRESS 4 / ( 2 - 2 )", "I207"),
        ("SQRT R000 -1.0", "I202"),
    ],
)
def test_what_the_controller_stops_with_an_alarm_for_is_an_error_on_its_line(body: str, code: str) -> None:
    plan = plan_of(f"{body}\nMOVL C00001 V=50.0")
    line = plan.sources[0].lines.index(body.splitlines()[-1]) + 1
    assert errors(plan) == [(code, line)]
    assert visited(plan) == [1]


@pytest.mark.parametrize(
    "body",
    [
        "SQRT R000", "SIN R000", "COS R000", "ATAN R000", "MULMAT P007", "MULMAT P007 P008", "INVMAT P007",
        "CNVRT P007", "MID$ S000 S001", "LEN I000", "ASC B000", "CHR$ S000", "VAL I000",
    ],
)  # fmt: skip
def test_a_function_without_its_arguments_is_told_and_the_job_goes_on(body: str) -> None:
    found = read_source(decode(job_text(f"{body}\nMOVL C00001 V=50.0").encode(), "TEST.JBI"))
    plan = run(found, assumptions=NOTHING)
    line = plan.sources[0].lines.index(body) + 1
    told = [d.line for d in (*found.diagnostics, *plan.diagnostics) if d.is_error]
    assert told[:1] == [line]
    assert visited(plan) == [1]


@pytest.mark.parametrize(
    "body", ["SET B000 255", "SET I000 -32768", "SET I000 32767", "SET D000 -2147483648"]
)
def test_the_ends_of_each_range_fit(body: str) -> None:
    assert not findings(plan_of(body))


def test_a_variable_keeps_its_value_when_a_new_one_does_not_fit() -> None:
    assert shown("SET B000 250\nADD B000 10\nSET D000 B000") == 250


@pytest.mark.parametrize(
    ("body", "value"),
    [
        ("SET D000 7\nDIV D000 2", 3),
        ("SET D000 -7\nDIV D000 2", -3),
        ("SET D000  EXPRESS 7 * 3 - ( 4 + 5 ) / 3", 18),
        ("SET I000 3\nSET D000  EXPRESS 10 / -I000 * 3", -10),
        ("SET I004 2\nSET D000  EXPRESS 4 * 5 - ( 6 + 8 ) / -I004", 27),
        ("SET R000 2.5\nSET D000 R000", 3),
        ("SET R000 -2.5\nSET D000 R000", -3),
        ("SET R000 2.49\nSET D000 R000", 2),
        ("SQRT R000 144\nSET D000 R000", 12),
        ("SET B000 12\nAND B000 10\nSET D000 B000", 8),
        ("SET B000 12\nOR B000 10\nSET D000 B000", 14),
        ("SET B000 12\nXOR B000 10\nSET D000 B000", 6),
        ("SET B000 1\nNOT B000 B000\nSET D000 B000", 254),
        ("SET D017 44\nSET LI003 17\nSET D000 D[LI003]", 44),
        ("SET LI003 17\nSET D[LI003] 45\nSET D000 D017", 45),
        ("SET D000 5\nSET D001 6\nCLEAR D000 1", 0),
        ("SET D001 6\nCLEAR D000 ALL\nSET D000 D001", 0),
        ("SET D001 6\nSET D000 5\nCLEAR D001 ALL", 5),
        ("SET D001 6\nSET D000 5\nSET D002 7\nCLEAR D000 2\nADD D000 D002", 7),
        ("SET D000 -6\nDIV D000 -2", 3),
        ("SET D000 0\nDIV D000 -3", 0),
        ("SETREG MREG#(3) 258\nGETREG D000 MREG#(3) HIGH", 1),
        ("SETREG MREG#(3) 258\nGETREG D000 MREG#(3) LOW", 2),
        ("SETREG MREG#(3) 258\nSETREG MREG#(3) HIGH 4\nGETREG D000 MREG#(3)", 1026),
        ("SETREG MREG#(3) 258\nSETREG MREG#(3) LOW 4\nGETREG D000 MREG#(3)", 260),
        ('SET S000 "AB417"\nMID$ S001 S000 3 2\nVAL D000 S001', 41),
        ('SET S000 "LEFT"\nSTRSTR D000 S000 "FT"', 3),
        ('SET S000 "LEFT"\nASC D000 S000', 76),
        ("SIN R000 30\nMUL R000 100\nSET D000 R000", 50),
        ("COS R000 60\nMUL R000 100\nSET D000 R000", 50),
        ("ATAN R000 1\nSET D000 R000", 45),
        ('SET S000 "417"\nVAL D000 S000', 417),
        ('SET S000 "LEFT"\nLEN D000 S000', 4),
    ],
)
def test_arithmetic_gives_what_the_controller_would(body: str, value: int) -> None:
    assert shown(body) == value


def test_a_negative_index_is_an_error() -> None:
    assert [code for code, _ in errors(plan_of("SET LI000 -1\nSET D000 D[LI000]"))] == ["I221"]


def test_rounding_and_lost_fractions_are_reported_where_they_happen() -> None:
    assert "is rounded to the nearest integer" in said(plan_of("SET R000 2.5\nSET D000 R000"))
    assert "loses its fraction" in said(plan_of("SET D000 7\nDIV D000 2"))
    assert not said(plan_of("SET R000 4.0\nSET D000 R000\nSET D001 8\nDIV D001 2"))


def test_texts_are_compared_and_joined() -> None:
    body = """
    SET LS000 "OUT"
    CAT$ LS001 LS000 "WARDS"
    IFTHENEXP LS001="OUTWARDS"
    MOVL C00001 V=50.0
    ENDIF
    """
    assert visited(plan_of(body)) == [1]


def test_a_variable_that_nobody_set_is_zero_and_told_once_with_its_first_line() -> None:
    plan = plan_of("SET D000 D007\nSET D001 D007\nSET D002 D008")
    first = plan.sources[0].lines.index("SET D000 D007") + 1
    assert said(plan).splitlines() == [
        f"{first}: D007 is taken as 0: not in VAR.DAT or olp.toml",
        f"{first + 2}: D008 is taken as 0: not in VAR.DAT or olp.toml",
    ]


def test_first_values_come_from_var_dat_and_olp_toml_wins(tmp_path: Path) -> None:
    main = write_jobs(tmp_path, {"MAIN": "TIMER T=I000\nTIMER T=I001\nTIMER T=I002"})
    (tmp_path / "VAR.DAT").write_bytes(b"//VAR\r\n///SHARE 0,3,0,0,0,0,0,0\r\n///I\r\n110,120,130\r\n")
    (tmp_path / "olp.toml").write_text("[variables]\nI001 = 77\n", encoding="utf-8")
    plan = run(read(main))
    assert waits(plan) == pytest.approx([1.10, 0.77, 1.30])
    assert not said(plan)


def test_an_undefined_name_is_an_error_and_nothing_else_stops() -> None:
    text = job_text("SET Speed_1 5\nMOVL C00001 V=50.0")
    plan = run(read_source(decode(text.encode(), "TEST.JBI")), assumptions=NOTHING)
    assert visited(plan) == [1]
    assert "I218" in [code for code, _ in errors(plan)]


# --- random arithmetic against a small evaluator of its own ---------------------------------------------------

LIMITS = {"B": (0, 255), "I": (-32768, 32767), "D": (-(2**31), 2**31 - 1)}
NAMES = [f"{letter}{n:03d}" for letter in "BID" for n in range(3)]
OPERATIONS = st.tuples(
    st.sampled_from(["SET", "ADD", "SUB", "MUL", "DIV", "INC", "DEC"]),
    st.sampled_from(NAMES),
    st.one_of(st.sampled_from(NAMES), st.integers(-40000, 40000).map(str)),
)


def reference(operations: list[tuple[str, str, str]]) -> dict[str, int]:
    """The variables after the operations; one that cannot be done changes nothing."""
    held = dict.fromkeys(NAMES, 0)
    for word, target, operand in operations:
        right = held[operand] if operand in held else int(operand)
        left = held[target]
        if word == "DIV":
            if right == 0:
                continue
            result = abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1)
        else:
            result = {
                "SET": right, "ADD": left + right, "SUB": left - right, "MUL": left * right,
                "INC": left + 1, "DEC": left - 1,
            }[word]  # fmt: skip
        low, high = LIMITS[target[0]]
        if low <= result <= high:
            held[target] = result
    return held


@settings(max_examples=60, deadline=None)
@given(st.lists(OPERATIONS, min_size=1, max_size=25))
def test_random_programs_compute_what_an_independent_evaluator_computes(
    operations: list[tuple[str, str, str]],
) -> None:
    lines = [
        f"{word} {target}" + ("" if word in ("INC", "DEC") else f" {operand}")
        for word, target, operand in operations
    ]
    # Each result is compared inside the job: any difference makes a wait.
    expected = reference(operations)
    checks = [f"IFTHENEXP {name}<>{value}\nTIMER T=1.00\nENDIF" for name, value in expected.items()]
    zeros = Assumptions(
        variables={
            ({"B": Store.BYTE, "I": Store.INTEGER, "D": Store.DOUBLE}[n[0]], int(n[1:])): 0 for n in NAMES
        }
    )
    plan = run(program("\n".join([*lines, *checks])), assumptions=zeros)
    assert waits(plan) == []


STATEMENTS = st.sampled_from(
    [
        "*A", "*B", "JUMP *A", "JUMP *B IF B000=0", "JUMP *A IF IN#(1)=ON", "INC B000", "SET B000 0",
        "MOVL C00001 V=50.0",
        "MOVL C00099 V=50.0", "IFTHENEXP B000>2", "ELSE", "ELSEIFEXP IN#(2)=ON", "ENDIF", "WHILE B000<3", "ENDWHILE",
        "FOR LI000 START= 0 TO 2", "NEXT LI000", "TIMER T=0.10", "CALL JOB:TEST", "CALL JOB:NOWHERE", "RET",
        "SWITCH B000", "CASE 1", "DEFAULT", "ENDSWITCH", "JUMP LABEL: B000", "*0", "WAIT IN#(1)=ON T=0.50",
        "SETE P001 (1) 1200", "SFTON P001", "SFTOF", "IMOV P001 V=50.0 BF", "GETS PX000 $PX001", "MOVL P000 V=50.0",
        "CLEAR STACK", "DIV B000 B001", "SET D000 B000", "PULSE OT#(1) T=0.20",
    ]
)  # fmt: skip


@settings(max_examples=150, deadline=None)
@given(st.lists(STATEMENTS, max_size=14))
def test_no_job_whatever_breaks_the_interpreter_or_keeps_it_running(statements: list[str]) -> None:
    source = decode(job_text("\n".join(statements)).encode(), "TEST.JBI")
    plan = run(read_source(source), assumptions=NOTHING, max_steps=3000)
    lines = len(source.lines)
    assert all(0 <= d.line <= lines for d in plan.diagnostics)
    assert all(d.help for d in plan.diagnostics if d.is_error)
    assert len(plan) <= 3000


def test_a_mistake_that_the_reader_has_told_is_not_told_again() -> None:
    text = job_text("MOVL C00003 V=50.0\nMOVL C00077 V=50.0\nJUMP *NOWHERE")
    broken = text.replace("C00003=123.500", "C00003=12x.500", 1)
    assert broken != text
    program_ = read_source(decode(broken.encode(), "TEST.JBI"))
    plan = run(program_, assumptions=NOTHING)
    assert [d.code for d in plan.diagnostics if d.is_error] == [
        d.code for d in program_.diagnostics if d.is_error
    ]
