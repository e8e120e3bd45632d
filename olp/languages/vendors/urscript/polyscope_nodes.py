"""The nodes of PolyScope as lines of script.

Waypoints are joint positions, as taught. A node that refers to another one by its path is that one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Final
from xml.etree import ElementTree

_DEEPEST = 60  # nodes in one another
_MOST_STEPS = 200  # of a reference
_PIN: Final = re.compile(r"(digital|config|tool|analog)_(in|out)\[(\d+)\]")
_WORDS: Final = {"digital": "standard_digital", "config": "configurable_digital", "tool": "tool_digital"}
_MOTIONS: Final = {"MoveJ": "movej", "MoveL": "movel", "MoveP": "movep"}
_STEP: Final = re.compile(r"([A-Za-z]+)(?:\[(\d+)\])?")
_SIX: Final = re.compile(r"[-+0-9.eE]+(?:, ?[-+0-9.eE]+){5}")
_NUMBER: Final = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_SILENT: Final = frozenset({"InitVariablesNode", "Placeholder", "SafeHome", "Until"})
_AROUND: Final = frozenset({"Force", "Contributed"})  # what is in them runs, in its order

Element = ElementTree.Element


class Script:
    """Writes the nodes down. `unknown`: how many nodes of a kind have no line of their own."""

    def __init__(self, root: Element, stem: str) -> None:
        self.lines: list[str] = []
        self.unknown: dict[str, int] = {}
        self._parents = {child: parent for parent in root.iter() for child in parent}
        self._depth = 1  # of the lines
        self._inside = 0  # nodes around
        self._counters = 0
        name = re.sub(r"\W+", "_", root.get("name") or stem, flags=re.ASCII).strip("_") or "program"
        self._add(f"def {name if not name[0].isdigit() else f'program_{name}'}():", -1)
        main = None
        for node in self._children(root):
            if node.tag == "MainProgram":
                main = node
            else:
                self._nodes([node], None)
        if main is not None:
            self._main(main)
        self._add("end", -1)

    def _add(self, text: str, shift: int = 0) -> None:
        self.lines.append("  " * max(0, self._depth + shift) + " ".join(text.split("\n")))

    def _main(self, node: Element) -> None:
        children = self._children(node)
        before = [child for child in children if child.tag == "SpecialSequence"]
        self._nodes(before, None)
        rest = [child for child in children if child.tag != "SpecialSequence"]
        if node.get("runOnlyOnce") == "true":
            self._nodes(rest, None)
        else:
            self._block("while (True):", rest, None)
            self._add("end")

    def _block(self, head: str, nodes: list[Element], move: Element | None) -> None:
        self._add(head)
        self._depth += 1
        self._nodes(nodes, move)
        self._depth -= 1

    def _nodes(self, nodes: list[Element], move: Element | None) -> None:
        """Nodes in order; `move`: the one around them. An If stays open for the branches behind it."""
        if self._inside > _DEEPEST:
            self._unknown("nodes too deep")
            return
        self._inside += 1
        open_if = False
        for node in map(self._resolved, nodes):
            branch = node.get("type") if node.tag == "If" else ""
            if open_if and branch not in ("ElseIf", "Else"):
                self._add("end")
                open_if = False
            if branch:
                open_if = self._branch(node, branch, open_if, move)
                continue
            write = _NODES.get(node.tag)
            if write is not None:
                write(self, node, move)
            elif node.tag not in _SILENT:
                self._unknown(node.tag)
                if node.tag in _AROUND:
                    self._nodes(self._children(node), move)
        if open_if:
            self._add("end")
        self._inside -= 1

    def _unknown(self, tag: str) -> None:
        self.unknown[tag] = self.unknown.get(tag, 0) + 1
        self._add(f"# PolyScope node: {tag}")

    # --- parts of nodes ---------------------------------------------------------------------------------

    def _children(self, node: Element) -> list[Element]:
        found = node.find("children")
        return [] if found is None else list(found)

    def _resolved(self, node: Element) -> Element:
        """The element that a reference names by its path, or the element itself."""
        path = node.get("reference")
        steps = 0
        while path and steps < _MOST_STEPS:
            place: Element | None = node
            for step in path.split("/")[:_MOST_STEPS]:
                steps += 1
                place = self._step(place, step)
            if place is None or place is node:
                break
            node, path = place, place.get("reference")
        return node

    def _step(self, place: Element | None, step: str) -> Element | None:
        if place is None or step == "..":
            return None if place is None else self._parents.get(place)
        match = _STEP.fullmatch(step)
        if match is None:
            return None
        same = place.findall(match[1])
        index = int(match[2] or 1) - 1
        return same[index] if index < len(same) else None

    def _named(self, node: Element | None) -> str:
        """The name of a variable, feature or subprogram."""
        if node is None:
            return "unknown"
        node = self._resolved(node)
        name = node.get("name") or node.get("featureName") or node.get("referencedName") or "unknown"
        return re.sub(r"\W", "_", name, flags=re.ASCII)

    def _expression(self, node: Element | None) -> str:
        if node is None:
            return "True"
        parts = []
        for one in self._resolved(node):
            match one.tag:
                case "ExpressionChar":
                    parts.append(one.get("character") or "")
                case "ExpressionToken":
                    parts.append(one.get("token") or "")
                case "ExpressionIO":
                    parts.append(self._pin(one.find("pin"), "get"))
                case "ExpressionVariable" | "ExpressionGeomFeature":
                    parts.append(self._named(next(iter(one), None)))
        text = "".join(parts).replace("\u225f", "==").replace("\u2265", ">=").replace("\u2264", "<=")
        return text.replace("\u2260", "!=").replace("\n", " ").strip() or "True"

    def _pin(self, node: Element | None, verb: str, value: str = "") -> str:
        """The call that reads or switches a pin; a pin of the installation keeps its name."""
        name = "" if node is None else self._resolved(node).get("referencedName") or ""
        known = _PIN.fullmatch(name)
        more = f", {value}" if value else ""
        if known is None:
            direction = "out" if verb == "set" else "in"
            return f'{verb}_standard_digital_{direction}("{name.replace(chr(34), "")}"{more})'
        if known[1] == "analog":
            return f"{verb}_standard_analog_{known[2]}({known[3]}{more})"
        return f"{verb}_{_WORDS[known[1]]}_{known[2]}({known[3]}{more})"

    # --- nodes ------------------------------------------------------------------------------------------

    def _branch(self, node: Element, kind: str, is_open: bool, move: Element | None) -> bool:
        """Whether further branches may follow. A branch that no If is open for is told, and left out."""
        if kind != "If" and not is_open:
            self._unknown(f"{kind} without If")
            return False
        condition = self._expression(node.find("expression"))
        head = {"If": f"if ({condition}):", "Else": "else:"}.get(kind, f"elif ({condition}):")
        self._block(head, self._children(node), move)
        if kind == "Else":
            self._add("end")
        return kind != "Else"

    def _move(self, node: Element, _: Element | None) -> None:
        self._nodes(self._children(node), node)

    def _circle(self, node: Element, move: Element | None) -> None:
        points = [child for child in self._children(node) if child.tag == "Waypoint"]
        if len(points) != 2:
            self._unknown("CircleMove")
            return
        places = ", ".join(self._place(point) for point in points)
        mode = ", mode=1" if node.get("OrientationMode") == "FIXED" else ""
        self._add(f"movec({places}{self._manner(move, points[1])}{mode})")

    def _waypoint(self, node: Element, move: Element | None) -> None:
        word = _MOTIONS.get("" if move is None else move.get("motionType") or "")
        if word is None:
            self._unknown("Waypoint")
            return
        name = (node.get("name") or "").replace("\n", " ")
        self._add(f"{word}({self._place(node)}{self._manner(move, node)})  # {name}")
        self._nodes(self._children(node), move)

    def _place(self, node: Element) -> str:
        if node.get("type") == "Variable":
            return self._named(node.find("variable"))
        place = self._joints(node.find("position"))
        if node.get("type") != "Relative":
            return place
        start = self._joints(node.find("relativeFromPosition"))
        shift = f"pose_sub(get_forward_kin({place}), get_forward_kin({start}))"
        return f"pose_add(get_target_tcp_pose(), {shift})"

    def _joints(self, node: Element | None) -> str:
        if node is None:
            return "[0, 0, 0, 0, 0, 0]"
        node = self._resolved(node)
        angles = node.find("JointAngles")
        text = (node.get("joints") if angles is None else self._resolved(angles).get("angles")) or ""
        if not _SIX.fullmatch(text):
            self.unknown["Waypoint without joints"] = self.unknown.get("Waypoint without joints", 0) + 1
            return "[0, 0, 0, 0, 0, 0]"
        return f"[{text}]"

    def _manner(self, move: Element | None, node: Element) -> str:
        texts = []
        given = node.find("motionParameters")
        if move is not None:
            texts += [
                ("a", move.get("acceleration")),
                ("v", move.get("speed")),
                ("r", move.get("blendRadius")),
            ]
        for until in self._children(node):
            own = until.find("motionParameters") if until.tag == "Until" else None
            given = own if own is not None and own.get("blendRadius") else given
        if given is not None and given.get("blendRadius"):
            texts = [*(pair for pair in texts if pair[0] != "r"), ("r", given.get("blendRadius"))]
        return "".join(f", {name}={text}" for name, text in texts if text and _NUMBER.fullmatch(text))

    def _wait(self, node: Element, _: Element | None) -> None:
        match node.get("type"):
            case "Sleep":
                text = (node.findtext("waitTime") or "").strip()
                if _NUMBER.fullmatch(text):
                    self._add(f"sleep({text})")
                else:
                    self._unknown("Wait without a time")
                return
            case "DigitalInput":
                level = node.findtext("digitalValue") == "1"
                condition = f"{self._pin(node.find('pin'), 'get')} == {not level}"
            case "Condition":
                condition = f"not ({self._expression(node.find('expression'))})"
            case _:
                self._unknown(f"Wait {node.get('type')}")
                return
        self._add(f"while ({condition}):")
        self._add("sync()", 1)
        self._add("end")

    def _set(self, node: Element, _: Element | None) -> None:
        pin = node.find("pin")
        match node.get("type"):
            case "DigitalOutput":
                self._add(self._pin(pin, "set", str(node.findtext("digitalValue") == "1")))
            case "ExpressionOutput":
                self._add(self._pin(pin, "set", self._expression(node.find("expression"))))
            case "AnalogOutput":
                text = (node.findtext("analogValue") or "").strip()
                if _NUMBER.fullmatch(text):
                    self._add(self._pin(pin, "set", text))
                else:
                    self._unknown("Set without a value")
            case "NoAction":
                pass
            case kind:
                self._unknown(f"Set {kind}")

    def _loop(self, node: Element, move: Element | None) -> None:
        children = self._children(node)
        if node.get("type") == "Counting":
            count = node.get("count") or ""
            if not count.isdecimal():
                self._unknown("Loop without a count")
                return
            self._counters += 1
            name = self._named(node.find("loopVariable"))
            name = f"loop_{self._counters}" if name == "unknown" else name
            self._add(f"{name} = 0")
            self._block(f"while ({name} < {count}):", children, move)
            self._add(f"{name} = {name} + 1", 1)
        else:
            endless = node.get("type") == "Forever"
            condition = "True" if endless else self._expression(node.find("expression"))
            self._block(f"while ({condition}):", children, move)
        self._add("end")

    def _switch(self, node: Element, move: Element | None) -> None:
        value = self._expression(node.find("expression"))
        word, has_default = "if", False
        for case in self._children(node):
            number = case.get("caseValue") or ""
            if case.tag == "Case" and _NUMBER.fullmatch(number):
                self._block(f"{word} ({value} == {number}):", self._children(case), move)
                word = "elif"
            elif word == "elif" and not has_default:
                self._block("else:", self._children(case), move)
                has_default = True
            else:
                self._unknown(f"{case.tag} that no value leads to")
        if word == "elif":
            self._add("end")

    def _assignment(self, node: Element, _: Element | None) -> None:
        if node.get("valueSource") == "Expression":
            name = self._named(node.find("variable"))
            self._add(f"global {name} = {self._expression(node.find('expression'))}")
        else:
            self._unknown("Assignment by the operator")

    def _script(self, node: Element, _: Element | None) -> None:
        text = node.findtext("cachedContents") if node.get("type") == "File" else None
        lines = [self._expression(node.find("expression"))] if text is None else text.splitlines()
        for line in lines[:100_000]:
            self._add(line)

    def _popup(self, node: Element, _: Element | None) -> None:
        given = node.find("variable")
        message = (node.get("message") or "").replace('"', "'")
        text = f'"{message}"' if given is None else self._named(given)
        kind = (node.get("type") or "Message").lower()
        more = f", {kind}=True" if kind in ("warning", "error") else ""
        self._add(f"popup({text}{more}, blocking=True)")
        if node.get("haltProgram") == "true":
            self._add("halt")

    def _call(self, node: Element, _: Element | None) -> None:
        self._add(f"{self._named(node.find('subprogram'))}()")

    def _definition(self, node: Element, _: Element | None) -> None:
        word = "thread" if node.tag == "Thread" else "def"
        children = self._children(node)
        name = self._named(node)
        self._add(f"{word} {name}():")
        self._depth += 1
        if word == "thread" and node.get("runOnlyOnce") != "true":
            self._block("while (True):", [*children], None)
            self._add("sync()", 1)
            self._add("end")
        else:
            self._nodes(children, None)
        self._depth -= 1
        self._add("end")
        if word == "thread":
            self._add(f"run {name}()")

    def _comment(self, node: Element, _: Element | None) -> None:
        self._add(f"# {node.get('comment') or ''}".rstrip())

    def _folder(self, node: Element, move: Element | None) -> None:
        if node.get("name"):
            self._add(f"# {node.get('name')}")
        self._nodes(self._children(node), move)

    def _suppressed(self, node: Element, _: Element | None) -> None:
        inner = node.find("suppressedNode")
        kind = "" if inner is None else inner.get("class") or ""
        self._add(f"# switched off: {kind}".rstrip())

    def _halt(self, node: Element, _: Element | None) -> None:
        self._add("halt")


_NODES: Final[Mapping[str, Callable[[Script, Element, Element | None], None]]] = {
    "Assignment": Script._assignment,
    "CallSubProgram": Script._call,
    "CircleMove": Script._circle,
    "Comment": Script._comment,
    "Folder": Script._folder,
    "Halt": Script._halt,
    "Loop": Script._loop,
    "Move": Script._move,
    "Popup": Script._popup,
    "Script": Script._script,
    "Set": Script._set,
    "SpecialSequence": Script._folder,
    "SubProgram": Script._definition,
    "SuppressedNode": Script._suppressed,
    "Switch": Script._switch,
    "Thread": Script._definition,
    "Wait": Script._wait,
    "Waypoint": Script._waypoint,
    "subprogram": Script._definition,
}
