"""Moves as the inline forms of the pendant, so that points are touched up there.

A form is a fold with the lines that bas.src needs, and rows of the list: XP1 is the point, FP1 its tool and frame,
PPDAT1 or LCPDAT1 acceleration and corner, one set for each form as the pendant makes them. Its fields bound what it can
say: points of the list, whole percents, numbered tools and frames. All other moves stay plain KRL.

The texts are those of KUKA System Software 8.3, which later versions take, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from olp.core.units import mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.program import AccelerationUnit, BlendKind, Path, SpeedUnit
from olp.ir.transformer import changed_by
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.scope import Scope
from olp.languages.vendors.krl.write_values import pose_text

DECIMALS: Final = 6  # of positions; the controller's REAL has seven digits
_MOST_MOVES: Final = (
    1_000  # longer programs come from CAM: nobody touches up their points, and lists are loaded whole
)
_LONGEST: Final = 23  # of a point's name, to which X and F are added
_MOST_SPEED: Final = 2.0  # [m/s] that the field takes
_TYPES: Final = ("position", "joints")
_WORDS: Final = {Path.JOINT: "PTP", Path.LINEAR: "LIN", Path.CIRCULAR: "CIRC"}
_VERSION: Final = "%R 8.3.38,%MKUKATPBASIS,%CMOVE"
END_OF_FORM: Final = ";ENDFOLD"
_STOP: Final = ("100", "#CDIS")  # what the pendant puts into the data of a move that stops
HEADER: Final = (
    "&ACCESS RVP\n&REL 1\n&PARAM EDITMASK = *\n&PARAM TEMPLATE = C:\\KRC\\Roboter\\Template\\vorgabe\n"
)
EXTERNAL: Final = (
    ";FOLD EXTERNAL DECLARATIONS;%{PE}%MKUKATPBASIS,%CEXT,%VCOMMON,%P",
    ";FOLD BASISTECH EXT;%{PE}%MKUKATPBASIS,%CEXT,%VEXT,%P",
    "EXT BAS (BAS_COMMAND :IN,REAL :IN )",
    ";ENDFOLD (BASISTECH EXT)",
    ";ENDFOLD (EXTERNAL DECLARATIONS)",
)


class _Motion(NamedTuple):
    """What the fields of one form say, as text. `size`, `mode`: of the corner; `passed`: the words behind the point."""

    speed: str
    acceleration: str
    size: str
    mode: str
    passed: str


def initialisation(rows: Sequence[str]) -> list[str]:
    """The INI fold, with `rows` where a user's own belong."""
    return [
        ";FOLD INI;%{PE}",
        "  ;FOLD BASISTECH INI",
        "    GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )",
        "    INTERRUPT ON 3",
        "    BAS (#INITMOV,0 )",
        "  ;ENDFOLD (BASISTECH INI)",
        "  ;FOLD USER INI",
        *(f"    {row}" for row in rows or (";Make your modifications here",)),
        "  ;ENDFOLD (USER INI)",
        ";ENDFOLD (INI)",
    ]


class InlineForms:
    """The forms of one program. `names`: of each point that a form moves to, as KRL says it.

    `spelled`: a quantity in a unit, as the writer has it.
    """

    def __init__(
        self,
        program: st.Program,
        scope: Scope,
        spelled: Callable[[ex.Quantity, float], str],
    ) -> None:
        self._scope = scope
        self._spelled = spelled
        self.names: dict[str, str] = {}
        self._systems: dict[str, tuple[int, int]] = {}  # point -> the tool and frame of its FDAT
        self._labels = _labels(program)
        self._made: dict[ex.PositionLiteral, str] = {}  # positions without a name -> the point made of it
        self._rows: dict[str, list[str]] = {}  # behind the point's own row
        self._loose: list[str] = []  # points without a declaration, and motion data
        self._numbers = {"PPDAT": 0, "LCPDAT": 0, "XP": 0}
        self._points = self._nameable(program)
        self._folds: dict[int, list[str] | None] = {}  # by the id of the move
        moves = [s for s in program.statements() if type(s) is st.Move]
        for s in moves if len(moves) <= _MOST_MOVES else ():
            if id(s) not in self._folds:
                self._folds[id(s)] = self._lines(s)

    def _nameable(self, program: st.Program) -> frozenset[str]:
        """The points of the list that forms may move to; what the program computes nobody touches up."""
        routines = program.routines
        self._taken = {routine.name.upper() for routine in routines}
        local = {p.name.upper() for r in routines for p in r.parameters}
        local |= {s.name.upper() for r in routines for s in r.body if type(s) is st.Declare}
        local |= {name.upper() for s in program.statements() for name in changed_by(s)}
        found = set()
        for it in (*program.data, *(one for routine in routines for one in routine.data)):
            if it.type in _TYPES and type(it.value) is ex.PositionLiteral and not it.sizes:
                free = not any(map(self._is_taken, (f"X{it.name}", f"F{it.name}")))
                if free and len(it.name) <= _LONGEST and it.name.upper() not in local:
                    found.add(it.name)
        return frozenset(found)

    def _is_taken(self, name: str) -> bool:
        return self._scope.known(name.upper()) or name.upper() in self._taken

    # --- one move ---------------------------------------------------------------------------------------

    def lines(self, s: st.Move) -> list[str] | None:
        """The fold of a move, None where no form says it."""
        return self._folds.get(id(s))

    def _lines(self, s: st.Move) -> list[str] | None:
        systems = _systems(s)
        motion = self._motion(s)
        if systems is None or motion is None or not _is_usual(s):
            return None
        given = (s.targets[0],) if s.via is None else (s.via, s.targets[0])
        if not all(map(self._can_name, given)) or self._other_systems(given[-1], systems):
            return None
        points = [self._point(one) for one in given]
        self._taught_with(points[-1], systems)
        return self._fold(s.path, points, systems, motion)

    def _can_name(self, it: ex.Expression) -> bool:
        return type(it) is ex.PositionLiteral or (type(it) is ex.Named and it.name in self._points)

    def _other_systems(self, it: ex.Expression, systems: tuple[int, int]) -> bool:
        """Whether another form has the point already, with another tool or frame: it has but one FDAT."""
        name = it.name if type(it) is ex.Named else self._made.get(it, "")  # type: ignore[arg-type]
        return self._systems.get(name, systems) != systems

    def _point(self, it: ex.Expression) -> str:
        if type(it) is ex.Named:
            self.names.setdefault(it.name, f"X{it.name}")
            return it.name
        assert type(it) is ex.PositionLiteral
        name = self._made.get(it)
        if name is None:
            name = self._made[it] = self._free("XP")[1:]
            word = "E6AXIS" if it.kind == "joint" else "E6POS"
            self._loose.append(f"DECL {word} X{name}={pose_text(it, own=False, decimals=DECIMALS)}")
        return name

    def _free(self, stem: str) -> str:
        """The next name of this kind that nothing else has."""
        while True:
            self._numbers[stem] += 1
            name = f"{stem}{self._numbers[stem]}"
            others = (name[1:], f"F{name[1:]}") if stem == "XP" else ()
            if not any(map(self._is_taken, (name, *others))):
                return name

    def _taught_with(self, point: str, systems: tuple[int, int]) -> None:
        if point in self._systems:
            return
        self._systems[point] = systems
        tool, frame = systems
        row = (
            f"DECL FDAT F{point}={{TOOL_NO {tool},BASE_NO {frame},IPO_FRAME #BASE,"
            'POINT2[] " ",TQ_STATE FALSE}'
        )
        (self._rows.setdefault(point, []) if point in self.names else self._loose).append(row)

    def _fold(self, path: Path, points: list[str], systems: tuple[int, int], it: _Motion) -> list[str]:
        word, last = _WORDS[path], points[-1]
        joint = path is Path.JOINT
        data = self._free("PPDAT" if joint else "LCPDAT")
        self._loose.append(f"DECL {_joint_data(data, it) if joint else _path_data(data, it)}")
        shown, said = data[1:], f"{it.speed} {'%' if joint else 'm/s'}"
        fields = [word, *points, it.passed, "", it.speed, "", shown]
        listed = ", ".join(f"{n}:{one}" for n, one in enumerate(fields, 1) if one or n == len(points) + 2)
        cont = " CONT" if it.passed else ""
        head = f"{word} {' '.join(points)}{cont} Vel={said} {shown} {self._shown(systems)}"
        passed = f" {it.passed}" if it.passed else ""
        return [
            f";FOLD {head};%{{PE}}{_VERSION},%V{word},%P {listed}",
            "$BWDSTART=FALSE",
            f"{'P' if joint else 'L'}DAT_ACT={data}",
            f"FDAT_ACT=F{last}",
            f"BAS (#{'PTP' if joint else 'CP'}_PARAMS,{it.speed} )",
            f"{word} {','.join(f'X{point}' for point in points)}{passed}",
            END_OF_FORM,
        ]

    def _shown(self, systems: tuple[int, int]) -> str:
        """`Tool[1]:gripper Base[0]`."""
        parts = []
        for word, kind, number in zip(("Tool", "Base"), ("tool", "user"), systems, strict=True):
            label = self._labels.get((kind, number), "")
            parts.append(f"{word}[{number}]{f':{label}' if label else ''}")
        return " ".join(parts)

    # --- the fields -------------------------------------------------------------------------------------

    def _motion(self, s: st.Move) -> _Motion | None:
        joint = s.path is Path.JOINT
        speed = self._speed(s, joint)
        acceleration = self._acceleration(s, joint)
        blend = s.blend
        if speed is None or acceleration is None or blend is None:
            return None
        if values.is_stop(blend):
            return _Motion(speed, acceleration, *_STOP, passed="")
        if blend.value is None or type(blend.value.written) is not ex.Number:
            return None
        if blend.kind is BlendKind.RADIUS:
            passed = "C_DIS" if joint else "C_DIS C_DIS"
            return _Motion(speed, acceleration, self._spelled(blend.value, mm), "#CDIS", passed)
        if blend.kind is BlendKind.SHARE and joint:
            return _Motion(speed, acceleration, self._spelled(blend.value, percent), "#CPTP", "C_PTP")
        return None

    def _speed(self, s: st.Move, joint: bool) -> str | None:
        speed, unit = s.speed, SpeedUnit.FRACTION if joint else SpeedUnit.TRAVEL
        if speed is None or speed.unit is not unit or type(speed.value.written) is not ex.Number:
            return None
        text = self._spelled(speed.value, percent if joint else 1.0)
        value = float(text)
        if joint:
            return str(round(value)) if value == round(value) and 1 <= value <= 100 else None
        return f"{value:.9f}".rstrip("0").rstrip(".") if 0.001 <= value <= _MOST_SPEED else None

    def _acceleration(self, s: st.Move, joint: bool) -> str | None:
        """[%] of what $config.dat has for 100 %."""
        share, rate = s.acceleration, s.rate
        if share is None and rate is None:
            return "100"
        if rate is not None:
            if joint or rate.unit is not AccelerationUnit.TRAVEL or share is not None:
                return None
            given, whole = rate.value, values.ACC_CP
        else:
            assert share is not None
            given, whole = share, values.ACC_PTP if joint else percent
        if type(given.written) is not ex.Number:
            return None
        text = self._spelled(given, whole)
        return text if 1 <= float(text) <= 100 else None

    # --- the list ---------------------------------------------------------------------------------------

    def rows_behind(self, name: str) -> Iterator[str]:
        """The FDAT of a declared point."""
        yield from self._rows.get(name, ())

    def rows(self) -> list[str]:
        """All other data of the forms."""
        return self._loose


def _is_usual(s: st.Move) -> bool:
    rest = (s.arc, s.relative, s.offset, s.tool_offset, s.until, s.search, s.deceleration)
    whole = len(s.targets) == 1 and s.path in _WORDS and (s.path is Path.CIRCULAR) == (s.via is not None)
    return whole and not (s.parts or s.other) and all(one is None for one in rest)


def _systems(s: st.Move) -> tuple[int, int] | None:
    """The numbers of tool and frame, 0 for flange and base; None where one has no number."""
    tool, frame = _number(s.tool, "tool"), _number(s.frame, "user")
    if type(s.frame) is ex.FrameRef and s.frame.kind == "base" and s.frame.number is None:
        frame = 0
    return None if tool is None or frame is None else (tool, frame)


def _number(it: ex.Expression | None, kind: str) -> int | None:
    if type(it) is ex.FrameRef and it.kind == kind and type(it.number) is ex.Number:
        return int(it.number.value)
    return None


def _labels(program: st.Program) -> Mapping[tuple[str, int], str]:
    """What the statements that set tools and frames call them in their comments."""
    found = {}
    for s in program.statements():
        if type(s) is st.Assign and type(s.target) is ex.FrameRef and type(s.target.number) is ex.Number:
            found[(s.target.kind, int(s.target.number.value))] = s.comment if s.comment.isidentifier() else ""
    return found


def _joint_data(name: str, it: _Motion) -> str:
    return (
        f"PDAT {name}={{VEL 100,ACC {it.acceleration},APO_DIST {it.size},APO_MODE {it.mode},"
        "GEAR_JERK 50,EXAX_IGN 0}"
    )


def _path_data(name: str, it: _Motion) -> str:
    return (
        f"LDAT {name}={{VEL 2,ACC {it.acceleration},APO_DIST {it.size},APO_FAC 50,AXIS_VEL 100,AXIS_ACC 100,"
        "ORI_TYP #VAR,CIRC_TYP #BASE,JERK_FAC 50,GEAR_JERK 50,EXAX_IGN 0}"
    )
