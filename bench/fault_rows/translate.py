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
        "slowest = max(known) if unit is st.SpeedUnit.TIME else min(known)",
        "slowest = min(known) if unit is st.SpeedUnit.TIME else max(known)",
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
        "return value**2 * self._braking(row)",
        "return value * self._braking(row)",
        "CNT proportional to the distance",
    ),
    Fault(
        "blends.py",
        "Number(_clean(radius / mm)), mm)",
        "Number(_clean(radius)), mm)",
        "radii a thousand times too small",
    ),
    Fault(
        "speeds.py",
        "Quantity(Number(_accelerations_clean(100 * value / rated)), percent)",
        "Quantity(Number(_accelerations_clean(value / rated)), percent)",
        "shares of the acceleration as fractions",
    ),
    Fault(
        "frames.py",
        'ex.Function("pose-product", (ex.Function("pose-inverse", (frame,)), HERE))',
        'ex.Function("pose-product", (frame, HERE))',
        "where the arm stands, in its frame: not inverse",
    ),
    Fault(
        "frames.py",
        'return ex.Function("pose-product", (frame, target))',
        'return ex.Function("pose-product", (target, frame))',
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
        "current_position.py",
        'return ex.Function("pose-relative-tool", (here, *values))',
        'return ex.Function("pose-offset", (here, *values[:3]))',
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
        "name_mangling.py",
        "return self._unique(text[:longest] if longest else text, longest, room)",
        "return text[:longest] if longest else text",
        "long names that become one",
    ),
    Fault(
        "name_mangling.py",
        "text[:longest] if longest else text, longest, room",
        "text, longest, room",
        "names longer than the target takes",
    ),
    Fault(
        "move_lowering.py",
        "return _tool(state.tool) if state.tool >= 0 else None",
        "return _tool(0) if state.tool >= 0 else None",
        "taught points: tool lost",
    ),
    Fault(
        "move_lowering.py",
        "return None if state.user is None else _user(state.user)",
        'return FrameRef("base")',
        "taught points: user frame lost",
    ),
    Fault(
        "move_lowering.py",
        'v / (mm if unit == "mm" else deg)',
        "v / deg",
        "slides in metres taken for angles",
    ),
    Fault("partial_positions.py", "v == v and v != 0.0", "v != v", "tracks and stations left out in silence"),
    Fault(
        "current_position.py",
        "last = (s.tool, s.frame)",
        "last = (s.tool, last[1])",
        "CRobT seen in the world, not in the last work object",
    ),
    Fault(
        "move_lowering.py",
        'changes["tool"] = tool_of(state)',
        'changes["tool"] = frame_of(state)',
        "the frame taken for the tool",
    ),
    Fault(
        "signals.py",
        "known = next(free, -1)",
        "known = 1",
        "all signals without a number are one",
    ),
    Fault(
        "signals.py",
        "number = int(digits[1]) if digits else 0",
        "number = int(digits[1]) + 1 if digits else 0",
        "signals shifted by one",
    ),
    Fault(
        "../ir/block_structure.py",
        "return SignalState(not on)",
        "return SignalState(on)",
        "endless loops never entered",
    ),
    Fault(
        "../ir/block_structure.py",
        'turned = tuple(("or" if word == "and" else "and", negated(part))',
        "turned = tuple((word, negated(part))",
        "not (a and b) as not a and not b",
    ),
    Fault(
        "structuring.py",
        'Compare(">" if not isinstance(step, Number) or step.value > 0 else "<"',
        'Compare(">=" if not isinstance(step, Number) or step.value > 0 else "<="',
        "loops run once too few",
    ),
    Fault(
        "structuring.py",
        "Jump(head.line, end, negated(head.condition), head.comment)",
        "Jump(head.line, end, head.condition, head.comment)",
        "WHILE as jumps: condition inverted",
    ),
    Fault(
        "modal_state.py",
        "size: Any = self.value((_BLEND, blend.kind), _BLENDS.get(blend.kind, _NO_BLEND))",
        "size: Any = _BLENDS.get(blend.kind, _NO_BLEND)",
        "modal blend sizes ignored",
    ),
    Fault(
        "modal_state.py",
        'changes["frame"] = self.value(_FRAME, _BASE)',
        'changes["frame"] = _BASE',
        "$BASE that was set ignored",
    ),
    Fault(
        "commented_out.py",
        "lines = {**filling, **_users(program, lost), **bodies, **out.lines}",
        "lines = {**filling, **bodies, **out.lines}",
        "what needs data that are gone stays",
    ),
    Fault(
        "commented_out.py",
        "_tell_users(program, lines, work)",
        "_tell_users(program, {}, work)",
        "what needs a value that a comment sets is not named",
    ),
    Fault(
        "implicit_declarations.py",
        "_refuse_own(program, own, work)",
        "_refuse_own(program, set(), work)",
        "a controller's variables as a program's own",
    ),
    Fault(
        "implicit_declarations.py",
        "                places.add(name)\n",
        "",
        "positions set from undeclared ones count as exact",
    ),
    Fault(
        "arrays.py", "not 1 <= value.value <= size", "not 1 <= value.value", "elements beyond an array's end"
    ),
    Fault(
        "partial_positions.py",
        "return _joined(e, before.values)",
        "return _joined(e, (0.0,) * len(e.values))",
        "components that are left out are zeros",
    ),
    Fault(
        "partial_positions.py",
        "self.last = self.last if isinstance(s, _STEADY) else None",
        "self.last = self.last",
        "components of a move that may not be the one before",
    ),
    Fault(
        "arrays.py",
        "row is not None and len(e.indices) == row.indices and",
        "row is None and",
        "a character of a text taken for the text",
    ),
    Fault(
        "arrays.py",
        "enumerate(e.members, 1)",
        "enumerate(reversed(e.members), 1)",
        "arrays assigned in reverse",
    ),
    Fault(
        "frames.py",
        "self.taken[_KINDS[name]].add(int(number.value))",
        "number.value",
        "a tool of another file gets a number that is used",
    ),
    Fault(
        "frames.py",
        "if (kind, number) in written and",
        "if (kind, number) not in written and",
        "what a frame holds before it is set: lost",
    ),
    Fault(
        "first_values.py",
        "return ex.Number(left - right)",
        "return ex.Number(right - left)",
        "differences of constants the wrong way round",
    ),
    Fault("first_values.py", "range(_DEEPEST)", "range(1)", "values that name values that name others: lost"),
    Fault(
        "integer_inference.py",
        'return "analog" not in bus',
        "return True",
        "analogue inputs count as whole numbers",
    ),
    Fault(
        "integer_inference.py",
        "                self._set(caller, value, None)\n",
        "                pass\n",
        "a number that a routine changes counts as whole",
    ),
    Fault("blends.py", "if size < room:", "if size < 2 * room:", "URScript: blends that meet"),
    Fault(
        "blends.py",
        "cut = max(math.ceil(room / _GRAIN) - 1, 0) * _GRAIN",
        "cut = math.ceil(room / _GRAIN) * _GRAIN",
        "URScript: blends cut to where they meet",
    ),
    Fault("dead_code.py", "(alone and _is_said(d))", "False", "tools of a file of data lost"),
    Fault(
        "dead_code.py",
        "if alone and not kept(d)]",
        "if False]",
        "data that a list cannot hold left out in silence",
    ),
    Fault(
        "implicit_declarations.py",
        "found -= _names(s)",
        "found -= set()",
        "the limit of waits refused although a wait has it",
    ),
    Fault(
        "name_types.py",
        "changed = symbol is None or symbol.assigned",
        "changed = False",
        "parameters that are changed go by value",
    ),
)
