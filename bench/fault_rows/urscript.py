"""Faults in the reader and the writer of URScript."""

from typing import Final

from fault_rows import Fault

FAULTS: Final = (
    Fault(
        "rotations.py",
        "half * x * y + one * z, half * x * z - one * y, half * y * z + one * x",
        "half * x * y - one * z, half * x * z + one * y, half * y * z - one * x",
        "rotation vectors turn the other way",
    ),
    Fault(
        "rotations.py",
        "one = sin(angle) / angle\n        sine = sin(0.5 * angle) / angle",
        "one = sin(2.0 * angle) / angle\n        sine = sin(angle) / angle",
        "rotation vector scaled by two",
    ),
    Fault(
        "rotations.py",
        "factor = 2.0 * atan2(sine, w) / sine if sine > 1e-12 else 2.0",
        "factor = atan2(sine, w) / sine if sine > 1e-12 else 1.0",
        "rotation vector written half as long",
    ),
    Fault("rotations.py", "w, x, y, z = -w, -x, -y, -z", "w = -w", "long turns written the other way"),
    Fault(
        "builtins.py",
        "JOINT_DEFAULTS: Final = (1.4, 1.05)",
        "JOINT_DEFAULTS: Final = (1.05, 1.4)",
        "defaults of a and v swapped",
    ),
    Fault(
        "builtins.py",
        '"movej": ("q", "a", "v", "t", "r")',
        '"movej": ("q", "v", "a", "t", "r")',
        "movej: a and v swapped",
    ),
    Fault(
        "builtins.py",
        '"movel": ("pose", "a", "v", "t", "r")',
        '"movel": ("pose", "a", "v", "r", "t")',
        "movel: t and r swapped",
    ),
    Fault("builtins.py", '"get_digital_out": "out"', '"get_digital_out": "in"', "outputs read as inputs"),
    Fault("builtins.py", '"pose_trans": "pose-product"', '"pose_trans": "pose-add"', "pose_trans adds"),
    Fault(
        "moves.py",
        "return _STOP if radius.literal == 0.0 else Blend(BlendKind.RADIUS, radius)",
        "return Blend(BlendKind.RADIUS, Quantity(radius.written, 0.001))",
        "r in mm",
    ),
    Fault("moves.py", 'if "r" not in arguments:', 'if "t" not in arguments:', "blend dropped"),
    Fault(
        "moves.py",
        "word, arguments, SpeedUnit.AXIS if joint else SpeedUnit.TRAVEL, defaults[1]",
        "word, arguments, SpeedUnit.FRACTION if joint else SpeedUnit.TRAVEL, defaults[1]",
        "rad/s of movej as a fraction",
    ),
    Fault(
        "moves.py", "            (found[-1],),\n", "            (found[0],),\n", "movec ends in its via point"
    ),
    Fault(
        "moves.py",
        "(_, frame), (_, place) = target.arguments",
        "(_, place), (_, frame) = target.arguments",
        "pose_trans: frame and target swapped",
    ),
    Fault("expressions.py", "return Number(value + 1)", "return Number(value)", "indices from 0"),
    Fault(
        "expressions.py",
        "return member if place > 2 else scaled(member, mm)",
        "return member",
        "components of a pose in mm",
    ),
    Fault(
        "expressions.py",
        'return scaled(item, deg) if kind == "joints" else item',
        "return item",
        "components of joints in degrees",
    ),
    Fault("expressions.py", '"d2r": _times(deg)', '"d2r": _times(1.0 / deg)', "d2r is r2d"),
    Fault("waits.py", '"<": ">="', '"<": ">"', "wait for < ends too late"),
    Fault(
        "waits.py",
        "return Compare(condition.operator, condition.left, State(not condition.right.on))",
        "return condition",
        "waits for the wrong state",
    ),
    Fault(
        "calls.py",
        "Dwell(line, Quantity(fold(self._expressions.lower(value)), 1.0), comment)",
        "Dwell(line, Quantity(fold(self._expressions.lower(value)), 0.001), comment)",
        "sleep in ms",
    ),
    Fault(
        "calls.py",
        "number, value = (self._expressions.lower(one.value) for one in given)",
        "value, number = (self._expressions.lower(one.value) for one in given)",
        "set_digital_out: number and value swapped",
    ),
    Fault(
        "bodies.py",
        "found.append(ElseIf(number, condition, comment))",
        "found.append(Else(number, comment))",
        "elif read as else",
    ),
    Fault(
        "write_moves.py",
        "*self._speed(s, other), *self._blend(s.blend)]",
        "*self._speed(s, other)]",
        "blend dropped",
    ),
    Fault(
        "write_moves.py",
        'return [f"a={self._words.quantity(s.rate.value)}"]',
        'return [f"v={self._words.quantity(s.rate.value)}"]',
        "acceleration written as v",
    ),
    Fault(
        "write_moves.py",
        'return f"pose_trans({self._words.value(frame)}, {self._words.value(e)})"',
        'return f"pose_trans({self._words.value(e)}, {self._words.value(frame)})"',
        "frame and target swapped",
    ),
    Fault(
        "write_moves.py",
        'target = f"{self.place(s.via, s.frame)}, {target}"',
        'target = f"{target}, {self.place(s.via, s.frame)}"',
        "movec written with its points swapped",
    ),
    Fault(
        "write_moves.py",
        "numbers = (speed.value.literal, blend.value.literal, ",
        "numbers = (speed.value.literal, 0.0, ",
        "moves of one speed share a blend",
    ),
    Fault(
        "write_values.py",
        "map(self.decimal, e.values[:3])",
        "map(self.decimal, [1e3 * v for v in e.values[:3]])",
        "poses written in mm",
    ),
    Fault(
        "write_values.py",
        "return self.value(q.written if q.scale == 1.0 else scaled(q.written, q.scale))",
        "return self.value(q.written)",
        "units of numbers dropped",
    ),
    Fault(
        "write_functions.py",
        'return f"pose_add({words.value(base)}',
        'return f"pose_trans({words.value(base)}',
        "an offset goes along the tool",
    ),
    Fault(
        "write_functions.py",
        "for axis, angle in enumerate(numbers[3:6]):",
        "for axis, angle in reversed(list(enumerate(numbers[3:6]))):",
        "RelTool: order of the turns",
    ),
    Fault(
        "write_functions.py",
        "words.value(scaled(one, deg)) if type(one) is Number else words.radians(one)",
        "words.value(one) if type(one) is Number else words.radians(one)",
        "joints written in degrees",
    ),
    Fault(
        "write_functions.py",
        "factors = (mm, mm, mm, deg, deg, deg)",
        "factors = (mm, mm, mm, 1.0, 1.0, 1.0)",
        "angles of poses in degrees",
    ),
    Fault(
        "write_statements.py",
        "condition = words.at_least(inverted(s.condition), 4)",
        "condition = words.at_least(s.condition, 4)",
        "waits as long as it holds",
    ),
    Fault(
        "write_statements.py",
        "value = State(value == Number(1))",
        "value = State(value == Number(0))",
        "outputs inverted",
    ),
    Fault(
        "write_statements.py",
        'return [f"sleep({words.quantity(s.duration)})"]',
        'return [f"sleep(0.001 * {words.quantity(s.duration)})"]',
        "sleep written in ms",
    ),
    Fault(
        "write_statements.py",
        "written = words.value(scaled(value, mm) if place < 3 else value)",
        "written = words.value(value)",
        "a component stored in mm",
    ),
    Fault(
        "write_statements.py",
        'return [f"# {text.strip()}".rstrip()]',
        "return []",
        "comments of other languages dropped",
    ),
)
