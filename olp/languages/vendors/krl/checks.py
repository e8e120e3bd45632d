"""What must hold beyond single lines: blocks pair, labels are there, targets have a value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import PurePath, PureWindowsPath
from typing import Final

from olp.core.diagnostic import Severity
from olp.ir import program as st
from olp.ir.block_structure import LAST_BRANCHES
from olp.ir.expressions import Item, Named, Unknown
from olp.languages.findings import Findings
from olp.languages.vendors.krl.scope import Scope

_OPENS: Final[dict[type, tuple[type, str, str]]] = {
    st.If: (st.EndIf, "IF", "ENDIF"),
    st.While: (st.EndWhile, "WHILE or LOOP", "ENDWHILE or ENDLOOP"),
    st.For: (st.Next, "FOR", "ENDFOR"),
    st.Repeat: (st.Until, "REPEAT", "UNTIL"),
    st.Switch: (st.EndSwitch, "SWITCH", "ENDSWITCH"),
}
_CLOSES: Final = {closer: (opener, words) for opener, (closer, *words) in _OPENS.items()}
_LOOPS = (st.While, st.For, st.Repeat)
_WITHIN: Final[Mapping[type, tuple[type, str, str]]] = {
    st.Else: (st.If, "ELSE", "IF"),
    st.ElseIf: (st.If, "ELSEIF", "IF"),
    st.Case: (st.Switch, "CASE", "SWITCH"),
}
_MOST_TOLD = 50
_MOST_DEEP = 500


def check_readable(findings: Findings) -> bool:
    """Whether the file is text at all; if not, all its lines are errors (P400)."""
    raw = findings.source.raw
    message = ""
    if not raw.strip():
        message = "the file is empty"
    elif b"\0" in raw and not findings.source.encoding.startswith("utf-16"):
        message = "this is no text: it holds zero bytes"
    if not message:
        return True
    findings.error("P400", message, 1, "a KRL program begins with DEF or DEFDAT")
    for place in range(len(findings.kinds)):
        findings.kinds[place] = st.LineKind.ERROR
    return False


def check_body(findings: Findings, body: Sequence[st.Statement], markers: Sequence[st.Statement]) -> None:
    """Blocks (P405), EXIT (P405) and labels (P406, P407) of one routine."""
    ordered = sorted([*body, *markers], key=lambda one: one.line) if markers else body
    open_: list[st.Statement] = []
    last: dict[int, st.Statement] = {}  # by the identity of its block: the ELSE or DEFAULT
    for one in ordered:
        kind = type(one)
        if kind in _OPENS:
            open_.append(one)
            if len(open_) == _MOST_DEEP:
                _tell(findings, "P405", f"{_MOST_DEEP} blocks within each other", one, "fewer")
        elif kind in _CLOSES:
            _close(findings, open_, one)
        elif kind in _WITHIN or kind is st.Default:
            opener, word, wanted = _WITHIN.get(kind, (st.Switch, "DEFAULT", "SWITCH"))
            if not open_ or type(open_[-1]) is not opener:
                _tell(
                    findings,
                    "P405",
                    f"{word} outside {wanted}",
                    one,
                    f"it belongs between {wanted} and its end",
                )
            elif (before := last.get(id(open_[-1]))) is not None:
                ends = type(before).__name__.upper()
                message = f"{word} behind the {ends} of line {before.line}"
                _tell(findings, "P405", message, one, f"{ends} comes last, and once")
            elif kind in LAST_BRANCHES:
                last[id(open_[-1])] = one
        elif kind is st.Break and not any(type(block) in _LOOPS for block in open_):
            _tell(findings, "P405", "EXIT outside a loop", one, "it leaves LOOP, WHILE, FOR or REPEAT")
    for one in open_[:_MOST_TOLD]:
        _, word, end = _OPENS[type(one)]
        _tell(findings, "P405", f"{word} is never closed", one, f"add {end}")
    _check_labels(findings, body)


def _close(findings: Findings, open_: list[st.Statement], one: st.Statement) -> None:
    opener, (word, end) = _CLOSES[type(one)]
    if open_ and type(open_[-1]) is opener:
        open_.pop()
        return
    depth = next((at for at in range(len(open_) - 1, -1, -1) if type(open_[at]) is opener), None)
    if depth is None:
        _tell(findings, "P405", f"{end} without {word}", one, f"remove it, or open the block with {word}")
        return
    for left in open_[depth + 1 : depth + 1 + _MOST_TOLD]:
        _, other, other_end = _OPENS[type(left)]
        _tell(findings, "P405", f"{other} is never closed", left, f"add {other_end} before line {one.line}")
    del open_[depth:]


def _check_labels(findings: Findings, body: Sequence[st.Statement]) -> None:
    labels: dict[str, int] = {}
    for one in body:
        if type(one) is st.Label:
            if one.name in labels:
                message = f"a second label {one.name}, the first is in line {labels[one.name]}"
                _tell(findings, "P407", message, one, "rename one")
            labels.setdefault(one.name, one.line)
    for one in body:
        if type(one) is st.Jump and isinstance(one.target, str) and one.target not in labels:
            _tell(
                findings, "P406", f"there is no label {one.target} in this routine", one, f"add {one.target}:"
            )


def _tell(findings: Findings, code: str, message: str, one: st.Statement, help: str) -> None:
    findings.error(code, message, one.line, help)


def _tell_untaught(findings: Findings, line: int) -> None:
    help = "teach it, or put a point in place of the !"
    message = "! stands for a point that was never taught"
    findings.once(Severity.WARNING, "P412", "!", message, findings.whole_line(line), help)


def check_targets(findings: Findings, scope: Scope, routines: Sequence[st.Routine], listed: bool) -> None:
    """Targets of moves that nothing declares: P411, or P412 once when the list is not there."""
    unknown: dict[str, int] = {}
    for routine in routines:
        local = {one.name.upper() for one in routine.body if isinstance(one, st.Declare)}
        local.update(parameter.name.upper() for parameter in routine.parameters)
        for one in routine.body:
            if type(one) is not st.Move:
                continue
            for target in one.targets if one.via is None else (*one.targets, one.via):
                base = target.base if type(target) is Item else target
                if type(base) is Unknown:
                    _tell_untaught(findings, one.line)
                elif type(base) is Named and base.name[:1] != "$":
                    key = base.name.upper()
                    if key not in scope.types and key not in local:
                        unknown.setdefault(base.name, one.line)
    if not unknown:
        return
    if not listed:
        name, line = next(iter(unknown.items()))
        more = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        message = f"{name}{more}: nothing here says where these points are"
        name = PurePath(PureWindowsPath(findings.source.path).name).stem
        help = f"put {name}.dat beside the program, and $config.dat or the list where they are GLOBAL"
        findings.warning("P412", message, line, help)
        return
    for name, line in list(unknown.items())[:_MOST_TOLD]:
        help = "declare it, or put the file that does (such as $config.dat) beside the program"
        findings.once(
            Severity.WARNING, "P411", name, f"{name} is declared nowhere", findings.whole_line(line), help
        )
