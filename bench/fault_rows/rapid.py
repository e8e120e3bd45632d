"""Faults in the reader and the writer of ABB RAPID."""

from typing import Final

from fault_rows import Fault

FAULTS: Final = (
    Fault(
        "literals.py",
        "def quaternion_angles(w: float, x: float, y: float, z: float)",
        "def quaternion_angles(x: float, y: float, z: float, w: float)",
        "quaternion read with the scalar last",
    ),
    Fault(
        "literals.py", "sine = s * (w * y - x * z)", "sine = s * (x * z - w * y)", "sign of the turn about Y"
    ),
    Fault("literals.py", "s * (x * y + w * z)", "s * (x * y - w * z)", "sign of the turn about Z"),
    Fault(
        "literals.py",
        'PositionLiteral("joint", tuple(v * deg for v in axes)',
        'PositionLiteral("joint", tuple(axes)',
        "jointtarget in radians",
    ),
    Fault(
        "literals.py",
        "pose.values, connected(external), flags",
        "pose.values, (), flags",
        "external axes of a robtarget lost",
    ),
    Fault(
        "literals.py",
        "return tuple(ex.Number(v / deg) for v in value.values[3:6])",
        "return tuple(ex.Number(v) for v in value.values[3:6])",
        "angles of an orient in radians",
    ),
    Fault(
        "moves.py",
        "as_number(values[0]), mm)",
        "as_number(values[0]), 1.0)",
        "v_tcp in m/s",
    ),
    Fault("moves.py", "as_number(values[1]), deg)", "as_number(values[1]), 1.0)", "v_ori in rad/s"),
    Fault(
        "moves.py",
        "_blend(0.0 if flag[0].on else rest[0], native)",
        "_blend(rest[0], native)",
        "finep of a zonedata ignored",
    ),
    Fault(
        "moves.py",
        'return _blend(0.0 if texts[0].upper() == "TRUE" else values[0], ',
        'return _blend(0.0 if texts[0].upper() == "TRUE" else values[1], ',
        "pzone_ori as the zone's radius",
    ),
    Fault(
        "moves.py",
        'Quantity(self.rules.coerce(time, ""), 1.0)',
        'Quantity(self.rules.coerce(time, ""), 0.001)',
        "\\T in ms",
    ),
    Fault(
        "moves.py",
        '"movec": ArgumentLayout(_C, "vtszo")',
        '"movec": ArgumentLayout(_C, "tvszo")',
        "MoveC: via point and target swapped",
    ),
    Fault(
        "moves.py",
        "return Blend(BlendKind.RADIUS, ex.Quantity(radius, mm), native)",
        "return Blend(BlendKind.RADIUS, ex.Quantity(radius, 1.0), native)",
        "zones in metres",
    ),
    Fault(
        "expressions.py",
        'Number(0)) for name in ("rx", "ry", "rz"))',
        'Number(0)) for name in ("rz", "ry", "rx"))',
        "RelTool: \\Rx and \\Rz swapped",
    ),
    Fault("expressions.py", "z, y, x = (_value", "x, y, z = (_value", "OrientZYX read as XYZ"),
    Fault(
        "predefined_data.py",
        '"offs": "pose-offset"',
        '"offs": "pose-relative-tool"',
        "Offs goes along the tool",
    ),
    Fault(
        "instructions.py",
        'SignalState(name.lower() == "set")',
        'SignalState(name.lower() == "reset")',
        "Set and Reset inverted",
    ),
    Fault(
        "instructions.py",
        "st.Dwell(0, ex.Quantity(values_of(rules, name, given, 1)[0], 1.0))",
        "st.Dwell(0, ex.Quantity(values_of(rules, name, given, 1)[0], 0.001))",
        "WaitTime in ms",
    ),
    Fault(
        "instructions.py",
        "None if limit is None else ex.Quantity(limit, 1.0)",
        "None",
        "\\MaxTime of a wait lost",
    ),
    Fault("instructions.py", '{"lt": "<", "gt": ">"', '{"lt": ">", "gt": "<"', "\\LT and \\GT swapped"),
    Fault(
        "instructions.py",
        '("pose-product", (there, ex.Function("pose-inverse", (point,))))',
        '("pose-product", (point, ex.Function("pose-inverse", (there,))))',
        "PDispOn \\Rot the other way round",
    ),
    Fault(
        "statements.py",
        "replace(inner[0], condition=condition)",
        "replace(inner[0], condition=None)",
        "IF c GOTO always jumps",
    ),
    Fault("fast.py", "target, via = via, target", "pass", "MoveC read quickly: points swapped"),
    Fault(
        "write_values.py",
        "cz * cy * sx - sz * sy * cx",
        "cz * cy * sx + sz * sy * cx",
        "quaternion: sign of q2",
    ),
    Fault("write_values.py", "x, y, z = values[:3]", "y, x, z = values[:3]", "x and y swapped"),
    Fault(
        "write_values.py",
        "decimal(value, deg, own) for value in values",
        "decimal(value, 1.0, own) for value in values",
        "jointtarget written in radians",
    ),
    Fault(
        "write_values.py",
        'return f"[TRUE,[{pose}],[1',
        'return f"[FALSE,[{pose}],[1',
        "every tool stands in the room",
    ),
    Fault(
        "write_moves.py",
        "(value.literal / mm, None if turn",
        "(value.literal, None if turn",
        "speeds written in m/s",
    ),
    Fault("write_moves.py", "round(turn / deg, 6)", "round(turn, 6)", "v_ori written in rad/s"),
    Fault("write_moves.py", 'return "fine"', 'return "z0"', "exact stops passed flying"),
    Fault(
        "write_moves.py",
        "radius = round(value.literal / mm, 4)",
        "radius = round(value.literal / mm * 0.1, 4)",
        "zones in cm",
    ),
    Fault(
        "write_moves.py",
        "{conc}{via}{self._position(target)},{how}",
        "{conc}{self._position(target)},{via}{how}",
        "MoveC written with its points swapped",
    ),
    Fault(
        "write_moves.py",
        '{self._tool(s)}{self._work_object(s)}"',
        '{self._tool(s)}"',
        "work object dropped",
    ),
    Fault(
        "write_values.py",
        "for value in reversed(values))})",
        "for value in values)})",
        "OrientZYX(x,y,z) written",
    ),
    Fault(
        "write_values.py",
        'zip(("Rx", "Ry", "Rz"), given[4:7]',
        'zip(("Rz", "Ry", "Rx"), given[4:7]',
        "RelTool written with \\Rx and \\Rz swapped",
    ),
    Fault("write_values.py", 'return f"Offs({base', 'return f"RelTool({base', "Offs written as RelTool"),
    Fault(
        "write_values.py",
        "','.join(map(self.as_pose, given))",
        "','.join(map(self.as_pose, reversed(given)))",
        "PoseMult(b,a)",
    ),
    Fault(
        "write_statements.py",
        'return f"SetDO {signal},{int(on)};"',
        'return f"SetDO {signal},{int(not on)};"',
        "outputs inverted",
    ),
    Fault(
        "write_statements.py",
        '"WaitTime {duration};"',
        '"WaitTime {duration}000;"',
        "WaitTime written in ms",
    ),
    Fault(
        "write_statements.py",
        'st.Case: "CASE {values}:"',
        'st.Case: "CASE 1:"',
        "CASE of one value only",
    ),
    Fault(
        "write_statements.py",
        'comment_form = " !{}"',
        'comment_form = ""',
        "comments dropped",
    ),
    Fault(
        "write_statements.py",
        "def forget(self) -> None:\n        self._rate = None",
        "def forget(self) -> None:\n        pass",
        "AccSet believed behind a branch",
    ),
    Fault("__init__.py", 'name = "rapid"', 'name = "rapid"\n    newline = "\\n"', "line ends LF"),
)
