"""Renders templates that may come from anybody: a small, bounded part of jinja2.

A template sees values, never objects with methods; it cannot reach a file outside its folder; and however it
is written, it ends: steps, characters and seconds are counted while it runs. Everything that goes wrong is a
diagnostic with the template's file and line.

Codes: J001 a mistake in the template's text, J002 a mistake while it ran, J003 something a template may not
do, J004 a limit was reached, J005 no such template.
"""

from __future__ import annotations

import math
import os
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from jinja2 import (
    BytecodeCache,
    FunctionLoader,
    StrictUndefined,
    Template,
    TemplateSyntaxError,
    Undefined,
    nodes,
)
from jinja2.bccache import Bucket
from jinja2.exceptions import SecurityError, TemplateNotFound, TemplatesNotFound, UndefinedError
from jinja2.runtime import BlockReference, Context, Macro
from jinja2.sandbox import ImmutableSandboxedEnvironment
from jinja2.utils import pass_context

from olp.core import resources
from olp.core.diagnostic import Diagnostic, OlpError, Span, error

FOLDER = "templates"
SUFFIX = ".j2"
LARGEST_TEMPLATE = 256 * 1024  # characters; also bounds what a static text can cost per step
LARGEST_NUMBER = 10**18


class RenderingLimits(NamedTuple):
    """What one rendering may cost. Iterations, calls, includes and outputs are steps."""

    steps: int = 200_000
    characters: int = 1_000_000
    seconds: float = 10.0


class LimitError(Exception):
    """A template ran longer or wrote more than it may."""


class _Spent:
    """What the current rendering has cost."""

    def __init__(self) -> None:
        self.begin(RenderingLimits())

    def begin(self, limits: RenderingLimits) -> None:
        self.limits = limits
        self.steps = self.characters = 0
        self.deadline = time.monotonic() + limits.seconds

    def step(self) -> None:
        self.steps += 1
        if self.steps > self.limits.steps:
            raise LimitError(f"more than {self.limits.steps:,} steps")
        if not self.steps & 255 and time.monotonic() > self.deadline:
            raise LimitError(f"more than {self.limits.seconds:g} s")

    def text(self, text: str) -> str:
        self.step()
        self.characters += len(text)
        if self.characters > self.limits.characters:
            raise LimitError(f"more than {self.limits.characters:,} characters")
        return text


class _Compiled(BytecodeCache):
    """Compiled templates by file and text: compiling takes longer than rendering most programs."""

    MOST = 64

    def __init__(self) -> None:
        self._codes: dict[tuple[str, str], Any] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        bucket.code = self._codes.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        if len(self._codes) < self.MOST:
            self._codes[bucket.key, bucket.checksum] = bucket.code


_COMPILED = _Compiled()


class Sandbox(ImmutableSandboxedEnvironment):
    """jinja2 with nothing but expressions, loops, macros and includes, all of them counted."""

    intercepted_binops = frozenset({"+", "-", "*", "/", "//", "%", "**"})

    def __init__(self, load: Callable[[str], tuple[str, str, None] | None]) -> None:
        # Folding constants would run operators and filters uncounted, while the template is compiled.
        super().__init__(
            loader=FunctionLoader(lambda name: self._kept(load(name))),
            undefined=StrictUndefined,
            autoescape=False,
            keep_trailing_newline=True,
            trim_blocks=True,
            lstrip_blocks=True,
            optimized=False,
            auto_reload=False,
            bytecode_cache=_COMPILED,
            finalize=_finalize,
        )
        self.spent = _Spent()
        self.sources: dict[str, str] = {}  # by file, for the line below a diagnostic
        self.globals.clear()
        self.filters = {**FILTERS, _COUNTED: self._counted, _JOINED: self._joined}

    def _kept(self, found: tuple[str, str, None] | None) -> tuple[str, str, None] | None:
        if found is not None:
            source, file, _ = found
            self.sources[file] = source
        return found

    def is_safe_attribute(self, obj: Any, attr: str, value: Any) -> bool:
        return not attr.startswith("_") and (not callable(value) or isinstance(value, Macro))

    def is_safe_callable(self, obj: Any) -> bool:
        return isinstance(obj, (Macro, BlockReference))

    def call(self, context: Context, obj: Any, *args: Any, **kwargs: Any) -> Any:
        self.spent.step()
        if isinstance(obj, Undefined):
            str(obj)  # raises, naming what is undefined
        return super().call(context, obj, *args, **kwargs)

    def call_binop(self, context: Context, operator: str, left: Any, right: Any) -> Any:
        if operator == "**" or not (isinstance(left, (int, float)) and isinstance(right, (int, float))):
            raise SecurityError(f"{operator} is for numbers (texts are joined with ~)")
        result = super().call_binop(context, operator, left, right)
        if isinstance(result, int) and abs(result) > LARGEST_NUMBER:
            raise LimitError("a number above 10^18")
        return result

    def get_template(self, name: Any, parent: str | None = None, globals: Any = None) -> Template:
        self.spent.step()
        return super().get_template(name, parent, globals)

    def _parse(self, source: str, name: str | None, filename: str | None) -> nodes.Template:
        if len(source) > LARGEST_TEMPLATE:
            raise TemplateSyntaxError(f"longer than {LARGEST_TEMPLATE:,} characters", 1, name, filename)
        tree = super()._parse(source, name, filename)
        _make_countable(self, tree, name, filename)
        return tree

    def _counted(self, items: Iterable[Any]) -> Iterator[Any]:
        for item in items:
            self.spent.step()
            yield item

    def _joined(self, items: Iterable[Any]) -> str:
        return self.spent.text("".join(scalar(item) for item in items))


@pass_context
def _finalize(context: Context, value: Any) -> str:
    # With a context jinja2 cannot call it while compiling, so every output is counted when it is written.
    sandbox = context.environment
    assert isinstance(sandbox, Sandbox)
    return sandbox.spent.text(scalar(value))


_COUNTED, _JOINED = "counted ", "joined "  # the blank keeps templates from naming them


def _make_countable(sandbox: Sandbox, tree: nodes.Template, name: str | None, filename: str | None) -> None:
    """Rewrites what jinja2 would do uncounted: loops, joins with ~ and text between the tags."""
    for literal in tree.find_all((nodes.List, nodes.Tuple, nodes.Dict)):
        # Lists of lists of lists … take exponential time to compare or to write.
        if getattr(literal, "ctx", "load") == "load" and not all(map(_literal, literal.iter_child_nodes())):
            raise TemplateSyntaxError("a list may hold literals only", literal.lineno, name, filename)
    for output in tree.find_all(nodes.Output):
        for index, child in enumerate(output.nodes):
            if isinstance(child, nodes.TemplateData):
                output.nodes[index] = nodes.Const(child.data, lineno=child.lineno)
    for loop in tree.find_all(nodes.For):
        loop.iter = nodes.Filter(loop.iter, _COUNTED, [], [], None, None, lineno=loop.lineno)
    _replace_joins(tree)
    tree.set_environment(sandbox)


def _literal(node: nodes.Node) -> bool:
    if isinstance(node, nodes.Pair):
        return _literal(node.value)
    return isinstance(node, nodes.Const)


def _replace_joins(node: nodes.Node) -> None:
    for field, value in node.iter_fields():
        if isinstance(value, nodes.Concat):
            setattr(node, field, _join_filter(value))
        elif isinstance(value, list):
            value[:] = [_join_filter(item) if isinstance(item, nodes.Concat) else item for item in value]
    for child in node.iter_child_nodes():
        _replace_joins(child)


def _join_filter(concat: nodes.Concat) -> nodes.Filter:
    items = nodes.List(concat.nodes, lineno=concat.lineno)
    return nodes.Filter(items, _JOINED, [], [], None, None, lineno=concat.lineno)


class Renderer:
    """A loaded template."""

    def __init__(self, sandbox: Sandbox, name: str) -> None:
        self._sandbox = sandbox
        sandbox.spent.begin(RenderingLimits())
        try:
            self._template = sandbox.get_template(name)
        except Exception as problem:
            self._refuse(problem, name)

    @property
    def path(self) -> str:
        """The template's file, as it is shown in diagnostics."""
        return self._template.filename or ""

    def render(self, values: Mapping[str, Any], limits: RenderingLimits | None = None) -> str:
        """The template's text. Raises OlpError with the template's file and line."""
        self._sandbox.spent.begin(limits or RenderingLimits())
        try:
            context = self._template.new_context(dict(values))
            return "".join(self._template.root_render_func(context))
        # What a stranger's template can raise is everything that Python can.
        except Exception as problem:
            self._refuse(problem, self.path)

    def _refuse(self, problem: Exception, name: str) -> NoReturn:
        found = _explain(problem, name)
        lines = self._sandbox.sources.get(found.file, "").splitlines()
        if 0 < found.line <= len(lines):
            text = lines[found.line - 1]
            found = replace(found, source_line=text, end_column=len(text) + 1)
        raise OlpError(found) from problem


def shipped(name: str) -> Renderer:
    """The template `name` (without its suffix) that comes with olp. Raises OlpError."""
    return Renderer(Sandbox(_read_shipped), name + SUFFIX)


def given(path: str | os.PathLike[str]) -> Renderer:
    """A user's template; it may include files of its own folder and olp's. Raises OlpError."""
    file = Path(path)
    folder = file.parent.resolve()

    def load(name: str) -> tuple[str, str, None] | None:
        return _read_beside(folder, name) or _read_shipped(name)

    if not file.is_file():
        raise OlpError(error("J005", "there is no such template", file=str(file)))
    return Renderer(Sandbox(load), file.name)


def _plain(name: str) -> bool:
    return name not in ("", ".", "..") and not set(name) & set("/\\:\0")


def _read_beside(folder: Path, name: str) -> tuple[str, str, None] | None:
    file = folder / name
    if not _plain(name) or file.resolve().parent != folder or not file.is_file():
        return None
    if file.stat().st_size > 4 * LARGEST_TEMPLATE:
        raise LimitError(f"{name} is larger than {LARGEST_TEMPLATE:,} characters")
    return file.read_text(encoding="utf-8"), str(file), None


def _read_shipped(name: str) -> tuple[str, str, None] | None:
    if not _plain(name) or not name.endswith(SUFFIX):
        return None
    try:
        return resources.read_text(FOLDER, name), name, None
    except FileNotFoundError:
        return None


def _explain(problem: Exception, name: str) -> Diagnostic:
    file, line = _place(problem, name)
    span = Span(line) if line else None
    if isinstance(problem, SyntaxError):
        return error("J001", "nested too deeply", file=file)
    if isinstance(problem, TemplateSyntaxError):
        return error("J001", problem.message or "not a template", span, file=file)
    if isinstance(problem, (TemplateNotFound, TemplatesNotFound)):
        text = f"there is no template {problem.message!r}"
        return error("J005", text, span, file=file, help="a template can use files of its own folder")
    if isinstance(problem, SecurityError):
        return error("J003", f"not allowed in a template: {problem}", span, file=file)
    if isinstance(problem, (LimitError, RecursionError, MemoryError)):
        text = str(problem) if isinstance(problem, LimitError) else "nested too deeply"
        return error("J004", f"the template was stopped: {text}", span, file=file)
    if isinstance(problem, UnicodeDecodeError):
        return error("J001", "a template is UTF-8 text, this is not", file=file)
    if isinstance(problem, UndefinedError):
        # Classes of olp mean nothing to those who write templates; their last word does (AnnotationRow: a row).
        text = re.sub(
            r"'(?:\w+\.)*\w*?([A-Z][a-z]*) object' has",
            lambda match: f"a {match[1].lower()} has",
            str(problem),
        )
        return error("J002", text, span, file=file, help="the head of olp's own template lists what there is")
    return error("J002", f"{type(problem).__name__}: {problem}", span, file=file)


def _place(problem: Exception, name: str) -> tuple[str, int]:
    """File and line of the innermost template that was running."""
    if isinstance(problem, TemplateSyntaxError):
        return problem.filename or problem.name or name, problem.lineno
    place, trace = (name, 0), problem.__traceback__
    while trace is not None:
        template = trace.tb_frame.f_globals.get("__jinja_template__")
        if isinstance(template, Template):
            place = template.filename or name, template.get_corresponding_lineno(trace.tb_lineno)
        trace = trace.tb_next
    return place


# --- Template filters ---
# What a template can do with a value: the filters, and the rule that only texts and numbers are written.


def scalar(value: Any) -> str:
    """The text of a text or number. Raises SecurityError for anything else, UndefinedError for what is missing."""
    if isinstance(value, (str, int, float, Undefined)):
        return str(value)
    raise SecurityError(f"only texts and numbers can be written, not a {type(value).__name__}")


def fixed(value: float, decimals: int = 3) -> str:
    """`value` with that many decimals (at most 9), never "-0"."""
    text = f"{float(value):.{min(max(int(decimals), 0), 9)}f}"
    return text.lstrip("-") if not text.strip("-0.") else text


def short(value: float, digits: int = 3) -> str:
    """`value` rounded to that many digits, without an exponent or needless zeros: 592, 7.41, 0.0533."""
    number = float(value)
    if not number or not math.isfinite(number):
        return "0" if not number else str(number)
    decimals = min(max(int(digits), 1), 9) - 1 - math.floor(math.log10(abs(number)))
    text = fixed(round(number, decimals), max(decimals, 0))
    return text.rstrip("0").rstrip(".") if "." in text else text


def known(value: Any) -> bool:
    """Whether `value` is a number and not nan, None or an empty text."""
    return (isinstance(value, str) and bool(value)) or (isinstance(value, (int, float)) and value == value)


def cut(text: str, width: int) -> str:
    """The first `width` characters."""
    return scalar(text)[: max(int(width), 0)]


def default(value: Any, other: Any = "") -> Any:
    """`other` where `value` is undefined or None."""
    return other if value is None or isinstance(value, Undefined) else value


FILTERS: Mapping[str, Callable[..., Any]] = {
    "fixed": fixed,
    "short": short,
    "known": known,
    "cut": cut,
    "default": default,
    "upper": lambda text: scalar(text).upper(),
    "lower": lambda text: scalar(text).lower(),
    "trim": lambda text: scalar(text).strip(),
    "round": lambda value: round(float(value)),
    "abs": lambda value: abs(value) if isinstance(value, (int, float)) else abs(float(value)),
    "length": len,
    "first": lambda items: items[0],
    "last": lambda items: items[-1],
}
