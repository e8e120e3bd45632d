"""What a KRC4 or KRC5 controller refuses when it loads a KRL module ("Operating and Programming Instructions for System
Integrators", KSS 8: names, declarations, files; error list of the compiler).

K107 (first values that are computed) and K109 (components, indices, constants of enumerations) are from memory of that
manual; so are, from "Expert Programming" (KSS 5): the three dimensions of an array, interrupts of the priorities 1 to
128, SWITCH with at least one CASE, constants that nothing sets, GLOBAL in lists that are PUBLIC alone. From the
"Quickguide KRL-Syntax" (KSS 8): an index is a whole number. From memory of "Expert Programming", data
lists: other modules see what is GLOBAL or imported, of $config.dat all; a first value is of the declared type (both
were repaired in a real history).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.source import Source
from olp.languages.loading import MOST_MISSING, LoadedCell, LoadFindings, Loading, is_near
from olp.languages.vendors.krl import parsing
from olp.languages.vendors.krl.known_routines import FUNCTIONS, KNOWN_ROUTINES
from olp.languages.vendors.krl.neighbours import stem

_TOKEN: Final = re.compile(
    r"(?P<text>\"[^\"]*\"?|'[^']*'?)|(?P<number>(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)|(?P<word>[$A-Za-z_][\w$]*)"
    r"|(?P<sign>==|<>|<=|>=|[-+*/=<>(){}\[\],:.#&?!^])|(?P<odd>\S)"
)
_LONGEST: Final = 24  # characters of a name
_TEXT_TYPES: Final = """
    axis bool box cell_t char circ_type cp date direction e3axis e3pos e6axis e6pos eki_access eki_status eki_type
    ekrlmsgpartype
    ekrlmsgtype error_t esys fdat frame inertia int ipo_mode krlmsg_t krlmsgdlgsk_t krlmsgopt_t krlmsgpar_t
    krlmsgpartype_t ldat load modus_t mode_op ori_type p00_command p00_config pdat pos
    pro_ip pro_mode pro_state real siginf state_t stopmess stopm sw_onoff var_state
"""
_TYPES: Final = frozenset(_TEXT_TYPES.split())
# What the words of a statement are; they name nothing.
_TEXT_WORDS: Final = """
    and anin  anout b_and b_exor b_not b_or base brake brake_f c_dis c_ori c_ptp c_spl c_vel ca case
    cclose channel chopen circ circ_rel condstop confirm const continue copen coutput cread  cwrite
    decl  def default defdat deffct delay digin disable distance do else enable end end_spline enddat
    endfct endfor endif endloop endspline endswitch endwhile enum exit exor ext extfct extfctp extp f false for
    global goto halt if import in interrupt ir_offset is lin lin_rel loop maximum minimum not off on onstart or
    out part path prio private process process_sync ptp ptp_rel ptp_spline public pulse repeat resume return
    scirc scirc_rel sec sig signal slin slin_rel spl spline sptp sptp_rel sread sspl start step stop struc
    switch swrite sync tech tech_off then time_block timeblock to tool trigger true until var wait when while
    with
"""
_WORDS: Final = frozenset(_TEXT_WORDS.split())
# Of these, words at one place of a statement alone, which may name something else.
_TEXT_IN_PLACE: Final = """
    base disable enable f maximum minimum part path process start state static step sync tech time tool
"""
_IN_PLACE: Final = frozenset(_TEXT_IN_PLACE.split())
# Of options that many cells have: "CREAD/CWRITE" and "KUKA.Ethernet KRL 3.1".
_TEXT_OPTIONS: Final = """
    cast_from cast_to eki_check eki_checkbuffer eki_clear eki_clearbuffer eki_close eki_getbool eki_getboolarray
    eki_getframe eki_getint eki_getintarray eki_getreal eki_getrealarray eki_getstring eki_init eki_lock eki_open
    eki_send eki_setbool eki_setframe eki_setint eki_setreal eki_setstring eki_unlock
"""
_OPTIONS: Final = frozenset(_TEXT_OPTIONS.split())
# Names of motion data and structures that stand in every $config.dat, and inline forms' prefixes of a program's own.
_TEXT_CONFIG: Final = """
    act_base act_tool base_data base_name base_type basis_suggest_t cpdat_act cpdefault def_acc_cp def_acc_jt
    def_apo_c_ptp def_override def_vel_cp def_vel_fact default err_t ext_mam fdat_act fhome g_vel_cp g_vel_ptp
    gensor home1 home2 home3 home4 home5 i_time ia_dat last_basis last_ipo ldat_act ldefault ldefstart load_data
    machine_def max_acc_cp max_base max_tool move_type no_ia pdat_act pdefault pdefstart pgno pgno_req
    pgno_valid phome ptp_dat s_read set_io_size state stopm_t success tool_data tool_name tool_type tq_state
    vel_cp vel_ptp xhome xhome1 xhome2 xhome3 xhome4 xhome5
"""
_CONFIG: Final = frozenset(_TEXT_CONFIG.split())
_DECLARES: Final = re.compile(
    r"(?P<head>(?:GLOBAL\s+)?(?:DECL\s+)?(?:GLOBAL\s+)?(?:CONST\s+)?)(?P<type>[A-Za-z_]\w*)\s+(?P<names>[A-Za-z_$].*)",
    re.IGNORECASE,
)
_ROUTINE: Final = re.compile(
    r"(?:GLOBAL\s+)?(DEF|DEFFCT)\s+(?:([A-Za-z_]\w*)(?:\s*\[[^\]]*\])?\s+)?([A-Za-z_]\w*)\s*\((.*?)\)",
    re.IGNORECASE,
)
# What a statement says beside names: texts, constants of enumerations, values with their components, members.
_PASSED_OVER: Final = re.compile(r"\"[^\"]*\"?|'[^']*'?|#\w+|\{[^}]*\}?|\.\s*[A-Za-z_]\w*")
_USED: Final = re.compile(r"(?<![\w$])[A-Za-z_]\w*")
# A value with an index, a component or a call in it: a list takes constants alone.
_COMPUTED: Final = re.compile(r"\s*=\s*[A-Za-z_]\w*\s*(?:[(\[]|\.\s*[A-Za-z_])")
_INERT: Final = re.compile(
    r"(?:&|(?:GLOBAL\s+)?DEF(?:FCT|DAT)?\b|END(?:FCT|DAT)?\b\s*$|EXT(?:FCT)?P?\b|IMPORT\b)", re.IGNORECASE
)


_NAMED: Final = re.compile(r"\s*([$A-Za-z_][\w$]*)\s*(\[[^\]]*\])?")


_SET: Final = re.compile(r"([A-Za-z_]\w*)\s*(?:\[[^\]]*\]|\.\s*\w+)*\s*=(?!=)")
_IMPORTED: Final = re.compile(r"IMPORT\s+\w+\s+(\w+)", re.IGNORECASE)
_PRIORITY: Final = re.compile(r"(?:GLOBAL\s+)?INTERRUPT\s+DECL\s+(\d+)\b", re.IGNORECASE)
_LEAST_PRIORITY: Final = 128
_MOST_DIMENSIONS: Final = 3
_ENDS: Final = {"DEF": "END", "DEFFCT": "ENDFCT"}


class Name(NamedTuple):
    text: str
    span: Span

    @property
    def key(self) -> str:
        return self.text.casefold()


@dataclass(slots=True)
class KrlRoutine:
    """`result`: the type of what a function returns. `names`: what its declarations declare; `body`: its other lines,
    with their numbers. `end`: the word that closes it.
    """

    name: Name
    kind: str
    result: str = ""
    parameters: list[Name] = field(default_factory=list)
    names: list[tuple[Name, str]] = field(default_factory=list)
    body: list[tuple[int, str]] = field(default_factory=list)
    late: list[tuple[int, str]] = field(default_factory=list)
    shared: bool = False
    end: Name | None = None


@dataclass(slots=True)
class File:
    """A module or a list: `names` are those of a list, with their types; `types` what STRUC and ENUM declare.

    `members`: by structure (small letters), its components with their types. `enums`: by enumeration, its constants.
    Types end with a pair of brackets that holds one comma less than there are indices.
    """

    routines: list[KrlRoutine] = field(default_factory=list)
    names: list[tuple[Name, str]] = field(default_factory=list)
    types: set[str] = field(default_factory=set)
    list_name: Name | None = None
    public: bool = False
    constants: set[str] = field(default_factory=set)
    members: dict[str, dict[str, str]] = field(default_factory=dict)
    enums: dict[str, set[str]] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)  # names in statements, in small letters
    computed: list[Name] = field(default_factory=list)  # declared with a value that is no constant
    valued: list[Name] = field(default_factory=list)  # declared with a value
    values: list[tuple[int, str]] = field(default_factory=list)  # `NAME = VALUE` of these, with their lines
    published: list[Name] = field(default_factory=list)  # GLOBAL variables of the list
    imported: set[str] = field(default_factory=set)  # names that IMPORT gives to variables of other lists
    visible: set[str] = field(default_factory=set)  # names of the list that all modules may use
    repeated: list[tuple[str, Name]] = field(
        default_factory=list
    )  # constants of an enumeration that it has already


_POSE: Final = dict.fromkeys(("x", "y", "z", "a", "b", "c"), "real")
_TURNS: Final = dict.fromkeys(("s", "t"), "int")
_EXTERNAL: Final = dict.fromkeys(("e1", "e2", "e3", "e4", "e5", "e6"), "real")
_AXES: Final = dict.fromkeys(("a1", "a2", "a3", "a4", "a5", "a6"), "real")
# Components of the controller's own structures ("System Integrators", KSS 8: data types).
_COMPONENTS: Final[Mapping[str, Mapping[str, str]]] = {
    "frame": _POSE,
    "pos": _POSE | _TURNS,
    "e6pos": _POSE | _TURNS | _EXTERNAL,
    "axis": _AXES,
    "e6axis": _AXES | _EXTERNAL,
}


@dataclass(frozen=True, slots=True)
class Structures:
    """What all files of a cell say of types; a type that two of them declare otherwise has what any of them says."""

    members: Mapping[str, Mapping[str, str]]
    enums: Mapping[str, set[str]]

    @classmethod
    def of(cls, files: Iterable[File]) -> Structures:
        members: dict[str, dict[str, str]] = {kind: dict(known) for kind, known in _COMPONENTS.items()}
        enums: dict[str, set[str]] = {}
        for file in files:
            for kind, own in file.members.items():
                known = members.setdefault(kind, {})
                for name, type_ in own.items():
                    known[name] = type_ if known.get(name, type_) == type_ else ""
            for kind, constants in file.enums.items():
                enums.setdefault(kind, set()).update(constants)
        return cls(members, enums)


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller refuses in one module, with its list."""
    found = LoadFindings(source)
    files = [(one, file_of(one)) for one in cell.sources]
    own = files[0][1]
    if re.search(r"[\\/](?:System|TP|Mada|STEU)[\\/]", source.path, re.IGNORECASE):
        return []  # the controller's own
    types = {name for _, file in files for name in file.types} | _TYPES
    for kind, name in own.repeated:
        found.tell("K102", f"the enumeration {kind} has {name.text} twice", name.span, "take one of them out")
    for name, kind in (*own.names, *(pair for r in own.routines for pair in r.names)):
        if kind.count(",") >= _MOST_DIMENSIONS:
            says = f"{name.text} has {kind.count(',') + 1} dimensions"
            found.tell("K109", says, name.span, f"{_MOST_DIMENSIONS} at most")
    closed = own.list_name if not own.public else None
    for name in own.published if closed is not None else ():
        help = f"DEFDAT {closed.text} PUBLIC" if closed is not None else ""
        found.tell("K115", f"{name.text} is GLOBAL in a list that is not PUBLIC", name.span, help)
    for name in own.computed:
        help = "give it a number here, and compute it in a statement"
        found.tell("K107", f"the first value of {name.text} is computed", name.span, help)
    if not own.routines:
        found.doubles((name.key, name.text, name.span) for name, _ in own.names)
        for name, kind in own.names:
            _type(found, name, kind, types)
        _first_values(found, own, Structures.of(file for _, file in files))
        return found.finish({kind.upper() for kind in types}, whole=False, shared=True)
    mine = stem(source.path)
    beside = [file for one, file in files[1:] if stem(one.path) == mine and file.list_name is not None]
    _characters(found)
    _heads(found, own, mine)
    inside = {name.span for routine in own.routines for name, _ in routine.names}
    for name in own.valued:
        if name.span in inside:
            help = "set it in a statement, or declare it in the list"
            found.tell("K115", f"{name.text} gets a value where a routine declares it", name.span, help)
    shared: dict[str, str] = {}
    for _, file in files:
        for name, kind in file.names:
            shared[name.key] = kind if shared.get(name.key, kind) == kind else ""
    structures = Structures.of(file for _, file in files)
    constants = {one for file in (own, *beside) for one in file.constants}
    routines: dict[str, KrlRoutine] = {}
    for index, (_, file) in enumerate(files):
        for number, routine in enumerate(file.routines):
            if not index or not number or routine.shared:
                routines.setdefault(routine.name.key, routine)
    lists = {n.key: (n, kind) for file in (own, *beside) for n, kind in file.names}
    users = _users_lines(source)
    hidden = {r.name.key: one.path for one, file in files[1:] for r in file.routines[1:] if not r.shared}
    configured = any(stem(one.path) == "$CONFIG" for one, _ in files)
    visible = {key for file in (own, *beside) for key in file.imported}.union(*(f.visible for _, f in files))
    kept = {
        n.key: one.path for one, file in files for n, _ in file.names if n.key not in lists.keys() | visible
    }
    shared_names = set(shared) - (kept.keys() if configured else set())
    found.doubles((r.name.key, r.name.text, r.name.span) for r in own.routines)
    for routine in own.routines:
        _routine(found, routine, shared, shared_names, routines, types, lists, structures)
        _kept(
            found,
            routine,
            constants - {n.key for n, _ in routine.names} - {n.key for n in routine.parameters},
        )
    names = {n.text for _, file in files for n, _ in file.names} | {r.name.text for r in routines.values()}
    names |= {n.text for r in own.routines for n, _ in r.names} | {kind.upper() for kind in types}
    complete = configured and _is_complete((file for _, file in files), names)
    found.unknown = [one for one in found.unknown if users is None or one[1].line in users]
    _of_other_modules(found, hidden, kept if configured else {})
    return found.finish(names, complete and _in_tree(source), shared=not configured, complete=complete)


def _of_other_modules(found: LoadFindings, hidden: dict[str, str], kept: dict[str, str]) -> None:
    """Unknown names that another module has for itself alone: every call of its routines, and each of its variables
    once. `hidden`, `kept`: the paths of these modules, by routine and by variable."""
    once: set[str] = set()
    for name, span, what in list(found.unknown):
        key = name.casefold()
        path = (hidden if what == "the routine" else kept).get(key)
        if path is None:
            continue
        found.unknown.remove((name, span, what))
        if what == "the routine":
            says = f"{name} of {Path(path).name} is not GLOBAL: no other module calls it"
            found.tell("K101", says, span, f"GLOBAL DEF {name}")
        elif key not in once:
            once.add(key)
            says = f"{name} of {Path(path).name} is not GLOBAL: no other module sees it"
            found.tell("K101", says, span, "DEFDAT … PUBLIC and DECL GLOBAL, or declare it in $config.dat")


def _users_lines(source: Source) -> set[int] | None:
    """Lines in USER folds of a submit program, whose other lines are the controller's and its options'; else None."""
    if not source.path.lower().endswith(".sub"):
        return None
    found: set[int] = set()
    folds: list[bool] = []
    for number, line in enumerate(source.lines, 1):
        text = line.strip().upper()
        if text.startswith(";FOLD"):
            folds.append(text[5:].lstrip().startswith("USER"))
        elif text.startswith(";ENDFOLD"):
            del folds[-1:]
        elif any(folds):
            found.add(number)
    return found


def _is_complete(files: Iterable[File], declared: Iterable[str]) -> bool:
    """Whether a cell declares nearly all that its programs name."""
    known = {name.casefold() for name in declared} | _CONFIG | FUNCTIONS | _OPTIONS | KNOWN_ROUTINES.keys()
    used: set[str] = set()
    for file in files:
        used |= file.used
        known |= {n.key for r in file.routines for n in (r.name, *r.parameters, *(n for n, _ in r.names))}
    return len(used - known) <= max(1, MOST_MISSING * len(used))


def _in_tree(source: Source) -> bool:
    """Whether the file stands in an archive's program folder, so that all other files are there."""
    return bool(re.search(r"[\\/]R1[\\/](?:Program|System|TP)[\\/]", source.path, re.IGNORECASE))


def _code(line: str) -> str:
    code, _ = parsing.split(line)
    return code


@lru_cache(maxsize=1024)
def file_of(source: Source) -> File:
    """The declarations of a module or a list, as far as they can be told."""
    file = File()
    routine: KrlRoutine | None = None
    begun = in_list = False
    for number, line in enumerate(source.lines, 1):
        code = _code(line)
        if not code:
            continue
        head = _ROUTINE.match(code)
        if head is not None:
            routine = _begun(head, number, line)
            file.routines.append(routine)
            begun = False
            continue
        word = code.split("(", 1)[0].split(None, 1)[0].upper()
        if word == "DEFDAT":
            match = re.match(r"DEFDAT\s+(\$?\w+)\s*(PUBLIC)?", code, re.IGNORECASE)
            if match:
                file.list_name = Name(match[1], _span(line, number, match[1]))
                file.public = bool(match[2]) or match[1].startswith("$")
            in_list = True
            continue
        if imported := _IMPORTED.match(code):
            file.imported.add(imported[1].casefold())
            continue
        if _INERT.match(code) and not in_list:
            if routine is not None and word in _ENDS.values():
                routine.end = Name(word, _span(line, number, line.split()[0]))
                routine = None
            continue
        if word in ("ENDDAT",):
            in_list = False
            continue
        declared = _declared(code, number, line, file)
        if declared is None:
            begun = begun or routine is not None
            if routine is not None:
                routine.body.append((number, code))
                file.used |= {word.casefold() for word in _USED.findall(_PASSED_OVER.sub("", code))} - _WORDS
        elif routine is not None:
            routine.names += declared
            if begun and declared:
                routine.late.append((number, line))
        else:
            file.names += declared
            whole = file.list_name is None or file.list_name.text.startswith("$")
            if whole or re.search(r"\bGLOBAL\b", code.split("=", 1)[0], re.IGNORECASE):
                file.visible |= {name.key for name, _ in declared}
    return file


def _begun(head: re.Match[str], number: int, line: str) -> KrlRoutine:
    kind, shared = head[1].upper(), head[0].upper().startswith("GLOBAL")
    result = (head[2] or "").casefold() if kind == "DEFFCT" else ""
    routine = KrlRoutine(Name(head[3], _span(line, number, head[3])), kind, result, shared=shared)
    given = re.sub(r"\[[^\]]*\]", "", head[4])  # an array of several indices has commas of its own: OUTPUT[,]
    for text in filter(None, (one.split(":")[0].strip() for one in given.split(","))):
        routine.parameters.append(Name(text, _span(line, number, text)))
    return routine


def _span(line: str, number: int, text: str) -> Span:
    match = re.search(rf"(?<![\w$]){re.escape(text)}(?![\w$])", line)
    at = match.start() + 1 if match else 1
    return Span(number, at, at + len(text))


def _declared(code: str, number: int, line: str, file: File) -> list[tuple[Name, str]] | None:
    """The names that a line declares with their type; None for a statement."""
    match = _DECLARES.match(code)
    word = code.split(None, 1)[0].upper()
    if word == "SIGNAL" or re.match(r"GLOBAL\s+SIGNAL\b|DECL\s+(?:GLOBAL\s+)?SIGNAL\b", code, re.IGNORECASE):
        name = re.search(r"SIGNAL\s+([$\w]+)", code, re.IGNORECASE)
        return [(Name(name[1], _span(line, number, name[1])), "signal")] if name else []
    if match is None:
        return None
    kind = match["type"].casefold()
    if kind in ("struc", "enum"):
        name = re.match(r"[\w$]+", match["names"])
        if name:
            file.types.add(name[0].casefold())
            rest = match["names"][name.end() :]
            if kind == "enum":
                words = [one.strip() for one in rest.split(",")]
                file.enums[name[0].casefold()] = {one.casefold() for one in words}
                doubled = {
                    one for i, one in enumerate(words) if one.casefold() in map(str.casefold, words[:i])
                }
                file.repeated += [(name[0], Name(one, _span(line, number, one))) for one in sorted(doubled)]
            else:
                file.members[name[0].casefold()] = _components(rest)
        return []
    explicit = re.search(r"\b(?:DECL|CONST)\b", match["head"], re.IGNORECASE) or kind in _TYPES | _FOREIGN
    if not explicit or kind in _WORDS - _IN_PLACE:
        return None
    found = []
    for part in _parts(match["names"]):
        name = _NAMED.match(part)
        if name:
            found.append((Name(name[1], _span(line, number, name[1])), kind + _indices(name[2])))
            if "const" in match["head"].casefold():
                file.constants.add(name[1].casefold())
            if "global" in match["head"].casefold():
                file.published.append(found[-1][0])
            value = part[name.end() :].strip()
            if _COMPUTED.match(value):
                file.computed.append(found[-1][0])
            if value.startswith("="):
                file.valued.append(found[-1][0])
                file.values.append((number, part.strip()))
    return found


def _indices(written: str | None) -> str:
    """`[3,15]` as `[,]`: how many indices there are, not how far they go."""
    return "" if written is None else f"[{',' * written.count(',')}]"


def _components(text: str) -> dict[str, str]:
    """The components of a structure, with their types; a type holds for all names until the next one."""
    found: dict[str, str] = {}
    kind = ""
    for part in _parts(text):
        typed = re.match(r"\s*([A-Za-z_]\w*)\s+(?=[A-Za-z_$])", part)
        if typed:
            kind = typed[1].casefold()
        name = _NAMED.match(part[typed.end() :] if typed else part)
        if name:
            found[name[1].casefold()] = kind + _indices(name[2])
    return found


def _parts(text: str) -> list[str]:
    """What stands between commas that no bracket holds."""
    found, depth, start, quoted = [], 0, 0, False
    for i, sign in enumerate(text):
        quoted ^= sign == '"'
        if not quoted:
            depth += (sign in "([{") - (sign in ")]}")
            if sign == "," and depth == 0:
                found.append(text[start:i])
                start = i + 1
    return [*found, text[start:]]


def _characters(found: LoadFindings) -> None:
    for number, line in enumerate(found.source.lines, 1):
        code = _code(line)
        if code.isascii() or code.startswith("&"):
            continue
        bare = re.sub(r'"[^"]*"', "", code)
        odd = next((sign for sign in bare if not sign.isascii()), "")
        if odd:
            at = line.find(odd) + 1
            found.tell(
                "K105",
                f"the character {odd!r} stands outside of a comment or a text",
                Span(number, at, at + 1),
            )


def _heads(found: LoadFindings, own: File, mine: str) -> None:
    names = [r.name for r in own.routines] + [n for r in own.routines for n, _ in r.names]
    for name in names:
        found.too_long("name", name.text, name.span, _LONGEST)
        if name.key in _WORDS - _IN_PLACE and len(name.key) > 2:
            found.tell("K104", f"{name.text} is a word of KRL and no name", name.span, "call it otherwise")
    first = own.routines[0].name
    named = re.fullmatch(r"[A-Z_]\w*", mine) is not None  # else no controller has the file under this name
    # A copy under another name is no mistake before it comes to the controller.
    meant = _in_tree(found.source) or is_near(mine.casefold(), first.text.casefold())
    if named and meant and all(r.name.text.upper() != mine for r in own.routines):
        found.tell(
            "K113",
            f"the file is called {mine}, and no routine in it is",
            first.span,
            f"call the file {first.text}.src, or the first routine {mine}",
            Severity.WARNING,
        )


def _routine(
    found: LoadFindings,
    routine: KrlRoutine,
    shared: dict[str, str],
    shared_names: set[str],
    routines: dict[str, KrlRoutine],
    types: set[str],
    lists: dict[str, tuple[Name, str]],
    structures: Structures,
) -> None:
    for number, line in routine.late:
        help = "the declarations of a routine stand before its first statement, INI among them"
        begin = len(line) - len(line.lstrip()) + 1
        found.tell(
            "K106", "a declaration behind a statement", Span(number, begin, len(line.rstrip()) + 1), help
        )
    if routine.end is not None and routine.end.text != _ENDS[routine.kind]:
        says = f"{routine.end.text} closes a {routine.kind}"
        found.tell("K114", says, routine.end.span, _ENDS[routine.kind])
    declared = [n for n, _ in routine.names]
    found.doubles((n.key, n.text, n.span) for n in declared)
    for name, kind in routine.names:
        _type(found, name, kind, types)
    local = {n.key for n in declared} | {n.key for n in routine.parameters}
    own = {n.key: kind for n, kind in (*lists.values(), *routine.names)}
    unsure = {n.key: "" for n in routine.parameters if n.key not in own}
    kinds = {**shared, **unsure, **own}
    for parameter in routine.parameters:  # their brackets say nothing of how many indices there are
        if "[" in kinds[parameter.key]:
            kinds[parameter.key] = ""
    for parameter in routine.parameters:
        if parameter.key not in own and parameter.key not in _WORDS:
            help = f"declare it below {routine.kind}: DECL REAL {parameter.text}"
            found.tell("K101", f"the parameter {parameter.text} has no type", parameter.span, help)
    scope = _KrlScope(local | set(lists), shared_names, routines, kinds, structures, routine)
    in_spline = ""
    for number, code in routine.body:
        word = code.split(None, 1)[0].upper()
        in_spline = word if word in ("SPLINE", "PTP_SPLINE") else "" if word in _SPLINE_ENDS else in_spline
        _placed(found, number, code, word, in_spline)
        _line(found, number, code, scope)
    if routine.kind == "DEFFCT" and not any(re.match(r"RETURN\b", c, re.IGNORECASE) for _, c in routine.body):
        found.tell("K108", f"{routine.name.text} is a DEFFCT and returns nothing", routine.name.span)


def _kept(found: LoadFindings, routine: KrlRoutine, constants: set[str]) -> None:
    """Tells what sets a constant, and a SWITCH that has no CASE."""
    switch = 0
    for number, code in routine.body:
        if (set_one := _SET.match(code)) and set_one[1].casefold() in constants:
            span = found.place_of(number, set_one[1])
            found.tell("K111", f"{set_one[1]} is a constant", span, "declare it without CONST")
        word = code.split(None, 1)[0].upper()
        if switch and word in ("DEFAULT", "ENDSWITCH"):
            found.tell("K114", "SWITCH without a CASE", found.whole_line(switch), "write at least one CASE")
        switch = number if re.match(r"SWITCH\b", code, re.IGNORECASE) else 0
        if (priority := _PRIORITY.match(code)) and not 1 <= int(priority[1]) <= _LEAST_PRIORITY:
            span = found.place_of(number, priority[1])
            found.tell("K109", f"an interrupt has no priority {priority[1]}", span, f"1 to {_LEAST_PRIORITY}")


_SPLINE_ENDS: Final = ("ENDSPLINE", "END_SPLINE")
_OLD_MOVES: Final = ("PTP", "LIN", "CIRC", "PTP_REL", "LIN_REL", "CIRC_REL")


def _placed(found: LoadFindings, number: int, code: str, word: str, in_spline: str) -> None:
    """Words that may not stand where they do."""
    if in_spline and word in _OLD_MOVES:
        says, help = f"{word} within {in_spline}", f"write S{word}, or SPL"
    elif word == "ELSEIF":
        says, help = "KRL has no ELSEIF", "write ELSE and IF … ENDIF"
    elif word in ("LIN", "CIRC", "LIN_REL", "CIRC_REL") and re.search(r"\bC_PTP\b", code, re.IGNORECASE):
        says, help = f"C_PTP belongs to PTP, not to {word}", "write C_DIS, C_VEL or C_ORI"
    elif match := re.match(r"(\$IN(?:GRP)?\s*\[[^\]]*\]|\$ANIN\s*\[[^\]]*\])\s*=(?!=)", code, re.IGNORECASE):
        says, help = f"{match[1]} is an input and cannot be set", "set an output: $OUT[n]"
    else:
        return
    line = found.source.line(number)
    begin = len(line) - len(line.lstrip()) + 1
    found.tell("K115", says, Span(number, begin, begin + len(word)), help)


# Types of other languages, which no cell declares.
_FOREIGN: Final = frozenset(
    ("string", "integer", "double", "float", "boolean", "num", "byte", "word", "long")
)


def _type(found: LoadFindings, name: Name, kind: str, types: set[str]) -> None:
    bare = kind.partition("[")[0]
    if bare in _FOREIGN - types:
        help = "KRL has INT, REAL, BOOL, CHAR and CHAR[]"
        found.tell("K101", f"KRL has no type {bare.upper()}", name.span, help)
    elif bare not in types and bare != "signal" and bare[-2:] != "_t":
        found.unknown.append((bare.upper(), name.span, "the type"))


_Token = tuple[str | None, str, int]


@dataclass(frozen=True, slots=True)
class _KrlScope:
    """What a line of a routine may name. `kinds`: types of variables; `local`: names of the module and its list."""

    local: set[str]
    shared: set[str]
    routines: Mapping[str, KrlRoutine]
    kinds: Mapping[str, str]
    structures: Structures
    routine: KrlRoutine


def _tokens(found: LoadFindings, number: int, code: str) -> list[_Token]:
    offset = max(0, found.source.line(number).find(code[:8]))
    return [(m.lastgroup, m[0], m.start() + offset + 1) for m in _TOKEN.finditer(code)]


def _first_values(found: LoadFindings, file: File, structures: Structures) -> None:
    """First values of a list that are of another kind, or have components and constants that their type does not."""
    of_list = KrlRoutine(file.list_name or Name("", Span(1, 1, 1)), "DEFDAT")
    scope = _KrlScope(set(), set(), {}, {n.key: kind for n, kind in file.names}, structures, of_list)
    for number, code in file.values:
        tokens = _tokens(found, number, code)
        sign = next(i for i, t in enumerate(tokens) if t[1] == "=")
        says = "".join(t[1] for t in tokens[:sign]) + " is"
        _fits(found, number, _kind_of(tokens[:sign], scope), tokens[sign + 1 :], scope, says)
        _constants(found, number, tokens, scope)
        _aggregates(found, number, tokens, scope)


def _line(found: LoadFindings, number: int, code: str, scope: _KrlScope) -> None:
    tokens = _tokens(found, number, code)
    if not tokens or re.match(r"[A-Za-z_]\w*\s*:\s*$", code):
        return
    head = tokens[0][1].casefold()
    if head == "goto":
        return  # the reader knows the labels
    _types(found, number, tokens, scope)
    _constants(found, number, tokens, scope)
    _aggregates(found, number, tokens, scope)
    for i, token in enumerate(tokens):
        kind, text, _ = token
        key = text.casefold()
        before = tokens[i - 1][1] if i else ""
        after = tokens[i + 1][1] if i + 1 < len(tokens) else ""
        if kind != "word" or key.startswith("$") or before in (".", "#") or key in _WORDS:
            continue
        if _is_member(tokens, i):
            continue
        if after == "(":
            _call(found, number, tokens, i, scope)
        elif key in scope.local or key in scope.shared or key in _CONFIG or key in FUNCTIONS:
            found.known.add(key)
            _part(found, number, tokens, i, scope.kinds.get(key, ""), scope.structures)
        elif i == 0 and after == "=" and len(tokens) > 1:
            found.unknown.append((text, _at(number, token), "the variable"))
        else:
            found.unknown.append((text, _at(number, token), "the name"))


def _is_member(tokens: list[_Token], at: int) -> bool:
    """Whether a word names a member, or the type, of a value written out: {E6POS: X 1, Y 2}."""
    if tokens[at - 1][1] not in ("{", ",", ":") or not at:
        return False
    depth: list[str] = []
    for _, text, _ in tokens[:at]:
        if text in ("{", "(", "["):
            depth.append(text)
        elif text in ("}", ")", "]") and depth:
            depth.pop()
    return bool(depth) and depth[-1] == "{"


def _at(number: int, token: _Token) -> Span:
    return Span(number, token[2], token[2] + len(token[1]))


def _part(
    found: LoadFindings,
    number: int,
    tokens: list[_Token],
    at: int,
    kind: str,
    structures: Structures,
) -> None:
    """Whether the indices and members behind a variable are such as its declaration has."""
    name = tokens[at]
    while kind:
        bare, bracket, commas = kind.partition("[")
        if at + 1 < len(tokens) and tokens[at + 1][1] == "[":
            end = _closing(tokens, at + 1)
            given = _commas(tokens[at + 1 : end])
            if not bracket or end < 0:
                if end > 0 and bare != "signal":
                    found.tell("K109", f"{name[1]} is declared without indices", _at(number, name))
                return
            index = tokens[at + 2] if end == at + 3 else None
            if index is not None and index[0] == "number" and not index[1].isdigit():
                found.tell("K109", f"the index {index[1]} is no whole number", _at(number, index))
            if given != commas.count(","):
                says = f"{name[1]} has {commas.count(',') + 1} indices, and {given + 1} are given"
                found.tell("K109", says, _at(number, name))
                return
            at = end
        elif bracket and (at + 1 == len(tokens) or tokens[at + 1][1] != "["):
            found.tell("K109", f"{name[1]} is declared with indices, and none are given", _at(number, name))
            return
        known = structures.members.get(bare)
        if known is None or at + 2 >= len(tokens) or tokens[at + 1][1] != ".":
            return
        at += 2
        name = tokens[at]
        if name[0] == "word" and name[1].casefold() not in known:
            found.tell(
                "K109",
                f"{bare.upper()} has no component {name[1]}",
                _at(number, name),
                f"one of {', '.join(one.upper() for one in list(known)[:_SHOWN])}",
            )
        kind = known.get(name[1].casefold(), "")


def _closing(tokens: list[_Token], start: int) -> int:
    """Where the bracket that opens at `start` closes, -1 where it does not."""
    depth = 0
    for i in range(start, len(tokens)):
        depth += (tokens[i][1] in "([{") - (tokens[i][1] in ")]}")
        if not depth:
            return i
    return -1


def _commas(tokens: list[_Token]) -> int:
    """How many commas stand between the outer brackets alone."""
    depth = count = 0
    for _, text, _ in tokens:
        depth += (text in "([{") - (text in ")]}")
        count += text == "," and depth == 1
    return count


# Types that the controller converts into each other; a structure or an enumeration is like itself alone.
_ALIKE: Final[Mapping[str, str]] = {
    **dict.fromkeys(("int", "real"), "number"),
    **dict.fromkeys(("frame", "pos", "e6pos"), "pose"),
    **dict.fromkeys(("axis", "e6axis"), "axes"),
    "bool": "bool",
}
_SYSTEM_KINDS: Final[Mapping[str, str]] = dict.fromkeys(("$in", "$out", "$flag", "$cycflag"), "bool[]")
_COMPARES: Final = frozenset(("==", "<>", "<", ">", "<=", ">=", "and", "or", "not", "exor"))
_COMPUTES: Final = frozenset(("+", "-", "*", "/", "b_and", "b_or", "b_exor", "b_not"))
_TEXT, _CONSTANT = "text", "#"


def _types(found: LoadFindings, number: int, tokens: list[_Token], scope: _KrlScope) -> None:
    """Whether the values of a line are such as its statement takes."""
    head = tokens[0][1].casefold()
    last = len(tokens) - (tokens[-1][1].casefold() in ("then", "do"))
    sign = next((i for i, t in enumerate(tokens) if t[1] == "=" and not _depth(tokens, i)), 0)
    if head in ("if", "while", "until"):
        _condition(found, number, tokens[1:last], scope)
    elif head == "for" and sign > 1 and _alike(_kind_of(tokens[1:sign], scope), scope) not in ("", "number"):
        found.tell("K108", f"{tokens[1][1]} is no number, and counts no loop", _at(number, tokens[1]))
    elif head == "for" and sign > 1 and _kind_of(tokens[1:sign], scope) == "real":
        found.tell("K108", f"{tokens[1][1]} is REAL, and loops count with INT", _at(number, tokens[1]))
    elif head in ("switch", "case"):
        _choice(found, number, tokens[1:], scope)
    elif head == "wait" and tokens[1:] and tokens[1][1].casefold() == "for":
        _condition(found, number, tokens[2:], scope)
    elif head == "wait":
        _fits(found, number, "real", tokens[2:], scope, "WAIT SEC takes a")
    elif head == "return" and scope.routine.kind == "DEF" and len(tokens) > 1:
        found.tell("K108", "only a DEFFCT returns a value", _at(number, tokens[1]))
    elif head == "return":
        result, says = scope.routine.result, f"{scope.routine.name.text} returns"
        _fits(found, number, result, tokens[1:], scope, says)
        if result and len(tokens) == 1:
            found.tell("K108", f"{says} {result.upper()}, and here nothing", _at(number, tokens[0]))
    elif sign and head not in _WORDS:
        says = "".join(t[1] for t in tokens[:sign]) + " is"
        _fits(found, number, _kind_of(tokens[:sign], scope), tokens[sign + 1 :], scope, says)
    elif head in _MOVES and tokens[1:] and tokens[1][0] == "word":
        end = next((i for i, t in enumerate(tokens) if t[1].casefold() in _MOVE_ENDS), len(tokens))
        kind = _ALIKE.get(_kind_of(tokens[1:end], scope), "")
        if kind in ("number", "bool") or scope.kinds.get(tokens[1][1].casefold()) in _MOVE_DATA:
            found.tell("K108", f"{tokens[1][1]} is no place", _at(number, tokens[1]))
    _logic(found, number, tokens[sign + 1 if sign and head not in _WORDS else 1 : last], scope)
    _sums(found, number, tokens, scope)
    for at in range(len(tokens) - 1):
        routine = scope.routines.get(tokens[at][1].casefold()) if tokens[at + 1][1] == "(" else None
        if routine is not None and (not at or tokens[at - 1][1] != "."):
            _arguments(found, number, tokens[at + 1 :], routine, scope)


_LOGIC: Final = frozenset(("and", "or", "exor", "not"))


def _choice(found: LoadFindings, number: int, given: list[_Token], scope: _KrlScope) -> None:
    """What SWITCH asks and CASE answers: whole numbers, characters and constants of enumerations."""
    for one in _split(given):
        computed = any(t[1].casefold() in _COMPUTES for t in one)  # INT or REAL: what it is of is not asked
        if not computed and _kind_of(one, scope) in ("real", "bool"):
            says = f"{_shown(one, scope)}, and SWITCH takes INT, CHAR or an enumeration"
            found.tell("K108", says, _at(number, one[0]))


def _logic(found: LoadFindings, number: int, given: list[_Token], scope: _KrlScope) -> None:
    """Operands of AND, OR, EXOR and NOT that are no BOOL, those in brackets too."""
    places = [i for i, t in enumerate(given) if t[1].casefold() in _LOGIC and not _depth(given, i)]
    starts = [0, *(i + 1 for i in places)]
    for start, end in zip(starts, [*places, len(given)], strict=True):
        operand = given[start:end]
        if not operand:
            continue
        if operand[0][1] == "(" and _closing(operand, 0) == len(operand) - 1:
            _logic(found, number, operand[1:-1], scope)
        if places and _alike(_kind_of(operand, scope), scope) not in ("", "bool"):
            says = f"{_shown(operand, scope)}, and no condition"
            found.tell("K108", says, _at(number, operand[0]), "compare it with a value, or write B_AND, B_OR")


def _sums(found: LoadFindings, number: int, tokens: list[_Token], scope: _KrlScope) -> None:
    """Operands of + - * / that are BOOL, as digital signals are."""
    for at, (_, sign, _) in enumerate(tokens):
        if sign not in _SIGNS:
            continue
        for operand in (_before(tokens, at), _behind(tokens, at)):
            if operand and _kind_of(operand, scope) == "bool":
                text = "".join(t[1] for t in operand)
                wanted = "set a number where it is TRUE, with IF"
                found.tell("K108", f"{text} is BOOL, and no number", _at(number, operand[0]), wanted)


def _behind(tokens: list[_Token], at: int) -> list[_Token]:
    """The operand behind an operator: a name with its indices and components, or a bracket."""
    end = at + 1
    if end < len(tokens) and tokens[end][0] == "word":
        end += 1
    while 0 < end < len(tokens) and tokens[end][1] in ("[", "(", "."):
        end = end + 2 if tokens[end][1] == "." else _closing(tokens, end) + 1
    return tokens[at + 1 : max(end, at + 1)]


def _before(tokens: list[_Token], at: int) -> list[_Token]:
    """The operand before an operator; none before a sign."""
    start = at
    while start and tokens[start - 1][1] in ("]", ")"):
        start = next(i for i in range(start - 1, -1, -1) if _closing(tokens, i) == start - 1)
    if start and tokens[start - 1][0] == "word" and tokens[start - 1][1].casefold() not in _WORDS:
        start -= 1
    return tokens[start:at] if start < 2 or tokens[start - 1][1] != "." else []


_SIGNS: Final = frozenset(("+", "-", "*", "/"))
_MOVES: Final = frozenset(("ptp", "lin", "sptp", "slin"))
_MOVE_ENDS: Final = frozenset(("c_ptp", "c_dis", "c_vel", "c_ori", "c_spl", "with"))
_MOVE_DATA: Final = ("fdat", "ldat", "pdat")  # of inline forms, which stand beside their place


def _arguments(
    found: LoadFindings, number: int, tokens: list[_Token], routine: KrlRoutine, scope: _KrlScope
) -> None:
    """What a routine is given in the bracket that opens, by type; a place may be left empty."""
    end = _closing(tokens, 0)
    types = {n.key: kind for n, kind in routine.names}
    for parameter, given in zip(routine.parameters, _split(tokens[1:end]), strict=False):
        wanted = types.get(parameter.key, "")
        if given and "[" not in wanted:
            _fits(found, number, wanted, given, scope, f"{parameter.text} of {routine.name.text} is")


def _split(tokens: list[_Token]) -> list[list[_Token]]:
    """What stands between the commas that no bracket holds."""
    found: list[list[_Token]] = [[]]
    depth = 0
    for token in tokens:
        depth += (token[1] in "([{") - (token[1] in ")]}")
        if token[1] == "," and not depth:
            found.append([])
        else:
            found[-1].append(token)
    return found


def _condition(found: LoadFindings, number: int, given: list[_Token], scope: _KrlScope) -> None:
    """Whether what a statement asks for can be true."""
    if _alike(_kind_of(given, scope), scope) not in ("", "bool"):
        says = f"{_shown(given, scope)}, and no condition"
        found.tell("K108", says, _at(number, given[0]), "compare it with a value")


def _fits(
    found: LoadFindings, number: int, wanted: str, given: list[_Token], scope: _KrlScope, says: str
) -> None:
    """Tells a value of another type than is taken; nothing where one of them is not known. `says`: what takes it."""
    own, other = (_alike(kind, scope) for kind in (wanted, _kind_of(given, scope)))
    if own and other and own != other and not (other == _CONSTANT and wanted in scope.structures.enums):
        found.tell("K108", f"{says} {wanted.upper()}, and {_shown(given, scope)}", _at(number, given[0]))


def _shown(given: list[_Token], scope: _KrlScope) -> str:
    """A value, and of which type it is."""
    kind = _kind_of(given, scope)
    text = "".join(one[1] for one in given) if kind == _CONSTANT or len(given) == 1 else "this"
    return f"{text} is {'a constant of an enumeration' if kind == _CONSTANT else kind.upper()}"


def _alike(kind: str, scope: _KrlScope) -> str:
    if kind in scope.structures.enums or kind in scope.structures.members or kind in (_TEXT, _CONSTANT):
        return _ALIKE.get(kind, kind)
    return _ALIKE.get(kind, "")


def _kind_of(tokens: list[_Token], scope: _KrlScope) -> str:
    """The type of an expression, "" where it is not known."""
    outer = {t[1].casefold() for i, t in enumerate(tokens) if not _depth(tokens, i)}
    if not tokens or outer & _COMPARES:
        return "bool" if tokens else ""
    if ":" in outer:
        return "frame"
    if outer & _COMPUTES:
        return "real"
    kind, text, _ = tokens[0]
    if text == "#":
        return _CONSTANT
    if text == "(" and _closing(tokens, 0) == len(tokens) - 1:
        return _kind_of(tokens[1:-1], scope)
    if len(tokens) == 1 and kind == "number":
        return "real" if "." in text else "int"
    if len(tokens) == 1 and kind == "text":
        return _TEXT if text.startswith('"') else "int"  # a number of other digits, as 'B101'
    if len(tokens) == 1 and text.casefold() in ("true", "false"):
        return "bool"
    return _named(tokens, scope) if kind == "word" else ""


def _named(tokens: list[_Token], scope: _KrlScope) -> str:
    """The type of a call, or of a variable with its indices and components."""
    key = tokens[0][1].casefold()
    if tokens[1:] and tokens[1][1] == "(":
        routine = scope.routines.get(key)
        return routine.result if routine is not None and _closing(tokens, 1) == len(tokens) - 1 else ""
    kind, at = scope.kinds.get(key) or _SYSTEM_KINDS.get(key, ""), 1
    while at < len(tokens) and kind:
        if tokens[at][1] == "[" and "[" in kind:
            at, kind = _closing(tokens, at) + 1, kind.partition("[")[0]
        elif tokens[at][1] == "." and at + 1 < len(tokens):
            at, kind = at + 2, scope.structures.members.get(kind, {}).get(tokens[at + 1][1].casefold(), "")
        else:
            return ""
        if not at:
            return ""
    return "" if "[" in kind else kind


def _depth(tokens: list[_Token], at: int) -> int:
    return sum((t[1] in "([{") - (t[1] in ")]}") for t in tokens[:at])


def _aggregates(found: LoadFindings, number: int, tokens: list[_Token], scope: _KrlScope) -> None:
    """`NAME = {X 1, S 2}`: whether the structure of the name has the components."""
    sign = next((i for i, t in enumerate(tokens) if t[1] == "="), 0)
    if not sign or tokens[sign + 1 : sign + 2] == [] or tokens[sign + 1][1] != "{":
        return
    known = scope.structures.members.get(_kind_of(tokens[:sign], scope))
    part = tokens[sign + 1 :]
    if known is None or any(t[1] == ":" for t in part):
        return
    for i in range(1, len(part)):
        name = part[i]
        begins = part[i - 1][1] in ("{", ",") and _depth(part, i) == 1 and name[0] == "word"
        if begins and name[1].casefold() not in known:
            kind = _kind_of(tokens[:sign], scope).upper()
            help = f"one of {', '.join(one.upper() for one in list(known)[:_SHOWN])}"
            found.tell("K109", f"{kind} has no component {name[1]}", _at(number, name), help)


def _constants(found: LoadFindings, number: int, tokens: list[_Token], scope: _KrlScope) -> None:
    """`NAME = #CONSTANT`, `NAME == #CONSTANT`: whether the enumeration of the name has the constant."""
    for i in range(len(tokens) - 3):
        name, sign, mark, constant = tokens[i : i + 4]
        if name[0] != "word" or sign[1] not in ("=", "==", "<>") or mark[1] != "#":
            continue
        if i and tokens[i - 1][1] == ".":
            continue
        known = scope.structures.enums.get(scope.kinds.get(name[1].casefold(), ""))
        if known is not None and constant[1].casefold() not in known:
            says = f"{name[1]} has no value #{constant[1]}"
            help = f"one of {', '.join('#' + one.upper() for one in sorted(known)[:_SHOWN])}"
            found.tell("K109", says, _at(number, constant), help)


_SHOWN: Final = 8  # names in a help


def _call(
    found: LoadFindings,
    number: int,
    tokens: list[_Token],
    at: int,
    scope: _KrlScope,
) -> None:
    key = tokens[at][1].casefold()
    routine = scope.routines.get(key)
    if routine is None:
        declared = key in scope.local or key in scope.shared
        if not declared and key not in _OPTIONS | KNOWN_ROUTINES.keys():
            found.unknown.append((tokens[at][1], _at(number, tokens[at]), "the routine"))
        return
    found.known.add(key)
    if routine.kind == "DEF" and at and tokens[at - 1][1] not in ("DO", "do", "Do") and _is_value(tokens, at):
        found.tell(
            "K112", f"{tokens[at][1]} is a DEF and has no value", _at(number, tokens[at]), "make it a DEFFCT"
        )
    elif routine.kind == "DEFFCT" and not at and _closing(tokens, 1) == len(tokens) - 1:
        says = f"{tokens[at][1]} is a function: its value must go somewhere"
        found.tell("K112", says, _at(number, tokens[at]))
    depth = count = 0
    for _, text, _ in tokens[at + 1 :]:
        depth += (text in "([{") - (text in ")]}")
        if not depth:
            break
        count += text == "," and depth == 1
    given = 0 if tokens[at + 2 : at + 3] and tokens[at + 2][1] == ")" else count + 1
    if given > len(routine.parameters):
        takes = f"{len(routine.parameters)} parameter{'s' if len(routine.parameters) != 1 else ''}"
        found.tell("K112", f"{tokens[at][1]} takes {takes}, and {given} are given", _at(number, tokens[at]))


_TEXT_BEFORE_VALUES: Final = "= + - * / == <> < > <= >= ( if while until switch return for not and or exor"
_BEFORE_VALUES: Final = frozenset(_TEXT_BEFORE_VALUES.split())


def _is_value(tokens: list[_Token], at: int) -> bool:
    return tokens[at - 1][1].casefold() in _BEFORE_VALUES and tokens[0][1].upper() != "TRIGGER"


LOAD: Final = Loading(("krc4-8.5", "krc4-8.3", "krc5-8.7"), check)
