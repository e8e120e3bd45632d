"""Writes programs as KRL: what `templates/krl.j2` puts together.

Codes: X002 what KRL cannot say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import PureWindowsPath
from typing import Any, ClassVar, Final

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import expressions_of
from olp.languages.generator import (
    BRANCHES,
    CLOSES,
    CannotSayError,
    Joined,
    Lines,
    Spelled,
    as_text,
    framing_comments,
)
from olp.languages.vendors.krl import interrupts, texts
from olp.languages.vendors.krl.motion_data import ACTUAL, MotionData
from olp.languages.vendors.krl.scope import CONFIG_MARK, NEUTRAL_TYPES, Scope
from olp.languages.vendors.krl.write_forms import DECIMALS, END_OF_FORM, EXTERNAL, InlineForms, initialisation
from olp.languages.vendors.krl.write_forms import HEADER as HEADER_OF_FORMS
from olp.languages.vendors.krl.write_moves import KrlMoves, says_turning
from olp.languages.vendors.krl.write_values import KrlValues, is_of_config

# --- Bas calls ---
# Finds the statements that one call of BAS stands for, so that KRL's own programs keep their inline forms.

MODAL: Final = (st.SetSpeed, st.SetAcceleration, st.SetBlend, st.SetTool, st.SetFrame, st.ExternalTool)
_COMMANDS: Final = ("INITMOV", "PTP_PARAMS", "CP_PARAMS", "PTP_DAT", "CP_DAT", "FRAMES")


class BasCalls:
    """Follows a routine as the reader did."""

    def __init__(self, scope: Scope, words: KrlValues) -> None:
        self._words = words
        self._data = MotionData(scope)

    def follow(self, it: st.Statement) -> None:
        """Notes what a statement says about the motion data."""
        if isinstance(it, st.WAYS_MEET):
            self._data.forget()
        elif isinstance(it, st.ExternalTool):
            self._data.external = it.tool is not None
        elif (
            isinstance(it, st.Assign) and isinstance(it.target, ex.Named) and it.target.name.upper() in ACTUAL
        ):
            self._data.assign(it.target.name.upper(), it.value)

    def call(self, body: Sequence[st.Statement], place: int) -> tuple[int, str] | None:
        """How many statements from `place` on one call of BAS stands for, and that call; None: not one."""
        first = body[place]
        if not isinstance(first, MODAL) or not first.line:
            return None
        end = place + 1
        while end < len(body) and isinstance(one := body[end], MODAL) and one.line == first.line:
            end += 1
        if end - place < 2:
            return None
        group = body[place:end]
        argument = _speed(group[-1])
        external = self._data.external
        for command in _COMMANDS:
            found = self._data.bas(command, argument)
            if found is not None and len(found) == len(group) and all(map(_alike, found, group)):
                value = "0" if command in ("INITMOV", "FRAMES") else self._words.value(argument)
                plain = command in ("PTP_DAT", "CP_DAT", "FRAMES")
                return len(group), f"BAS (#{command})" if plain else f"BAS (#{command},{value})"
            self._data.external = external
        return None


def _continued(lines: list[str]) -> list[str]:
    """CONTINUE holds for the next line alone: one before each that reads what the controller holds."""
    if len(lines) == 1:
        return ["CONTINUE", *lines]
    return [row for line in lines for row in (["CONTINUE", line] if "$" in line else [line])]


def _speed(it: st.Statement) -> ex.Expression:
    return it.speeds[0].value.written if isinstance(it, st.SetSpeed) and it.speeds else ex.Number(0)


def _alike(one: st.Statement, other: st.Statement) -> bool:
    """Equal but for the line and the comment."""
    if type(one) is not type(other):
        return False
    skipped = "comment"
    names = [name for name in type(one).__dataclass_fields__ if name not in ("line", skipped)]
    return all(getattr(one, name) == getattr(other, name) for name in names)


# --- Writer ---

_TYPES: Final = {neutral: word for word, neutral in NEUTRAL_TYPES.items() if word not in ("POS", "AXIS")}
_REL: Final = "&REL 1\n"
_HEADER: Final = f"&ACCESS RVP\n{_REL}"
# Without INITMOV $VEL, $ACC and their like hold what the last program left, or nothing at all. It halves the axes'
# acceleration, which is the rated one in all other languages.
_INI: Final = (
    ";FOLD INI",
    "  BAS (#INITMOV,0)",
    *(f"  $ACC_AXIS[{axis}]=100" for axis in range(1, 7)),
    ";ENDFOLD (INI)",
)
_POLL = "0.012"  # [s] the interpolation cycle
_PULSE = "0.3"  # [s] of a pulse that names no time
_WHOLE_TEXT: Final = "TEXT_WHOLE[]"  # a text that is put together and has no variable
_HELPERS: Final = {"WAITED": "REAL", "TIMED_OUT": "BOOL"}  # variables that a wait with a limit uses
_CHANGES: Final = (st.Assign, st.Update, st.ReadInput)


def write(
    program: st.Program, date: str, pair: bool = False, forms: bool = False
) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that KRL cannot say. KRL programs hold no `date`.

    `pair`: data go into a list beside the program, "companions" {".dat": text}; else they are declared in the one
    routine that uses them, and what several routines share stands in a list behind the program. `forms`: moves as
    inline forms, whose data need such a list.
    """
    del date
    return KrlWriter(program, pair, forms).written()


@dataclass(frozen=True, slots=True)
class KrlRoutineText:
    """One routine as the template sees it. Texts of several lines end with a line end."""

    above: str  # &ACCESS lines and comments that stand before it
    head: str  # DEF NAME ( )
    declarations: str
    instructions: str
    end: str
    below: str


class KrlWriter(KrlMoves):
    """Writes statements, routines and the list of data."""

    templates: ClassVar = {
        st.SetOutput: "{signal}={value}",
        st.Dwell: "WAIT SEC {duration}",
        st.Label: "{name}:",
        st.Return: "RETURN{value: {}}",
        st.If: "IF {condition} THEN",
        st.ElseIf: "ELSEIF {condition} THEN",
        st.Else: "ELSE",
        st.EndIf: "ENDIF",
        st.For: "FOR {variable}={start} TO {stop}{step: STEP {}}",
        st.Next: "ENDFOR",
        st.Repeat: "REPEAT",
        st.Until: "UNTIL {condition}",
        st.Break: "EXIT",
        st.Switch: "SWITCH {value}",
        st.Case: "CASE {values}",
        st.Default: "DEFAULT",
        st.EndSwitch: "ENDSWITCH",
        st.Pause: "HALT",
        st.Comment: ";{text}",
    }
    cannot: ClassVar = {st.Call: {"macro": "a macro by its number"}}
    own_only: ClassVar = {
        st.Opaque: "a statement of another language",
    }
    step = "  "
    deepest = 20
    comment_form = " ;{}"
    joins = frozenset({*MODAL, st.Process})
    follows_branches = True
    forgets = CLOSES | BRANCHES | {st.While, st.For, st.Repeat, st.Label, st.Call}

    def __init__(self, program: st.Program, pair: bool, forms: bool = False) -> None:
        strings = {one.name for one in program.declarations() if one.type == "string"}
        strings |= {p.name for routine in program.routines for p in routine.parameters if p.type == "string"}
        super().__init__(program, _scope_of(program), frozenset(strings))
        self.pair = pair
        main = program.main
        ordered = sorted(program.routines, key=lambda one: bool(main) and one.name != main)
        self.routines = list(program.routines) if self.own else ordered
        self.offered = frozenset() if self.own else _uncalled(program, self.routines)
        if not self.own:
            self.rated = frozenset(
                s.path is st.Path.JOINT
                for s in program.statements()
                if type(s) is st.Move and not (s.acceleration is None and s.rate is None)
            )
            self.turns = any(type(s) is st.Move and says_turning(s) for s in program.statements())
        if forms and pair and not self.own:
            self.forms = InlineForms(program, self.scope, self.quantity)
            self.spelt = self.forms.names
            self.decimals = DECIMALS
            self.turning = self._one_turning()

    # --- values, signals and time -----------------------------------------------------------------------

    def write_assign(self, s: st.Assign) -> Lines:
        if not self.own and self._is_text(s.value) and not self._is_text(s.target):
            raise CannotSayError("a text in a variable of another type")
        if texts.is_put_together(s.value):
            return self._put_together(self.target(s.target), s.value)
        if type(s.target) is ex.SystemValue and s.target.name in ("timer", "timer-running"):
            return self._clock(s.target, s.value)
        before, s = self.computed(s)
        if not self.own and isinstance(s.target, ex.FrameRef):
            self.forget()
            return [*before, f"{self.value(s.target)}={self.value(s.value)}"]
        return [*before, f"{self.target(s.target)}={self.value(s.value)}"]

    def _is_text(self, e: ex.Expression) -> bool:
        name = e.base if isinstance(e, ex.Item) else e
        if isinstance(name, ex.Named):
            return name.name in self.strings
        constant = isinstance(e, ex.Text) and e.value[:1] != "#"
        return constant or texts.is_put_together(e)

    def spell_compare(self, e: ex.Compare) -> Spelled:
        """`==` compares no arrays of CHAR: texts are compared by StrComp, as KUKA's own bas.src does."""
        if self.own or e.operator not in ("=", "<>") or not (self._is_text(e.left) or self._is_text(e.right)):
            return super().spell_compare(e)
        same = ex.Function("same-text", (e.left, e.right))
        return self.spell_function(same) if e.operator == "=" else self.spell_unary(ex.Unary("not", same))

    def _clock(self, clock: ex.SystemValue, value: ex.Expression) -> str:
        """A clock is set, in ms, or started and stopped."""
        if clock.name == "timer-running":
            on = not value.on if isinstance(value, ex.SignalState) else None
            stopped = self.value(ex.Unary("not", value)) if on is None else self.value(ex.SignalState(on))
            return f"$TIMER_STOP[{clock.index}]={stopped}"
        if isinstance(value, ex.Number):
            return f"$TIMER[{clock.index}]={round(value.value * 1000)}"
        in_ms = isinstance(value, ex.Binary) and value.operator == "/" and value.right == ex.Number(1000)
        milliseconds = value.left if in_ms else ex.Binary("*", value, ex.Number(1000))  # type: ignore[union-attr]
        return f"$TIMER[{clock.index}]={self.value(milliseconds)}"

    def write_message(self, s: st.Message) -> Lines:
        if not texts.is_put_together(s.text):
            return f"MsgNotify({self.value(s.text)})"
        return [*self._put_together(_WHOLE_TEXT, s.text), f"MsgNotify({_WHOLE_TEXT})"]

    def _put_together(self, target: str, e: ex.Expression) -> list[str]:
        """A text of several parts; in an array of its own first where one of them is the target itself."""
        first, *later = texts.parts_of(e)
        later += [first] if texts.is_written(first) else []
        if target.endswith("[]") and not any(
            self.value(x) == target for part in later for x in expressions_of(part) if type(x) is ex.Named
        ):
            return texts.lines(target, e, self.value)
        return [*texts.lines(_WHOLE_TEXT, e, self.value), f"{target}={_WHOLE_TEXT}"]

    def write_pulse_output(self, s: st.PulseOutput) -> Lines:
        time = _PULSE if s.duration is None else self.seconds(s.duration)
        state = "FALSE" if s.spelling == "FALSE" else "TRUE"
        if self.own and s.condition is not None:
            state = self.value(s.condition)
        return f"PULSE ({self.signal(s.signal)},{state},{time})"

    def under(self, condition: ex.Expression, lines: list[str], s: st.Statement) -> list[str]:
        if self.own and isinstance(s, st.PulseOutput):
            return lines  # there the condition is the state
        return [f"IF {self.condition(condition)} THEN", *(f"  {line}" for line in lines), "ENDIF"]

    def write_wait(self, s: st.Wait) -> Lines:
        if s.timeout is None:
            return f"WAIT FOR {self.condition(s.condition)}"
        return self._polled(s, continued=False)

    def _polled(self, s: st.Wait, continued: bool) -> list[str]:
        """A wait with a limit, which KRL does not have: a loop that asks. `continued`: CONTINUE before each reading."""
        assert s.timeout is not None
        condition, limit = self.value(ex.Unary("not", s.condition)), self.seconds(s.timeout)
        ahead = ["CONTINUE"] if continued else []
        return [
            "WAITED=0.0",
            *ahead,
            f"WHILE {condition} AND (WAITED<{limit})",
            f"  WAIT SEC {_POLL}",
            f"  WAITED=WAITED+{_POLL}",
            "ENDWHILE",
            *ahead,
            f"TIMED_OUT={condition}",
        ]

    def write_external_tool(self, s: st.ExternalTool) -> Lines:
        return f"$IPO_MODE={'#BASE' if s.tool is None else '#TCP'}"

    # --- flow -------------------------------------------------------------------------------------------

    def write_jump(self, s: st.Jump) -> Lines:
        if not isinstance(s.target, str):
            raise CannotSayError("a jump to a computed label", "write it as SWITCH")
        return f"GOTO {s.target}"

    def write_return(self, s: st.Return) -> Lines:
        if s.value is None:
            return "RETURN"
        before, s = self.computed(s)
        assert s.value is not None
        return [*before, f"RETURN {self.value(s.value)}"]

    def write_call(self, s: st.Call) -> Lines:
        before, s = self.computed(s)
        text = f"{s.routine} ({self.handed(s.routine, s.arguments)})"
        line = text if s.result is None else f"{self.target(s.result)}={text}"
        return [*before, line, *(["RETURN"] if s.jump else [])]

    def write_while(self, s: st.While) -> Lines:
        line = "LOOP" if s.condition == ex.SignalState(True) else f"WHILE {self.condition(s.condition)}"
        self.ends.append("ENDLOOP" if line == "LOOP" else "ENDWHILE")
        return line

    def write_end_while(self, s: st.EndWhile) -> Lines:
        return self.ends.pop() if self.ends else "ENDWHILE"

    # --- the language's own -----------------------------------------------------------------------------

    def write_process(self, s: st.Process) -> Lines:
        if not self.own and (watched := interrupts.written(s, self.value)):
            return watched
        if not self.own and s.name not in ("continue", "BRAKE"):
            raise CannotSayError(f"the process instruction {s.name}")
        if s.name == "ENDSPLINE":
            return self.end_block()
        self.in_block = self.in_block or s.name in ("SPLINE", "PTP_SPLINE")
        if s.name == "TIME_BLOCK":
            value = [self.value(one) for word, one in s.arguments if word == "="]
            return f"TIME_BLOCK {self.value(s.arguments[0][1])}{'=' + value[0] if value else ''}"
        if not s.arguments:
            return s.name
        text = s.arguments[0][1]
        assert isinstance(text, ex.Text)
        return text.value

    def write_declare(self, s: st.Declare) -> Lines:
        """In KRL a program's declarations come first and take no values: these are assigned."""
        if self.own:
            return [self.declared(s, with_value=True), *self.elements(s)]
        self.declarations.append(self.declared(s, with_value=False) + _behind(s.comment))
        if s.value is None:
            return []
        if s.sizes or s.type == "string":
            return list(self.elements(s))
        return f"{s.name}={self.value(s.value)}"

    # --- bodies -----------------------------------------------------------------------------------------

    def together(self, body: Sequence[st.Statement], place: int) -> Joined | None:
        """The call of BAS that statements of KRL's own programs stand for, or what CONTINUE stands before."""
        if isinstance(s := body[place], st.Process):
            wait = body[place + 1] if s.name == "continue" and place + 1 < len(body) else None
            if isinstance(wait, st.Wait) and wait.timeout is not None:
                return Joined(self._polled(wait, continued=True), 2, wait.comment)
            if isinstance(wait, (st.Assign, st.Call, st.Return)) and not self.own:
                return Joined(_continued(self.lines(wait)), 2, wait.comment)
            return None
        taken = self.bas.call(body, place) if self.own else None
        if taken is None:
            return None
        count, line = taken
        self.forget()
        return Joined([line], count, getattr(body[place + count - 1], "comment", ""))

    def add(self, s: st.Statement, lines: list[str]) -> None:
        if isinstance(s, (st.Begin, st.End)):
            self.rows += [f";{s.comment}"] if s.comment else []
            return
        if self.own:
            self.bas.follow(s)
            if isinstance(s, st.Declare):
                self.rows += [lines[0] + _behind(s.comment), *lines[1:]]
                return
        if isinstance(s, (st.SetSpeed, st.SetAcceleration)) and lines:
            lines[0] += _behind(s.comment)
            self.put(lines)
            return
        if type(s) is st.Move and s.comment and lines[-1] == END_OF_FORM:
            self.put([f";{s.comment}", *lines])
            return
        super().add(s, lines)

    # --- routines ---------------------------------------------------------------------------------------

    def _routine(self, routine: st.Routine, data: Sequence[st.Declare]) -> KrlRoutineText:
        """`data`: what is declared in the routine because no other one uses it."""
        self.begin()
        self.ends: list[str] = []
        self.declarations: list[str] = []
        self.bas = BasCalls(self.scope, self)
        details = routine.details if self.own else {}
        framing = framing_comments(routine, self.own)
        statements = list(framing.body)
        above, head = [*([details["above"]] if "above" in details else []), *_rows(framing.above)], ""
        try:
            head = self._head(routine)
            self.declarations += self.parameter_rows(routine.parameters)
        except CannotSayError as problem:
            self.lose(problem, routine.line)
        if self._moves_first(routine):
            self.rows += _INI if self.forms is None else initialisation(self._settings_of(statements))
            self.initialised()
        self.body(data)
        self.body(statements)
        waits = any(isinstance(one, st.Wait) and one.timeout is not None for one in routine.body)
        if any(_WHOLE_TEXT in row for row in self.rows):
            self.temporaries[_WHOLE_TEXT.replace("]", f"{self.text_length}]")] = "CHAR"
        used = "\n".join(self.rows)
        put = {} if self.own else {name: word for name, word in texts.HELPERS.items() if name in used}
        added = {**(_HELPERS if waits else {}), **put, **self.temporaries}
        self.declarations += [f"DECL {word} {name}" for name, word in added.items()]
        return KrlRoutineText(
            above=as_text(above)
            or (self._header(routine.comment) if routine is self.routines[0] and not self.own else ""),
            head=head + _behind(routine.comment if self._told_behind(routine) else framing.head),
            declarations=as_text(self.declarations),
            instructions=as_text(self.rows),
            end=("ENDFCT" if routine.returns else "END") + _behind(framing.end),
            below=as_text(_rows(framing.below)),
        )

    def _head(self, routine: st.Routine) -> str:
        offered = routine.starts or routine.name in self.offered
        shared = "GLOBAL " if offered or ("GLOBAL" in routine.details and self.own) else ""
        given = self.parameters_text(routine.parameters)
        if routine.returns:
            word = _TYPES.get(routine.returns) or routine.returns
            text = f"[{self.text_length}]" if routine.returns == "string" and not self.own else ""
            return f"{shared}DEFFCT {word}{routine.details.get('array', text)} {routine.name} ({given})"
        return f"{shared}DEF {routine.name} ({given or ' '})"

    def _moves_first(self, routine: st.Routine) -> bool:
        """Whether a program of another language starts with this routine, and moves: KRL's own says itself how."""
        first = self.program.main or self.routines[0].name
        if routine.name != first and not routine.starts:
            return False
        rows = self.program.statements() if routine.name == first else routine.body
        return not self.own and any(type(s) is st.Move for s in rows)

    def _header(self, comment: str = "") -> str:
        """What stands before the first head. `comment`: what the controller's list of programs shows."""
        text = _HEADER if self.forms is None else HEADER_OF_FORMS
        return text.replace(_REL, f"{_REL}&COMMENT {comment}\n") if comment else text

    def _told_behind(self, routine: st.Routine) -> bool:
        """Whether the routine's comment stands behind its head: a file has one, for its first routine."""
        return bool(routine.comment) and not self.own and routine is not self.routines[0]

    def _one_turning(self) -> str:
        """$VEL.ORI1 and 2 where all moves that say them say the same, else ""."""
        found = set()
        for s in self.program.statements():
            if type(s) is st.Move and s.turn is not None:
                found.add(self.quantity(s.turn, deg))
            elif type(s) is st.SetSpeed or (type(s) is st.Move and s.path is not st.Path.JOINT):
                return ""
        return found.pop() if len(found) == 1 else ""

    def _settings_of(self, statements: list[st.Statement]) -> list[str]:
        """What belongs into the INI fold: how fast the tool turns; tools and frames, which the body then lacks."""
        rows = [f"$VEL.ORI{n}={self.turning}" for n in (1, 2)] if self.turning else []
        start = next(
            (at for at, s in enumerate(statements) if not isinstance(s, (st.Begin, st.Declare))), None
        )
        end = start = len(statements) if start is None else start
        while end < len(statements) and _is_system(statements[end], end == start):
            if isinstance(s := statements[end], st.Assign):
                rows += [f"{line}{_behind(s.comment)}" for line in self.lines(s)]
            end += 1
        del statements[start:end]
        return rows

    # --- the whole program ------------------------------------------------------------------------------

    def template_values(self) -> dict[str, object]:
        local, shared = self._places()
        texts = tuple(self._routine(one, local.get(one.name, ())) for one in self._programs())
        list_text = self._list(shared)
        values: dict[str, object] = {"routines": texts, "list": "" if self.pair else list_text}
        if self.pair and list_text:
            values["companions"] = {".dat": list_text}
        return values

    def _programs(self) -> list[st.Routine]:
        return [one for one in self.routines if "list" not in one.details or not self.own]

    def _places(self) -> tuple[dict[str, tuple[st.Declare, ...]], list[st.Declare]]:
        """(data declared in a routine, by its name; data of the list)."""
        rows = [one for one in self.program.data if not is_of_config(one)]
        rows += [one for routine in self.routines for one in routine.data]
        if self.pair or self.own:
            return {}, rows
        local: dict[str, tuple[st.Declare, ...]] = {}
        shared: list[st.Declare] = []
        users = _users(self.program)
        first = self.routines[0].name if self.routines else ""
        for one in rows:
            names, assigned = users.get(one.name, (set(), False))
            if len(names) == 1 and (not assigned or names == {first}):
                local[next(iter(names))] = (*local.get(next(iter(names)), ()), one)
            else:
                shared.append(one)
        return local, shared

    def _list(self, rows: list[st.Declare]) -> str:
        lists = [one for one in self.routines if "list" in one.details] if self.own else []
        details = next((one.details for one in self.routines if "data head" in one.details and self.own), {})
        alone = not self.routines
        seen = set() if self.own else self._seen(rows)
        if not (rows or lists or details or alone or (self.forms is not None and self.forms.rows())):
            return ""
        owner = lists[0] if lists else None
        stem = (
            PureWindowsPath(self.program.path.replace("/", "\\")).stem
            if self.own and self.program.path
            else ""
        )
        name = owner.name if owner else (self.program.main or stem or self._first_name())
        above = owner.details.get("above", "") if owner else details.get("data above", "")
        public = (
            " PUBLIC" if alone or seen or (owner is not None and owner.details["list"] == "PUBLIC") else ""
        )
        head = [details.get("data head", f"DEFDAT {name}{public}")]
        if self.forms is not None:
            head += EXTERNAL
        if "data rows" in details:
            head.append(details["data rows"])
        written: list[str] = []
        for one in rows:
            try:
                written += self.list_rows([one], alone or one.name in seen)
                if self.forms is not None:
                    written += self.forms.rows_behind(one.name)
            except CannotSayError as problem:
                self.lose(problem, one.line)
        if self.forms is not None:
            written += self.forms.rows()
        return (above + "\n" if above else "" if self.own else self._header()) + as_text(
            [*head, *written, "ENDDAT"]
        )

    def _seen(self, rows: list[st.Declare]) -> set[str]:
        """Data that other programs of the source see, and may change: tools and frames where this one does so."""
        users = _users(self.program)
        return {
            one.name
            for one in rows
            if one.storage == "persistent" and one.shared
            if one.type not in ("tool", "frame") or users.get(one.name, (set(), False))[1]
        }

    def _first_name(self) -> str:
        return self.routines[0].name if self.routines else "PROGRAM"


def _uncalled(program: st.Program, routines: Sequence[st.Routine]) -> frozenset[str]:
    """Routines that nothing in the program calls: they are there for other files, which see GLOBAL ones alone."""
    called = {s.routine.casefold() for s in program.statements() if type(s) is st.Call}
    called |= {
        e.routine.casefold()
        for s in program.statements()
        for e in expressions_of(s)
        if type(e) is ex.CallValue
    }
    return frozenset(r.name for r in routines[1:] if r.shared and r.name.casefold() not in called)


def _is_system(s: st.Statement, first: bool) -> bool:
    """A tool or frame that is set by its number; `first`: or the comment above them."""
    if isinstance(s, st.Comment):
        return first and s.text == terminology.SYSTEMS_ARE_SET
    return type(s) is st.Assign and type(s.target) is ex.FrameRef


def _scope_of(program: st.Program) -> Scope:
    """Types and values of all data, as the reader would know them."""
    scope = Scope()
    for one in program.declarations():
        native = one.native.removesuffix(CONFIG_MARK) if program.vendor == "krl" else ""
        scope.declare(one.name, native or _TYPES.get(one.type, one.type.upper()), bool(one.sizes))
        if one.native == "STRUC":
            members = getattr(one.value, "members", ())
            scope.structures[one.name.upper()] = {name.upper(): it.type for name, it in members}
    for one in (*program.data, *(one for routine in program.routines for one in routine.data)):
        if one.value is not None:
            scope.values[one.name.upper()] = one.value
    for routine in program.routines:
        for given in routine.parameters:
            word = given.native.removesuffix("[]") if program.vendor == "krl" else ""
            scope.declare(given.name, word or _TYPES.get(given.type, ""), given.native.endswith("[]"))
    return scope


def _users(program: st.Program) -> dict[str, tuple[set[str], bool]]:
    """Name -> (the routines that use it, whether one of them assigns it)."""
    found: dict[str, tuple[set[str], bool]] = {}
    for routine in program.routines:
        for one in routine.body:
            for name, assigned in _names_in(one):
                names, before = found.get(name, (set(), False))
                found[name] = (names | {routine.name}, before or assigned)
    return found


def _names_in(statement: st.Statement) -> Iterator[tuple[str, bool]]:
    """(name, whether the statement may change it); what a call is given may be changed by it."""
    changed: set[str] = set()
    if isinstance(statement, _CHANGES):
        changed = {_stored(statement.target)}
    elif isinstance(statement, st.For):
        changed = {_stored(statement.variable)}
    elif isinstance(statement, st.Call):
        changed = {name for one in (*statement.arguments, statement.result) for name in _names(one)}
    for name in set(_names(statement)):
        yield name, name in changed


def _stored(it: Any) -> str:
    while isinstance(it, (ex.Item, ex.Member)):
        it = it.base
    return it.name if isinstance(it, ex.Named) else ""


def _names(it: Any) -> Iterator[str]:
    if type(it) is ex.Named:
        yield it.name
    elif isinstance(it, tuple):
        for one in it:
            yield from _names(one)
    elif is_dataclass(it) and not isinstance(it, type):
        for field in fields(it):
            yield from _names(getattr(it, field.name))


def _rows(comments: Sequence[str]) -> list[str]:
    return [f";{one}" for one in comments]


def _behind(comment: str) -> str:
    return f" ;{comment}" if comment else ""
