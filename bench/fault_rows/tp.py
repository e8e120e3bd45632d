"""Faults in the reader and the writer of FANUC TP."""

from typing import Final

from fault_rows import Fault

FAULTS: Final = (
    Fault(
        "values.py",
        '"cm/min": (SpeedUnit.TRAVEL, 10.0 * mm / 60.0)',
        '"cm/min": (SpeedUnit.TRAVEL, mm)',
        "cm/min read as mm/s",
    ),
    Fault(
        "values.py",
        '"deg/sec": (SpeedUnit.TURN, deg)',
        '"deg/sec": (SpeedUnit.TURN, 1.0)',
        "deg/sec read as rad/s",
    ),
    Fault(
        "values.py",
        '"%": (SpeedUnit.FRACTION, 0.01)',
        '"%": (SpeedUnit.FRACTION, 1.0)',
        "percent as a fraction",
    ),
    Fault("values.py", '"msec": (SpeedUnit.TIME, 1e-3)', '"msec": (SpeedUnit.TIME, 1.0)', "msec read as sec"),
    Fault(
        "values.py", '"CNT": (BlendKind.SPEED, PERCENT)', '"CNT": (BlendKind.RADIUS, mm)', "CNT read as mm"
    ),
    Fault("values.py", '"CR": (BlendKind.RADIUS, mm)', '"CR": (BlendKind.RADIUS, 1.0)', "CR in metres"),
    Fault("values.py", "TICK: Final = 0.01", "TICK: Final = 0.001", "$WAITTMOUT in ms"),
    Fault(
        "values.py",
        '"x", "y", "z", "rx", "ry", "rz", "e1"',
        '"x", "y", "z", "rz", "ry", "rx", "e1"',
        "PR[1,4] is R instead of W",
    ),
    Fault(
        "values.py",
        "2: Store.STATION, 3: Store.BASE",
        "2: Store.BASE, 3: Store.STATION",
        "motion groups swapped",
    ),
    Fault(
        "positions.py",
        "values.append([*map(float, row)])",
        "values.append([*map(float, row[:3]), *map(float, row[:2:-1])])",
        "W and R swapped",
    ),
    Fault("positions.py", "pose[:3] = mm", "pose[:2] = mm", "Z in degrees"),
    Fault(
        "positions.py",
        "fourth, fifth, sixth = counts",
        "sixth, fifth, fourth = counts",
        "turns of J4 and J6 swapped",
    ),
    Fault("positions.py", '{"F": 0, "N": 1}', '{"F": 1, "N": 0}', "wrist flip inverted"),
    Fault(
        "positions.py",
        'None if user in ("0", "F") else int(user)',
        'None if user in ("0", "F") else int(tool)',
        "UF of a position is its UT",
    ),
    Fault(
        "positions.py",
        "pose[6 + place] = axes[6 + place] = scale",
        "pass",
        "external axes in mm read as degrees",
    ),
    Fault("moves.py", 'return TpMoveOption("relative", OWN)', 'return kept("INC")', "INC read as absolute"),
    Fault(
        "moves.py",
        'return TpMoveOption("offset", children[1])',
        'return TpMoveOption("tool_offset", children[1])',
        "Offset read as Tool_Offset",
    ),
    Fault(
        "moves.py",
        'via=positions[0] if letter == "C" else None',
        'via=positions[-1] if letter == "C" else None',
        "C: via point lost",
    ),
    Fault(
        "grammar.py",
        'if word.startswith("UTOOL_NUM"):',
        'if word.startswith("UFRAME_NUM"):',
        "UTOOL_NUM and UFRAME_NUM swapped",
    ),
    Fault(
        "grammar.py",
        "return st.Dwell(0, ex.Quantity(children[0], 1.0))",
        "return st.Dwell(0, ex.Quantity(children[0], 0.001))",
        "WAIT in ms",
    ),
    Fault("grammar.py", 'ex.Number(-1) if word == "DOWNTO" else None', "None", "DOWNTO counts upwards"),
    Fault(
        "grammar.py",
        "Statements((st.Default(0), *_all(children[0])))",
        "Statements((*_all(children[0]),))",
        "SELECT without ELSE",
    ),
    Fault(
        "grammar.py",
        "replace(action, condition=condition)",
        "replace(action, condition=None)",
        "IF …,JMP always jumps",
    ),
    Fault(
        "moves.py",
        "values.ELEMENTS[int(place.value) - 1]",
        "values.ELEMENTS[int(place.value) % 9]",
        "PR index shifted by one",
    ),
    Fault(
        "write_positions.py",
        "x, y, z, w, p, r, *more = row",
        "x, y, z, r, p, w, *more = row",
        "W and R swapped",
    ),
    Fault(
        "write_positions.py",
        "scale = [mm] * 3 + [deg] * 3 if pose",
        "scale = [mm] * 3 + [1.0] * 3 if pose",
        "angles of added positions in rad",
    ),
    Fault(
        "write_positions.py",
        "{'FN'[min(abs(wrist), 1)]}",
        "{'NF'[min(abs(wrist), 1)]}",
        "wrist flip inverted",
    ),
    Fault(
        "write_positions.py",
        "{fourth}, {rest[0] if len(rest) == 1 else 0}, {sixth}",
        "{sixth}, {rest[0] if len(rest) == 1 else 0}, {fourth}",
        "turns of J4 and J6 swapped",
    ),
    Fault(
        "write_positions.py",
        'user = "F" if frames[0] is None else str(frames[0])',
        'user = "F" if frames[0] is None else str(frames[1])',
        "UF written as UT",
    ),
    Fault(
        "write_moves.py",
        'return f"CNT{round(value.literal / values.PERCENT)}"',
        'return f"CNT{round(value.literal)}"',
        "CNT written as a fraction",
    ),
    Fault(
        "write_moves.py",
        "{word}{self._argument(value, mm)}",
        "{word}{self._argument(value, 1.0)}",
        "CR written in metres",
    ),
    Fault("write_moves.py", 'return "FINE"', 'return "CNT0"', "FINE written as CNT0"),
    Fault(
        "write_moves.py",
        '(("Offset", s.offset), ("Tool_Offset", s.tool_offset))',
        '(("Tool_Offset", s.offset), ("Offset", s.tool_offset))',
        "Offset and Tool_Offset swapped",
    ),
    Fault("write_moves.py", "lines.append(self.select_frame(s.frame))", "pass", "UFRAME_NUM dropped"),
    Fault(
        "writer.py",
        "frozenset({st.Label, st.Call,",
        "frozenset({st.Call,",
        "frames believed behind a label",
    ),
    Fault(
        "write_moves.py",
        "for place, part in enumerate(parts, 1)]",
        "for place, part in enumerate(parts, 2)]",
        "PR index shifted by one",
    ),
    Fault(
        "write_moves.py",
        'return "Tool_Offset", first, second',
        'return "Offset", first, second',
        "an offset along the tool goes along the frame",
    ),
    Fault(
        "write_moves.py",
        "[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]",
        "[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]",
        "rotation vector with the wrong sign",
    ),
    Fault(
        "write_moves.py", "scaled(one, 1000) for one", "scaled(one, 1) for one", "computed poses in metres"
    ),
    Fault(
        "writer.py",
        "wait.timeout is not None\n        lines = self._timeout(wait.timeout)",
        "wait.timeout is not None\n        lines: list[str] = []",
        "the limit of a wait never set",
    ),
    Fault(
        "writer.py",
        'yield f"       ELSE,{action}"',
        'yield "       ! ELSE"',
        "SELECT without its default",
    ),
    Fault("writer.py", "self.rows += _comment_lines(comment)", "pass", "comments dropped"),
    Fault(
        "writer.py",
        'word = "DOWNTO" if step == -1 else "TO"',
        'word = "TO"',
        "DOWNTO written as TO",
    ),
    Fault(
        "writer.py",
        "map(self._call_argument, given)",
        "map(self._call_argument, reversed(given))",
        "arguments of CALL swapped",
    ),
    Fault("__init__.py", 'name = "tp"', 'name = "tp"\n    newline = "\\n"', "line ends LF"),
    Fault(
        "positions.py",
        "((3, fourth), (4, fifth), (5, sixth))",
        "((3, fourth), (4, sixth), (5, fifth))",
        "turns of J5 and J6 exchanged",
    ),
    Fault(
        "positions.py",
        'own = max(_SIX, sum(name[0] == "J" for name in values)) if extra else 0',
        "own = 0",
        "external axes taken for the arm's",
    ),
    Fault(
        "positions.py",
        "pose[6 + place] = axes[6 + place] = scale",
        "axes[6 + place] = scale",
        "tracks of poses in mm taken for degrees",
    ),
)
