"""Writes programs as TOY: what `templates/toy.j2` puts together."""

from __future__ import annotations

from typing import ClassVar, Final

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.generator import CannotSayError, Generator, Lines, Spelled, as_text, decimal, without_noise

_WORDS: Final = {
    "tool": "TOOL", "frame": "FRAME", "position": "POSE", "joints": "AXES", "integer": "NUM", "real": "NUM",
    "boolean": "NUM",
}  # fmt: skip


def write(program: st.Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that TOY cannot say."""
    return ToyWriter(program, own=program.vendor == "toy").written()


class ToyWriter(Generator):
    """What no table can say is a method: `spell_KIND` of an expression, `write_KIND` of a statement."""

    language = "TOY"
    binary: ClassVar = {"+": (" + ", 5), "-": (" - ", 5), "*": (" * ", 6), "/": (" / ", 6)}
    unary: ClassVar = {"-": ("-{}", 7, 7), "not": ("NOT {}", 3, 3)}
    logic: ClassVar = {"and": (" AND ", 2), "or": (" OR ", 1)}
    comparisons: ClassVar = {"=": " = ", "<>": " <> ", "<": " < ", ">": " > ", "<=": " <= ", ">=": " >= "}
    compared = (4, 5)
    functions: ClassVar = {"pose-offset": "OFFSET"}
    signals: ClassVar = {"in": "IN"}
    not_in_text = frozenset('"#\n')
    no_text = 'a text that holds ", # or a line end'
    states = ("OFF", "ON")
    separator = ", "
    templates: ClassVar = {
        st.Assign: "{target} = {value}",
        st.Dwell: "PAUSE {duration}",
        st.If: "IF {condition} THEN",
        st.ElseIf: "ELSEIF {condition} THEN",
        st.Else: "ELSE",
        st.EndIf: "ENDIF",
        st.While: "WHILE {condition} DO",
        st.EndWhile: "ENDWHILE",
        st.For: "FOR {variable} = {start} TO {stop}{step: STEP {}}",
        st.Next: "ENDFOR",
        st.Break: "BREAK",
        st.Label: "LABEL {name}",
        st.Jump: "GOTO {target}",
        st.Call: "CALL {routine}",
        st.Return: "RETURN",
        st.Pause: "STOP",
        st.Comment: "# {text}",
    }
    cannot: ClassVar = {
        st.Call: {
            "macro": "a macro by its number",
            "jump": "a call that does not come back",
            "arguments": "arguments",
            "result": "a call that keeps what a routine returns",
        },
        st.Wait: {"timeout": "a wait with a limit"},
    }
    own_only: ClassVar = {
        st.Process: "the instruction {s.name}",
        st.Opaque: "a line that only its own language understands",
        st.Disabled: "a disabled line",
    }
    step, comment_form = "  ", " # {}"
    renamed: ClassVar[dict[str, str]] = {}  # of the routine that is written: its own variables

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        if it.literal is None:
            raise CannotSayError("a computed speed, blend or time")
        return decimal(without_noise(it.literal / unit))

    def spell_call_value(self, e: ex.CallValue) -> Spelled:
        return self.spell_other(e)

    def spell_member(self, e: ex.Member) -> str:
        return f"{self.value(e.base)}.{e.name}"

    def spell_named(self, e: ex.Named) -> Spelled:
        return self.renamed.get(e.name, e.name)

    def spell_frame_ref(self, e: ex.FrameRef) -> str:
        if e.kind == "base":
            return "WORLD"
        if e.kind == "tool" and e.number in (None, ex.Number(0)):
            return "FLANGE"
        raise CannotSayError("a tool or frame by its number")

    def write_wait(self, s: st.Wait) -> Lines:
        return f"WAIT {self.condition(s.condition)}"

    def write_message(self, s: st.Message) -> Lines:
        if not isinstance(s.text, ex.Text):
            raise CannotSayError("a message that is computed")
        return f"SAY {self.value(s.text)}"

    def write_set_output(self, s: st.SetOutput) -> Lines:
        if s.signal.bus != "out":
            raise CannotSayError("an output of that kind")
        return f"OUT {self.value(s.signal.index)} {self.value(s.value)}"

    def write_move(self, s: st.Move) -> Lines:
        if s.speed is None:
            raise CannotSayError("a move without a speed")
        # `Limits` promise it: each move names all others, in units that TOY has.
        assert s.blend is not None
        assert s.blend.value is not None
        assert s.tool is not None
        assert s.frame is not None
        joint = s.path is st.Path.JOINT
        word = {st.Path.JOINT: "JOINT", st.Path.LINEAR: "LINE", st.Path.CIRCULAR: "ARC"}.get(s.path)
        if word is None:
            raise CannotSayError("a spline")
        speed = f"{self.quantity(s.speed.value, percent)} %" if joint else self.quantity(s.speed.value, mm)
        places = " ".join(self.value(one) for one in (s.via, s.targets[0]) if one is not None)
        end = (
            f"BLEND {self.quantity(s.blend.value, mm)} TOOL {self.value(s.tool)} FRAME {self.value(s.frame)}"
        )
        return f"{word} {places} SPEED {speed} {end}"

    def write_declare(self, s: st.Declare) -> Lines:
        name = self.renamed.get(s.name, s.name)
        word = "NUM" if isinstance(s.value, ex.Number) else _WORDS.get(s.type)
        if word is None or s.sizes:
            raise CannotSayError(
                f"data of the type {s.type}", "TOY has whole numbers, positions, tools and frames"
            )
        if isinstance(s.value, ex.PositionLiteral):  # written out: SI becomes what TOY writes
            units = [deg] * 6 if s.value.kind == "joint" else [mm] * 3 + [deg] * 3
            numbers = [decimal(without_noise(v / u)) for v, u in zip(s.value.values, units, strict=False)]
            return f"{word} {name} = {' '.join(numbers)}"
        if isinstance(s.value, ex.Number):
            return f"{word} {name} = {self.value(s.value)}"
        if s.value is None or isinstance(s.value, ex.FrameRef):  # of the flange, of the world: no offset
            return f"{word} {name} = {'0' if word == 'NUM' else '0 0 0 0 0 0'}"
        if isinstance(s.value, ex.SignalState):
            return f"{word} {name} = {int(s.value.on)}"
        raise CannotSayError("data with a value that is computed")

    def own_names(self, routine: st.Routine, taken: set[str]) -> dict[str, str]:
        """A name for each variable of the routine's own: TOY's routines share all, whatever their case."""
        found = {}
        for declare in (*routine.data, *(s for s in routine.body if isinstance(s, st.Declare))):
            tries = (f"{declare.name[:20]}{end}" for end in ("", *range(2, 1000)))
            found[declare.name] = next(name for name in tries if name.lower() not in taken)
            taken.add(found[declare.name].lower())
        return found

    def template_values(self) -> dict[str, object]:
        self.begin()
        self.body(self.program.data)
        data, routines = as_text(self.rows), []
        taken = {declare.name.lower() for declare in self.program.data}
        for routine in self.program.routines:
            self.renamed = self.own_names(routine, taken)
            self.begin()
            self.body([*routine.data, *routine.body])
            routines.append({"name": routine.name, "body": as_text(self.rows)})
        return {"name": routines[0]["name"], "data": data, "routines": routines}
