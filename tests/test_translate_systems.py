"""Tools and frames that other files declare, files beside the program, and what a missing robot stops."""

import math
import re

import pytest
from translated_texts import ROBOT, converted, krl, module, read, script, translated

import olp
from olp.core.diagnostic import OlpError
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate, Mapping
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link
from olp.transpile.preflight import before_it_runs

TARGET = "[[{},30,410],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
POINTS = [f"CONST robtarget p{n}:={TARGET.format(500 + 40 * n)};" for n in (1, 2)]
RAPID = module(
    "MoveL p1, v100, fine, tGripper\\WObj:=wTable;",
    "MoveL p2, v100, fine, tCut\\WObj:=wTable;",
    "MoveL p1, v100, fine, tGripper;",
    data=POINTS,
)
TOOL = "PERS tooldata {}:=[TRUE,[[12,-7,150],[0.96592583,0,0.25881905,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
FRAME = 'PERS wobjdata {}:=[FALSE,TRUE,"",[[310,-45,20],[0.98480775,0,0,0.17364818]],[[0,0,0],[1,0,0,0]]];'
SYSTEM = "\r\n".join(
    [
        "MODULE Cell(SYSMODULE)",
        TOOL.format("tGripper"),
        TOOL.format("tCut"),
        FRAME.format("wTable"),
        "ENDMODULE",
    ]
)
NUMBERED = ("inform", "krl", "tp")


def written(folder, **files):
    """Writes files (stem_suffix -> text) and reads the first with what it names from the others."""
    paths = []
    for name, text in files.items():
        path = folder / name.replace("_", ".")
        path.write_text(text, encoding="cp1252")
        paths.append(path)
    return link(olp.read(paths[0]))


def made(program, target, on_loss="error", **mapping):
    return convert(program, target, Context(robot=ROBOT, mapping=Mapping(**mapping), on_loss=on_loss))


def text_of(converted):
    return b"\n".join(converted.files.values()).decode("cp1252")


def difference(program, converted, target):
    return compare_plans(program.plan(robot=ROBOT), run_converted(converted, target, ROBOT, program))


def assert_same(program, converted, target, steps):
    found = difference(program, converted, target)
    assert found.steps == steps
    assert not [one for one in found.differences if "apart" in one]
    assert found.worst_position < 1e-6


# --- tools and frames of a file that is not at hand -----------------------------------------------------------------


@pytest.mark.parametrize("target", NUMBERED)
def test_a_tool_of_another_module_gets_a_free_number_and_the_receipt_asks_for_its_values(tmp_path, target):
    program = written(tmp_path, part_mod=RAPID).program
    one = made(program, target)
    says = [(x.line, x.fate, x.says) for x in one.translated.losses if x.part == "name"]
    asked = [row for row in says if "have to be set on the controller" in row[2]]
    assert [(line, fate) for line, fate, _ in asked] == [(5, Fate.APPROXIMATED)] * 2 + [
        (6, Fate.APPROXIMATED)
    ]
    assert {line for line, _, _ in says} == {5, 6, 7}
    numbers = {name: one.translated.mapping[("tool", name)] for name in ("tGripper", "tCut")}
    assert numbers == {"tGripper": "1", "tCut": "2"}
    assert any("both runs take the flange for tGripper" in note for note in one.translated.notes)
    assert_same(program, one, target, 3)


@pytest.mark.parametrize(
    ("target", "shown"), [("inform", "TL#(7)"), ("krl", "TOOL_DATA[7]"), ("tp", "UTOOL_NUM=7")]
)
def test_a_mapped_tool_of_another_module_has_its_number_and_no_loss(tmp_path, target, shown):
    program = written(tmp_path, part_mod=RAPID).program
    one = made(program, target, tools={"TGRIPPER": "7", "tCut": "2"}, frames={"wTable": "3"})
    assert not [x for x in one.translated.losses if x.part in ("name", "tool", "frame")]
    asked = before_it_runs(written(tmp_path, part_mod=RAPID), one.translated, target, None, True)
    assert "set tools 2, 7 and frame 3 on the controller: the program does not" in asked
    if target == "inform":
        assert {"///TOOL 7", "///USER 3", "///TOOL 2"} <= set(text_of(one).split("\r\n"))
    else:
        assert shown in text_of(one)
    assert_same(program, one, target, 3)


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_a_free_number_is_none_of_a_tool_that_the_program_selects_by_its_number(tmp_path, target):
    rows = ("BAS (#INITMOV,0)", "$TOOL=TOOL_DATA[1]", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}",
            "$TOOL=TGRIP", "PTP {A1 5,A2 -90,A3 90,A4 0,A5 10,A6 0}")  # fmt: skip
    program = written(tmp_path, part_src=krl(*rows)).program
    mapping = made(program, target).translated.mapping
    assert mapping["tool", "TGRIP"] != mapping.get(("tool", "1"), "1")


def test_a_free_number_is_none_that_the_program_or_the_mapping_has(tmp_path):
    program = written(tmp_path, part_mod=RAPID).program
    one = made(program, "tp", tools={"tCut": "1"})
    assert one.translated.mapping[("tool", "tGripper")] == "2"


def test_rapid_has_a_place_for_the_values_of_a_tool_that_nothing_declares(tmp_path):
    program = written(
        tmp_path, part_script=script("set_tcp(grip_tcp)", "movel(p[0.4,0.1,0.3,0,3.1,0.1], v=0.2)")
    ).program
    one = made(program, "rapid")
    assert "PERS tooldata grip_tcp;" in text_of(one)
    assert_same(program, one, "rapid", 1)
    mapped = made(program, "rapid", tools={"grip_tcp": "tGrip"})
    assert "tooldata" not in text_of(mapped)
    assert "tGrip;" in text_of(mapped)
    assert mapped.translated.asks == {"see that the controller has these, with their values": ("tool tGrip",)}


def test_urscript_needs_the_values_and_says_where_they_may_stand(tmp_path):
    program = written(tmp_path, part_mod=RAPID).program
    one = made(program, "urscript")
    helps = [x.help for x in one.translated.losses if "needs the values" in x.says]
    assert len(helps) == 3
    assert all(
        "beside the program" in h and "[names] of olp.toml" in h and "mapping file" in h for h in helps
    )
    mapping = {"tools": {"tGripper": "grip", "tCut": "cut"}, "frames": {"wTable": "table"}}
    text = text_of(made(program, "urscript", **mapping))
    assert "set_tcp(grip)" in text
    assert "pose_trans(table, p1)" in text


@pytest.mark.parametrize("target", [*NUMBERED, "urscript"])
def test_olp_toml_gives_the_values_of_what_no_file_declares(tmp_path, target):
    rows = [
        "[names]",
        *(f"{name} = {{ pose_mm_deg = [11, 4, 120, 0, 25, 0] }}" for name in ("tgripper", "tcut")),
    ]
    rows.append("wtable = { pose_mm_deg = [210, -80, 35, 0, 0, 15] }")
    (tmp_path / "olp.toml").write_text("\n".join(rows))
    program = written(tmp_path, part_mod=RAPID).program
    one = made(program, target)
    assert not [x for x in one.translated.losses if x.part in ("name", "tool", "frame")]
    assert not any("both runs take" in note for note in one.translated.notes)
    plan = program.plan(robot=ROBOT)
    assert plan.positions.position[int(plan.moves.target[0])].tolist() != pytest.approx([0.54, 0.03, 0.41])
    assert_same(program, one, target, 3)


@pytest.mark.parametrize("target", ["inform", "tp", "rapid"])
def test_numbers_of_krl_stay_and_are_told_without_config_dat(tmp_path, target):
    rows = [
        "$TOOL=TOOL_DATA[3]",
        "$BASE=BASE_DATA[2]",
        "$VEL.CP=0.5",
        "LIN {X 600,Y 90,Z 400,A 10,B 20,C 170}",
    ]
    program = written(tmp_path, part_src=krl(*rows)).program
    mapping = {"tools": {"TOOL_DATA[3]": "tool_a" if target == "rapid" else "8"}}
    one = made(program, target, **mapping)
    assert one.translated.mapping[("tool", "3")] == mapping["tools"]["TOOL_DATA[3]"]
    if target == "rapid":
        assert any("frame 2" in x.says and "zeros are written" in x.says for x in one.translated.losses)
    else:
        asked = before_it_runs(written(tmp_path, part_src=krl(*rows)), one.translated, target, None, True)
        assert "set tool 8 and frame 2 on the controller: the program does not" in asked


def test_a_number_that_the_target_does_not_have_is_refused(tmp_path):
    rows = ["$TOOL=TOOL_DATA[13]", "$VEL.CP=0.5", "LIN {X 600,Y 90,Z 400,A 10,B 20,C 170}"]
    program = written(tmp_path, part_src=krl(*rows)).program
    with pytest.raises(OlpError) as told:
        made(program, "tp")
    assert "number 13: there are 10 tools" in told.value.diagnostics[0].message
    assert "UTOOL_NUM=4" in text_of(made(program, "tp", tools={"13": "4"}))


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "rapid"])
def test_both_runs_have_the_values_that_the_controller_is_to_hold(tmp_path, target):
    """With set_values = false the program does not set them: the run of the translation has them all the same."""
    source = krl if target == "rapid" else None
    if source is None:
        text, suffix = "\r\n".join([SYSTEM.replace("SYSMODULE", "NOVIEW"), RAPID]), "part_mod"
        mapping = {"tools": {"tGripper": "5"}}
        program = written(tmp_path, **{suffix: text}).program
    else:
        rows = ["$TOOL=TOOL_DATA[3]", "$VEL.CP=0.5", "LIN {X 600,Y 90,Z 400,A 10,B 20,C 170}"]
        (tmp_path / "olp.toml").write_text("[tools]\n3 = [10, 20, 130, 0, 30, 0]\n")
        program, mapping = written(tmp_path, part_src=krl(*rows)).program, {"tools": {"3": "tMine"}}
    one = made(program, target, set_values=False, **mapping)
    found = difference(program, one, target)
    assert found.steps
    assert found.worst_position < 1e-5


# --- KRL writes its own tools and frames ---

FRAMES = [
    "DEFDAT $CONFIG PUBLIC", "DECL FRAME BASE_DATA[32]", "BASE_DATA[1]={X 5,Y 6,Z 7,A 0,B 0,C 0}",
    "BASE_DATA[2]={X 300,Y -40,Z 15,A 12,B 0,C 0}", "ENDDAT", "",
]  # fmt: skip
WHOLE = krl(
    "BASE_DATA[2]={X 210,Y -35,Z 20,A 15,B 0,C 0}", "TOOL_DATA[1]={X 3,Y 2,Z 140,A 0,B 10,C 0}",
    "$TOOL=TOOL_DATA[1]", "$BASE=BASE_DATA[2]", "$VEL.CP=0.5", "LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}",
    "BASE_DATA[2]={X 230,Y -30,Z 45,A 25,B 0,C 0}", "$BASE=BASE_DATA[2]", "LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}",
    "$BASE=BASE_DATA[1]", "LIN {X 620,Y 60,Z 320,A 10,B 20,C 170}",
)  # fmt: skip


@pytest.mark.parametrize("config", [False, True])
@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_a_frame_that_krl_sets_as_a_whole_is_set_in_the_target(tmp_path, target, config):
    if config:
        (tmp_path / "$config.dat").write_text("\r\n".join(FRAMES))
    program = written(tmp_path, part_src=WHOLE).program
    one = made(program, target)
    plan = program.plan(robot=ROBOT)
    places = [plan.positions.position[int(at)].tolist() for at in plan.moves.target[:2]]
    assert math.dist(*places) > 0.03  # the same numbers in a frame that has moved
    found = difference(program, one, target)
    assert found.steps == 3
    assert found.worst_position < 1e-5
    if target in ("inform", "tp"):
        assert {"inform": "MFRAME UF#(2)", "tp": "UFRAME[2]="}[target] in text_of(one)


@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_a_frame_holds_what_config_dat_says_until_the_program_sets_it(tmp_path, target):
    (tmp_path / "$config.dat").write_text("\r\n".join(FRAMES))
    rows = ("$TOOL=$NULLFRAME", "$BASE=BASE_DATA[2]", "$VEL.CP=0.5", "LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}",
            "BASE_DATA[2]={X 210,Y -35,Z 20,A 15,B 0,C 0}", "$BASE=BASE_DATA[2]",
            "LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}")  # fmt: skip
    program = written(tmp_path, part_src=krl(*rows)).program
    one = made(program, target)
    found = difference(program, one, target)
    assert found.steps == 2
    assert found.worst_position < 1e-5


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_a_component_of_a_frame_that_krl_sets_moves_what_stands_in_it(tmp_path, target):
    (tmp_path / "$config.dat").write_text("\r\n".join(FRAMES))
    rows = ("$TOOL=$NULLFRAME", "BASE_DATA[2].X=BASE_DATA[2].X+40.5", "BASE_DATA[2].Z=7.5", "$BASE=BASE_DATA[2]",
            "$VEL.CP=0.5", "LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}", "BASE_DATA[2].X=BASE_DATA[2].X-25",
            "$BASE=BASE_DATA[2]", "LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}")  # fmt: skip
    program = written(tmp_path, part_src=krl(*rows)).program
    one = made(program, target)
    found = difference(program, one, target)
    assert found.steps == 2
    assert found.worst_position < 1e-5


COMPUTED = (
    *("DECL INT N", "$TOOL=$NULLFRAME", "$VEL.CP=0.5", "$BASE=BASE_DATA[2]"),
    *("LIN {X 400,Y 90,Z 300,A 10,B 20,C 170}", "FOR N=1 TO 2"),
    *("BASE_DATA[N]=BASE_DATA[N]:{X 0,Y 0,Z 30,A 5,B 0,C 0}", "$BASE=BASE_DATA[N]"),
    *("LIN {X 400,Y 80,Z 300,A 10,B 20,C 170}", "ENDFOR", "BASE_DATA[1].X=5", "$BASE=BASE_DATA[1]"),
    "LIN {X 400,Y 80,Z 300,A 10,B 20,C 170}",
)


def test_frames_by_computed_numbers_are_elements_of_an_array_in_rapid(tmp_path):
    (tmp_path / "$config.dat").write_text("\r\n".join(FRAMES))
    program = written(tmp_path, part_src=krl(*COMPUTED)).program
    one = made(program, "rapid")
    found = difference(program, one, "rapid")
    assert found.steps == 4
    assert found.worst_position < 1e-5
    assert "PERS wobjdata numbered_frames{" in text_of(one)


def test_frames_that_nothing_declares_are_to_be_taught(tmp_path):
    program = written(tmp_path, part_src=krl("DECL INT N", "N=2", "BAS(#TOOL,N)", "PTP {A1 5}")).program
    one = made(program, "rapid", on_loss="comment")
    assert "PERS tooldata numbered_tools{16};" in text_of(one)
    told = [(x.line, x.fate) for x in one.translated.losses if "to be taught" in x.says]
    assert told == [(4, Fate.APPROXIMATED)]


@pytest.mark.parametrize("config", [False, True])
@pytest.mark.parametrize("target", ["inform", "tp", "urscript"])
def test_an_element_of_a_frame_is_no_register_that_other_variables_have(tmp_path, target, config):
    if config:
        (tmp_path / "$config.dat").write_text("\r\n".join(FRAMES))
    row, reason = "BASE_DATA[nOwn] = {X 1,Y 2,Z 3,A 0,B 0,C 0}", "computed while the program runs"
    rows = ["DECL INT nOwn", "DECL REAL rKept", "nOwn = 2", row, "rKept = 2.5", "WAIT SEC rKept"]
    program = written(tmp_path, part_src=krl(*rows)).program
    one = made(program, target, on_loss="comment")
    told = [(x.line, x.fate) for x in one.translated.losses if reason in x.says]
    assert told == [(5, Fate.COMMENTED)]
    assert not [x for x in one.translated.losses if x.line == 6]


# --- files beside the program ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", [*NUMBERED, "urscript"])
def test_tools_and_points_are_found_in_the_modules_beside_the_program(tmp_path, target):
    linked = written(tmp_path, part_mod=RAPID, cell_sys=SYSTEM)
    assert [part.path.rpartition("/")[2] for part in linked.parts] == ["part.mod", "cell.sys"]
    one = made(linked.program, target)
    assert not [x for x in one.translated.losses if x.part == "name"]
    assert_same(linked.program, one, target, 3)


def test_the_system_modules_of_a_task_stand_in_the_folder_beside_its_programs(tmp_path):
    for name in ("PROGMOD", "SYSMOD"):
        (tmp_path / name).mkdir()
    (tmp_path / "SYSMOD" / "cell.sys").write_text(SYSTEM)
    linked = written(tmp_path / "PROGMOD", part_mod=RAPID)
    assert {declare.name for declare in linked.program.data} >= {"tGripper", "wTable"}
    plan = olp.read(tmp_path / "PROGMOD" / "part.mod").plan(robot=ROBOT)
    assert not [d.message for d in plan.diagnostics if "nothing at hand" in d.message or d.is_error]


def test_a_name_of_another_file_may_be_spelt_in_other_letters(tmp_path):
    linked = written(tmp_path, part_mod=RAPID.replace("tGripper", "TGRIPPER"), cell_sys=SYSTEM)
    assert not [x for x in made(linked.program, "tp").translated.losses if x.part == "name"]


LISTED = "X 500,Y 10,Z 600,A 10,B 20,C 170"
HOME = krl("$TOOL=TGRIP", "$BASE=$NULLFRAME", "PTP XHOME", "LIN {X 600,Y 90,Z 400,A 10,B 20,C 170}")


def test_a_list_of_krl_without_a_program_gives_its_global_data(tmp_path):
    rows = ["DEFDAT CELL PUBLIC", f"DECL GLOBAL E6POS XHOME={{{LISTED},S 2,T 2}}"]
    rows += ["DECL GLOBAL FRAME TGRIP={X 1,Y 2,Z 150,A 0,B 0,C 0}", "ENDDAT", ""]
    linked = written(tmp_path, part_src=HOME, cell_dat="\r\n".join(rows))
    assert {declare.name for declare in linked.program.data} == {"XHOME", "TGRIP"}
    assert_same(linked.program, made(linked.program, "inform"), "inform", 2)


def test_a_point_of_another_list_that_is_not_global_is_another_point(tmp_path):
    """Every list of a KUKA has an XP1 of its own."""
    other = "\r\n".join(["DEFDAT OTHER", f"DECL E6POS XHOME={{{LISTED}}}", "ENDDAT", ""])
    linked = written(
        tmp_path, part_src=HOME, other_src=krl("PTP XHOME").replace("PART", "OTHER"), other_dat=other
    )
    assert not linked.program.data
    plan = olp.read(tmp_path / "part.src").plan(robot=ROBOT)
    assert "nothing defines XHOME" in " ".join(d.message for d in plan.diagnostics)


# --- without a robot ------------------------------------------------------------------------------------------------

JOINTS = script("movej([0.1,-1.2,1.5,-1.0,-1.5,0.2], v=1.05)", "movel(p[0.4,0.1,0.3,0,3.1,0.1], v=0.25)")


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_what_needs_a_robot_says_which_there_are_or_becomes_a_comment(tmp_path, target):
    program = written(tmp_path, part_script=JOINTS).program
    with pytest.raises(OlpError) as told:
        convert(program, target, Context())
    (found,) = told.value.diagnostics
    assert (found.code, found.line) == ("X012", 2)
    assert all(
        word in found.help for word in ("--robot", "olp robots", "docs/robots.md", "--on-loss comment")
    )
    one = convert(program, target, Context(on_loss="comment"))
    fates = {(x.line, x.fate) for x in one.translated.losses if x.part == "statement"}
    assert fates == {(2, Fate.COMMENTED)}
    # Comments are cut into lines of 32 characters.
    assert "not translated: movej" in re.sub(r"[\r\n]+\W*", " ", text_of(one))


def test_points_in_pulses_without_a_robot_become_comments(tmp_path):
    job = ["/JOB", "//NAME PART", "//POS", "///NPOS 1,0,0,0,0,0", "///TOOL 0", "///POSTYPE PULSE", "///PULSE"]
    job += [
        "C00000=100,200,300,400,500,600",
        "//INST",
        "///DATE 2026/03/02 14:07",
        "///ATTR SC,RW",
        "///GROUP1 RB1",
    ]
    job += ["NOP", "MOVJ C00000 VJ=10.00", "TIMER T=1.00", "END", ""]
    program = written(tmp_path, part_jbi="\r\n".join(job)).program
    with pytest.raises(OlpError) as told:
        convert(program, "tp", Context())
    assert {d.code for d in told.value.diagnostics} == {"X012"}
    one = convert(program, "tp", Context(on_loss="comment"))
    assert [x.fate for x in one.translated.losses if x.statement == "Move joint"] == [Fate.COMMENTED]
    assert "WAIT" in text_of(one)


def test_frames_whose_components_change_keep_their_numbers():
    """FANUC's frames 2 and 3 were KUKA's 3 and 2: the program's own, and not those that the pendant has."""
    rows = ["BASE_DATA[3].Z=BASE_DATA[3].Z-5", "BASE_DATA[2].Z=BASE_DATA[2].Z+155"]
    rows += [
        f"SLIN {{X 900,Y 0,Z 500,A 0,B 90,C 0}} WITH $VEL=SVEL_CP(0.3),$BASE=SBASE({n}),$TOOL=STOOL2(F1)"
        for n in (3, 2)
    ]
    text = translated(krl(*rows), "krl", "tp")
    numbers = re.findall(r"UFRAME(?:_NUM=|\[)(\d)", text)
    assert numbers == ["3", "2"] * 3  # as taught at the start, as the program sets them, and the moves


def test_a_tool_whose_number_the_target_lacks_gets_a_free_one(tmp_path):
    config = ["DECL FRAME TOOL_DATA[16]", "TOOL_DATA[14]={X 10.5,Y 0,Z 120,A 0,B 30,C 0}"]
    (tmp_path / "$config.dat").write_text("\n".join(["DEFDAT $CONFIG", *config, "ENDDAT", ""]))
    rows = ("$TOOL=TOOL_DATA[1]", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}")
    rows += ("$TOOL=TOOL_DATA[14]", "PTP {A1 5,A2 -90,A3 90,A4 0,A5 10,A6 0}")
    program = written(tmp_path, part_src=krl("BAS (#INITMOV,0)", *rows)).program
    one = made(program, "tp")
    assert one.translated.mapping["tool", "TOOL_DATA[14]"] == "2"
    assert_same(program, one, "tp", 2)


def test_tools_beyond_those_of_the_target_are_refused_where_they_are_chosen(tmp_path):
    names = [f"T{n}" for n in range(1, 13)]
    config = [f"DECL FRAME {name}={{X {n},Y 0,Z 120,A 0,B 30,C 0}}" for n, name in enumerate(names, 1)]
    (tmp_path / "$config.dat").write_text("\n".join(["DEFDAT $CONFIG", *config, "ENDDAT", ""]))
    rows = [
        row
        for n, name in enumerate(names)
        for row in (f"$TOOL={name}", f"PTP {{A1 {n},A2 -90,A3 90,A4 0,A5 10,A6 0}}")
    ]
    program = written(tmp_path, part_src=krl("BAS (#INITMOV,0)", *rows)).program
    one = made(program, "tp", on_loss="comment")
    assert [x.says for x in one.translated.losses if x.fate is Fate.COMMENTED] == ["more than 10 tools"] * 2
    assert "UTOOL_NUM=10" in text_of(one)
    assert "UTOOL_NUM=11" not in text_of(one)


def test_a_tool_that_is_chosen_by_a_computed_number_is_told_as_that(tmp_path):
    """It was "TOOL_DATA is declared nowhere", though a list declares it: one of its numbers is none of the target."""
    config = ["DECL FRAME TOOL_DATA[16]"]
    config += [f"TOOL_DATA[{n}]={{X {n}.5,Y 0,Z 120,A 0,B 30,C 0}}" for n in (3, 14)]
    (tmp_path / "$config.dat").write_text("\n".join(["DEFDAT $CONFIG", *config, "ENDDAT", ""]))
    place = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}"
    rows = ("BAS(#INITMOV,0)", "$BASE=$NULLFRAME", "IF $IN[1] THEN", "N=14", "ENDIF")
    rows += ("BAS(#TOOL,N)", place, "$TOOL=TOOL_DATA[14]", place)
    program = written(tmp_path, part_src=krl("DECL INT N", "N=3", *rows)).program
    says = [
        x.says for x in made(program, "tp", on_loss="comment").translated.losses if x.fate is Fate.COMMENTED
    ]
    computed = "TOOL_DATA: which element it takes is computed while the program runs"
    assert says[:-1] == [computed] * 4  # the choice, and IF, ELSE and ENDIF that keep it from an element 0
    assert says[-1].startswith("it needs the tool")  # the move


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_axis_values_are_told_where_no_robot_is_named_for_the_translation(target):
    """They were called exact, and make another pose of another maker's arm."""
    rows = ("MoveAbsJ home,v100,fine,tool0;", "MoveJ p1,v100,fine,tool0;")
    data = (
        "CONST jointtarget home:=[[0,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
        "CONST robtarget p1:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    )
    text = module(*rows, data=data)
    linked, one = link(read(text, "rapid")), converted(text, "rapid", target)
    says = "see that the arm counts its axes as the source's does"
    asked = [
        one for one in before_it_runs(linked, one.translated, target, None, True) if one.startswith(says)
    ]
    assert len(asked) == 1
    assert asked[0].endswith(":5")
    assert not any(
        one.startswith(says)
        for one in before_it_runs(linked, one.translated, target, None, True, arm_named=True)
    )
