"""What a translation writes loads on the target's controller, or is a comment that tells why it would not."""

import pytest
from translated_texts import converted, krl, module, script, translated

from olp.core.source import decode
from olp.fluent import read_source
from olp.transpile import Context
from olp.transpile.convert import convert

VAL3 = """<?xml version="1.0" encoding="utf-8"?>
<Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2">
  <Program name="a">
    <Locals>{locals}</Locals>
    <Code><![CDATA[begin
{rows}
end]]></Code>
  </Program>
</Programs>
"""


def val3(rows, target, locals=""):
    program = read_source(
        decode(VAL3.format(rows="\n".join(rows), locals=locals).encode(), "a.pgx"), vendor="val3"
    )
    return convert(program, target, Context(on_loss="comment"), date="2026/01/01 00:00")


def text_of(made):
    return b"\n".join(made.files.values()).decode("cp1252")


def says(made):
    return [loss.says for loss in made.translated.losses]


INDEXED = [
    "def gain(w, k):", "  if w[0] > k:", "    return w[1]", "  end", "  return w[0]*k", "end",
    "def handed(w):", "  return gain(w, 2)", "end",
    "a = [1.5, 2.5]", "a[1] = get_digital_in(1)",
]  # fmt: skip


def test_a_parameter_that_is_used_with_an_index_is_declared_as_an_array():
    made = converted(script(*INDEXED, "b = get_list()", "c = handed(b)", "textmsg(c)"), "urscript", "rapid")
    assert "FUNC num gain(num w{*},num k)" in text_of(made)
    assert "FUNC num handed(num w{*})" in text_of(made)  # which hands it on
    assert any("handed with one value, where it takes an array" in one for one in says(made))


@pytest.mark.parametrize("target", ["rapid", "krl", "tp", "inform"])
def test_a_variable_without_indices_has_no_elements(target):
    rows = ("def pos(q):", "  movej(q)", "  return q[2]", "end", "a = pos(get_list())", "textmsg(a)")
    made = converted(script(*rows), "urscript", target)
    assert any("q with 1 index, declared with none" in one for one in says(made))


@pytest.mark.parametrize("target", ["rapid", "krl"])
def test_an_axis_by_a_computed_number_is_told(target):
    rows = (
        "q = get_actual_joint_positions()",
        "i = 0",
        "while i < length(q):",
        "  i = i + 1",
        "  a = q[i]",
        "end",
    )
    made = converted(script(*rows), "urscript", target)
    assert "an axis by a computed number" in says(made)
    assert "Dim(" not in text_of(made)


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_signals_are_compared_with_on_and_off(target):
    on, off = ("DI[1]=ON", "DO[1]=OFF") if target == "tp" else ("IN#(1)=ON", "DOUT OT#(1) OFF")
    data = '<Local name="x" type="num" xsi:type="array" size="1"/>'
    made = val3(
        ["if dioGet(din)==1", "dioSet(dout,0)", "endIf", "if dioGet(din)==2", "delay(1)", "endIf"],
        target,
        data,
    )
    assert on in text_of(made)
    assert off in text_of(made)
    assert "a digital signal compared with 2" in says(made)


def test_functions_of_val3_are_told_as_what_they_are_and_left_out():
    made = val3(['x=taskStatus("a")', "x=sioGet(port,x)", "call open(x)"], "krl")
    assert "taskStatus, a function of VAL3, is unknown to KRL" in says(made)
    assert "\nx_1=taskStatus" not in text_of(made)
    assert "sioGet is a function of VAL3: KRL needs a routine of its own for it" in says(made)
    assert "open is in no file here: KRL needs a routine of its own for it" in says(
        made
    )  # a program of that name


@pytest.mark.parametrize("target", ["rapid", "inform"])
def test_the_flange_and_the_world_are_values_without_a_place(target):
    made = val3(["t=flange", "movej(p,t,m)"], target)
    assert "tool0;" not in text_of(made).split("MoveJ")[0]
    assert " BF" not in text_of(made)
    assert " TL#(0)" not in text_of(made).split("MOVJ")[0]


def test_arrays_that_a_routine_of_no_file_takes_are_whole_arrays_in_krl():
    text = translated(module("VAR num a{3}:=[1,2,3];", "elsewhere a, a{2};"), "rapid", "krl")
    assert "elsewhere (a_1[],a_1[2])" in text


def test_constants_of_other_enumerations_keep_their_names():
    text = krl(
        "ENUM OWN ONE,BASE",
        "DECL CIRC_TYPE C",
        "DECL OWN O",
        "O=#BASE",
        "C=#BASE",
        "IF C==#BASE THEN",
        "ENDIF",
    )
    text = translated(text, "krl", "rapid")
    assert "O:=2;" in text
    assert 'C:="#BASE";' in text
    assert 'IF C="#BASE" THEN' in text


def test_no_signal_of_tp_has_the_number_zero():
    made = converted(krl("  DECL CONST INT N=0", "  $OUT[N]=TRUE", "  WAIT SEC 1"), "krl", "tp")
    assert "a signal with the number 0" in says(made)
    assert "DO[0]" not in text_of(made)


def test_what_a_choice_by_texts_asks_is_a_text_from_the_start():
    data = ('VAR string s{2}:=["abc","ab"];',)
    text = module("TEST s{1}", 'CASE "ab":', "WaitTime 1;", "ENDTEST", data=data)
    assert "choice[]=s_1[1,]" in translated(text, "rapid", "krl")


def test_a_wait_without_a_limit_is_a_constant_of_rapid():
    made = converted(
        module("SocketReceive s \\Str:=t \\Time:=WAIT_MAX;", data=("VAR socketdev s;", "VAR string t;")),
        "rapid",
        "krl",
    )
    assert not any("WAIT_MAX" in one for one in says(made))
    text = translated(module("WaitDI d1,1\\MaxTime:=WAIT_MAX;"), "rapid", "krl")
    assert "WAIT FOR $IN[1]" in text


def test_the_comment_of_a_header_has_no_more_characters_than_tp_takes():
    text = krl("WAIT SEC 1").replace("DEF", "&COMMENT Mastering Reference Main Task\r\nDEF", 1)
    listing = translated(text, "krl", "tp")
    assert 'COMMENT\t\t= "Mastering Refere";' in listing
    assert "1:  !Mastering Reference Main Task ;" in listing
