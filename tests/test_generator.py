"""The base of the writers: tables and templates of a language that is made up here, and promises that hold for all."""

from __future__ import annotations

from typing import get_args

import pytest

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.languages.generator import CannotSayError, Generator, as_text, decimal

X, ONE = ex.Named("x"), ex.Number(1)


class ToyWriter(Generator):
    language = "TOY"
    binary = {"+": (" + ", 1), "-": (" - ", 1), "*": (" * ", 2)}  # noqa: RUF012
    unary = {"not": ("NOT {}", 4, 5)}  # noqa: RUF012
    logic = {"and": (" AND ", 2), "or": (" OR ", 1)}  # noqa: RUF012
    templates = {  # noqa: RUF012
        st.Assign: "{target} = {value}",
        st.If: "IF {condition} THEN",
        st.Else: "ELSE",
        st.EndIf: "END",
        st.Return: "RETURN{value: ({})}",
        st.Pause: "STOP",
        st.Label: "{name}:",
    }
    cannot = {st.Return: {"spelling": ("a way to say it", "say it plainly")}}  # noqa: RUF012
    own_only = {st.Process: "the word {s.name} of {self.source_language} ({called})"}  # noqa: RUF012
    step, comment_form = "  ", "  // {}"

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        assert it.literal is not None
        return decimal(it.literal / unit, 1)

    def template_values(self) -> dict[str, object]:
        self.begin()
        self.body(self.program.routines[0].body)
        return {"text": as_text(self.rows)}


def toy(*body: st.Statement, vendor: str = "") -> ToyWriter:
    source = decode(b"a line\n" * 20, "toy")
    program = st.Program(vendor, source, (st.Routine("MAIN", 1, body, PointTable()),))
    return ToyWriter(program, own=not vendor)


def text(*body: st.Statement) -> object:
    values, problems = toy(*body).written()
    assert not problems
    return values["text"]


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        (ex.Binary("*", ex.Binary("+", X, ONE), X), "(x + 1) * x"),
        (ex.Binary("+", ex.Binary("*", X, ONE), X), "x * 1 + x"),
        (ex.Binary("-", X, ex.Binary("-", X, ONE)), "x - (x - 1)"),
        (ex.Logic(X, (("or", X), ("and", X))), "(x OR x) AND x"),
        (ex.Logic(X, (("and", X), ("or", X))), "x AND x OR x"),
        (ex.Unary("not", ex.Compare("<", X, ONE)), "NOT (x<1)"),
    ],
)
def test_parentheses_stand_where_the_tables_ask_for_them(expression: ex.Expression, wanted: str) -> None:
    assert toy().value(expression) == wanted


def test_blocks_are_indented_and_comments_stand_behind_their_line() -> None:
    body = (st.If(1, X, "why"), st.Assign(2, X, ONE), st.Else(3), st.Return(4, ONE), st.EndIf(5))
    assert text(*body) == "IF x THEN  // why\n  x = 1\nELSE\n  RETURN (1)\nEND\n"


def test_a_statement_under_a_condition_becomes_a_block_where_the_language_has_no_other_form() -> None:
    assert text(st.Pause(1, X)) == "IF x THEN\n  STOP\nEND\n"


def test_what_cannot_be_said_is_told_in_its_line_and_the_rest_is_written() -> None:
    body = (st.Return(3, spelling="EXIT"), st.Process(4, "ARC"), st.Message(5, X), st.Label(6, "a"))
    values, problems = toy(*body, vendor="krl").written()
    assert [(found.code, found.line, found.message, found.help) for found in problems] == [
        ("X002", 3, "TOY cannot express this: a way to say it", "say it plainly"),
        ("X002", 4, "TOY cannot express this: the word ARC of KRL (process instruction)", ""),
        ("X002", 5, "TOY cannot express this: message", ""),
    ]
    assert values["text"] == "a:\n"


def test_a_template_that_names_no_field_is_refused_when_the_language_is_loaded() -> None:
    with pytest.raises(TypeError, match="a Label has no 'nome'"):
        type("Wrong", (ToyWriter,), {"templates": {st.Label: "{nome}:"}})


def test_a_dialect_changes_what_its_language_says_and_keeps_the_rest() -> None:
    dialect = type("Dialect", (ToyWriter,), {"templates": {st.Label: "LABEL {name}"}})
    writer = dialect(toy(st.Label(1, "a"), st.Pause(2)).program, True)
    assert writer.written()[0]["text"] == "LABEL a\nSTOP\n"


def test_no_expression_and_no_statement_ends_in_another_error_than_a_refusal() -> None:
    unknown = ex.Element(ex.Taught(ex.Store.ROBOT, 1), ONE)
    with pytest.raises(CannotSayError, match="a value of a kind"):
        toy().value(unknown)
    assert set(ToyWriter._spellers) == set(get_args(ex.Expression))
    assert not issubclass(CannotSayError, OlpError)  # it becomes a diagnostic with a place
