"""Faults in the reader and the writer of KUKA KRL."""

from typing import Final

from fault_rows import Fault

FAULTS: Final = (
    Fault(
        "values.py",
        '("X", "Y", "Z", "C", "B", "A")',
        '("X", "Y", "Z", "A", "B", "C")',
        "A and C swapped in the reader",
    ),
    Fault(
        "values.py", "(mm, mm, mm, deg, deg, deg)", "(mm, mm, mm, 1.0, 1.0, 1.0)", "angles of a pose in rad"
    ),
    Fault("values.py", "(mm, mm, mm, deg, deg, deg)", "(mm, mm, 1.0, deg, deg, deg)", "Z in metres"),
    Fault("values.py", "ACC_PTP: Final = 0.005", "ACC_PTP: Final = 0.01", "ACC 100 is all of the rated one"),
    Fault("values.py", "ACC_CP: Final = 0.023", "ACC_CP: Final = 2.3", "ACC_CP in m/s² instead of percent"),
    Fault("values.py", "int(not status & 4)", "int(bool(status & 4))", "sign of A5 in the status S"),
    Fault(
        "values.py",
        "    return tuple(numbers.get(key, NOTHING) for key in EXTERNALS[:last])",
        "    return ()",
        "external axes lost",
    ),
    Fault("moves.py", '"C_DIS": BlendKind.RADIUS', '"C_DIS": BlendKind.SHARE', "C_DIS read as C_PTP"),
    Fault(
        "moves.py",
        "self.plain(target), self.plain(via), angle, details)",
        "self.plain(via), self.plain(target), angle, details)",
        "CIRC: auxiliary and end point swapped",
    ),
    Fault("moves.py", 'fields["arc"] = ex.Quantity(self.plain(angle), deg)', "pass", "CA of an arc lost"),
    Fault(
        "moves.py",
        'ex.FrameRef("tool") if frames[:1] == ["TOOL"] else ex.FrameRef("own")',
        'ex.FrameRef("own")',
        "LIN_REL #TOOL goes along the base",
    ),
    Fault(
        "moves.py", "        if relative:\n", "        if relative and frames:\n", "LIN_REL read as absolute"
    ),
    Fault(
        "motion_data.py",
        "st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(value, percent)),)",
        "st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(value, 1.0)),)",
        "percent of $VEL_AXIS as a fraction",
    ),
    Fault(
        "motion_data.py",
        "st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(value, 1.0)),)",
        "st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(value, mm)),)",
        "$VEL.CP in mm/s",
    ),
    Fault(
        "motion_data.py",
        '"TOOL": lambda data, value: data.chosen_tool(value)',
        '"TOOL": lambda data, value: data.chosen_frame(value)',
        "BAS(#TOOL) selects a base",
    ),
    Fault(
        "motion_data.py",
        'ex.SystemValue("current-frame") if external else None',
        'None if external else ex.SystemValue("current-frame")',
        "$IPO_MODE inverted: the tool in the room",
    ),
    Fault(
        "motion_data.py",
        'self.member("FDAT_ACT", "TOOL_NO")',
        'self.member("FDAT_ACT", "BASE_NO")',
        "inline forms: the tool has the base's number",
    ),
    Fault(
        "system.py",
        '"CDIS": (st.BlendKind.RADIUS, mm)',
        '"CDIS": (st.BlendKind.RADIUS, 1.0)',
        "$APO.CDIS in metres",
    ),
    Fault(
        "expressions.py",
        '"pose-product", (self.plain(children[0]), self.plain(children[1]))',
        '"pose-product", (self.plain(children[1]), self.plain(children[0]))',
        "a:b composed as b:a",
    ),
    Fault("expressions.py", 'operator = "div"', 'operator = "/"', "quotient of integers not cut"),
    Fault(
        "grammar.py",
        "st.Dwell(0, ex.Quantity(time, 1.0))",
        "st.Dwell(0, ex.Quantity(time, 0.001))",
        "WAIT SEC in ms",
    ),
    Fault(
        "grammar.py",
        "self.plain(start), self.plain(stop), step",
        "self.plain(stop), self.plain(start), step",
        "FOR counts the wrong way",
    ),
    Fault(
        "write_values.py",
        '("X", "Y", "Z", "A", "B", "C"), (0, 1, 2, 5, 4, 3)',
        '("X", "Y", "Z", "A", "B", "C"), (0, 1, 2, 3, 4, 5)',
        "A and C swapped in the writer",
    ),
    Fault(
        "write_moves.py",
        'BlendKind.RADIUS: ("$APO.CDIS", mm',
        'BlendKind.RADIUS: ("$APO.CDIS", 1.0',
        "$APO.CDIS written in metres",
    ),
    Fault("write_moves.py", 'return f" {_SIZES[blend.kind][2]}"', 'return ""', "blend dropped"),
    Fault(
        "write_moves.py",
        'self._set(lines, "$TOOL", ',
        'self._set(lines, "$BASE", ',
        "the tool written as the base",
    ),
    Fault(
        "write_moves.py",
        'text = f"{self.value(s.via)},{text}"',
        'text = f"{text},{self.value(s.via)}"',
        "CIRC written with its points swapped",
    ),
    Fault(
        "write_moves.py",
        'self._set(lines, "$VEL.CP", self.quantity(speed.value, 1.0))',
        'self._set(lines, "$VEL.CP", self.quantity(speed.value, 0.001))',
        "$VEL.CP written in mm/s",
    ),
    Fault(
        "write_moves.py",
        "value = self.quantity(speed.value, percent)",
        "value = self.quantity(speed.value, 1.0)",
        "VEL_PTP written as a fraction",
    ),
    Fault(
        "write_moves.py",
        "(word, parts[place]) for word, place in POSE]",
        "(word, parts[8 - place if place > 2 else place]) for word, place in POSE]",
        "computed poses: A and C swapped",
    ),
    Fault(
        "write_moves.py",
        '"pose-product", (self._numbers((*arguments[1:4], _ZERO, _ZERO, _ZERO)), arguments[0])',
        '"pose-product", (arguments[0], self._numbers((*arguments[1:4], _ZERO, _ZERO, _ZERO)))',
        "an offset goes along the tool",
    ),
    Fault(
        "write_moves.py",
        "factors = [self._numbers((x, y, z, angles[0], _ZERO, _ZERO))]",
        "factors = [self._numbers((x, y, z, _ZERO, _ZERO, angles[0]))]",
        "RelTool turns about Z instead of X",
    ),
    Fault("write_moves.py", "parts[place] = angle", "parts[9 - place] = angle", "RelTool: Ry and Rz swapped"),
    Fault(
        "writer.py",
        "st.Repeat, st.Label, st.Call}",
        "st.Repeat, st.Call}",
        "tool and speed believed behind a label",
    ),
    Fault("writer.py", 'comment_form = " ;{}"', 'comment_form = ""', "comments dropped"),
    Fault(
        "writer.py",
        'f"TIMED_OUT={condition}"',
        'f"TIMED_OUT=NOT ({condition})"',
        "whether a wait gave up inverted",
    ),
    Fault(
        "writer.py",
        '"WAIT SEC {duration}"',
        '"WAIT SEC {duration}000"',
        "WAIT SEC written in ms",
    ),
    Fault(
        "writer.py",
        'st.Default: "DEFAULT"',
        'st.Default: ""',
        "SWITCH without its default",
    ),
    Fault("__init__.py", 'name = "krl"', 'name = "krl"\n    newline = "\\n"', "line ends LF"),
    Fault(
        "write_values.py",
        "it.shared and (self.own or public)",
        "it.shared and self.own",
        "data for other programs are the list's own",
    ),
)
