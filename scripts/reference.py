"""The reference pages of the documentation site, made from the code each time the site is built."""

from __future__ import annotations

import sys
from argparse import SUPPRESS, Action, HelpFormatter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import olp
from olp import cli
from olp.cli.command import Parser


class Written(NamedTuple):
    """A page of the site."""

    title: str
    text: str


@cache
def reference_pages() -> dict[str, Written]:
    """Every generated page by its place in the site."""
    made = {
        "commands": Written("Commands", _commands()),
        "python": Written("Python", _python()),
        "members": Written("Models, laws, terms, rules", _members()),
        "codes": Written("Codes", _codes()),
        "robots": Written("Robots", _robots()),
    }
    return {f"reference/{name}.md": page for name, page in made.items()}


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (f"| {' | '.join(map(_cell, row))} |" for row in rows)
    return "\n".join([f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}", *lines])


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def _commands() -> str:
    head = (
        "# Commands\n\n"
        "`olp COMMAND --help` says the same. Exit status: 0 done and held, 1 a finding, 2 the question could not be "
        "answered.\n"
    )
    return "\n".join([head, *(_command(name) for name in cli.names())])


def _command(name: str) -> str:
    command = cli.load(name)
    parser = Parser(f"olp {name}", command.SUMMARY)
    command.add_arguments(parser)
    parser.formatter_class = _Wide
    usage = parser.format_usage().removeprefix("usage: ").rstrip()
    # Groups are argparse's own way of listing what was declared; it has no public one.
    actions = [action for group in parser._action_groups for action in group._group_actions]
    rows = [_argument(action) for action in actions if action.dest != "help" and action.help != SUPPRESS]
    summary = command.SUMMARY[:1].upper() + command.SUMMARY[1:]
    return f"## olp {name}\n\n{summary}.\n\n```text\n{usage}\n```\n\n{_table(('argument', 'means'), rows)}\n"


class _Wide(HelpFormatter):
    """As wide as the page, whatever terminal the site is built in."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=88)


def _argument(action: Action) -> tuple[str, str]:
    value = action.metavar or (f"{{{','.join(map(str, action.choices))}}}" if action.choices else "")
    value = " ".join(value) if isinstance(value, tuple) else value
    if not action.option_strings:
        return f"`{value or action.dest}`", (action.help or "") % _values(action)
    taken = f" {value or action.dest.upper()}" if action.nargs != 0 else ""
    shown = ", ".join(f"`{option}{taken}`" for option in action.option_strings)
    return shown, (action.help or "") % _values(action)


def _values(action: Action) -> dict[str, Any]:
    return {key: value for key, value in vars(action).items() if not key.startswith("_")}


def _python() -> str:
    """Pages are filled in by mkdocstrings from the code."""
    homes = olp._HOME
    parts = [
        "# Python\n",
        "`import olp` is quick; what a name needs is loaded when it is first asked for. All else in the package may "
        "change without notice, but for what the pages here show. Inside olp everything is SI: metres, seconds, "
        "radians.\n",
    ]
    parts += [_filled_in(name, homes[name]) for name in olp.__all__ if name in homes]
    return "\n".join(parts)


def _filled_in(name: str, home: str) -> str:
    """What mkdocstrings fills in for one public name: of a class under its own name, with the public one above it."""
    public = getattr(olp, name)
    own = public.__name__ if isinstance(public, type) else name
    return f"::: {home}.{own}\n" + (
        f"    options: {{ heading: olp.{name}, toc_label: {name} }}\n" if own != name else ""
    )


def _members() -> str:
    parts = [
        "# Models, laws, terms, rules",
        "Each is one file in one folder, found by being there; a file of your own makes one more "
        "([how](../repository/CONTRIBUTING.md)).",
    ]
    for title, names, load, option in _kinds():
        rows = [(f"`{name}`", *_described(load(name))) for name in names]
        parts += [f"## {title}", option, _table(("name", "what it does", "source"), rows)]
    return "\n\n".join(parts) + "\n"


def _kinds() -> Iterator[tuple[str, Sequence[str], Callable[[str], Any], str]]:
    from olp.checks.lint.rule import all_rules
    from olp.identification.signature import estimator
    from olp.reports import formats, outcome
    from olp.timing import acceleration, blending, motion, physics

    yield (
        "Motion models",
        motion.model_names(),
        motion.load_model,
        "`--model NAME`: speed over time of a move.",
    )
    laws = "`--acceleration-law NAME`: what an axis can."
    yield "Acceleration laws", acceleration.law_names(), acceleration.load_law, laws
    corners = "`[blending] law` in `olp.toml`: the way round a corner."
    yield "Blending laws", blending.law_names(), blending.load_law, corners
    methods = "`olp calibrate --method NAME`: what is learnt from recorded moves."
    yield "Estimators", estimator.estimator_names(), estimator.load_estimator, methods
    yield (
        "Physics",
        physics.term_names(),
        physics.load_term,
        "What `olp diagnose` can name; [more](../physics.md).",
    )
    rules = {rule.code: rule for rule in all_rules()}
    yield "Rules", sorted(rules), rules.__getitem__, "What `olp lint` looks for; [more](../lint.md)."
    times = "`olp time --format NAME`."
    yield "Formats of times", formats.report_names(), formats.load_report, times
    findings = "`olp check`, `olp diff` and `olp lint --format NAME`."
    yield "Formats of findings", outcome.format_names(), outcome.load_format, findings


def _codes() -> str:
    from olp.checks.lint.rule import all_rules
    from olp.core.resources import code_meanings

    rules = {rule.code: f"{rule.title}: {rule.why}" for rule in all_rules()}
    rows = sorted({**code_meanings(), **rules}.items())
    head = "# Codes\n\n`olp help CODE` says the same; [codes](../codes.md) lists the areas.\n\n"
    return head + _table(("code", "means"), rows) + "\n"


def _described(thing: Any) -> tuple[str, str]:
    """Its summary and its source."""
    says = getattr(thing, "summary", "") or getattr(thing, "title", "") or _first(type(thing).__doc__ or "")
    return str(says), str(getattr(thing, "source", ""))


def _first(text: str) -> str:
    return text.strip().partition("\n\n")[0]


def _robots() -> str:
    from olp.robots.robot import load_robot, robot_names

    parts = [
        "# Robots\n\nThe library. `inferred` numbers are published by nobody; `olp robots NAME -v` says where each "
        "is from, [robots](../robots.md) how to add one.\n"
    ]
    rows = []
    for name in robot_names():
        robot = load_robot(name)
        reach = ", ".join(axis.name for axis in robot.axes)
        verified = "yes" if robot.pose_verified else "no"
        rows.append(
            (f"`{name}`", str(robot.kind), reach, verified, ", ".join(sorted(robot.inferred)) or "nothing")
        )
    parts.append(_table(("robot", "kind", "axes", "poses verified", "inferred"), rows))
    return "\n".join(parts) + "\n"
