"""What each construct means, from the makers' manuals alone: no reader, interpreter or writer of olp is asked.

A program of random constructs is spelt in one language by the table below, `olp convert` makes the other language of
it, and that text is understood by regular expressions of this file. Both have to mean the same. Rotations are scipy's.
"""

from __future__ import annotations

import re
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from translated_texts import converted, inform, krl, module, script, tp

LANGUAGES = ("inform", "krl", "rapid", "tp", "urscript")
Construct = tuple[Any, ...]
# A line: where [mm], Rz Ry Rx about the base's axes [deg], how fast [mm/s], blend [mm], 0: a stop.
_PLACES = st.tuples(st.integers(800, 950), st.integers(-150, 150), st.integers(350, 500))
_TURNS = st.tuples(st.integers(-40, 40), st.integers(-30, 30), st.integers(150, 210))
_LINES = st.tuples(
    st.just("line"), _PLACES, _TURNS, st.sampled_from([50, 100, 200, 300]), st.sampled_from([0, 0, 5, 10])
)
_OUTPUTS = st.tuples(st.just("out"), st.integers(1, 9), st.booleans())
_AWAITS = st.tuples(st.just("await"), st.integers(1, 9), st.booleans())
_DWELLS = st.tuples(st.just("dwell"), st.sampled_from([0.25, 0.5, 1.5]))
PROGRAMS = st.lists(st.one_of(_LINES, _LINES, _OUTPUTS, _AWAITS, _DWELLS), min_size=2, max_size=9)


def meaning(program: list[Construct], stops: bool = False) -> list[Construct]:
    """What happens. A blend before a dwell is a stop; with `stops` (KRL) also before what touches signals.

    "continue" stands for KRL's word, which holds for the next construct.
    """
    found: list[Construct] = []
    goes_on = False
    for one in program:
        if one[0] == "continue":
            goes_on = True
            continue
        if one[0] == "dwell" or (stops and one[0] in ("out", "await") and not goes_on):
            at = next((n for n in range(len(found) - 1, -1, -1) if found[n][0] == "line"), None)
            if at is not None:
                found[at] = (*found[at][:4], 0)
        goes_on = False
        found.append(one)
    return found


def quaternion(turns: tuple[float, ...]) -> list[float]:
    x, y, z, w = Rotation.from_euler("ZYX", turns, degrees=True).as_quat()
    return [w, x, y, z]


# --- spelling -------------------------------------------------------------------------------------------------------


def spelt(program: list[Construct], language: str) -> str:
    return {"inform": as_inform, "krl": as_krl, "rapid": as_rapid, "tp": as_tp, "urscript": as_script}[
        language
    ](program)


def as_krl(program: list[Construct]) -> str:
    rows = ["BAS(#INITMOV,0)", "$TOOL=$NULLFRAME", "$BASE=$NULLFRAME"]
    for one in program:
        match one:
            case "line", (x, y, z), (a, b, c), speed, blend:
                rows += (
                    [f"$VEL.CP={speed / 1000}", f"$APO.CDIS={blend}"]
                    if blend
                    else [f"$VEL.CP={speed / 1000}"]
                )
                rows.append(f"LIN {{X {x},Y {y},Z {z},A {a},B {b},C {c}}}{' C_DIS' if blend else ''}")
            case "out", n, on:
                rows.append(f"$OUT[{n}]={str(on).upper()}")
            case "await", n, on:
                rows.append(f"WAIT FOR $IN[{n}]=={str(on).upper()}")
            case "dwell", seconds:
                rows.append(f"WAIT SEC {seconds}")
            case ("continue",):
                rows.append("CONTINUE")
    return krl(*rows)


def as_rapid(program: list[Construct]) -> str:
    rows, data = [], []
    for one in program:
        match one:
            case "line", (x, y, z), turns, speed, blend:
                q = ",".join(f"{v:.15f}" for v in quaternion(turns))
                name = f"t{len(data)}"
                data.append(
                    f"CONST robtarget {name}:=[[{x},{y},{z}],[{q}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
                )
                rows.append(f"MoveL {name},v{speed},{f'z{blend}' if blend else 'fine'},tool0;")
            case "out", n, on:
                rows.append(f"SetDO do{n},{int(on)};")
            case "await", n, on:
                rows.append(f"WaitDI di{n},{int(on)};")
            case "dwell", seconds:
                rows.append(f"WaitTime {seconds};")
    return module(*rows, data=data)


def as_tp(program: list[Construct]) -> str:
    rows, positions = [], []
    for one in program:
        match one:
            case "line", place, (a, b, c), speed, blend:
                positions.append((len(positions) + 1, 0, 0, *place, c, b, a))
                corner = f"CR{blend}" if blend else "FINE"
                rows.append(f"L P[{len(positions)}] {speed}mm/sec {corner}")
            case "out", n, on:
                rows.append(f"DO[{n}]={'ON' if on else 'OFF'}")
            case "await", n, on:
                rows.append(f"WAIT DI[{n}]={'ON' if on else 'OFF'}")
            case "dwell", seconds:
                rows.append(f"WAIT {seconds:.2f}(sec)")
    return tp(*rows, positions=positions)


def as_inform(program: list[Construct]) -> str:
    rows, points = [], []
    for one in program:
        match one:
            case "line", (x, y, z), (a, b, c), speed, blend:
                points.append(f"C{len(points):05d}={x}.000,{y}.000,{z}.000,{c}.0000,{b}.0000,{a}.0000")
                corner = f"CR={blend}.0" if blend else "PL=0"
                rows.append(f"MOVL C{len(points) - 1:05d} V={speed}.0 {corner}")
            case "out", n, on:
                rows.append(f"DOUT OT#({n}) {'ON' if on else 'OFF'}")
            case "await", n, on:
                rows.append(f"WAIT IN#({n})={'ON' if on else 'OFF'}")
            case "dwell", seconds:
                rows.append(f"TIMER T={seconds:.2f}")
    flags = ",".join("0" * 24)
    head = ["///TOOL 0", "///POSTYPE BASE", "///RECTAN", f"///RCONF {flags}"] if points else []
    return inform(*rows, points=[*head, *points])


def as_script(program: list[Construct]) -> str:
    rows = []
    for one in program:
        match one:
            case "line", place, turns, speed, blend:
                vector = Rotation.from_euler("ZYX", turns, degrees=True).as_rotvec()
                values = ", ".join(f"{v:.12f}" for v in (*(v / 1000 for v in place), *vector))
                rows.append(
                    f"movel(p[{values}], a=1.2, v={speed / 1000}{f', r={blend / 1000}' if blend else ''})"
                )
            case "out", n, on:
                rows.append(f"set_standard_digital_out({n}, {on})")
            case "await", n, on:
                rows += [f"while (get_standard_digital_in({n}) == {not on}):", "  sync()", "end"]
            case "dwell", seconds:
                rows.append(f"sleep({seconds})")
    return script(*rows)


# --- understanding --------------------------------------------------------------------------------------------------

_NUMBER = r"(-?\d*\.?\d+(?:[eE][-+]?\d+)?)"


def numbers(text: str) -> list[float]:
    return [float(v) for v in re.findall(_NUMBER, text)]


def understood(text: str, language: str) -> list[Construct]:
    return {
        "inform": of_inform,
        "krl": of_krl,
        "rapid": of_rapid,
        "tp": of_tp,
        "urscript": of_script,
    }[language](text)


def turned(order: str, angles: list[float]) -> Rotation:
    return Rotation.from_euler(order, angles, degrees=True)


def of_krl(text: str) -> list[Construct]:
    poses = {
        name: numbers(re.sub(r"[A-Z]\d?(?= )", "", body))
        for name, body in re.findall(r"DECL (?:GLOBAL )?E6POS (\w+)=\{([^}]*)\}", text)
    }
    found: list[Construct] = []
    speed = size = 0.0
    for line in (row.partition(";")[0].strip() for row in text.splitlines()):
        if m := re.fullmatch(rf"\$VEL\.CP={_NUMBER}", line):
            speed = float(m[1]) * 1000
        elif m := re.fullmatch(rf"\$APO\.CDIS={_NUMBER}", line):
            size = float(m[1])
        elif m := re.fullmatch(r"LIN (?:(\w+)|\{(.*)\})( C_DIS)?", line):
            x, y, z, *abc = (poses[m[1]] if m[1] else numbers(re.sub(r"[A-Z]\d?(?= )", "", m[2])))[:6]
            found.append(("line", (x, y, z), turned("ZYX", abc), speed, size if m[3] else 0.0))
        elif m := re.fullmatch(r"\$OUT\[(\d+)\]=(TRUE|FALSE)", line):
            found.append(("out", int(m[1]), m[2] == "TRUE"))
        elif m := re.fullmatch(r"WAIT FOR \$IN\[(\d+)\]==(TRUE|FALSE)", line):
            found.append(("await", int(m[1]), m[2] == "TRUE"))
        elif m := re.fullmatch(rf"WAIT SEC {_NUMBER}", line):
            found.append(("dwell", float(m[1])))
        elif line == "CONTINUE":
            found.append(("continue",))
    return found


_RAPID_LINE = r"MoveL(?:DO)? (\w+|\[.*\]),(\w+),(\w+),tool0(?:\\WObj:=wobj0)?(?:,do(\d+),([01]))?;"


def of_rapid(text: str) -> list[Construct]:
    values = {name: numbers(body) for name, body in re.findall(r"(\w+):=\[(.*)\];", text)}
    found: list[Construct] = []
    for line in map(str.strip, text.splitlines()):
        if m := re.fullmatch(_RAPID_LINE, line):
            x, y, z, w, i, j, k = (values[m[1]] if m[1] in values else numbers(m[1]))[:7]
            speed = values[m[2]][0] if m[2] in values else float(m[2][1:])
            zone = 0.0 if m[3] == "fine" else values[m[3]][0] if m[3] in values else float(m[3][1:])
            found.append(("line", (x, y, z), Rotation.from_quat([i, j, k, w]), speed, zone))
            if m[4]:  # MoveLDO
                found.append(("out", int(m[4]), m[5] == "1"))
        elif m := re.fullmatch(r"SetDO do(\d+),([01]);", line):
            found.append(("out", int(m[1]), m[2] == "1"))
        elif m := re.fullmatch(r"WaitDI di(\d+),([01]);|WaitUntil di(\d+)=([01]);", line):
            found.append(("await", int(m[1] or m[3]), (m[2] or m[4]) == "1"))
        elif m := re.fullmatch(rf"WaitTime {_NUMBER};", line):
            found.append(("dwell", float(m[1])))
    return found


def of_tp(text: str) -> list[Construct]:
    poses = {
        int(n): [float(v) for v in re.findall(rf"[XYZWPR]\s*=\s*{_NUMBER}", body)]
        for n, body in re.findall(r"P\[(\d+)[^\]]*\]\{(.*?)\};", text, re.DOTALL)
    }
    found: list[Construct] = []
    for line in (re.sub(r"^\s*\d*:\s*", "", row).strip(" ;") for row in text.splitlines()):
        if m := re.fullmatch(rf"L P\[(\d+)(?::\w+)?\] {_NUMBER}mm/sec (FINE|CR{_NUMBER})(?: ACC\d+)?", line):
            x, y, z, w, p, r = poses[int(m[1])]
            found.append(("line", (x, y, z), turned("ZYX", [r, p, w]), float(m[2]), float(m[4] or 0)))
        elif m := re.fullmatch(r"DO\[(\d+)\]=(ON|OFF)", line):
            found.append(("out", int(m[1]), m[2] == "ON"))
        elif m := re.fullmatch(r"WAIT DI\[(\d+)\]=(ON|OFF)", line):
            found.append(("await", int(m[1]), m[2] == "ON"))
        elif m := re.fullmatch(rf"WAIT\s+{_NUMBER}\(sec\)", line):
            found.append(("dwell", float(m[1])))
    return found


def of_inform(text: str) -> list[Construct]:
    poses = {name: numbers(body) for name, body in re.findall(r"^(C\d+)=(.*)$", text, re.MULTILINE)}
    found: list[Construct] = []
    for line in map(str.strip, text.splitlines()):
        if m := re.fullmatch(
            rf"MOVL (C\d+) V={_NUMBER} (?:PL=0|CR={_NUMBER})(?: ACC=\d+)?(?: DEC=\d+)?(?:  //\w+)?", line
        ):
            x, y, z, rx, ry, rz = poses[m[1]]
            found.append(("line", (x, y, z), turned("ZYX", [rz, ry, rx]), float(m[2]), float(m[3] or 0)))
        elif m := re.fullmatch(r"DOUT OT#\((\d+)\) (ON|OFF)", line):
            found.append(("out", int(m[1]), m[2] == "ON"))
        elif m := re.fullmatch(r"WAIT IN#\((\d+)\)=(ON|OFF)", line):
            found.append(("await", int(m[1]), m[2] == "ON"))
        elif m := re.fullmatch(rf"TIMER T={_NUMBER}", line):
            found.append(("dwell", float(m[1])))
    return found


def of_script(text: str) -> list[Construct]:
    poses = {name: numbers(body) for name, body in re.findall(r"(\w+) = p\[(.*)\]", text)}
    found: list[Construct] = []
    for line in map(str.strip, text.splitlines()):
        if m := re.fullmatch(
            rf"movel\((?:(\w+)|p\[(.*?)\])(?:, a={_NUMBER})?, v={_NUMBER}(?:, r={_NUMBER})?\)", line
        ):
            x, y, z, *vector = poses[m[1]] if m[1] else numbers(m[2])
            place = (1000 * x, 1000 * y, 1000 * z)
            found.append(
                ("line", place, Rotation.from_rotvec(vector), 1000 * float(m[4]), 1000 * float(m[5] or 0))
            )
        elif m := re.fullmatch(r"set_standard_digital_out\((\d+), (True|False)\)", line):
            found.append(("out", int(m[1]), m[2] == "True"))
        elif m := re.fullmatch(r"while \(get_standard_digital_in\((\d+)\) == (True|False)\):", line):
            found.append(("await", int(m[1]), m[2] == "False"))
        elif m := re.fullmatch(rf"sleep\({_NUMBER}\)", line):
            found.append(("dwell", float(m[1])))
    return found


# --- the property ---------------------------------------------------------------------------------------------------


def differences(wanted: list[Construct], got: list[Construct], blends: bool) -> list[str]:
    told = [] if len(wanted) == len(got) else [f"{len(wanted)} and {len(got)} steps"]
    for n, (a, b) in enumerate(zip(wanted, got, strict=False)):
        if a[0] != b[0] or (a[0] != "line" and a[1:] != pytest.approx(b[1:])):
            told.append(f"{n}: {a} and {b}")
        elif a[0] == "line":
            turn = (turned("ZYX", list(a[2])).inv() * b[2]).magnitude()
            same = a[1] == pytest.approx(b[1], abs=2e-3) and turn < 2e-4 and a[3] == pytest.approx(b[3])
            if not same or (blends and a[4] != pytest.approx(b[4], abs=1e-3)):
                told.append(f"{n}: {a} and {b[:2]}, turned by {turn}, {b[3:]}")
    return told


@pytest.mark.parametrize("source", LANGUAGES)
@pytest.mark.parametrize("target", LANGUAGES)
def test_a_program_of_any_constructs_means_the_same_in_the_other_text(source, target):
    if source == target:
        return

    @settings(max_examples=2, deadline=None, derandomize=True)
    @given(PROGRAMS, st.lists(st.booleans(), min_size=9, max_size=9))
    def holds(program, continues):
        if source == "krl":
            words = [("continue",)]
            program = [
                row for one, on in zip(program, continues, strict=False) for row in [*words[: int(on)], one]
            ]
        made = converted(spelt(program, source), source, target)
        text = "\n".join(data.decode("cp1252") for data in made.files.values())
        # A receipt that names a blend of another size has said so.
        blends = not any(loss.part == "blend" for loss in made.translated.losses)
        wanted = meaning(program, stops=source == "krl")
        got = meaning(understood(text, target), stops=target == "krl")
        assert differences(wanted, got, blends) == [], f"{spelt(program, source)}\n{text}"

    holds()


def test_the_oracle_sees_a_fault():
    program = [("line", (900, 0, 400), (10, 0, 180), 100, 5), ("out", 3, True), ("dwell", 0.5)]
    assert differences(meaning(program), meaning(understood(spelt(program, "krl"), "krl")), True) == []
    text = spelt(program, "krl").replace("A 10", "A 11")
    assert differences(meaning(program), meaning(understood(text, "krl")), True)
