"""Plants faults in every member of a kind and runs the contract suite of that kind alone (`bench/faults.py -h`).

Faults of meaning are what a careless author does (`meaning`), faults of code are mutations of a member's own source
(`code`), faults of a robot file are wrong numbers (`numbers`). Each runs in a process of its own.
"""

from __future__ import annotations

import os
import signal
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from contract_faults import code, estimators, meaning, numbers, terms

LIMIT: Final = 90  # [s] of CPU that the suite of a faulty member may take
Planted = tuple[str, Callable[[], Callable[[], bool]]]


class Outcome(NamedTuple):
    """`state`: caught, survived, nothing (the fault changed nothing that the suite's programs hold) or unsound."""

    fault: str
    state: str
    by: str


@dataclass(frozen=True, slots=True)
class Kind:
    """`check`: the suite of one member, which stops at the first broken promise. `modules`: the source that is mutated.

    `faults`: those of meaning; they are all planted, and of the others as many as are asked for.
    """

    members: Callable[[], Sequence[str]]
    check: Callable[[str], None]
    modules: Callable[[str], Sequence[str]] = lambda name: ()
    faults: Callable[[str], Sequence[Planted]] = lambda name: ()


class Row(NamedTuple):
    """What the suite of one member caught: of faults of meaning, or in a file, and of faults of code."""

    kind: str
    member: str
    meaning: tuple[int, int]  # caught, planted
    code: tuple[int, int]

    @property
    def caught(self) -> int:
        return self.meaning[0] + self.code[0]

    @property
    def planted(self) -> int:
        return self.meaning[1] + self.code[1]


def run(kinds: Sequence[str], only: str, count: int, seed: int, *, meant: bool = True) -> int:
    """Prints what was caught, a row per member and a table of the kinds; exit status 1 when less than 98 % were.

    `count`, `seed`: of the mutations of code that are drawn. `meant`: plants the faults of meaning too.
    """
    import olp.contracts  # noqa: F401  # once for all processes; it imports no member

    print(
        f"{'kind':<10} {'member':<34} {'meaning':>9} {'code':>9} {'nothing':>8} {'lines not run':>14}",
        flush=True,
    )
    members = [(kind, one) for kind in kinds for one in KINDS[kind].members() if only.lower() in one.lower()]
    # The process of a fault ends without cleaning up.
    with tempfile.TemporaryDirectory(prefix="olp-faults-") as tempfile.tempdir:
        rows = [_member(kind, member, count, seed, meant=meant) for kind, member in members]
    print(table(rows))
    planted, caught = sum(row.planted for row in rows), sum(row.caught for row in rows)
    share = caught / planted if planted else 0.0
    print(f"caught {caught} of {planted}: {share:.1%}")
    return 0 if share >= 0.98 else 1


def table(rows: Sequence[Row]) -> str:
    """The kinds in Markdown, as CONTRIBUTING quotes them."""
    lines = [
        "| kind | members | meaning | code | caught | members at 98 % | least |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in dict.fromkeys(row.kind for row in rows):
        own = [row for row in rows if row.kind == kind and row.planted]
        if not own:
            continue
        parts = [f"{sum(one[0] for one in part)}/{sum(one[1] for one in part)}" for part in _parts(own)]
        caught, planted = sum(row.caught for row in own), sum(row.planted for row in own)
        good = sum(row.caught >= 0.98 * row.planted for row in own)
        least = min(own, key=lambda row: row.caught / row.planted)
        cells = [kind, str(len(own)), *parts, f"{caught / planted:.1%}", str(good)]
        lines.append(f"| {' | '.join(cells)} | {least.member} {least.caught}/{least.planted} |")
    return "\n".join(lines)


def _parts(rows: Sequence[Row]) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    return [row.meaning for row in rows], [row.code for row in rows]


def _member(name: str, member: str, count: int, seed: int, *, meant: bool) -> Row:
    kind = KINDS[name]
    wrong = _unharmed(lambda: kind.check(member))
    if wrong:
        print(f"{name} {member} breaks its contract without any fault: {wrong}")
        return Row(name, member, (0, 1), (0, 0))
    faults = kind.faults(member) if meant else ()
    found = [_tried(fault, lambda: kind.check(member)) for fault in faults]
    modules, rows, dead = kind.modules(member), [], 0
    same: dict[str, str] = {}
    if modules and count:
        lines, wrong = code.executed_lines(modules, lambda: kind.check(member))
        if wrong:
            print(f"{name} {member} breaks its contract without any fault:\n{wrong}")
            return Row(name, member, (0, 1), (0, 0))
        chosen, _, dead = code.mutants(modules, lines, count, seed)
        same = {code.as_fault(one)[0]: why for one in chosen if (why := code.equivalent(one))}
        faults_of_code = (code.as_fault(one) for one in chosen)
        rows = [_tried(one, lambda: kind.check(member)) for one in faults_of_code if one[0] not in same]
    parts = [Counter(one.state for one in part) for part in (found, rows)]
    shown = [f"{part['caught']}/{part['caught'] + part['survived']}" for part in parts]
    nothing = sum(part["nothing"] for part in parts)
    print(f"{name:<10} {member:<34} {shown[0]:>9} {shown[1]:>9} {nothing:>8} {dead:>14}", flush=True)
    for one in (*found, *rows):
        if one.state in ("survived", "unsound"):
            print(f"    {one.state}: {one.fault}", flush=True)
    for fault, why in same.items():
        print(f"    equivalent: {fault}: {why}", flush=True)
    meaning, mutated = ((part["caught"], part["caught"] + part["survived"]) for part in parts)
    return Row(name, member, meaning, mutated)


# --- one fault in a process of its own ----------------------------------------------------------------------


def _tried(fault: Planted, check: Callable[[], None]) -> Outcome:
    """What the suite says about a member with the fault."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        said = _in_child(fault, check)
        os.write(writing, "\0".join(said).encode("utf-8", "replace")[:60_000])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        text = pipe.read().decode("utf-8", "replace")
    os.waitpid(child, 0)
    state, _, by = text.partition("\0")
    return Outcome(fault[0], state or "caught", by or f"no end within {LIMIT} s of CPU")


def _unharmed(check: Callable[[], None]) -> str:
    """What the suite says of a member without a fault: "" when it passes."""
    outcome = _tried(("none", lambda: lambda: True), check)
    return "" if outcome.state == "survived" else outcome.by


def _in_child(fault: Planted, check: Callable[[], None]) -> tuple[str, str]:
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, LIMIT)
    silence = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(silence, stream)
    try:
        changed = fault[1]()
        check()
    except AssertionError as broken:
        found = getattr(broken, "broken", ())
        return "caught", found[0].promise if found else str(broken)[:200]
    except BaseException as problem:
        return (
            "caught",
            f"the member cannot even be loaded or asked: {type(problem).__name__}: {str(problem)[:150]}",
        )
    return ("survived" if changed() else "nothing"), ""


# --- the kinds ----------------------------------------------------------------------------------------------


def _vendors() -> Sequence[str]:
    from olp.languages.vendor import vendor_names

    return vendor_names()


def _written() -> Sequence[str]:
    from olp.languages.limits import writable

    return writable()


def _vendor(name: str) -> object:
    from olp.languages.vendor import find_vendor

    return find_vendor(name)


def _check_vendor(name: str) -> None:
    from olp.contracts import check_vendor
    from olp.languages.vendor import find_vendor

    check_vendor(find_vendor(name), first=True)


def _check_writer(name: str) -> None:
    from olp.contracts import check_writer
    from olp.languages.vendor import find_vendor

    check_writer(find_vendor(name), first=True)


def _language(name: str, writes: bool) -> list[str]:
    folder = code.ROOT / "olp" / "languages" / "vendors" / name
    stems = sorted(path.stem for path in folder.glob("*.py") if path.stem != "__init__")
    own = [stem for stem in stems if (stem in ("limits", "writer") or stem.startswith("write_")) == writes]
    return [f"olp.languages.vendors.{name}.{stem}" for stem in own]


def _terms() -> Sequence[str]:
    from olp.timing.physics import term_names

    return term_names()


def _check_term(name: str) -> None:
    from olp.contracts import check_term
    from olp.timing.physics import load_term

    check_term(load_term(name), first=True)


def _models() -> Sequence[str]:
    from olp.timing.motion import model_names

    return model_names()


def _check_model(name: str) -> None:
    from olp.contracts import check_model
    from olp.timing.motion import load_model

    check_model(load_model(name), first=True)


def _estimators() -> Sequence[str]:
    from olp.identification.signature.estimator import estimator_names

    return estimator_names()


def _check_estimator(name: str) -> None:
    from olp.contracts import check_estimator
    from olp.identification.signature.estimator import load_estimator

    check_estimator(load_estimator(name), first=True)


def _reports() -> Sequence[str]:
    from olp.reports.formats import report_names

    return report_names()


def _check_report(name: str) -> None:
    from olp.contracts import check_report

    check_report(name, first=True)


def _robots() -> Sequence[str]:
    from olp.robots.robot import robot_names

    return robot_names()


def _commands() -> Sequence[str]:
    from olp import cli

    return cli.names()


def _check_command(name: str) -> None:
    from olp.contracts import check_command

    check_command(name, first=True)


def _hosts() -> Sequence[str]:
    return sorted(path.name for path in (code.ROOT / "hosts").iterdir() if path.is_dir())


KINDS: Final = {
    "vendor": Kind(
        _vendors,
        _check_vendor,
        lambda name: _language(name, writes=False),
        lambda name: meaning.reader_faults(lambda: _vendor(name)),
    ),
    "writer": Kind(
        _written,
        _check_writer,
        lambda name: _language(name, writes=True),
        lambda name: meaning.writer_faults(lambda: _vendor(name)),
    ),
    "term": Kind(
        _terms,
        _check_term,
        lambda name: [f"olp.timing.physics.{name.replace('-', '_')}"],
        lambda name: terms.term_faults(name),
    ),
    "model": Kind(_models, _check_model, lambda name: [f"olp.timing.motion.{name}"]),
    "estimator": Kind(
        _estimators,
        _check_estimator,
        lambda name: [f"olp.identification.signature.estimators.{name}"],
        lambda name: estimators.estimator_faults(name),
    ),
    "report": Kind(_reports, _check_report, lambda name: [f"olp.reports.formats.{name}"]),
    "robot": Kind(_robots, lambda name: numbers.check(name), faults=numbers.robot_faults),
    "command": Kind(_commands, _check_command, faults=numbers.command_faults),
    "host": Kind(_hosts, lambda name: numbers.check_host_copy(name), faults=numbers.host_faults),
}
