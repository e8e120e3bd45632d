"""Labels by number, waits that give up, and SELECT: what takes more than one statement to spell."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from olp.expression import Number, Quantity, SystemValue
from olp.program import (
    Call,
    Case,
    Default,
    EndSwitch,
    Jump,
    Label,
    Routine,
    Statement,
    Switch,
    Wait,
)
from olp.vendors.tp import values
from olp.vendors.tp.limits import LARGEST_LABEL, NAME_LENGTH
from olp.vendors.tp.write_statements import StatementWriter
from olp.vendors.tp.write_values import CannotSayError, Words

_TIMED_OUT: Final = SystemValue("timed-out")
_FIRST_ADDED = 901  # label that the text needs and the program has not


class Labels:
    """A number for every label of a routine; those that are numbers keep theirs."""

    def __init__(self, routine: Routine, own: bool) -> None:
        self._own = own
        self._numbers = _numbered(routine)

    def number(self, name: str) -> str:
        """As JMP LBL[…] names it."""
        number = self._numbers.get(name)
        return name.split("/")[0] if number is None else str(number)

    def line(self, label: Label) -> str:
        """LBL[3:name]: a name of another language becomes the comment."""
        name = label.comment if self._own else "" if label.name.isdigit() else label.name[:NAME_LENGTH]
        return f"LBL[{self.number(label.name)}{f':{name}' if name else ''}]"

    def added(self) -> str:
        """The number of a further label."""
        taken = set(self._numbers.values())
        number = next(n for n in range(_FIRST_ADDED, LARGEST_LABEL) if n not in taken)
        self._numbers[f"added {number}"] = number
        return str(number)


class FlowWriter:
    """Spells what two or more statements say together."""

    def __init__(self, words: Words, statements: StatementWriter, labels: Labels) -> None:
        self.words = words
        self.statements = statements
        self.labels = labels

    # --- waiting ----------------------------------------------------------------------------------------

    def timed_wait(self, wait: Wait, following: Statement | None) -> tuple[list[str], int]:
        """WAIT … TIMEOUT,LBL[n]: goes to the label that the jump behind it names, or to one that comes next."""
        assert wait.timeout is not None
        lines = self._timeout(wait.timeout)
        text = f"WAIT {self.words.condition(wait.condition)} TIMEOUT,"
        if (
            isinstance(following, Jump)
            and following.condition == _TIMED_OUT
            and isinstance(following.target, str)
        ):
            return [*lines, f"{text}LBL[{self.labels.number(following.target)}]"], 2
        label = self.labels.added()
        return [*lines, f"{text}LBL[{label}]", f"LBL[{label}]"], 1

    def _timeout(self, timeout: Quantity) -> list[str]:
        """The line that sets $WAITTMOUT, where it does not hold already."""
        if not isinstance(timeout.written, Number):
            named = getattr(timeout.written, "name", "")
            if named == values.TIMEOUT:
                return []
            scale = timeout.scale / values.TICK
            return [f"{values.TIMEOUT}=({self.words.expression(timeout.written, 5)}*{scale:g})"]
        ticks = round(timeout.written.value * timeout.scale / values.TICK)
        return [f"{values.TIMEOUT}={ticks}"]

    # --- SELECT -----------------------------------------------------------------------------------------

    def select(self, body: tuple[Statement, ...], at: int) -> tuple[list[str], int]:
        """SELECT at index `at`, whose cases jump or call. Raises CannotSayError for cases that do more."""
        switch = body[at]
        assert isinstance(switch, Switch)
        end = next((n for n in range(at, len(body)) if type(body[n]) is EndSwitch), len(body) - 1)
        lines: list[str] = []
        part = at + 1
        while part < end:
            case = body[part]
            action = body[part + 1]
            (text,) = self.statements.lines(action) if isinstance(action, (Jump, Call)) else ("",)
            if not text or not isinstance(case, (Case, Default)) or text.startswith("IF"):
                raise CannotSayError("a SELECT whose cases do more than a jump or a call", "use IF blocks")
            lines.extend(self._case_lines(switch, case, text, not lines))
            part += 2
        return lines, end - at + 1

    def _case_lines(self, switch: Switch, case: Case | Default, action: str, first: bool) -> Iterator[str]:
        if isinstance(case, Default):
            yield f"       ELSE,{action}"
            return
        for value in case.values:
            head = f"SELECT {self.words.value(switch.value)}" if first else "      "
            yield f"{head}={self.words.value(value)},{action}"
            first = False


def _numbered(routine: Routine) -> dict[str, int]:
    """A number for every label of the routine; those that are numbers keep theirs."""
    names = [one.name for one in routine.body if type(one) is Label]
    numbers = {name: int(name.split("/")[0]) for name in names if name.split("/")[0].isdigit()}
    taken = set(numbers.values())
    following = 1
    for name in names:
        if name not in numbers:
            while following in taken:
                following += 1
            numbers[name] = following
            taken.add(following)
    return numbers
