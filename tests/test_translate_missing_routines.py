"""Routines that nobody has translated: those of the source's own controllers, and those of files that are not here."""

from __future__ import annotations

import re

import pytest
from translated_texts import ROBOT, converted, krl, module, read, run_elsewhere, script, translated

import olp
from olp.runtime.interpreter import run
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.context import Fate
from olp.transpile.convert import convert
from olp.transpile.link import link

# The first call sets n, the second decides what runs.
OWN = {
    "rapid": module("ok:=IsStopStateEvent(n);", "IF RobOS() THEN", "WaitTime 1;", "ENDIF", "WaitTime n;",
                    data=("VAR num n;", "VAR bool ok;")),
    "krl": krl("DECL INT n", "DECL CHAR t[9]", "n=MD_GETSTATE(t[],n)", "IF MBX_REC(n)>0 THEN", "WAIT SEC 1",
               "ENDIF", "WAIT SEC n"),
}  # fmt: skip


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp", "urscript"])
@pytest.mark.parametrize("vendor", OWN)
def test_what_only_the_sources_controllers_have_is_left_out(vendor, target):
    if vendor == target:
        return
    losses = converted(OWN[vendor], vendor, target).translated.losses
    first = next(
        i for i, text in enumerate(OWN[vendor].splitlines(), 1) if "IsStop" in text or "MD_GET" in text
    )
    gone = {loss.line for loss in losses if loss.fate is Fate.COMMENTED}
    assert gone >= {first, first + 1, first + 2, first + 3}
    assert any(loss.line == first + 4 for loss in losses)  # n is not what it was


def test_a_routine_of_the_mapping_file_takes_their_place():
    from olp.transpile.context import Mapping

    mapping = Mapping(routines={"robos": "MY_ROBOT", "isstopstateevent": "MY_VALUE"})
    context = Context(robot=ROBOT, mapping=mapping, on_loss="comment")
    made = convert(read(OWN["rapid"], "rapid"), "krl", context)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


def test_what_a_routine_elsewhere_is_handed_need_not_stay_whole():
    rows = ("FOR i FROM 1 TO 3 DO", "n:=n+1;", "{}", "list{{n}}:=1;", "ENDFOR")
    data = ("VAR num n:=1;", "VAR num list{9};")
    text = module(*(row.format("other n;") for row in rows), data=data)
    assert "DECL REAL n" in translated(text, "rapid", "krl")
    assert "DECL INT n" in translated(module(*(row.format("") for row in rows), data=data), "rapid", "krl")


@pytest.mark.parametrize(
    ("call", "storage"), [("other(XP)", "VAR"), ("m=other(XP)", "VAR"), ("m=2", "CONST")]
)
def test_what_a_routine_elsewhere_is_handed_may_change(tmp_path, call, storage):
    """KRL hands variables over by reference unless a routine says otherwise."""
    (tmp_path / "m.src").write_text(f"DEF m( )\nDECL INT m\n{call}\nPTP XP\nEND\n")
    (tmp_path / "m.dat").write_text("DEFDAT m\nDECL E6POS XP={X 900,Y 0,Z 400,A 0,B 90,C 0}\nENDDAT\n")
    made = convert(link(olp.read(tmp_path / "m.src")).program, "rapid", Context(ROBOT, on_loss="comment"))
    assert f"{storage} robtarget XP:=" in made.files[made.main].decode()


def test_a_first_value_that_is_asked_for_is_left_out_not_nearly_right():
    losses = converted(
        script("t = is_steady()", "if t:", "  sleep(1)", "end"), "urscript", "rapid"
    ).translated.losses
    assert {loss.fate for loss in losses if "first value" in loss.says} == {Fate.COMMENTED}


def test_decimals_of_a_text_are_rounded_where_they_cannot_be_said():
    text = module("s:=NumToStr(n,2);", "Incr n;", data=("VAR string s;", "VAR num n:=1.2345;"))
    told = [
        loss.part
        for loss in converted(text, "rapid", "urscript").translated.losses
        if "decimals" in loss.says
    ]
    assert told == ["text"]
    assert "to_str(olp_round(n * 100) / 100)" in translated(text, "rapid", "urscript")


def test_a_member_of_a_structure_without_a_value_is_set(tmp_path):
    (tmp_path / "s.src").write_text(
        "DEF s( )\nSTRUC part_t INT id, REAL h\nDECL part_t p\nDECL part_t q[3]\nDECL INT i\np.id=3\ni=p.id\n"
        "WAIT SEC i\nq[2].id=7\ni=q[2].id\nWAIT SEC i\ni=p.h\nEND\n"
    )
    plan = run(olp.read(tmp_path / "s.src"))
    assert [float(s) for s in plan.durations] == [3, 7]
    assert [d.line for d in plan.diagnostics if d.code == "I203"] == [12]


SOCKET = krl("DECL EKI_STATUS ret", "DECL INT v", 'ret=EKI_Open("CELL")', 'ret=EKI_GetInt("CELL","a/b",v)',
             "WAIT SEC v", "{}", 'ret=EKI_Close("CELL")')  # fmt: skip


def test_what_reaches_outside_the_arm_is_called_by_its_name_and_told():
    text = SOCKET.format("")
    told = converted(text, "krl", "rapid").translated.losses
    assert [(loss.fate, loss.part) for loss in told if "EKI" in loss.says] == [
        (Fate.APPROXIMATED, "call")
    ] * 3
    made = translated(text, "krl", "rapid")
    assert 'EKI_Open "CELL";' in made
    assert 'EKI_GetInt "CELL","a/b",v;' in made
    assert "ret_" not in made
    assert [
        loss.says
        for loss in converted(text, "krl", "urscript").translated.losses
        if "cannot change" in loss.says
    ]


def test_what_a_socket_tells_is_handed_over_member_by_member():
    made = translated(SOCKET.format("WAIT FOR ret.connected"), "krl", "rapid")
    members = "ret_Buff,ret_Read,ret_Msg_No,ret_Connected,ret_Counter"
    assert f'EKI_Open "CELL",{members};' in made
    assert "VAR bool ret_Connected;" in made
    assert "WaitUntil ret_Connected" in made


@pytest.mark.parametrize("row", ["RSI_MOVECORR()", "n=MBX_REC(n)"])
def test_what_moves_the_arm_or_belongs_to_the_controller_stays_rejected(row):
    losses = converted(krl("DECL INT n", row), "krl", "rapid").translated.losses
    assert [loss.fate for loss in losses if "unknown to" in loss.says] == [Fate.COMMENTED]


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_what_reaches_outside_the_arm_is_called_by_its_name(target):
    data = ("VAR socketdev line;", "VAR string answer;", "VAR num which;")
    rows = ("SocketCreate line;", 'SocketSend line\\Str:="go";', "SocketReceive line\\Str:=answer\\Time:=5;")
    rows += ('TPReadFK which,"Which?","A","B",stEmpty,stEmpty,stEmpty;', "g_Init \\maxSpd:=10 \\Calibrate;")
    made = converted(module(*rows, data=data), "rapid", target)
    told = {one.line: one for one in made.translated.losses if one.part == "call"}
    assert sorted(told) == [6, 7, 8, 9, 10]
    assert {one.fate for one in told.values()} == {Fate.APPROXIMATED}
    written = translated(module(*rows, data=data), "rapid", target).upper()
    calls = {"krl": 'SOCKETSEND (LINE,"GO")', "tp": "CALL SOCKETSEND(R[1:LINE],'GO')"}
    assert calls.get(target, 'SOCKETSEND(LINE, "GO")') in written
    assert {"krl": 'G_INIT (10,"CALIBRATE")', "tp": "CALL G_INIT(10,'CALIBRATE')"}.get(
        target, "G_INIT(10"
    ) in written


def test_a_handler_of_what_is_called_by_its_name_is_left_out():
    data = ("VAR socketdev line;",)
    text = module('SocketSend line\\Str:="go";', "ERROR", "IF ERRNO=ERR_SOCK_CLOSED RETRY;", data=data)
    losses = [one for one in converted(text, "rapid", "krl").translated.losses if one.statement == "Disabled"]
    assert {one.fate for one in losses} == {Fate.APPROXIMATED}


def test_functions_of_texts_are_called_by_their_names():
    data = ("VAR string s;", "VAR num n;", "VAR bool ok;")
    text = module('s:="12";', "ok:=StrToVal(s,n);", "WaitTime n;", data=data)
    made = converted(text, "rapid", "krl").translated.losses
    assert not [one for one in made if one.leaves_out]
    assert [one.line for one in made if one.part == "call"] == [7]
    assert "ok=StrToVal(s_1[],n)" in translated(text, "rapid", "krl")


RETURNING = [
    ("tp", "R[{}:", (r"CALL UINUMENTRY\(.*?(\d+)\)", r"CALL STRTOVAL\(SR\[1:s\],R\[\d+:n\],(\d+)\)")),
    ("tp", "SR[{}:", (r"CALL READSTR\(.*?(\d+)\)",)),
    ("inform", "R{:03}", (r"CALL JOB:UINumEntry .*ARGF(\d+)", r"CALL JOB:StrToVal ARGFS000 ARGFR\d+ ARGF(\d+)")),
    ("inform", "S{:03}", (r"CALL JOB:ReadStr .*ARGF(\d+)",)),
]  # fmt: skip


@pytest.mark.parametrize(("target", "register", "calls"), RETURNING)
def test_the_value_of_a_routine_elsewhere_comes_back_in_a_variable_whose_number_it_gets(
    target, register, calls
):
    """FANUC's and Yaskawa's calls have no value: it was lost into INFORM and refused into TP."""
    text = module(
        'n:=UINumEntry(\\Message:="count");',
        "ok:=StrToVal(s,n);",
        "s:=ReadStr(log);",
        "IF ok AND SocketGetStatus(link)=SOCKET_CONNECTED THEN",
        "WaitTime n;",
        "ENDIF",
        data=("VAR num n;", "VAR bool ok;", "VAR string s;", "VAR iodev log;", "VAR socketdev link;"),
    )
    made = converted(text, "rapid", target)
    losses = made.translated.losses
    assert not [loss for loss in losses if loss.leaves_out]
    assert sum("number is its last argument" in loss.says for loss in losses) == 4
    written = b"".join(made.files.values()).decode("latin-1")
    for call in calls:
        found = re.search(call, written)
        assert found is not None, call
        assert register.format(int(found[1])) in written[found.end() :]


def test_the_position_that_a_routine_elsewhere_returns_is_a_position_register():
    text = krl("PTP calc(1)", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}")
    assert re.search(r"CALL CALC\(1,(\d+)\).*J PR\[\1[:\]]", translated(text, "krl", "tp"), re.DOTALL)
    losses = converted(krl("PTP calc(1,$POS_ACT)"), "krl", "tp").translated.losses
    assert [
        loss.says for loss in losses if loss.leaves_out
    ]  # no call of FANUC's hands over where the arm stands


UR_SOCKET = script(
    'if (not socket_open("10.0.0.2", 30000, "cell")):',
    '  popup("no cell", "cell", error=True)',
    "end",
    'socket_send_string("go", "cell")',
    "write_output_integer_register(3, 7)",
    "n = read_input_integer_register(2)",
    "sleep(n)",
)


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_functions_of_urscript_that_reach_outside_the_arm_are_calls(target):
    made = converted(UR_SOCKET, "urscript", target)
    told = [one for one in made.translated.losses if "routine of its own" in one.says]
    assert {one.fate for one in told} == {Fate.APPROXIMATED}
    assert len({one.line for one in told}) == 4
    assert not [one for one in made.translated.losses if one.fate is Fate.COMMENTED]


def test_arguments_and_results_of_such_a_function_keep_their_place_and_kind():
    made = translated(UR_SOCKET, "urscript", "krl")
    assert 'IF NOT socket_open("10.0.0.2",30000,"cell") THEN' in made
    assert "write_output_integer_reg (3,7)" in made  # 24 characters
    assert "DECL INT n" in made


UR_LIST = script(
    'first = socket_read_ascii_float(2, "cell")',
    "sleep(first[1])",
    "while get_digital_in(0):",
    '  got = socket_read_ascii_float(3, "cell")',
    "  if got[0] >= 3:",
    "    sleep(got[3])",
    "  end",
    "end",
)


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_a_list_that_such_a_function_gives_is_filled_by_a_routine(target):
    """The number of values comes first, then the values."""
    losses = converted(UR_LIST, "urscript", target).translated.losses
    assert not [one for one in losses if one.fate is Fate.COMMENTED]
    told = [one for one in losses if one.part == "call"]
    assert [one.line for one in told] == [2, 5]
    # No routine of INFORM and TP can change what it is handed.
    assert all(("cannot change" in one.says) == (target in ("inform", "tp")) for one in told)
    made = translated(UR_LIST, "urscript", target)
    expected = {"krl": "DECL REAL got[4]", "rapid": "VAR num got{4}"}
    assert expected.get(target, "") in made
    assert {"rapid": 'socket_read_ascii_float 3,"cell",got;'}.get(target, "") in made


def test_how_much_is_read_may_be_a_sum():
    """As ROS drivers write it."""
    text = script("got = socket_read_binary_integer(1+6+1)", "sleep(got[8])")
    assert "VAR num got{9}" in translated(text, "urscript", "rapid")


def test_what_such_a_routine_fills_is_no_constant():
    text = script("got = [1.0, 2.0]", 'got = socket_read_ascii_float(1, "cell")', "sleep(got[1])")
    made = translated(text, "urscript", "rapid")
    assert "WaitTime 2" not in made


@pytest.mark.parametrize(
    "rows",
    [
        ('got = socket_read_ascii_float(n, "cell")', "sleep(got[1])"),  # nobody knows of how many
        ("got = [1.0]", 'got = socket_read_ascii_float(3, "cell")', "sleep(got[0])"),  # there is no room
    ],
)
def test_a_list_without_room_for_what_is_read_is_left_out(rows):
    text = script("n = 2", "sync()", "n = 3", *rows)
    line = next(n for n, row in enumerate(text.splitlines(), 1) if "socket" in row)
    losses = converted(text, "urscript", "rapid").translated.losses
    assert line in {one.line for one in losses if one.fate is Fate.COMMENTED}


GRIPPER = """def part():
  global act = [-1, -1, 3, 0.5]
  global previous = act
  def is_ack(bytes):
    if bytes[0] != 3:
      return False
    end
    return bytes[1] == 97
  end
  def is_not_ack(bytes):
    return not is_ack(bytes)
  end
  def sids(socket="1"):
    found = [17, 9, 8]
    return found
  end
  def set_var(name, socket="1"):
    write_output_integer_register(3, 1)
    return [3, 97, 99, 107]
  end
  def doubled(f):
    local out = [0, 0]
    out[0] = f[0] * 0.5
    out[1] = f[1]
    return out
  end
  sleep(previous[2])
  previous[2] = 4
  sleep(act[2])
  sid = sids()
  sleep(sid[1])
  if is_ack(set_var("ACT")):
    sleep(7)
  end
  set_var("GTO")
  half = doubled([1, 5])
  sleep(half[0])
  sleep(half[1])
end
"""


def waits_elsewhere(text: str, target: str) -> list[float]:
    """[s] that a URScript program waits when it is translated."""
    plan = run_elsewhere(text, "urscript", target)
    return [float(plan.durations[row]) for row in plan.row[plan.kind == StepKind.WAIT]]


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_lists_that_functions_take_and_give_back_are_arrays(target):
    """As the functions of a gripper do that a PolyScope program holds."""
    losses = converted(GRIPPER, "urscript", target).translated.losses
    assert {one.line for one in losses if one.fate is Fate.COMMENTED} <= {11}  # what nothing calls
    assert waits_elsewhere(GRIPPER, target) == pytest.approx([3, 3, 9, 7, 0.5, 5])


OF_ITSELF = """def part():
  global a = [1, 2]
  def turned(f):
    return [f[1], f[0]]
  end
  a = [a[1], a[0] + 5]
  sleep(a[0])
  sleep(a[1])
  a = turned(a)
  sleep(a[0])
  sleep(a[1])
end
"""


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_a_list_that_is_computed_from_itself_is_computed_before_it_changes(target):
    losses = converted(OF_ITSELF, "urscript", target).translated.losses
    assert not [one for one in losses if one.leaves_out]
    assert waits_elsewhere(OF_ITSELF, target) == pytest.approx([2, 6, 6, 2])


@pytest.mark.parametrize(
    "rows",
    [
        ("  if cell and is_ack(ask()):", "    sleep(1)", "  end"),  # asked in half of the cases
        ("  while is_ack(ask()):", "    sleep(1)", "  end"),  # asked again and again
    ],
)
def test_a_list_that_is_not_made_before_the_statement_stays_where_it_is(rows):
    head = (
        "def part():",
        "  global cell = False",
        "  def is_ack(bytes):",
        "    return bytes[0] == 3",
        "  end",
    )
    asks = ("  def ask():", "    cell = True", "    return [3, 97]", "  end")
    text = "\n".join((*head, *asks, *rows, "  sleep(2)", "end", ""))
    made = converted(text, "urscript", "rapid")
    losses = [one for one in made.translated.losses if one.fate is Fate.COMMENTED]
    assert 10 in {one.line for one in losses}
