"""The base of all writers: a language is a subclass with tables, and methods for what no table can say.

    class Toy(Generator):
        language = "TOY"
        binary = {"+": (" + ", 1), "*": (" * ", 2)}
        logic = {"and": (" AND ", 1)}
        comparisons = {"=": "=", "<": "<"}
        templates = {st.If: "IF {condition} THEN", st.Dwell: "WAIT {duration}", st.Label: "{name}:"}
        cannot = {st.Call: {"macro": "a macro by its number"}}

        def write_assign(self, s: st.Assign) -> Lines:
            return f"{self.target(s.target)} = {self.value(s.value)}"

Each kind of expression is spelled by `spell_KIND`, each kind of statement written by a template or by `write_KIND`,
where KIND is the class in snake case (`spell_position_literal`, `write_set_output`); a subclass overrides what
differs. Whatever the language cannot say raises CannotSayError, which becomes an error (X002) in the statement's line.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import lru_cache
from operator import attrgetter
from string import Formatter
from typing import Any, ClassVar, Final, NamedTuple, TypeVar, get_args

from olp.core.diagnostic import Diagnostic, Span, error
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import changed_by, expressions_of
from olp.languages.vendor import ENDS_PROGRAM, Weld, language_of

ATOM: Final = 99  # binds stronger than any operation: names, numbers, what has brackets of its own
OPENS: Final[frozenset[type]] = frozenset({st.If, st.While, st.For, st.Repeat, st.Switch})
BRANCHES: Final[frozenset[type]] = frozenset({st.Else, st.ElseIf, st.Case, st.Default})
CLOSES: Final[frozenset[type]] = frozenset({st.EndIf, st.EndWhile, st.Next, st.Until, st.EndSwitch})
# Statements that may hold under a condition only.
CONDITIONAL: Final[frozenset[type]] = frozenset(
    {st.Jump, st.Call, st.Return, st.Pause, st.PulseOutput, st.StartTask}
)
_DEEPER: Final = OPENS | BRANCHES
_SETS: Final = frozenset({st.Assign, st.Update, st.ReadInput, st.Clear})
_SHALLOWER: Final = CLOSES | BRANCHES
_MOST_DECIMALS: Final = 9
LARGEST_WHOLE: Final = 2**31 - 1  # of 32 bits
_WORD = re.compile(r"(?<!^)(?=[A-Z])")

Lines = str | list[str]
Spelled = str | tuple[str, int]  # a text, and how strongly it binds where that is less than an atom
Refusal = str | tuple[str, str]  # what cannot be said, and what could be done instead
It = TypeVar("It")


class CannotSayError(Exception):
    """Raised where the language cannot express something. `help`: what the user can do about it."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


class Joined(NamedTuple):
    """Several statements written as one instruction: its lines, the number of statements it covers, and their
    comment.
    """

    lines: list[str]
    taken: int
    comment: str = ""


# --- numbers ----------------------------------------------------------------------------------------------


@lru_cache(maxsize=50_000)
def decimal(value: float, at_least: int = 0, holder: str = "program") -> str:
    """`value` as a decimal fraction with that many decimals, more where it has more; never "-0", never an exponent.

    >>> decimal(187.0, 1), decimal(0.125, 1), decimal(-0.0)
    ('187.0', '0.125', '0')
    """
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a {holder} can hold")
    text = f"{value:.{at_least}f}"
    if float(text) != value:
        text = f"{value:.{_MOST_DECIMALS}f}".rstrip("0")
        text += "0" * (at_least - len(text.partition(".")[2]))
    return text.lstrip("-") if not text.strip("-0.") else text.rstrip(".")


def without_noise(value: float) -> float:
    """Return `value` rounded to nine significant digits, which removes the rounding errors of a unit conversion."""
    return float(f"{value:.9g}")


# --- the base ---------------------------------------------------------------------------------------------


class Generator(ABC):
    """Writes one program in one language.

    Tables of a language (a subclass of a language merges its statements' tables over them):

    `language`: its name in refusals. `binary`, `logic`: operator -> (its text, how strongly it binds). `unary`:
    operator -> (template of the operand, how strongly it binds, how strongly the operand has to). `comparisons`:
    operator -> its text where that differs; `compared`: how strongly a comparison binds, and its operands have to.
    `functions`: neutral function -> the language's word; a method `function_pose_offset` gets the function's arguments
    instead. `signals`: neutral bus -> word, for `IN[3]`; other brackets are a `spell_signal`. `states`: the words for
    off and on. `singles`: the kinds of expressions that `single` takes.

    `templates`: statement -> its line; `{field}` is the statement's field in the language's words, `{field: STEP {}}`
    stands only where the field has a value, "" is no line. `fields`: the method that spells a field, "*" of all others.
    `cannot`: statement -> field -> the refusal where that field is set. `own_only`: statement -> the refusal where
    it comes from another language; `{s.name}` in it is the statement's field, `{called}` what people call it,
    `{self.source_language}` the language that it is from.

    `welds`: instructions of the language's own that are written for other languages, too.

    `step`: the indent of one level, from `first_depth` on, never less than `least_depth`, never more than `deepest`
    levels. `comment_form`: a comment behind a line; `comment_row`: which line of a statement has it. `forgets`:
    statements after which it is not known what holds: they empty `holds`, where a writer keeps the texts of modal
    settings that it has written, under names of its own. `joins`: statements that `together` is asked about.
    """

    language: ClassVar[str]
    binary: ClassVar[Mapping[str, tuple[str, int]]] = {}
    unary: ClassVar[Mapping[str, tuple[str, int, int]]] = {}
    logic: ClassVar[Mapping[str, tuple[str, int]]] = {}
    comparisons: ClassVar[Mapping[str, str]] = {}
    compared: ClassVar[tuple[int, int]] = (3, 4)
    operator_help: ClassVar[str] = ""
    functions: ClassVar[Mapping[str, str]] = {}
    signals: ClassVar[Mapping[str, str]] = {}
    first_signal: ClassVar = 0  # the least number that a signal has
    states: ClassVar[tuple[str, str]] = ("FALSE", "TRUE")
    parentheses: ClassVar[tuple[str, str]] = ("(", ")")
    separator: ClassVar[str] = ","
    quotes: ClassVar[str] = '"'
    not_in_text: ClassVar[frozenset[str]] = frozenset('"\r\n')
    no_text: ClassVar[Refusal] = 'a text that holds " or a line end'
    no_value: ClassVar[Refusal] = "a value of a kind that the language does not have"
    singles: ClassVar[frozenset[type]] = frozenset()  # kinds of expressions that `single` takes

    templates: ClassVar[Mapping[type, str]] = {st.Begin: "", st.End: "", st.Opaque: "{text}"}
    fields: ClassVar[Mapping[str, str]] = {
        "*": "value",
        "condition": "condition",
        "signal": "signal",
        "duration": "seconds",
        "timeout": "seconds",
        "target": "target",
        "variable": "target",
        "result": "target",
        "values": "arguments",
        "arguments": "arguments",
    }
    cannot: ClassVar[Mapping[type, Mapping[str, Refusal]]] = {}
    own_only: ClassVar[Mapping[type, str]] = {}
    welds: ClassVar[tuple[Weld, ...]] = ()

    step: ClassVar[str] = ""
    first_depth: ClassVar[int] = 0
    least_depth: ClassVar[int] = 0
    deepest: ClassVar[int] = 1_000
    comment_form: ClassVar[str] = ""
    comment_row: ClassVar[int] = -1
    forgets: ClassVar[frozenset[type]] = frozenset()
    joins: ClassVar[frozenset[type]] = frozenset()
    follows_branches: ClassVar[bool] = (
        False  # what holds is followed through branches, and not forgotten there
    )

    _spellers: ClassVar[dict[type, Callable[[Any, Any], Spelled]]] = {}
    _writers: ClassVar[dict[type, Callable[[Any, Any], Lines]]] = {}
    _functions: ClassVar[dict[str, Callable[..., Spelled]]] = {}

    def __init_subclass__(cls) -> None:
        """Puts the tables and methods of the class and its bases together."""
        super().__init_subclass__()
        cls._spellers = dict.fromkeys(get_args(ex.Expression), Generator.spell_other)
        cls._writers, cls._functions = {}, {}
        spelled_as = _merged(cls, "fields")
        expressions = {_snake(kind): kind for kind in get_args(ex.Expression)}
        statements = {_snake(kind): kind for kind in get_args(st.Statement)}
        for base in reversed(cls.__mro__):
            for kind, template in base.__dict__.get("templates", {}).items():
                cls._writers[kind] = _filled(kind, template, spelled_as)
            for name, method in base.__dict__.items():
                verb, _, what = name.partition("_")
                if verb == "spell" and what in expressions:
                    cls._spellers[expressions[what]] = method
                elif verb == "write" and what in statements:
                    cls._writers[statements[what]] = method
                elif verb == "function":
                    cls._functions[what.replace("_", "-")] = method
        own_only, cannot = _merged(cls, "own_only"), _merged(cls, "cannot")
        for kind in {*cls._writers, *own_only, *cannot}:
            write = cls._writers.get(kind, _unsaid)
            cls._writers[kind] = _checked(kind, write, own_only.get(kind), cannot.get(kind, {}))

    def __init__(self, program: st.Program, own: bool, date: str = "") -> None:
        """`own`: the program was read from this language, so words that only it knows mean something.

        `date`: YYYY/MM/DD HH:MM, for programs that have none.
        """
        self.program = program
        self.own = own
        self.date = date
        self.problems: list[Diagnostic] = []
        self.rows: list[str] = []
        self.depth = 0
        self.holds: dict[str, object] = {}  # modal settings that are known to hold here
        self._texts: dict[int, tuple[object, str]] = {}
        self._changed_by: dict[str, frozenset[str]] | None = None

    @property
    def source_language(self) -> str:
        """Return the name of the language that the program was read from, such as INFORM (the last word of the
        vendor's title).
        """
        return language_of(self.program.vendor)

    def _welds(self, s: object) -> bool:
        return isinstance(s, st.Process) and any(weld.number(s) is not None for weld in self.welds)

    def written(self) -> tuple[dict[str, object], list[Diagnostic]]:
        """Return the values for the language's template, and an error (X002) for everything that the language
        cannot express.
        """
        return self.template_values(), self.problems

    @abstractmethod
    def template_values(self) -> dict[str, object]:
        """Return the values for the language's jinja2 template; errors are added to `problems`."""

    def lose(self, problem: CannotSayError, line: int) -> None:
        """Add an error (X002) for a line of the source."""
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"{self.language} cannot express this: {problem}"
        path = self.program.path
        self.problems.append(error("X002", message, span, file=path, source_line=text, help=problem.help))

    # --- expressions --------------------------------------------------------------------------------------

    def value(self, e: ex.Expression, strength: int = 0) -> str:
        """The expression as text, in parentheses where it binds less than `strength`. Raises CannotSayError."""
        found = self._spellers[type(e)](self, e)
        if isinstance(found, str):
            return found
        text, own = found
        return self.enclosed(text) if own < strength else text

    def enclosed(self, text: str) -> str:
        """In parentheses."""
        return f"{self.parentheses[0]}{text}{self.parentheses[1]}"

    def condition(self, e: ex.Expression, strength: int = 0) -> str:
        """What is true or false; most languages spell it as any value."""
        return self.value(e, strength)

    def target(self, e: ex.Expression) -> str:
        """What a value is stored in."""
        return self.value(e)

    def single(self, e: ex.Expression) -> str:
        """A value that nothing is computed for."""
        if type(e) not in self.singles:
            raise refusal(self.no_value)
        return self.value(e)

    def number_of(self, e: ex.Expression) -> ex.Expression:
        """The number of a variable, where a routine is told in which one it has to put its value."""
        if not isinstance(e, ex.Variable):
            raise CannotSayError("the value that a routine returns")
        return e.index

    def at_most_arguments(self, number: int, most: int) -> None:
        """Raises CannotSayError where a call gives, or a routine takes, more arguments than controllers pass."""
        if number > most and not self.own:
            raise CannotSayError(
                f"a routine with more than {most} arguments", "pass some of them in variables"
            )

    def arguments(self, given: Sequence[ex.Expression]) -> str:
        return self.separator.join(map(self.value, given))

    @abstractmethod
    def quantity(self, it: ex.Quantity, unit: float) -> str:
        """A number with a unit; `unit`: SI per written unit."""

    def seconds(self, it: ex.Quantity) -> str:
        return self.quantity(it, 1.0)

    def number(self, e: ex.Number) -> str:
        """A literal: 12 stays whole, 12.0 keeps its point; beyond 32 bits there are no whole numbers."""
        if isinstance(e.value, float):
            return decimal(e.value, 1)
        return f"{int(e.value)}.0" if abs(e.value) > LARGEST_WHOLE and not self.own else str(int(e.value))

    def signal(self, e: ex.Signal) -> str:
        """`IN[3]`: an input, output, group or register. Raises CannotSayError for a bus that `signals` lacks."""
        return f"{self.signal_word(e)}[{self.value(e.index)}]"

    def signal_word(self, e: ex.Signal) -> str:
        """The word of the signal's bus. Raises CannotSayError for a number that no signal has."""
        if type(e.index) is ex.Number and e.index.value < self.first_signal and not self.own:
            raise CannotSayError(f"a signal with the number {e.index.value:g}")
        word = self.signals.get(e.bus)
        if word is None:
            raise CannotSayError(*terminology.signal(e))
        return word

    def spell_other(self, e: ex.Expression) -> Spelled:
        raise refusal(self.no_value)

    def spell_number(self, e: ex.Number) -> Spelled:
        return self.number(e)

    def spell_text(self, e: ex.Text) -> Spelled:
        if not self.not_in_text.isdisjoint(e.value):
            raise refusal(self.no_text)
        return f"{self.quotes}{e.value}{self.quotes}"

    def spell_signal_state(self, e: ex.SignalState) -> Spelled:
        return self.states[e.on]

    def spell_named(self, e: ex.Named) -> Spelled:
        return e.name

    def spell_unknown(self, e: ex.Unknown) -> Spelled:
        if not self.own:
            raise CannotSayError(f"the word {e.text}" if e.text else "a value that is left out")
        return e.text

    def spell_signal(self, e: ex.Signal) -> Spelled:
        return self.signal(e)

    def spell_call_value(self, e: ex.CallValue) -> Spelled:
        return f"{e.routine}({self.arguments(e.arguments)})"

    def spell_unary(self, e: ex.Unary) -> Spelled:
        found = self.unary.get(e.operator)
        if found is None:
            raise CannotSayError(terminology.operation(e.operator), self.operator_help)
        form, own, wanted = found
        spell = self.operand if e.operator == "not" else self.value
        return form.replace("{}", spell(e.operand, wanted)), own

    def spell_binary(self, e: ex.Binary) -> Spelled:
        found = self.binary.get(e.operator)
        if found is None:
            raise CannotSayError(terminology.operation(e.operator), self.operator_help)
        text, own = found
        right = self.value(e.right, own + 1)
        if e.operator in "*/" and _begins_with_sign(e.left):
            own = min(own, self.unary.get("-", ("", own, own))[1])
        return f"{self.value(e.left, own)}{text}{right}", own

    def spell_compare(self, e: ex.Compare) -> Spelled:
        own, wanted = self.compared
        word = self.comparisons.get(e.operator, e.operator)
        return f"{self.value(e.left, wanted)}{word}{self.value(e.right, wanted)}", own

    def spell_logic(self, e: ex.Logic) -> Spelled:
        """From left to right; where AND follows OR, what stands before goes into parentheses."""
        missing = [operator for operator, _ in e.rest if operator not in self.logic]
        if missing:
            raise CannotSayError(terminology.operation(missing[0]), self.operator_help)
        text, bound = self.operand(e.first, self.logic[e.rest[0][0]][1] if e.rest else 0), ATOM
        for operator, operand in e.rest:
            word, own = self.logic[operator]
            left = text if bound >= own else self.enclosed(text)
            text, bound = f"{left}{word}{self.operand(operand, own + 1)}", own
        return text, bound

    def operand(self, e: ex.Expression, strength: int) -> str:
        """An operand of AND, OR and NOT."""
        return self.value(e, strength)

    def spell_function(self, e: ex.Function) -> Spelled:
        """By its method, `function_pose_offset`, or its word; else it is refused."""
        special = self._functions.get(e.name)
        if special is not None:
            return special(self, e.arguments)
        word = self.functions.get(e.name)
        if word is None:
            raise CannotSayError(terminology.function(e.name))
        return f"{word}({self.arguments(e.arguments)})"

    # --- statements ---------------------------------------------------------------------------------------

    def lines(self, s: st.Statement) -> list[str]:
        """The lines of one statement, without indent and comment. Raises CannotSayError."""
        found = self._writers.get(type(s), _unsaid)(self, s)
        return [found] if isinstance(found, str) else found

    def under(self, condition: ex.Expression, lines: list[str], s: st.Statement) -> list[str]:
        """The lines of a statement that holds under a condition only: a block by default."""
        opening = self.lines(st.If(s.line, condition))
        return [*opening, *(f"{self.step}{line}" for line in lines), *self.lines(st.EndIf(s.line))]

    def once(self, it: It, spell: Callable[[It], str]) -> str:
        """What `spell` makes of a speed or a blend; statements share these objects, so each is spelled once."""
        known = self._texts.get(id(it))
        if known is None:
            known = self._texts[id(it)] = (it, spell(it))  # the object is kept, so that its id stays its own
        return known[1]

    def forget(self) -> None:
        """From here on nothing is known to hold: a label, a block or a call came before."""
        self.holds.clear()

    # --- bodies -------------------------------------------------------------------------------------------

    def begin(self) -> None:
        """A routine begins: no lines yet, and nothing is known to hold."""
        self.rows, self.depth = [], self.first_depth
        self.forget()

    def body(self, statements: Sequence[st.Statement]) -> list[str]:
        """Adds a routine's statements to `rows`, with indents and comments; what cannot be said is noted instead."""
        place, count = 0, len(statements)
        branches: list[_OpenBranches] = []
        while place < count:
            one = statements[place]
            kind, taken = type(one), 1
            try:
                joined = self.together(statements, place) if kind in self.joins else None
                if joined is None:
                    self.add(one, self.lines(one))
                else:
                    taken = joined.taken
                    self.put(joined.lines, joined.comment)
            except CannotSayError as problem:
                self.lose(problem, one.line)
            place += taken
            if kind in _BRANCHING and self.follows_branches and not self.own:
                self._follow(one, branches)
            elif kind in self.forgets:
                self._forget_called(one) if kind is st.Call and not self.own else self.forget()
            elif kind in _SETS:
                self._forget_set(one)
        return self.rows

    def known(self) -> dict[str, object]:
        """What is known to hold here."""
        return dict(self.holds)

    def know(self, known: Mapping[str, object]) -> None:
        """From here on that is known to hold, and nothing else."""
        self.forget()
        self.holds.update(known)

    def _follow(self, s: st.Statement, branches: list[_OpenBranches]) -> None:
        """At the mark of a branch: each begins as the first one did, and behind them holds what all have left."""
        called = any(
            type(e) is ex.CallValue and self._changes(e.routine) != frozenset() for e in expressions_of(s)
        )
        if called or not (branches or isinstance(s, (st.If, st.Switch))):
            self.forget()
        if isinstance(s, (st.If, st.Switch)):
            branches.append(_OpenBranches(self.known(), whole=False, ends=[]))
        elif isinstance(s, (st.EndIf, st.EndSwitch)):
            if branches:
                at = branches.pop()
                first, *more = (self.known(), *at.ends, *(() if at.whole else (at.before,)))
                self.know({k: v for k, v in first.items() if all(k in one and one[k] == v for one in more)})
        elif branches:
            at = branches[-1]
            at.ends.append(self.known())
            whole = isinstance(s, (st.Else, st.Default))
            branches[-1] = at._replace(before={} if called else at.before, whole=whole)
            self.know(branches[-1].before)

    def _forget_called(self, s: st.Statement) -> None:
        """Behind a call: what was set from the variables that the routine changes, or all, where it may set more."""
        assert isinstance(s, st.Call)
        changed = self._changes(s.routine)
        if changed is None or s.jump:
            self.forget()
            return
        handed = {
            e.name for one in (*s.arguments, s.result) for e in expressions_of(one) if type(e) is ex.Named
        }
        for name in sorted(changed | handed):
            self.forget_from(self.value(ex.Named(name)))

    def _changes(self, name: str) -> frozenset[str] | None:
        """The variables that a routine of the program changes; None where it moves the arm or sets what moves need, as
        routines that are in no file here may.
        """
        if self._changed_by is None:
            self._changed_by = changes_of_quiet(self.program)
        return self._changed_by.get(name.casefold())

    def _forget_set(self, s: st.Statement) -> None:
        """Behind an assignment: what was set from the variable, or all, where it calls a routine."""
        target, value = getattr(s, "target", None), getattr(s, "value", None)
        while isinstance(target, (ex.Item, ex.Member)):
            target = target.base
        called = [e for e in expressions_of(value) if type(e) is ex.CallValue]
        changed = [None if self.own else self._changes(e.routine) for e in called]
        handed = {x.name for e in called for x in expressions_of(e.arguments) if type(x) is ex.Named}
        if None in changed:
            self.forget()
            return
        for name in sorted(handed.union(*filter(None, changed))):
            self.forget_from(self.value(ex.Named(name)))
        if isinstance(target, (ex.Named, ex.Variable)):
            try:
                self.forget_from(self.value(target))
            except CannotSayError:
                self.forget()

    def forget_from(self, name: str) -> None:
        """A variable has changed: what was set from it no longer holds."""
        known = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)")
        for key, text in list(self.holds.items()):
            if isinstance(text, str) and name in text and known.search(text):
                del self.holds[key]

    def together(self, body: Sequence[st.Statement], place: int) -> Joined | None:
        """The instruction that the statement at `place` and those behind it are, None where it stands alone."""
        return None

    def add(self, s: st.Statement, lines: list[str]) -> None:
        """Puts the lines of one statement behind those that are there."""
        kind = type(s)
        if kind in _SHALLOWER:
            self.depth = max(self.depth - 1, self.least_depth)
        self.put(lines, getattr(s, "comment", ""))
        if kind in _DEEPER:
            self.depth += 1

    def put(self, lines: list[str], comment: str = "") -> None:
        """Lines at the current depth, with a comment behind one of them."""
        margin = self.step * max(min(self.depth, self.deepest), self.least_depth) if self.step else ""
        rows = [f"{margin}{line}" for line in lines] if margin else list(lines)
        if comment and rows:
            rows[self.comment_row] += self.comment_form.replace("{}", comment)
        self.rows += rows


def refusal(given: Refusal) -> CannotSayError:
    """The error of a refusal in a table."""
    return CannotSayError(given) if isinstance(given, str) else CannotSayError(*given)


class FramingComments(NamedTuple):
    """The comments above a routine, on its head, on its end and below it; `body`: the statements between."""

    above: tuple[str, ...]
    below: tuple[str, ...]
    head: str
    end: str
    body: tuple[st.Statement, ...]


def framing_comments(routine: st.Routine, own: bool) -> FramingComments:
    """A reader leaves these in the routine's body, where other languages write them; their lines tell the place."""
    first, last = routine.line, routine.last_line
    if not own or not last:
        return FramingComments((), (), "", "", routine.body)
    found: dict[int, list[str]] = {-1: [], 0: [], 1: [], 2: []}
    body = []
    for s in routine.body:
        if type(s) is not st.Comment or not s.line or first < s.line < last:
            body.append(s)
        else:
            found[-1 if s.line < first else 0 if s.line == first else 1 if s.line == last else 2].append(
                s.text
            )
    return FramingComments(
        tuple(found[-1]), tuple(found[2]), "".join(found[0]), "".join(found[1]), tuple(body)
    )


def as_text(lines: Iterable[str]) -> str:
    """Whole lines, as templates take them."""
    return "".join([f"{line}\n" for line in lines])


def _snake(kind: type) -> str:
    """SetOutput as set_output."""
    return _WORD.sub("_", kind.__name__).lower()


def _merged(cls: type, name: str) -> dict[Any, Any]:
    """A table of a class with those of its bases below."""
    found: dict[Any, Any] = {}
    for base in reversed(cls.__mro__):
        found.update(base.__dict__.get(name, {}))
    return found


def _begins_with_sign(e: ex.Expression) -> bool:
    while type(e) is ex.Binary and e.operator in "*/":
        e = e.left
    return (type(e) is ex.Unary and e.operator == "-") or (type(e) is ex.Number and e.value < 0)


def _unsaid(self: Generator, s: st.Statement) -> Lines:
    raise CannotSayError(terminology.statement(s))


def _filled(kind: type, template: str, spelled_as: Mapping[str, str]) -> Callable[[Any, Any], Lines]:
    """Writes a statement by its template. Raises TypeError where that names a field that the statement lacks."""
    known = {one.name for one in fields(kind)}
    parts: list[
        tuple[str, str, str, str]
    ] = []  # text before the field, field, how it is spelled, text around it
    for before, name, around, _ in Formatter().parse(template):
        if name and name not in known:
            raise TypeError(f"a {kind.__name__} has no '{name}': {template!r}")
        parts.append((before, name or "", spelled_as.get(name or "", spelled_as["*"]), around or ""))

    def write(self: Generator, s: Any) -> Lines:
        text = ""
        for before, name, method, around in parts:
            text += before
            it = getattr(s, name) if name else None
            if it is not None:
                shown = it if type(it) is str else getattr(self, method)(it)
                text += around.replace("{}", shown) if around else shown
        return text

    return write if template else lambda self, s: []


_QUIET: Final = frozenset({
    st.Comment, st.Declare, st.Begin, st.End, st.Assign, st.Update, st.Clear, st.ReadInput, st.SetOutput,
    st.PulseOutput, st.Wait, st.Dwell, st.Message, st.Call, st.Return, st.Label, st.Jump, st.Break, st.If, st.ElseIf,
    st.Else, st.EndIf, st.While, st.EndWhile, st.Repeat, st.Until, st.For, st.Next, st.Switch, st.Case, st.Default,
    st.EndSwitch,
})  # fmt: skip


_BRANCHING: Final = frozenset(
    {st.If, st.ElseIf, st.Else, st.EndIf, st.Switch, st.Case, st.Default, st.EndSwitch}
)


class _OpenBranches(NamedTuple):
    """Open branches: what held `before` them, and at the `ends` of those so far. `whole`: one of them runs always."""

    before: dict[str, object]
    whole: bool
    ends: list[dict[str, object]]


def changes_of_quiet(program: st.Program) -> dict[str, frozenset[str]]:
    """The routines, case folded, that neither move the arm nor set what moves need, with the variables that they and
    what they call change.
    """
    found: dict[str, frozenset[str]] = {}
    calls: dict[str, set[str]] = {}
    for r in program.routines:
        if not all(type(s) in _QUIET and _sets_variables(s) for s in r.body):
            continue
        name = r.name.casefold()
        found[name] = frozenset(one for s in r.body for one in changed_by(s))
        calls[name] = {s.routine.casefold() for s in r.body if type(s) is st.Call}
        calls[name] |= {
            e.routine.casefold() for s in r.body for e in expressions_of(s) if type(e) is ex.CallValue
        }
    while True:
        loud = {name for name in found if not calls[name] <= found.keys()}
        more = {name: found[name].union(*(found[one] for one in calls[name])) for name in found.keys() - loud}
        if more == found:
            return found
        found = more


def _sets_variables(s: st.Statement) -> bool:
    """Whether nothing but a variable is set: no speed, tool or frame of the controller's."""
    target = getattr(s, "target", None)
    while isinstance(target, (ex.Item, ex.Member)):
        target = target.base
    return target is None or isinstance(target, (ex.Named, ex.Variable))


def _ends_program(s: st.Statement) -> bool:
    """Whether it is the one process that languages share, in this one's word."""
    return isinstance(s, st.Process) and s.name.casefold() in ENDS_PROGRAM


def _checked(
    kind: type, write: Callable[[Any, Any], Lines], foreign: str | None, cannot: Mapping[str, Refusal]
) -> Callable[[Any, Any], Lines]:
    """`write` behind the refusals of the tables, and under the statement's condition."""
    conditional = kind in CONDITIONAL
    if foreign is None and not cannot and not conditional:
        return write
    values: Callable[[Any], Any] = attrgetter(*cannot, "line") if cannot else lambda s: ()

    def checked(self: Generator, s: Any) -> Lines:
        if foreign is not None and not self.own and not _ends_program(s) and not self._welds(s):
            raise CannotSayError(
                foreign.format_map({"s": s, "self": self, "called": terminology.statement(s)})
            )
        if cannot and any(values(s)[:-1]):
            raise refusal(next(refused for name, refused in cannot.items() if getattr(s, name)))
        found = write(self, s)
        if not conditional or s.condition is None:
            return found
        return self.under(s.condition, [found] if isinstance(found, str) else found, s)

    return checked
