"""What an IRC5 or OmniCore controller refuses when it loads a RAPID module ("RAPID kernel", 3HAC050946).

First values with variables or functions in them (K107: "constant expressions"), names of labels (K102), what stands
behind what in a module (K106), values that a LOCAL PERS needs and a signal or clock has not, the three dimensions of an
array, RETRY and TRYNEXT outside of a handler, CONNECT of a routine's own variable ("RAPID Instructions": it must not be
declared within a routine) and data that := does not set ("RAPID overview": non-value data types) are from memory of
these manuals.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import dataclass
from itertools import takewhile
from typing import Final

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.source import Source
from olp.languages.loading import LoadedCell, LoadFindings, Loading
from olp.languages.vendors.rapid.declared import Data, Module, RapidRoutine, RapidToken, module_of
from olp.languages.vendors.rapid.known_routines import (
    FUNCTIONS,
    INSTRUCTIONS,
    RESERVED,
    SIGNATURES,
    TYPES,
    RoutineSignature,
)
from olp.languages.vendors.rapid.limits import LONGEST_TEXT
from olp.languages.vendors.rapid.predefined_data import RECORDS, SPEEDS, ZONES

_NAME_LENGTH: Final = {"irc5-5.15": 16, "irc5-6.13": 32, "omnicore-7": 32}
_ONE_CHARACTER: Final = re.compile(r'""|\\\\|\\[0-9A-Fa-f]{2}')  # of a text, written as two or three
_KINDS: Final = ("var", "pers", "const")
# What a parameter of each mode takes.
_CHANGED: Final = {"inout": ("var", "pers"), "var": ("var",), "pers": ("pers",)}
_MOST_DIMENSIONS: Final = 3
_WITHOUT_VALUES: Final = frozenset(("clock", "dir", "iodev", "rawbytes", "socketdev"))
_SECTIONS: Final = frozenset(("error", "undo", "backward"))
_OPERATORS: Final = frozenset(("and", "or", "xor", "not", "div", "mod"))
_TEXT_BLOCKS: Final = """
    case connect default do else elseif endfor endif endtest endwhile exit false for from goto if raise retry
    return step test then to true trynext while with
"""
_BLOCKS: Final = frozenset(_TEXT_BLOCKS.split())
# Where a name is a signal, a unit or a file of the configuration, which stands in no module: argument by number.
_TEXT_CONFIGURED: Final = """
    actunit ainput aliasio aoutput camgetparameter camgetresult camloadjob camreqimage camsetparameter
    camsetrunmode deactunit dinput doutput dropwobj getsignalorigin ginput goutput indamove indreset invertdo
    iodisable ioenable isignalai isignaldi isignaldo isignalgi isignalgo ismechunitactive load mechunitload
    movecdo movejdo moveldo pulsedo reset searchc searchl set setao setdo setgo startload syncmoveon testdi
    triggequip triggio triggrampao triggspeed validio waitai waitao waitdi waitdo waitgi waitgo waitrob
    waitsynctask waitwobj
"""
_CONFIGURED: Final = frozenset(_TEXT_CONFIGURED.split())
_TEXT_PREDEFINED: Final = """
    closed diskfree do_none end_of_list eof eof_bin eof_num false high load0 low null open pi sense stempty
    tool0 tp_latestprog tp_progpool tp_screenviewer true vmax wait_max wobj0
"""
_PREDEFINED: Final = frozenset(_TEXT_PREDEFINED.split()) | {name.casefold() for name in (*SPEEDS, *ZONES)}
_PREDEFINED_TYPES: Final[Mapping[str, str]] = {
    **{name.casefold(): "speeddata" for name in SPEEDS},
    **{name.casefold(): "zonedata" for name in ZONES},
    "tool0": "tooldata",
    "wobj0": "wobjdata",
    "load0": "loaddata",
}
_COMPONENTS: Final[Mapping[str, Mapping[str, str]]] = {
    **{name: dict(members) for name, members in RECORDS.items()},
    "robtarget": {"trans": "pos", "rot": "orient", "robconf": "confdata", "extax": "extjoint"},
    "jointtarget": {"robax": "robjoint", "extax": "extjoint"},
    "pose": {"trans": "pos", "rot": "orient"},
    "pos": dict.fromkeys("xyz", "num"),
    "orient": dict.fromkeys(("q1", "q2", "q3", "q4"), "num"),
}
# Constants of the controller: error numbers, states, buttons and events.
_PREFIXES: Final = (
    "err_", "sys_", "op_", "run_", "event_", "socket_", "str_", "egm_", "exec_", "handler_", "iobus_", "iounit_",
    "btn_", "icon_", "stop_", "mod_", "fc_", "tune_", "hex_", "float_", "cam_", "task_", "tsp_", "proc_",
)  # fmt: skip


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller refuses in one module of a cell."""
    found = LoadFindings(source)
    modules = [module_of(one) for one in cell.sources]
    own = modules[0]
    if not own.name:
        return []  # no module: other makers have files of the same ending
    _texts(found, own, _NAME_LENGTH.get(cell.controller, 32))
    _duplicates(found, own, modules[1:] if _is_task(source) else [])
    _persistents(found, own, modules[1:])
    for token in own.late:
        help = "a module declares its types, then its data, then its routines"
        found.tell("K106", f"{token.text} stands behind what a module declares later", token.span, help)
    shared = _SharedNames.of(modules)
    constants = {d.name.key for r in own.routines for d in (*r.data, *r.parameters)}
    for data, value in own.values:
        _value(found, shared, data, value)
        _first_value(found, shared, data, value, constants)
        _dimensions(found, data)
    for routine in own.routines:
        _routine(found, shared, routine)
    names = {d.name.text for m in modules for d in m.data} | {
        r.name.text for m in modules for r in m.routines
    }
    names |= {d.name.text for r in own.routines for d in (*r.data, *r.parameters)}
    above = [module_of(one) for one in cell.above]
    elsewhere = {name.key for one in above for name in _shared_names(one)} | {
        k for one in above for k in one.types
    }
    found.unknown = [one for one in found.unknown if one[0].casefold() not in elsewhere]
    found.doubtful = [one for one in found.doubtful if one[0].casefold() not in elsewhere]
    has_main = any(r.name.key == "main" for m in modules for r in m.routines)
    return found.finish(names, _is_whole(cell), shared=not has_main)


def _is_task(source: Source) -> bool:
    """Whether the files beside a module are loaded with it: in a backup they are."""
    return bool(re.search(r"[\\/](?:PROGMOD|SYSMOD)[\\/][^\\/]+$", source.path, re.IGNORECASE))


def _is_whole(cell: LoadedCell) -> bool:
    """Whether the cell lists its modules, and all are there: a program's .pgf."""
    stems = {re.split(r"[\\/]", one.path)[-1].casefold() for one in cell.sources}
    for one in cell.sources:
        if one.path.lower().endswith(".pgf"):
            listed = re.findall(r"<Module>([^<]+)</Module>", "\n".join(one.lines))
            return bool(listed) and {name.casefold() for name in listed} <= stems and _has_system(stems)
    return False


def _has_system(stems: set[str]) -> bool:
    return any(name.endswith((".sys", ".sysx")) for name in stems)


def _texts(found: LoadFindings, module: Module, longest: int) -> None:
    for token in module.tokens:
        if token.kind == "odd":
            found.tell(
                "K105", f"the character {token.text!r} stands outside of a comment or a text", token.span
            )
        elif token.kind == "word" and any(ord(letter) > 255 for letter in token.text):
            found.tell(
                "K105",
                f"the name {token.text} holds a letter that RAPID does not have",
                token.span,
                "use A to Z, 0 to 9 and _",
            )
        elif token.kind == "text" and (len(token.text) < 2 or not token.text.endswith('"')):
            found.tell("K105", "the text does not end within its line", token.span, 'close it with "')
        elif token.kind == "text" and len(_ONE_CHARACTER.sub("x", token.text[1:-1])) > LONGEST_TEXT:
            found.tell("K103", f"a text holds at most {LONGEST_TEXT} characters", token.span, "split it")
    declared = [*([] if module.title is None else [module.title]), *(d.name for d in module.data)]
    declared += [r.name for r in module.routines] + list(module.types.values())
    declared += [d.name for r in module.routines for d in (*r.data, *r.parameters)]
    for name in declared:
        found.too_long("name", name.text, name.span, longest)
        if name.key in RESERVED and name.kind == "word":
            found.tell("K104", f"{name.text} is a word of RAPID and no name", name.span, "call it otherwise")


def _duplicates(found: LoadFindings, own: Module, others: list[Module]) -> None:
    everything = [*(d.name for d in own.data), *(r.name for r in own.routines), *own.types.values()]
    found.doubles((name.key, name.text, name.span) for name in everything)
    for routine in own.routines:
        inside = (d.name for d in (*routine.parameters, *routine.data))
        found.doubles((name.key, name.text, name.span) for name in inside)
    elsewhere: dict[str, str] = {}
    for module in others:
        if module.name and module.name != own.name:  # a copy of the module beside it is not loaded with it
            for name in _shared_names(module):
                elsewhere.setdefault(name.key, module.name)
    for name in _shared_names(own):
        if name.key in elsewhere and name.key != "main":
            found.tell(
                "K102",
                f"{name.text} is declared in the module {elsewhere[name.key]}, too",
                name.span,
                "make one of them LOCAL, or take it out",
            )


def _persistents(found: LoadFindings, own: Module, others: list[Module]) -> None:
    """PERS that another module declares otherwise: tasks that have one of a name share it."""
    for module in others:
        theirs = {d.name.key: d for d in module.data if d.kind == "pers" and not (d.local or d.task)}
        for data in own.data if module.name and module.name != own.name else ():
            other = theirs.get(data.name.key)
            if data.kind != "pers" or data.local or data.task or other is None:
                continue
            if (data.type, len(data.sizes)) != (other.type, len(other.sizes)):
                shape = f"{{{','.join(other.sizes)}}}" if other.sizes else ""
                says = f"the PERS {data.name.text} is {other.type}{shape} in the module {module.name}"
                found.tell(
                    "K108", says, data.name.span, "declare it alike, or make one of them TASK or LOCAL"
                )


def _shared_names(module: Module) -> list[RapidToken]:
    """The names that other modules see."""
    return [
        *(data.name for data in module.data if not data.local),
        *(routine.name for routine in module.routines if not routine.local),
    ]


@dataclass(slots=True)
class _SharedNames:
    """What every module of the cell sees, and what the checked one has for itself."""

    data: dict[str, Data]
    routines: dict[str, RapidRoutine]
    types: set[str]
    components: dict[str, Mapping[str, str]]

    @classmethod
    def of(cls, modules: list[Module]) -> _SharedNames:
        data: dict[str, Data] = {}
        routines: dict[str, RapidRoutine] = {}
        for own, module in enumerate(modules):
            for one in module.data:
                if not own or not one.local:
                    data.setdefault(one.name.key, one)
            for routine in module.routines:
                if not own or not routine.local:
                    routines.setdefault(routine.name.key, routine)
        types = {key for module in modules for key in module.types}
        components: dict[str, Mapping[str, str]] = {}
        for module in reversed(modules):
            components.update(module.components)
        return cls(data, routines, types | TYPES, {**components, **_COMPONENTS})

    def type_of(self, name: RapidToken, local: Mapping[str, Data]) -> tuple[str, bool]:
        """The type of a name, "" where it is not known, and whether it is an array of such."""
        one = local.get(name.key) or self.data.get(name.key)
        return (one.type, one.array) if one else (_PREDEFINED_TYPES.get(name.key, ""), False)


_TRUTHS: Final = frozenset(("=", "<>", "<", ">", "<=", ">="))
_LOGIC: Final = frozenset(("and", "or", "xor", "not"))
_LITERALS: Final = {"text": "string", "number": "num"}
_SIMPLE: Final = frozenset(
    ("num", "bool", "string", "robtarget", "jointtarget", "pos", "orient", "pose", "tooldata", "wobjdata")
) | {"speeddata", "zonedata", "loaddata", "confdata", "clock", "socketdev", "iodev", "intnum", "triggdata"}
_COMPARED: Final = frozenset(("num", "bool", "string"))
_NUMBERS: Final = frozenset(("num", "dnum", "byte", "intnum", "errnum"))


def _value(found: LoadFindings, shared: _SharedNames, data: Data, value: list[RapidToken]) -> None:
    """A declaration's type and the value that it begins with."""
    if data.type not in shared.types:
        found.unknown.append((data.type, data.name.span, "the type"))
        return
    if data.kind == "const" and not value:
        found.tell(
            "K107", f"the constant {data.name.text} has no value", data.name.span, "write := and its value"
        )
    if data.kind == "pers" and data.local and not value:
        help = "write := and its value: only a PERS that all modules see may do without"
        found.tell("K107", f"the LOCAL PERS {data.name.text} has no value", data.name.span, help)
    if value and (data.type in _WITHOUT_VALUES or data.type.startswith("signal")):
        says = f"{data.name.text} is {data.type}, which begins with no value"
        found.tell("K107", says, data.name.span, "take the value out")
    if not data.array and data.type in _SIMPLE and value:
        _match(
            found,
            shared,
            data.type,
            _type_of(value, shared, {}),
            value[0].span,
            f"{data.name.text} is {data.type}",
        )


def _dimensions(found: LoadFindings, data: Data) -> None:
    if len(data.sizes) > _MOST_DIMENSIONS:
        says = f"{data.name.text} has {len(data.sizes)} dimensions"
        found.tell("K109", says, data.name.span, f"{_MOST_DIMENSIONS} at most")


def _first_value(
    found: LoadFindings,
    shared: _SharedNames,
    data: Data,
    value: list[RapidToken],
    inner: Set[str],
) -> None:
    """A first value with a variable or a function in it, or with fewer or more elements than its array.

    `inner`: the names that routines declare for themselves, which may hide those of the module.
    """
    for at, token in enumerate(value):
        if token.kind != "word" or (at and value[at - 1].text in (".", "\\")) or token.key in inner:
            continue
        called = at + 1 < len(value) and value[at + 1].text == "("
        if called and (token.key in FUNCTIONS or token.key in shared.routines):
            says = f"{data.name.text} begins with the value of {token.text}, which is computed"
            found.tell("K107", says, token.span, "assign it in a routine")
            return
        one = shared.data.get(token.key)
        if one is not None and one.kind in ("var", "pers"):
            says = f"{data.name.text} begins with {token.text}, which is no constant"
            found.tell("K107", says, token.span, "assign it in a routine")
            return
    if not data.array or not data.sizes[0].isdigit() or not value or value[0].text != "[":
        return
    if _closes(value, 0) == len(value) - 1:
        count = len(_between(value[1:-1], lambda t: t.text == ","))
        if count != int(data.sizes[0]):
            says = f"{data.name.text} has {data.sizes[0]} elements, and {count} are given"
            found.tell("K109", says, data.name.span)


def _type_of(tokens: list[RapidToken], shared: _SharedNames, local: Mapping[str, Data]) -> str:
    """The type of an expression that is a literal, a name with its components, a call or a comparison, else ""."""
    if any(t.text in _TRUTHS or t.key in _LOGIC for i, t in enumerate(tokens) if not _depth(tokens, i)):
        return "bool"
    if len(tokens) == 1 and (tokens[0].kind in _LITERALS or tokens[0].key in ("true", "false")):
        return _LITERALS.get(tokens[0].kind, "bool")
    if tokens and tokens[0].text == "[":
        return "aggregate"
    if not tokens or tokens[0].kind != "word":
        return ""
    if len(tokens) > 1 and tokens[1].text == "(":
        routine, known = shared.routines.get(tokens[0].key), SIGNATURES.get(tokens[0].key)
        type_ = routine.type if routine else known.result if known else ""
        return type_ if _closes(tokens, 1) == len(tokens) - 1 else ""
    *_, (end, type_, array) = _walk(tokens, 0, shared, local)
    return "" if array or end < len(tokens) else type_


def _walk(
    tokens: list[RapidToken], at: int, shared: _SharedNames, local: Mapping[str, Data]
) -> Iterator[tuple[int, str, bool]]:
    """A name and its components one after the other: where each ends, its type, and whether it is an array."""
    type_, array = shared.type_of(tokens[at], local)
    at += 1
    while True:
        if at < len(tokens) and tokens[at].text == "{":
            closed = _closes(tokens, at)
            at, array = (closed + 1 if closed > 0 else len(tokens)), False
        yield at, type_, array
        if at + 1 >= len(tokens) or tokens[at].text != ".":
            return
        type_ = shared.components.get(type_, {}).get(tokens[at + 1].key, "")
        at += 2


def _closes(tokens: list[RapidToken], start: int) -> int:
    depth = 0
    for i in range(start, len(tokens)):
        depth += (tokens[i].text in "([{") - (tokens[i].text in ")]}")
        if not depth:
            return i
    return -1


def _match(found: LoadFindings, shared: _SharedNames, wanted: str, given: str, span: Span, what: str) -> None:
    """Types that the kernel converts are alike: numbers, and signals with their values."""
    if not given or given == wanted or (wanted in _NUMBERS and given in _NUMBERS):
        return
    if given == "aggregate":
        if wanted in ("num", "bool", "string"):
            found.tell("K108", f"{what}, and this is a list of values", span)
        return
    if wanted in _SIMPLE and (given in (*_SIMPLE, "dnum") or given in shared.components):
        found.tell("K108", f"{what}, and this is {given}", span)


def _routine(found: LoadFindings, shared: _SharedNames, routine: RapidRoutine) -> None:
    for token in routine.late:
        help = "data of a routine are declared before its first statement"
        found.tell("K106", "a declaration behind a statement", token.span, help)
    for d in routine.data:
        if d.kind == "pers":
            help = "declare it in the module, or write VAR"
            found.tell("K115", "a routine declares no PERS", d.name.span, help)
    local = {d.name.key: d for d in (*routine.parameters, *routine.data)}
    for d in (*routine.parameters, *routine.data):
        if d.type not in shared.types and d.type != "switch":
            found.unknown.append((d.type, d.name.span, "the type"))
    statements = list(_statements(routine.body))
    labels = (s[0] for s in statements if len(s) == 2 and s[1].text == ":")
    found.doubles((one.key, one.text, one.span) for one in (*(d.name for d in routine.data), *labels))
    loops = {s[1].key for s in statements if s[0].key == "for" and len(s) > 1}
    scope = _Scope(local, loops, routine)
    handler = next(((t.line, t.column) for t in routine.body if t.key == "error"), None)
    for statement in statements:
        first = statement[0].line, statement[0].column
        handled = handler is not None and first > handler
        if statement[0].key in ("retry", "trynext") and len(statement) == 1 and not handled:
            says = f"{statement[0].text} outside of an error handler"
            found.tell("K115", says, statement[0].span, "it belongs behind ERROR")
        _statement(found, shared, scope, statement)
    _cases(found, shared, scope, routine.body)
    if routine.kind == "func" and not any(t.key in ("return", "raise") for t in routine.body):
        says = f"{routine.name.text} is a FUNC and returns nothing"
        found.tell("K108", says, routine.name.span, "RETURN with a value", Severity.WARNING)


def _cases(found: LoadFindings, shared: _SharedNames, scope: _Scope, body: list[RapidToken]) -> None:
    """Values of CASE of another kind than what their TEST asks."""
    tested: list[str] = []
    for i, token in enumerate(body):
        if token.key == "test":
            tested.append(_type_of(_until(body, i + 1, ("case", "default", "endtest")), shared, scope.local))
        elif token.key == "endtest":
            del tested[-1:]
        elif token.key == "case" and tested:
            for value in _between(_until(body, i + 1, (":",)), lambda t: t.text == ","):
                type_ = _type_of(value, shared, scope.local)
                if tested[-1] != type_ and {tested[-1], type_} <= _COMPARED:
                    says = f"TEST asks a {tested[-1]}, and {value[0].text} is {type_}"
                    found.tell("K108", says, value[0].span, "compare values of one kind")


def _until(body: list[RapidToken], start: int, ends: tuple[str, ...]) -> list[RapidToken]:
    return list(takewhile(lambda t: t.key not in ends and t.text not in ends, body[start:]))


@dataclass(slots=True)
class _Scope:
    local: Mapping[str, Data]
    loops: set[str]
    routine: RapidRoutine


_ENDS: Final = frozenset(
    ("then", "else", "do", "endif", "endfor", "endwhile", "endtest", "default", *_SECTIONS)
)
_BEGINS: Final = frozenset(("if", "elseif", "while", "for", "test", "case", *_ENDS))


def _statements(body: list[RapidToken]) -> Iterator[list[RapidToken]]:
    """Pieces that end with a semicolon, a colon, or a word that closes a head; the sign stays out but a label's."""
    piece: list[RapidToken] = []
    depth = 0
    for token in body:
        depth += (token.text in "([{") - (token.text in ")]}")
        if token.text == ";":
            depth = 0
            if piece:
                yield piece
            piece = []
        elif token.text == ":" and depth <= 0:
            if len(piece) == 1 and piece[0].key not in ("default",):
                piece.append(token)
            if piece:
                yield piece
            piece = []
        elif token.key in _ENDS and token.kind == "word":
            if piece:
                yield piece
            piece = []
        else:
            piece.append(token)
    if piece:
        yield piece


def _statement(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken]) -> None:
    head = s[0].key
    if len(s) == 2 and s[1].text == ":":
        return
    if head == "goto":
        return  # the reader knows the labels
    if head == "connect" and len(s) == 4:
        _connect(found, shared, scope, s)
    if head == "return":
        _return(found, shared, scope, s)
    assigned = next((i for i, t in enumerate(s) if t.text in (":=", "\\") and _depth(s, i) == 0), 0)
    assigned = assigned if s[assigned].text == ":=" else 0  # not that of an option
    if assigned and head not in _BEGINS:
        _assignment(found, shared, scope, s[:assigned], s[assigned + 1 :])
    elif head in ("if", "elseif", "while") and _is_one_word(s):
        given = _type_of(s[1:2], shared, scope.local)
        if given in ("num", "string", "dnum") or given.startswith("signal"):
            found.tell(
                "K108", f"{s[1].text} is {given}, and no condition", s[1].span, "compare it with a value"
            )
    elif head in ("if", "elseif", "while"):
        _operators(found, shared, scope, s[1:])
    elif (
        s[0].kind == "word"
        and head not in _BLOCKS
        and (len(s) == 1 or s[1].text not in (":=", ".", "{", "("))
    ):
        _call(found, shared, scope, s[0], s[1:])
    _names(found, shared, scope, s)


def _connect(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken]) -> None:
    """`CONNECT number WITH trap`."""
    type_, _ = shared.type_of(s[1], scope.local)
    if type_ in _SIMPLE and type_ != "intnum":
        found.tell("K108", f"CONNECT takes an intnum here, and this is {type_}", s[1].span)
    one = scope.local.get(s[1].key)
    if one is not None and one.kind == "var":
        says = f"{s[1].text} belongs to the routine, and an interrupt outlives it"
        found.tell("K115", says, s[1].span, "declare it in the module")
    routine = shared.routines.get(s[3].key)
    if routine is not None and routine.kind != "trap":
        found.tell("K112", f"{s[3].text} is no TRAP", s[3].span)


def _is_one_word(s: list[RapidToken]) -> bool:
    """Whether the condition of a head is one word; behind it an IF on one line has its statement."""
    return len(s) == 2 or (len(s) > 2 and s[2].kind == "word" and s[2].key not in _OPERATORS)


def _depth(s: list[RapidToken], at: int) -> int:
    return sum((t.text in "([{") - (t.text in ")]}") for t in s[:at])


def _return(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken]) -> None:
    if scope.routine.kind == "func" and len(s) == 1:
        found.tell(
            "K108", f"{scope.routine.name.text} returns {scope.routine.type}, and here nothing", s[0].span
        )
    elif scope.routine.kind != "func" and len(s) > 1:
        found.tell("K108", "only a FUNC returns a value", s[1].span)
    elif scope.routine.kind == "func":
        _match(
            found,
            shared,
            scope.routine.type,
            _type_of(s[1:], shared, scope.local),
            s[1].span,
            f"{scope.routine.name.text} returns {scope.routine.type}",
        )


def _assignment(
    found: LoadFindings, shared: _SharedNames, scope: _Scope, left: list[RapidToken], right: list[RapidToken]
) -> None:
    target = left[0]
    one = scope.local.get(target.key) or shared.data.get(target.key)
    if one is not None and one.kind == "const":
        found.tell(
            "K111", f"{target.text} is a constant (line {one.name.line})", target.span, "declare it with VAR"
        )
    if target.key in scope.loops and one is None:
        found.tell("K111", f"{target.text} counts a loop and cannot be set", target.span)
    if one is None and target.key in shared.routines and len(left) == 1:
        found.tell("K111", f"{target.text} is a routine", target.span)
    if one is not None and len(left) == 1 and not one.array and right:
        if one.type.startswith("signal"):
            found.tell("K111", f"{target.text} is a signal: := does not set it", target.span, "write SetDO")
        elif one.type in _WITHOUT_VALUES:
            found.tell("K111", f"{target.text} is {one.type}, which := does not set", target.span)
        else:
            given = _type_of(right, shared, scope.local)
            _match(found, shared, one.type, given, right[0].span, f"{target.text} is {one.type}")
            _whole_array(found, shared, scope, right)
    if right:
        _operators(found, shared, scope, right)


def _whole_array(found: LoadFindings, shared: _SharedNames, scope: _Scope, given: list[RapidToken]) -> None:
    """The name of an array where one element is taken."""
    one = scope.local.get(given[0].key) or shared.data.get(given[0].key)
    if len(given) == 1 and one is not None and one.array:
        says = f"{given[0].text} is declared with indices, and none are given"
        found.tell("K109", says, given[0].span, f"write {given[0].text}{{1}} for its first element")


def _operators(found: LoadFindings, shared: _SharedNames, scope: _Scope, given: list[RapidToken]) -> None:
    """Operands of AND, OR, XOR and NOT that are no bool; + with values that it does not add."""
    places = [i for i, t in enumerate(given) if not _depth(given, i)]
    if any(given[i].key in _LOGIC for i in places):
        for operand in _between(given, lambda t: t.key in _LOGIC):
            _compared(found, shared, scope, operand)
            type_ = _type_of(operand, shared, scope.local)
            if type_ in ("num", "dnum", "string", "robtarget", "jointtarget"):
                says = f"{operand[0].text} is {type_}, and no condition"
                found.tell("K108", says, operand[0].span, "compare it with a value")
    elif any(given[i].text in _TRUTHS for i in places):
        _compared(found, shared, scope, given)
    elif any(given[i].text == "+" for i in places) and not any(given[i].text in _TRUTHS for i in places):
        operands = _between(given, lambda t: t.text == "+")
        types = [_type_of(operand, shared, scope.local) for operand in operands]
        for operand, type_ in zip(operands, types, strict=True):
            if type_ in ("bool", "robtarget", "jointtarget", "pose") and len(operands) > 1:
                found.tell("K108", f"{operand[0].text} is {type_}, which + does not add", operand[0].span)
            elif type_ in ("num", "dnum") and "string" in types:
                says = f"{operand[0].text} is {type_}, and + joins texts"
                found.tell("K108", says, operand[0].span, "write NumToStr, or an argument as \\Num:=")


def _compared(found: LoadFindings, shared: _SharedNames, scope: _Scope, given: list[RapidToken]) -> None:
    """A comparison of values of two kinds."""
    sides = _between(given, lambda t: t.text in _TRUTHS)
    types = [_type_of(side, shared, scope.local) for side in sides]
    if len(sides) == 2 and types[0] != types[1] and all(one in _COMPARED for one in types):
        says = f"{sides[0][0].text} is {types[0]}, and {sides[1][0].text} is {types[1]}"
        found.tell("K108", says, sides[1][0].span, "compare values of one kind")


def _between(tokens: list[RapidToken], is_sign: Callable[[RapidToken], bool]) -> list[list[RapidToken]]:
    """What stands between the signs that no bracket holds."""
    found: list[list[RapidToken]] = [[]]
    for i, token in enumerate(tokens):
        if is_sign(token) and not _depth(tokens, i):
            found.append([])
        else:
            found[-1].append(token)
    return [one for one in found if one]


def _call(
    found: LoadFindings, shared: _SharedNames, scope: _Scope, name: RapidToken, rest: list[RapidToken]
) -> None:
    routine = shared.routines.get(name.key)
    if routine is None and name.key in INSTRUCTIONS:
        _given(found, shared, scope, name, rest)
        return
    if routine is None:
        if name.key in scope.local or name.key in shared.data:
            found.tell(
                "K112", f"{name.text} is no routine", name.span, "write := behind it, or correct the name"
            )
        else:
            found.unknown.append((name.text, name.span, "the routine"))
        return
    found.known.add(name.key)
    if routine.kind == "func":
        found.tell("K112", f"{name.text} is a function: its value must go somewhere", name.span)
    elif routine.kind == "trap":
        found.tell("K112", f"{name.text} is a trap: only an interrupt calls it", name.span)
    _given(found, shared, scope, name, rest)


def _given(
    found: LoadFindings, shared: _SharedNames, scope: _Scope, name: RapidToken, rest: list[RapidToken]
) -> None:
    """What a routine is given: how many arguments, of which types, and which options."""
    wanted = _wanted(shared, name)
    if wanted is None:
        return
    given, options = _arguments(rest)
    found.arguments(name.text, name.span, (len(wanted.takes), len(wanted.takes)), len(given))
    routine = shared.routines.get(name.key)
    modes = [""] * len(given) if routine is None else routine.modes
    for type_, mode, tokens in zip(wanted.takes, modes, given, strict=False):
        is_type = _type_of(tokens, shared, scope.local)
        _match(found, shared, type_, is_type, tokens[0].span, f"{name.text} takes a {type_} here")
        _operators(found, shared, scope, tokens)
        _changed(found, shared, scope, name, mode, tokens)
        if not is_type and type_ in _SIMPLE and len(tokens) == 1 and tokens[0].kind == "word":
            _argument(found, shared, scope, tokens[0], type_)
    for option in options:
        if wanted.options is not None and option.key not in wanted.options:
            found.tell("K112", f"{name.text} has no optional argument {option.text}", option.span)


def _changed(
    found: LoadFindings,
    shared: _SharedNames,
    scope: _Scope,
    name: RapidToken,
    mode: str,
    given: list[RapidToken],
) -> None:
    """What a routine changes: data, and of the kind that it asks for."""
    if not mode:
        return
    first = given[0]
    called = len(given) > 1 and first.kind == "word" and given[1].text == "("
    if called or first.kind in _LITERALS or first.text in ("[", "-") or first.key in ("true", "false"):
        says = f"{name.text} takes data of yours here ({mode.upper()}), and this is a value"
        found.tell("K108", says, first.span, "hand over a variable")
        return
    one = scope.local.get(first.key) or (None if first.key in scope.loops else shared.data.get(first.key))
    kinds = _CHANGED[mode]
    if one is not None and one.kind in _KINDS and one.kind not in kinds:
        says = f"{name.text} takes {mode.upper()} here, and {first.text} is {one.kind.upper()}"
        found.tell("K108", says, first.span, f"declare it with {' or '.join(kinds).upper()}")


def _argument(found: LoadFindings, shared: _SharedNames, scope: _Scope, name: RapidToken, type_: str) -> None:
    """A name that is given for data: nothing of the configuration, but the value of a signal is a number, too."""
    declared = name.key in scope.local or name.key in shared.data or name.key in shared.routines
    if not declared and name.key not in scope.loops and name.key not in RESERVED and not _is_known(name.key):
        names = found.doubtful if type_ in ("num", "bool") else found.unknown
        names.append((name.text, name.span, "the name"))


def _wanted(shared: _SharedNames, name: RapidToken) -> RoutineSignature | None:
    """What a routine takes, of the modules or of the controller."""
    routine = shared.routines.get(name.key)
    if routine is None:
        return SIGNATURES.get(name.key)
    return RoutineSignature(routine.type, tuple(routine.takes), frozenset(routine.options))


def _arguments(tokens: list[RapidToken]) -> tuple[list[list[RapidToken]], list[RapidToken]]:
    """The arguments that are no options, and the names of the options."""
    given: list[list[RapidToken]] = [[]]
    options: list[RapidToken] = []
    depth, optional = 0, False
    for i, token in enumerate(tokens):
        if depth == 0 and token.text in (",", "\\"):
            optional = token.text == "\\"
            options += tokens[i + 1 : i + 2] if optional else []
            given.append([])
            continue
        depth += (token.text in "([{") - (token.text in ")]}")
        if not optional:
            given[-1].append(token)
    return [one for one in given if one], options


def _names(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken]) -> None:
    """The names that a statement uses: told where nothing declares them, unless the configuration may."""
    head = s[0].key
    for i, token in enumerate(s):
        if token.kind != "word" or token.key in RESERVED or token.key in _BLOCKS or token.key in _OPERATORS:
            continue
        before, after = (s[i - 1].text if i else ""), (s[i + 1].text if i + 1 < len(s) else "")
        if before not in (".", "\\", "%") and after in (".", "{"):
            _members(found, shared, scope, s, i)
            _indices(found, shared, scope, s, i)
        if before in (".", "\\", "%") or (i == 0 and after not in (":=", ".", "{")):
            continue
        if after == "(":
            _function(found, shared, scope, s, i)
            continue
        if token.key in scope.local or token.key in scope.loops or _is_known(token.key):
            continue
        if token.key in shared.data or token.key in shared.routines:
            found.known.add(token.key)
            continue
        if (
            head in _CONFIGURED
            or (i and _called(s, i) in _CONFIGURED)
            or (head == "for" and i == 1)
            or head == "connect"
        ):
            continue
        # Beside a comparison a name may be a signal of the configuration, and so may an argument of a routine.
        certain = (i == 0 and after in (":=", ".", "{")) or after in (".", "{")
        if certain:
            what = "the variable" if i == 0 else "the name"
            found.unknown.append((token.text, token.span, what))


def _members(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken], at: int) -> None:
    """Components that the type of a name does not have."""
    for end, type_, _ in _walk(s, at, shared, scope.local):
        members = shared.components.get(type_)
        if members is None or end + 1 >= len(s) or s[end].text != ".":
            return
        if s[end + 1].kind == "word" and s[end + 1].key not in members:
            near = ", ".join(members)
            found.tell(
                "K109", f"{type_} has no component {s[end + 1].text}", s[end + 1].span, f"it has {near}"
            )
            return


def _indices(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken], at: int) -> None:
    """As many indices as a name is declared with."""
    one = scope.local.get(s[at].key) or shared.data.get(s[at].key)
    end = _closes(s, at + 1)
    if one is None or s[at + 1].text != "{" or end < 0 or s[at].key in scope.loops:
        return
    given = _between(s[at + 2 : end], lambda t: t.text == ",")
    if not one.array:
        found.tell("K109", f"{s[at].text} is declared without indices", s[at].span)
    elif len(given) != len(one.sizes):
        says = f"{s[at].text} has {len(one.sizes)} indices, and {len(given)} are given"
        found.tell("K109", says, s[at].span)


_BEFORE_VALUES: Final = frozenset((":=", "(", "[", ",", "+", "-", "*", "/", *_TRUTHS))


def _function(found: LoadFindings, shared: _SharedNames, scope: _Scope, s: list[RapidToken], at: int) -> None:
    token = s[at]
    end = _closes(s, at + 1)
    inner = s[at + 2 : end] if end > 0 else []
    routine = shared.routines.get(token.key)
    if routine is not None:
        found.known.add(token.key)
        if routine.kind == "func" and end > 0:
            _given(found, shared, scope, token, inner)
        elif routine.kind != "func" and at:
            found.tell("K112", f"{token.text} is a procedure and has no value", token.span)
    elif token.key in FUNCTIONS:
        if end > 0:
            _given(found, shared, scope, token, inner)
    elif token.key not in INSTRUCTIONS:
        found.unknown.append((token.text, token.span, "the function"))
    elif at and (s[at - 1].text in _BEFORE_VALUES or s[at - 1].key in _OPERATORS):
        found.tell("K112", f"{token.text} is an instruction and has no value", token.span)


def _called(s: list[RapidToken], at: int) -> str:
    """The function whose arguments hold the token."""
    depth = 0
    for i in reversed(range(at)):
        depth += (s[i].text == ")") - (s[i].text == "(")
        if depth < 0:
            return s[i - 1].key
    return ""


def _is_known(key: str) -> bool:
    return key in _PREDEFINED or key in INSTRUCTIONS or key in FUNCTIONS or key.startswith(_PREFIXES)


LOAD: Final = Loading(("irc5-6.13", "irc5-5.15", "omnicore-7"), check, (".pgf",), looks_above=True)
