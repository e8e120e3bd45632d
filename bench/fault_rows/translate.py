"""Faults between the languages: speeds, blends, accelerations, frames, arcs."""

from typing import Final

from fault_rows import Fault

FAULTS: Final = (
    Fault(
        "speeds.py",
        "return max(axes) / value",
        "return min(axes) / value",
        "rad/s of the axis that turns least instead of most",
    ),
    Fault(
        "speeds.py",
        "return row.length / value if",
        "return row.length / (value * mm) if",
        "mm/s taken as m/s",
    ),
    Fault(
        "speeds.py",
        "return max(a / w for a, w in zip(row.axes, _rated(robot), strict=False)) / time",
        "return max(a * w for a, w in zip(row.axes, _rated(robot), strict=False)) / time",
        "share of the axes' speed times their limits",
    ),
    Fault(
        "speeds.py",
        "slowest = max(known) if unit is SpeedUnit.TIME else min(known)",
        "slowest = min(known) if unit is SpeedUnit.TIME else max(known)",
        "of several lengths the fastest is written",
    ),
    Fault(
        "blends.py",
        "return zones[min(round(value), len(zones)) - 1]",
        "return zones[min(round(value), len(zones) - 1)]",
        "position levels shifted by one",
    ),
    Fault(
        "blends.py",
        "Blend(kind, Quantity(Number(level + 1), 1.0))",
        "Blend(kind, Quantity(Number(level), 1.0))",
        "levels written one too small",
    ),
    Fault(
        "blends.py", "return 0.5 * value * row.length", "return value * row.length", "C_PTP of the whole way"
    ),
    Fault(
        "blends.py",
        "return value**2 * self._braking(s, row)",
        "return value * self._braking(s, row)",
        "CNT proportional to the distance",
    ),
    Fault(
        "blends.py",
        "Number(_clean(radius / mm)), mm)",
        "Number(_clean(radius)), mm)",
        "radii a thousand times too small",
    ),
    Fault(
        "accelerations.py",
        "Quantity(Number(_clean(100 * value / rated)), percent)",
        "Quantity(Number(_clean(value / rated)), percent)",
        "shares of the acceleration as fractions",
    ),
    Fault(
        "frames.py",
        'Function("pose-product", (Function("pose-inverse", (frame,)), HERE))',
        'Function("pose-product", (frame, HERE))',
        "where the arm stands, in its frame: not inverse",
    ),
    Fault(
        "frames.py",
        'return Function("pose-product", (frame, target))',
        'return Function("pose-product", (target, frame))',
        "frame and target composed the wrong way round",
    ),
    Fault(
        "frames.py",
        "((_FAR, 0, 0), (_FAR, _FAR, 0))",
        "((_FAR, 0, 0), (_FAR, -_FAR, 0))",
        "MFRAME: the plane's third point on the other side",
    ),
    Fault(
        "frames.py", 'changes["via"] = self._in_base(frame, s.via)', "pass", "via points stay in their frame"
    ),
    Fault(
        "arcs.py",
        "pose_of_literal(literal) @ tool.inverse() @ new_tool",
        "pose_of_literal(literal) @ tool @ new_tool",
        "change of tool before an arc: not inverse",
    ),
    Fault(
        "arcs.py",
        "new_frame.inverse() @ frame @",
        "frame.inverse() @ new_frame @",
        "change of frame before an arc inverted",
    ),
    Fault(
        "arcs.py",
        "return [entry, through, end]",
        "return [entry, end, through]",
        "chain of an arc in the wrong order",
    ),
    Fault(
        "arcs.py",
        "away = -(third - (start + end) / 2)",
        "away = third - (start + end) / 2",
        "the long arc instead of the short one",
    ),
    Fault(
        "relative.py",
        'Function("pose-relative-tool", (self._place(s.tool, s.frame), *values))',
        'Function("pose-offset", (self._place(s.tool, s.frame), *values[:3]))',
        "a move along the tool goes along the base",
    ),
    Fault(
        "records.py",
        "pose_of_literal(outer) @ pose_of_literal(inner)",
        "pose_of_literal(inner) @ pose_of_literal(outer)",
        "wobj: uframe and oframe in the wrong order",
    ),
    Fault(
        "records.py",
        "return outer if inner is None else literal_of",
        "return outer if inner is not None else literal_of",
        "wobj: oframe left out",
    ),
    Fault(
        "names.py",
        "return self._unique(text[:longest] if longest else text, longest, room)",
        "return text[:longest] if longest else text",
        "long names that become one",
    ),
    Fault(
        "names.py",
        "text[:longest] if longest else text, longest, room",
        "text, longest, room",
        "names longer than the target takes",
    ),
    Fault(
        "lift.py",
        'first = 1 if self.work.source.vendor == "inform" else 0',
        "first = 0",
        "arrays counted from 0 and from 1",
    ),
    Fault(
        "lift_points.py",
        "return _tool(state.tool) if state.tool >= 0 else None",
        "return _tool(0) if state.tool >= 0 else None",
        "taught points: tool lost",
    ),
    Fault(
        "lift_points.py",
        "return None if state.user is None else _user(state.user)",
        'return FrameRef("base")',
        "taught points: user frame lost",
    ),
    Fault(
        "lift_points.py",
        'v / (mm if unit == "mm" else deg)',
        "v / deg",
        "slides in metres taken for angles",
    ),
    Fault("externals.py", "v == v and v != 0.0", "v != v", "tracks and stations left out in silence"),
    Fault(
        "here.py",
        "last = (s.tool, s.frame)",
        "last = (s.tool, last[1])",
        "CRobT seen in the world, not in the last work object",
    ),
    Fault(
        "modal.py",
        "seen_in(tool, frame) if e == HERE",
        'seen_in(tool, FrameRef("base")) if e == HERE',
        "$POS_ACT seen in the world",
    ),
    Fault(
        "lift_moves.py",
        'changes["tool"] = tool_of(state)',
        'changes["tool"] = frame_of(state)',
        "the frame taken for the tool",
    ),
    Fault(
        "signals.py",
        "next(n for n in range(1, 100_000) if n not in taken)",
        "1",
        "all signals without a number are one",
    ),
    Fault(
        "signals.py",
        "number = int(digits[1]) if digits else 0",
        "number = int(digits[1]) + 1 if digits else 0",
        "signals shifted by one",
    ),
    Fault("tree.py", "return State(not on)", "return State(on)", "endless loops never entered"),
    Fault(
        "tree.py",
        'turned = tuple(("or" if word == "and" else "and", negated(part))',
        "turned = tuple((word, negated(part))",
        "not (a and b) as not a and not b",
    ),
    Fault(
        "jumps.py",
        'Compare(">" if not isinstance(step, Number) or step.value > 0 else "<"',
        'Compare(">=" if not isinstance(step, Number) or step.value > 0 else "<="',
        "loops run once too few",
    ),
    Fault(
        "jumps.py",
        "Jump(head.line, end, negated(head.condition), head.comment)",
        "Jump(head.line, end, head.condition, head.comment)",
        "WHILE as jumps: condition inverted",
    ),
    Fault(
        "modal.py",
        "Number(written * known / speed.value.scale)",
        "Number(written / speed.value.scale)",
        "override lost",
    ),
    Fault(
        "modal.py",
        "size: Any = self.value((_BLEND, s.blend.kind), usual)",
        "size: Any = usual",
        "modal blend sizes ignored",
    ),
    Fault(
        "modal.py",
        'changes["frame"] = self.value(_FRAME, FrameRef("base"))',
        'changes["frame"] = FrameRef("base")',
        "$BASE that was set ignored",
    ),
)
