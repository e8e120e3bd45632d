"""Spells values, names, arithmetic, conditions and declarations in KRL: the way back of `expressions` and `values`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from functools import lru_cache
from typing import ClassVar, Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.text_lengths import text_lengths
from olp.ir.transformer import calls_nothing, expressions_of
from olp.languages.generator import LARGEST_WHOLE, CannotSayError, Generator, Spelled
from olp.languages.literals import all_trimmed, trimmed
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.expressions import BUSES, FUNCTIONS, SYSTEM_VALUES
from olp.languages.vendors.krl.scope import AXES, COMPONENTS, CONFIG_MARK, Scope

_SYSTEM: Final = {name: word for word, name in reversed(SYSTEM_VALUES.items())}
_MEMBERS: Final = {name: word for word, name in COMPONENTS.items()}
POSE: Final = tuple(zip(("X", "Y", "Z", "A", "B", "C"), (0, 1, 2, 5, 4, 3), strict=True))
AXIS_WORDS: Final = ("A1", "A2", "A3", "A4", "A5", "A6")
_BITS: Final = {"and": ("B_AND", 7), "xor": ("B_EXOR", 6), "or": ("B_OR", 5)}
_CONDITIONS: Final = (ex.Logic, ex.Compare, ex.SignalState)
_SUM, _UNARY, _PRODUCT, _ATOM = 10, 12, 13, 14  # a sign stands in parentheses behind an operator
_MILLISECONDS: Final = ex.Number(1000)  # of a second
_DIGITS = 12
_DECIMALS = 9
_NINE_DECIMALS = 1000.0  # up to here nine decimals are not more than twelve digits
_PARTS_OF_POSE = 6
_TYPES: Final = {
    "integer": "INT",
    "real": "REAL",
    "boolean": "BOOL",
    "string": "CHAR",
    "position": "E6POS",
    "joints": "E6AXIS",
    "frame": "FRAME",
    "tool": "FRAME",
    "": "REAL",
}
TEXT_LENGTH: Final = 80  # of a text, and of Msg_txt[]
_STRUCTURES: Final = ("ENUM", "STRUC", "SIGNAL")


@lru_cache(maxsize=50_000)
def decimal(value: float) -> str:
    """`value` with twelve digits, without an exponent and never "-0"."""
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a program can hold")
    text = f"{value:.{_DIGITS}g}"
    if "e" in text:
        text = format(Decimal(text), "f")
    return "0" if text in ("-0", "") else text


@lru_cache(maxsize=10_000)
def _in_units(value: float, has: float, scale: float) -> str:
    return decimal(float(f"{value * has / scale:.10g}"))


def _foreign(value: float) -> str:
    """Without the noise of another language's units: a millionth of a millimetre, a billionth of a degree."""
    text = trimmed(value, _DECIMALS) if abs(value) < _NINE_DECIMALS else None
    return decimal(round(value, _DECIMALS)) if text is None else text.rstrip(".")


def pose_text(it: ex.PositionLiteral, own: bool = True, decimals: int = _DECIMALS) -> str:
    """`{X 1,Y 2,…}` of a position; components that are not written stay out. `own`: with all digits."""
    found: list[str] = []
    if not own:
        return _plain_pose(it, decimals) or _any_foreign(it)
    if it.kind == "pose":
        for word, place in POSE:
            value = it.values[place]
            if value == value:
                found.append(f"{word} {decimal(value / values.POSE_SCALES[place])}")
        found += _status(it)
    else:
        for word, value in zip(AXIS_WORDS, it.values, strict=False):
            if value == value:
                found.append(f"{word} {decimal(value / deg)}")
    found += [f"E{n} {decimal(value)}" for n, value in enumerate(it.external, 1) if value == value]
    if not found:
        raise CannotSayError("a position without a number")
    return f"{{{','.join(found)}}}"


def _plain_pose(it: ex.PositionLiteral, decimals: int) -> str:
    """A pose with all six numbers and no further axes, as nearly all are; empty for others."""
    if it.kind != "pose" or it.external or len(it.values) != _PARTS_OF_POSE:
        return ""
    x, y, z, rx, ry, rz = it.values
    written = (x / mm, y / mm, z / mm, rz / deg, ry / deg, rx / deg)
    if not (min(written) > -_NINE_DECIMALS and max(written) < _NINE_DECIMALS):
        return ""
    texts = all_trimmed(written, decimals)
    if texts is None:
        return ""
    given = _pattern(it.native, it.configuration, it.sectors)
    return given % tuple([one.rstrip(".") for one in texts])


@lru_cache(maxsize=1000)
def _pattern(
    native: tuple[tuple[str, str], ...], flags: tuple[int, ...], sectors: tuple[tuple[int, float, float], ...]
) -> str:
    status = _status(ex.PositionLiteral("pose", (), (), flags, native, sectors))
    texts = [*(f"{word} %s" for word, _ in POSE), *(one.replace("%", "%%") for one in status)]
    return f"{{{','.join(texts)}}}"


def _any_foreign(it: ex.PositionLiteral) -> str:
    if it.kind == "pose":
        pairs = [(word, it.values[place] / values.POSE_SCALES[place]) for word, place in POSE]
    else:
        pairs = [(word, value / deg) for word, value in zip(AXIS_WORDS, it.values, strict=False)]
    pairs += [(f"E{n}", value) for n, value in enumerate(it.external, 1)]
    found = [f"{word} {_foreign(value)}" for word, value in pairs if value == value]
    if not found:
        raise CannotSayError("a position without a number")
    place = 6 if it.kind == "pose" and len(found) >= 6 else len(found)
    return f"{{{','.join([*found[:place], *_status(it), *found[place:]])}}}"


def _status(it: ex.PositionLiteral) -> list[str]:
    native = dict(it.native)
    if "S" in native or "T" in native:
        return [f"{word} {native[word]}" for word in ("S", "T") if word in native]
    if len(it.configuration) < 3:
        return []
    turn = values.turn(it.sectors)
    return [f"S {values.status(it.configuration)}", *([] if turn is None else [f"T {turn}"])]


def _longest_text(program: st.Program, declared: Iterable[st.Statement]) -> int:
    """How many characters the program's texts take: 80, or more where one that is written out or joined has more."""
    if not any(isinstance(d, st.Declare) and d.type == "string" for d in declared):
        return TEXT_LENGTH
    rows = (s for s in program.statements() if not (calls_nothing(s) or isinstance(s, st.Message)))
    texts = [len(e.value) for s in rows for e in expressions_of(s) if type(e) is ex.Text]
    joined = [length for _, length in text_lengths(program) if not math.isinf(length)]
    return int(max([TEXT_LENGTH, *texts, *joined]))


class KrlValues(Generator):
    """Spells expressions and declarations. `strings`: names whose values are texts in another language."""

    language = "KRL"
    binary: ClassVar = {"+": ("+", _SUM), "-": ("-", _SUM), "*": ("*", 11)}
    unary: ClassVar = {"-": ("-{}", _SUM, _UNARY), "not": ("NOT {}", _UNARY, _PRODUCT)}
    logic: ClassVar = {"and": (" AND ", 4), "xor": (" EXOR ", 3), "or": (" OR ", 2)}
    comparisons: ClassVar = {"=": "=="}
    compared = (1, 8)
    operator_help = "KRL has + - * / and B_AND, B_OR, B_EXOR"
    functions: ClassVar = {name: word for word, name in FUNCTIONS.items()}
    signals: ClassVar = {bus: word for word, bus in BUSES.items()}
    no_value = "a value of a kind that KRL does not have"
    decimals = _DECIMALS  # of positions, in mm and deg

    def __init__(self, program: st.Program, scope: Scope, strings: frozenset[str]) -> None:
        super().__init__(program, program.vendor == "krl")
        self.scope = scope
        self.strings = frozenset() if self.own else strings
        self.spelt: dict[str, str] = {}  # names that KRL's editor wants otherwise
        self._dimensions = {  # of what each routine takes
            r.name.casefold(): [len(p.sizes) for p in r.parameters] for r in program.routines if not self.own
        }
        declared = [*program.data, *(s for r in program.routines for s in (*r.data, *r.body))]
        self._array_sizes = {
            d.name: len(d.sizes)
            for d in (declared if not self.own else ())
            if isinstance(d, st.Declare) and d.sizes
        }
        self.text_length = TEXT_LENGTH if self.own else _longest_text(program, declared)

    # --- names ------------------------------------------------------------------------------------------

    def target(self, e: ex.Expression) -> str:
        """What can stand left of an equals sign."""
        numbered = (
            isinstance(e, ex.FrameRef) and e.kind in ("tool", "user") and e.number not in (None, ex.Number(0))
        )
        if numbered or isinstance(e, (ex.Named, ex.Item, ex.Member, ex.SystemValue, ex.Signal)):
            return self.value(e)
        raise CannotSayError("an assignment to this", "assign to a variable")

    def spell_named(self, e: ex.Named) -> str:
        return f"{e.name}[]" if e.name in self.strings else self.spelt.get(e.name, e.name)

    def spell_item(self, e: ex.Item) -> str:
        base, first = e.base, e.indices[0] if e.indices else None
        array = isinstance(base, ex.Named) and base.name.upper() in self.scope.arrays
        if self.scope.type_of(base) in AXES and len(e.indices) == 1 and not array:
            if type(first) is ex.Number:
                place = int(first.value)
                external = place - len(AXIS_WORDS)
                return f"{self.target(base)}.{f'E{external}' if external > 0 else f'A{place}'}"
            if not self.own:
                raise CannotSayError("an axis by a computed number")
        if base == ex.SystemValue("current-joints") and type(first) is ex.Number:
            return f"$AXIS_ACT.A{first.value}"
        indices = ",".join("" if type(one) is ex.Unknown else self.value(one) for one in e.indices)
        if isinstance(base, ex.Named) and base.name in self.strings:
            return f"{base.name}[{indices},]"
        return f"{self.target(base)}[{indices}]"

    def spell_member(self, e: ex.Member) -> str:
        own = self.scope.type_of(e.base) in self.scope.structures and e.name in _MEMBERS
        return f"{self.target(e.base)}.{e.name if own else _MEMBERS.get(e.name, e.name)}"

    def signal(self, e: ex.Signal) -> str:
        return e.index.value if isinstance(e.index, ex.Text) else super().signal(e)

    def spell_system_value(self, e: ex.SystemValue) -> Spelled:
        if e.name == "timer":
            return f"$TIMER[{e.index}]/1000.0", 11
        if e.name == "timer-running":
            return f"NOT $TIMER_STOP[{e.index}]", _UNARY
        if e.name == "timed-out":
            return "TIMED_OUT"
        if e.name not in _SYSTEM:
            raise CannotSayError(terminology.value(e.name))
        return _SYSTEM[e.name]

    # --- values -----------------------------------------------------------------------------------------

    def number(self, e: ex.Number) -> str:
        value = e.value
        if isinstance(value, float):
            text = repr(value)
            text = text if "e" not in text and "n" not in text else decimal(value)
            return text if "." in text else f"{text}.0"
        return f"{value}.0" if abs(value) > LARGEST_WHOLE and not self.own else str(value)

    def spell_number(self, e: ex.Number) -> Spelled:
        text = self.number(e)
        return (text, _SUM) if text[0] == "-" else text

    def spell_position_literal(self, e: ex.PositionLiteral) -> str:
        if e.native and dict(e.native).get("name") and not any(e.values):
            return "$NULLFRAME"
        return pose_text(e, self.own, self.decimals)

    def spell_text(self, e: ex.Text) -> str:
        if e.value[:1] == "#" and e.value[1:].isidentifier():
            return e.value
        if '"' in e.value or not e.value.isprintable():
            raise CannotSayError('a text that holds " or a control character')
        return f'"{e.value}"'

    def spell_unknown(self, e: ex.Unknown) -> Spelled:
        return e.text if self.own or not e.text else self.spell_other(e)

    def spell_record_literal(self, e: ex.RecordLiteral) -> str:
        if not self.own and any(not name for name, _ in e.members):
            raise CannotSayError("an array as a whole in this place")
        types = self.scope.structures.get(e.type.upper(), {})
        parts = []
        for name, value in e.members:
            word = name if name.upper().partition("[")[0] in types else _MEMBERS.get(name, name)
            parts.append(f"{word} {self.value(value)}")
        return f"{{{','.join(parts)}}}"

    def spell_frame_ref(self, e: ex.FrameRef) -> str:
        """A tool or frame by its number."""
        if e.kind == "robot" and e.number is None:
            return "$ROBROOT"
        if e.kind == "base" and e.number is None:
            return "$NULLFRAME"
        if type(e.number) is ex.Number and e.number.value == 0:
            return "$NULLFRAME"
        if e.number is None or e.kind not in ("tool", "user"):
            raise CannotSayError(terminology.SYSTEMS.get(e.kind, e.kind))
        return f"{'TOOL_DATA' if e.kind == 'tool' else 'BASE_DATA'}[{self.value(e.number)}]"

    # --- operations -------------------------------------------------------------------------------------

    def spell_unary(self, e: ex.Unary) -> Spelled:
        if e.operator == "not" and type(e.operand) is ex.SystemValue and e.operand.name == "timer-running":
            return f"$TIMER_STOP[{e.operand.index}]"
        return super().spell_unary(e)

    def spell_binary(self, e: ex.Binary) -> Spelled:
        left, right = e.left, e.right
        if e == ex.Binary("*", left, _MILLISECONDS) and type(left) is ex.SystemValue and left.name == "timer":
            return f"$TIMER[{left.index}]"
        if e.operator in ("/", "div"):
            return self._quotient(e, 11)
        if e.operator in _BITS:
            word, own = _BITS[e.operator]
            if e.operator == "xor" and self._is_condition(left) and self._is_condition(right):
                return f"{self.value(left, 4)} EXOR {self.value(right, 4)}", 3
            return f"{self.value(left, own)} {word} {self.value(right, own + 1)}", own
        if e.operator == "mod" and self._is_integer(left) and self._is_integer(right):
            a, b = self.value(left, 11), self.value(right, 12)
            return f"{a}-{a}/{b}*{b}", 10
        return super().spell_binary(e)

    def _quotient(self, e: ex.Binary, own: int) -> Spelled:
        """A quotient of two INT is cut: that is `div`; of others it is not."""
        whole = self._is_integer(e.left) and self._is_integer(e.right)
        right = self.value(e.right, own + 1)
        if whole == (e.operator == "div") or (e.operator == "/" and not whole):
            return f"{self.value(e.left, own)}/{right}", own
        if e.operator == "div":
            raise CannotSayError("a whole quotient of numbers that are not INT")
        if type(e.left) is ex.Number:
            return f"{self.number(ex.Number(float(e.left.value)))}/{right}", own
        if type(e.right) is ex.Number:
            return f"{self.value(e.left, own)}/{self.number(ex.Number(float(e.right.value)))}", own
        return f"1.0*{self.value(e.left, own + 1)}/{right}", own

    def _is_integer(self, e: ex.Expression) -> bool:
        if isinstance(e, ex.Binary):
            return e.operator != "/" and self._is_integer(e.left) and self._is_integer(e.right)
        if isinstance(e, ex.Unary):
            return self._is_integer(e.operand)
        return self.scope.type_of(e) == "INT"

    def _is_condition(self, e: ex.Expression) -> bool:
        if isinstance(e, ex.Unary):
            return e.operator == "not"
        digital = isinstance(e, ex.Signal) and e.bus in ("in", "out", "flag", "cyclic-flag", "timer-flag")
        return digital or type(e) in _CONDITIONS or self.scope.type_of(e) == "BOOL"

    # --- functions --------------------------------------------------------------------------------------

    def function_pose_product(self, given: tuple[ex.Expression, ...]) -> Spelled:
        if len(given) != 2:
            raise CannotSayError(terminology.function("pose-product"))
        return f"{self.value(given[0], _PRODUCT)}:{self.value(given[1], _ATOM)}", _PRODUCT

    def function_inverse(self, given: tuple[ex.Expression, ...]) -> str:
        return self._solved("INVERSE", "inverse", given)

    def function_forward(self, given: tuple[ex.Expression, ...]) -> str:
        return self._solved("FORWARD", "forward", given)

    def _solved(self, word: str, name: str, given: tuple[ex.Expression, ...]) -> str:
        """Both take the variable of an error number, INVERSE also where the axes start, which others do not name."""
        if not self.own:
            raise CannotSayError(terminology.function(name))
        return f"{word}({','.join(map(self.value, given))})"

    def function_joined_text(self, given: tuple[ex.Expression, ...]) -> str:
        if len(given) == 1 and isinstance(given[0], ex.Text):
            return f'"{given[0].value}"'
        raise CannotSayError(terminology.function("joined-text"))

    def function_find_in_text(self, given: tuple[ex.Expression, ...]) -> str:
        text, start, pattern = map(self.value, given)
        return f"StrFind({start},{text},{pattern},#CASE_SENS)"

    def function_same_text(self, given: tuple[ex.Expression, ...]) -> str:
        return f"StrComp({','.join(map(self.value, given))},#CASE_SENS)"

    def function_atan(self, given: tuple[ex.Expression, ...]) -> str:
        return f"ATAN2({self.value(given[0])},1.0)"

    def function_bit_not(self, given: tuple[ex.Expression, ...]) -> str:
        return f"B_NOT {self.value(given[0], _PRODUCT)}"

    def function_pose_angles(self, given: tuple[ex.Expression, ...]) -> str:
        if len(given) < _PARTS_OF_POSE:
            raise CannotSayError(terminology.function("pose-angles"))
        return self._aggregate([*((word, given[place]) for word, place in POSE), *self._named_parts(given)])

    def function_joints(self, given: tuple[ex.Expression, ...]) -> str:
        return self._aggregate([*zip(AXIS_WORDS, given[:6], strict=False), *self._named_parts(given)])

    def _named_parts(self, given: tuple[ex.Expression, ...]) -> list[tuple[str, ex.Expression]]:
        """S, T and external axes of KRL's own position."""
        records = [one.value for one in given if isinstance(one, ex.NamedArgument)]
        if records and not self.own:
            raise CannotSayError("external axes of a computed position")
        parts = [
            part for record in records if isinstance(record, ex.RecordLiteral) for part in record.members
        ]
        return [(name, one) for name, one in parts if one != ex.Number(values.NOT_CONNECTED)]

    def _aggregate(self, parts: list[tuple[str, ex.Expression]]) -> str:
        """Numbers only, but in KRL's own programs; `computed` puts other ones into a variable first."""
        given = [
            (word, one) for word, one in parts if not (type(one) is ex.Number and one.value != one.value)
        ]
        if not self.own and not all(type(one) is ex.Number for _, one in given):
            raise CannotSayError("a computed position in this place", "compute it into a variable first")
        return f"{{{','.join(f'{word} {self.value(one)}' for word, one in given)}}}"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        written = it.written
        if math.isclose(it.scale, unit, rel_tol=1e-12):
            return self.value(written)
        if type(written) is ex.Number:
            return _in_units(written.value, it.scale, unit)
        return f"{self.value(written, 11)}*{decimal(float(f'{it.scale / unit:.12g}'))}"

    # --- declarations -------------------------------------------------------------------------------------

    def type_word(self, type: str, native: str) -> str:
        """The KRL type of a neutral one, or of KRL's own program the one that was written."""
        if self.own:
            return native if type in _TYPES and native else type
        if type in _TYPES:
            return _TYPES[type]
        raise CannotSayError(f"data of the type '{type}'")

    def declared(self, it: st.Declare, with_value: bool, public: bool = False) -> str:
        """`DECL E6POS XP1={…}`: one declaration, with its value where the place takes one.

        `public`: other programs use what is shared, as those of KRL itself say on their own.
        """
        shared = "GLOBAL " if it.shared and (self.own or public) else ""
        if it.native in _STRUCTURES and isinstance(it.value, (ex.RecordLiteral, ex.Signal)):
            return f"{shared}{self._structure(it)}"
        constant = "CONST " if it.storage == "constant" and self.own else ""
        word = self.type_word(it.type, it.native)
        value = ""
        if with_value and it.value is not None and not self._is_array(it):
            value = f"={self.value(it.value)}"
        name = self.spelt.get(it.name, it.name)
        return f"DECL {shared}{constant}{word} {name}{self._sizes(it)}{value}"

    def _sizes(self, it: st.Declare) -> str:
        if it.sizes:
            shown = (("" if type(one) is ex.Unknown else self.value(one)) for one in it.sizes)
            text = f",{self.text_length}" if it.type == "string" and not self.own else ""
            return f"[{','.join(shown)}{text}]"
        return f"[{self.text_length}]" if it.type == "string" and not self.own else ""

    def _is_array(self, it: st.Declare) -> bool:
        """Values of arrays and texts stand on lines of their own."""
        return bool(it.sizes) or it.type == "string"

    def _structure(self, it: st.Declare) -> str:
        value = it.value
        if isinstance(value, ex.Signal):
            return f"SIGNAL {it.name} {self.signal(value)}"
        assert isinstance(value, ex.RecordLiteral)
        if it.native == "SIGNAL":
            first, last = (self.value(one) for _, one in value.members)
            return f"SIGNAL {it.name} {first} TO {last}"
        if it.native == "ENUM":
            names = ",".join(one.value[1:] for _, one in value.members if isinstance(one, ex.Text))
            return f"ENUM {it.name} {names}"
        return f"STRUC {it.name} {','.join(self._member(name, one) for name, one in value.members)}"

    def _member(self, name: str, it: ex.Expression) -> str:
        assert isinstance(it, ex.RecordLiteral)
        sizes = ",".join("" if type(one) is ex.Unknown else self.value(one) for _, one in it.members)
        return f"{it.type} {name}{f'[{sizes}]' if it.members else ''}"

    def elements(self, it: st.Declare) -> Iterator[str]:
        """`NAME[1]={…}`: the values of an array or a text, one line each."""
        if it.value is None or not self._is_array(it):
            return
        if isinstance(it.value, ex.RecordLiteral) and all(not name for name, _ in it.value.members):
            depth = len(it.sizes) + (it.type == "string" and not self.own)
            yield from self._rows(it.name, "", it.value, depth)
        elif isinstance(it.value, ex.Text):
            yield f"{it.name}[]={self.value(it.value)}"
        else:
            raise CannotSayError(f"the value that {it.name} begins with")

    def _rows(self, name: str, before: str, it: ex.RecordLiteral, left: int) -> Iterator[str]:
        for place, (_, value) in enumerate(it.members, 1):
            if type(value) is ex.Unknown:
                continue
            index = f"{before}{place}"
            if isinstance(value, ex.RecordLiteral) and left > 1 and all(not one for one, _ in value.members):
                yield from self._rows(name, f"{index},", value, left - 1)
            else:
                yield f"{name}[{index}{',' * (left - 1)}]={self.value(value)}"

    def list_rows(self, given: Iterable[st.Declare], public: bool = False) -> Iterator[str]:
        """What stands between DEFDAT and ENDDAT."""
        for it in given:
            yield from () if self.own else (f";{line}" for line in it.above)
            yield self.declared(it, with_value=True, public=public) + (
                f" ;{it.comment}" if it.comment else ""
            )
            yield from self.elements(it)

    def _brackets(self, it: st.Parameter) -> str:
        """`[]`, `[,]` of arrays, and of texts of other languages, which are arrays of CHAR; nothing of others."""
        text = it.type == "string" and (it.native.endswith("[]") or not self.own)
        count = len(it.sizes) + text
        return f"[{',' * (count - 1)}]" if count else ""

    def handed(self, routine: str, given: Sequence[ex.Expression]) -> str:
        """Arguments; an array as a whole is `name[]`, `name[,]`."""
        counts = self._dimensions.get(routine.casefold())
        if counts is None:  # in no file here
            counts = [self._array_sizes.get(e.name, 0) if type(e) is ex.Named else 0 for e in given]
        wanted = (*counts, *(0 for _ in given[len(counts) :]))
        return self.separator.join(map(self._argument, given, wanted))

    def _argument(self, e: ex.Expression, dimensions: int) -> str:
        if not dimensions or type(e) is not ex.Named:
            return self.value(e)
        return f"{e.name}[{',' * (dimensions - 1 + (e.name in self.strings))}]"

    def spell_call_value(self, e: ex.CallValue) -> Spelled:
        return f"{e.routine}({self.handed(e.routine, e.arguments)})"

    def parameters_text(self, given: tuple[st.Parameter, ...]) -> str:
        """`a :IN,b :OUT`."""
        parts = []
        for one in given:
            if one.optional or one.switch:
                raise CannotSayError(f"the optional parameter {one.name}")
            parts.append(f"{one.name}{self._brackets(one)} :{'OUT' if one.by_reference else 'IN'}")
        return ",".join(parts)

    def parameter_rows(self, given: tuple[st.Parameter, ...]) -> list[str]:
        """The declarations of parameters at the head of a routine."""
        rows = []
        for one in given:
            if self.own and not one.type:
                continue
            word = self.type_word(one.type, one.native.removesuffix("[]"))
            rows.append(f"DECL {word} {one.name}{self._brackets(one)}")
        return rows


def is_of_config(it: st.Declare) -> bool:
    """Whether the controller's own list declares it."""
    return it.native.endswith(CONFIG_MARK)
