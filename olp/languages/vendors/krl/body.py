"""The lines between DEF and END: the fast path first, then lines seen before, then the grammar."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from olp.core.diagnostic import Severity
from olp.ir import program as st
from olp.ir.expressions import Expression, Named, Number, SystemValue, Text
from olp.languages.findings import Findings
from olp.languages.lark_host import placed, values_of
from olp.languages.vendors.krl import interrupts, parsing, texts, triggers
from olp.languages.vendors.krl.declarations import Head, Tail
from olp.languages.vendors.krl.fast import ACTUAL, NUMBER_ROW, KrlMoveLines, declared
from olp.languages.vendors.krl.moves import SPLINE_PASS, SplineBlock, SplineEnd
from olp.languages.vendors.krl.parsing import KrlLineReader
from olp.languages.vendors.krl.scope import Scope
from olp.languages.vendors.krl.system import Modal
from olp.languages.vendors.krl.values import number as number_of

# Blocks that a broken line opens or closes all the same, for the check of blocks.
_MARKERS: Final[dict[str, Callable[[int], st.Statement]]] = {
    "IF": lambda line: st.If(line, Text("")),
    "ENDIF": st.EndIf,
    "WHILE": lambda line: st.While(line, Text("")),
    "LOOP": lambda line: st.While(line, Text("")),
    "ENDWHILE": st.EndWhile,
    "ENDLOOP": st.EndWhile,
    "FOR": lambda line: st.For(line, Named(""), Text(""), Text("")),
    "ENDFOR": lambda line: st.Next(line, None),
    "REPEAT": st.Repeat,
    "UNTIL": lambda line: st.Until(line, Text("")),
    "SWITCH": lambda line: st.Switch(line, Text("")),
    "ENDSWITCH": st.EndSwitch,
}
_MODAL = (st.Assign, st.Call)
# A WITH list that sets one axis by a value: SVEL_JOINT and SACC_JOINT set the others themselves.
_FIRST_ALONE = re.compile(
    r"(?i)(\$(?:VEL|ACC))_AXIS\s*\[\s*1\s*\]\s*=(?!\s*S(?:VEL|ACC)_JOINT\b)(?!.*\1_AXIS\s*\[\s*2\s*\])"
)
_WORD = re.compile(r"\w+")
_MOST_CACHED = 50_000

# Class and all values but the line; whether the lines before decide what it means; whether it changes nothing of that
# and is added as it is.
_Template = tuple[Callable[..., st.Statement], tuple[Any, ...], bool, bool]


class BodyReader:
    """Reads the lines of one routine into `body`. `markers`: stand for broken lines that open or close a block."""

    def __init__(self, findings: Findings, scope: Scope, reader: KrlLineReader) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._reader = reader
        self._scope = scope
        self._moves = KrlMoveLines(scope)
        self._modal = Modal(scope)
        self._seen: dict[str, _Template] = {}
        self._set_to_numbers: dict[str, Expression] = {}  # by their text: what lines give a number to
        self._block: SplineBlock | None = None
        self.body: list[st.Statement] = []
        self.markers: list[st.Statement] = []
        self.declared: dict[str, int] = {}

    def comment(self, text: str, number: int) -> None:
        self._kinds[number - 1] = st.LineKind.COMMENT
        self.body.append(st.Comment(number, text))

    def read(self, code: str, comment: str, number: int) -> Head | Tail | None:
        """One line without its comment. Heads and tails are given back."""
        template = self._seen.get(code)
        if template is None and self._block is None:
            move = self._moves.read(code, number, comment)
            if move is not None:
                self._kinds[number - 1] = st.LineKind.STATEMENT
                self.body.append(move)
                return None
            actual = ACTUAL.fullmatch(code)
            if actual is not None and not comment:
                self._actual(actual[1], actual[2], number)
                return None
            position = declared(code, self._scope)
            if position is not None:
                self._structure((position,), comment, number)
                return None
        if template is None:
            return self._parse(code, comment, number)
        kind, values, modal, plain = template
        if plain and not comment:
            self._kinds[number - 1] = st.LineKind.STATEMENT
            self.body.append(kind(number, *values))
        else:
            self._add(kind(number, *values), comment, number, modal)
        return None

    def _actual(self, word: str, name: str, number: int) -> None:
        """`FDAT_ACT=FP1`: the motion data that BAS takes."""
        value = Named(self._scope.spell(name))
        self._modal.data.assign(word.upper(), value)
        self._kinds[number - 1] = st.LineKind.STATEMENT
        self.body.append(st.Assign(number, Named(self._scope.spell(word)), value))

    def _parse(self, code: str, comment: str, number: int) -> Head | Tail | None:
        put = texts.written(code, self._scope.spell) if code[:6].upper() == "SWRITE" else ()
        if put:
            self._several(put, comment, number)
            return None
        kept = parsing.kept(code)
        if isinstance(kept, st.Process) and kept.name == triggers.NAME:
            kept = triggers.read_trigger(code, self._scope)
        elif isinstance(kept, st.Process) and kept.name == interrupts.NAME:
            kept = interrupts.read_interrupt(code, self._scope)
        result = self._reads_number(code, number) if kept is None else kept
        if result is None:
            word = _WORD.match(code)
            if word is not None and word[0].upper() in _MARKERS:
                self.markers.append(_MARKERS[word[0].upper()](number))
            return None
        if isinstance(result, (Head, Tail)):
            return result
        if isinstance(result, tuple):
            self._structure(result, comment, number)
            return None
        put = texts.changed(result)
        if put:
            self._several(put, comment, number)
            return None
        if isinstance(result, st.Move) and "WITH" in code.upper():
            for alone in _FIRST_ALONE.findall(code):
                self._first_alone(f"{alone.upper()}_AXIS", number)
        result = self._modal.fixed(result) or result
        modal = isinstance(result, _MODAL)
        if len(self._seen) < _MOST_CACHED:
            plain = not modal and not isinstance(result, (*st.WAYS_MEET, st.Opaque, st.Move))
            self._seen[code] = (type(result), values_of(result), modal, plain)
        self._add(placed(result, number), comment, number, modal)
        return None

    def _reads_number(self, code: str, number: int) -> Any:
        """What the grammar makes of a line; what it made of `$VEL.CP=0.1` says what `$VEL.CP=0.2` is."""
        match = NUMBER_ROW.fullmatch(code)
        if match is None:
            return self._reader.parse(code, number)
        known = self._set_to_numbers.get(match[1])
        if known is not None:
            return st.Assign(0, known, number_of(match[2]))
        result = self._reader.parse(code, number)
        if (
            type(result) is st.Assign
            and type(result.target) is not SystemValue  # $TIMER is set in ms
            and type(result.value) is Number
            and len(self._set_to_numbers) < _MOST_CACHED
        ):
            self._set_to_numbers[match[1]] = result.target
        return result

    def _several(self, found: tuple[st.Statement, ...], comment: str, number: int) -> None:
        """The statements that one of KRL stands for."""
        self._kinds[number - 1] = st.LineKind.STATEMENT
        here = [placed(one, number) for one in found]
        self.body += [*here[:-1], parsing.commented(here[-1], comment) if comment else here[-1]]

    def _add(self, it: st.Statement, comment: str, number: int, modal: bool) -> None:
        """One statement, or those that it stands for."""
        kinds, body = self._kinds, self.body
        if isinstance(it, st.Opaque):
            kinds[number - 1] = st.LineKind.OPAQUE
            body.append(it)
            return
        kinds[number - 1] = st.LineKind.STATEMENT
        if modal:
            self._add_modal(it, comment, number)
            return
        if self._block is not None and isinstance(it, st.Move):
            it = self._within(it)
        if isinstance(it, st.WAYS_MEET):
            self._modal.forget()
            if isinstance(it, st.ElseIf):
                help = "write it as ELSE and IF … ENDIF"
                self._findings.once(Severity.WARNING, "P418", "", "KRL has no ELSEIF", number, help)
        body.append(parsing.commented(it, comment) if comment else it)

    def _add_modal(self, it: st.Statement, comment: str, number: int) -> None:
        found = self._modal.lower(it)
        if not found and comment:
            self.body.append(st.Comment(number, comment))
        last = len(found) - 1
        for place, one in enumerate(found):
            here = one if one is it else placed(one, number)
            self.body.append(parsing.commented(here, comment) if comment and place == last else here)
        if self._modal.data.missing or self._modal.odd:
            self._tell(number)

    def _tell(self, number: int) -> None:
        span = self._findings.whole_line(number)
        for name in self._modal.data.missing:
            message = f"the motion data {name} have no value here: the move's speed and frames are computed from them"
            if not self._scope.known(name.upper()):
                message = (
                    f"no list gives the motion data {name}: its values are those that a form begins with"
                )
            help = "put the .dat (and $config.dat) beside the program"
            self._findings.once(Severity.WARNING, "P413", name, message, span, help)
        for name in self._modal.odd:
            message = f"{name} differs from axis to axis: the first axis speaks for all"
            self._findings.once(Severity.WARNING, "P416", name, message, span, "give all axes one value")
        self._modal.data.missing.clear()
        self._modal.odd.clear()

    # --- declarations and spline blocks -----------------------------------------------------------------

    def _structure(self, result: Any, comment: str, number: int) -> None:
        kinds = self._kinds
        kinds[number - 1] = st.LineKind.STATEMENT
        if isinstance(result, SplineBlock):
            if self._block is not None:
                self._findings.error(
                    "P405", "a spline block within a spline block", number, "close the first: ENDSPLINE"
                )
            self._block = result
            self.body.append(st.Process(number, result.word, (), comment))
            return
        if isinstance(result, SplineEnd):
            self._end_spline(result, comment, number)
            return
        for place, one in enumerate(result):
            assert isinstance(one, st.Declare)
            key = one.name.upper()
            if key in self.declared:
                span = self._findings.whole_line(number)
                message = f"{one.name} is declared twice, first in line {self.declared[key]}"
                self._findings.warning("P415", message, span, "remove one")
            self.declared.setdefault(key, number)
            said = comment if place == len(result) - 1 else ""
            self.body.append(replace(one, line=number, comment=said))

    def _within(self, it: st.Move) -> st.Move:
        """A move of a spline block: it passes its point, and what the block says holds for it."""
        assert self._block is not None
        fields = {name: value for name, value in self._block.fields.items() if name not in ("sizes", "other")}
        missing = {name: value for name, value in fields.items() if getattr(it, name) is None}
        other = (*it.other, *self._block.fields.get("other", ()))
        return replace(it, blend=SPLINE_PASS, other=other, **missing)

    def _end_spline(self, end: SplineEnd, comment: str, number: int) -> None:
        if self._block is None:
            self._findings.error("P405", "ENDSPLINE without SPLINE", number, "remove it")
            return
        self._block = None
        for place in range(len(self.body) - 1, -1, -1):
            one = self.body[place]
            if isinstance(one, st.Move):
                self.body[place] = replace(one, blend=end.blend)
                break
            if isinstance(one, st.Process) and one.name in ("SPLINE", "PTP_SPLINE"):
                break
        self.body.append(st.Process(number, "ENDSPLINE", (), comment))

    def _first_alone(self, name: str, number: int) -> None:
        message = f"{name} is set for the first axis alone: it speaks for all"
        span = self._findings.whole_line(number)
        self._findings.once(Severity.WARNING, "P416", f"{name}[1]", message, span, "give all axes one value")

    def finish(self, number: int) -> None:
        """The routine ends in line `number`."""
        self._modal.finish()
        for name, line in self._modal.first_alone:
            self._first_alone(name, line)
        if self._block is not None:
            self._findings.error("P405", "SPLINE without ENDSPLINE", number, "close it: ENDSPLINE")
