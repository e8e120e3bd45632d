"""Faults of code: one operator of mutation at one place of a member's own source, on a line that its suite executes."""

from __future__ import annotations

import ast
import functools
import importlib
import importlib.abc
import importlib.util
import os
import random
import re
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any, Final, NamedTuple

ROOT: Final = Path(__file__).resolve().parents[2]


class NotPlantedError(Exception):
    """The fault cannot be planted in this process, so that nothing follows from what the suite says."""


def source_of(module: str) -> str:
    """The file of a module, found without importing the packages around it."""
    path = ROOT / module.replace(".", "/")
    return str(path / "__init__.py" if path.is_dir() else path.with_suffix(".py"))


# Mutants that were looked at and change nothing that anybody can tell: (file, text of the line, change) -> why. They
# are printed, and count neither as caught nor as planted.
EQUIVALENT: Final[Mapping[tuple[str, str, str], str]] = {
    (
        "formats/json.py",
        'return part.text[:-1] + ", " + json.dumps(more, ensure_ascii=False)[1:]',
        "True and False change places",
    ): "JSON with and without escapes is the same object",
    (
        "urscript/scopes.py",
        "_ROUNDS = 3  # a type passes from a value to a name, from a name to a parameter, and on",
        "a number is another",
    ): "one more round finds nothing new",
    (
        "urscript/scopes.py",
        "kinds = {self.infer(part, item) for item in items[:50]}",
        "a number is another",
    ): "a bound of the work, not of the meaning",
}


class Mutant(NamedTuple):
    """One change of one place of a module's source."""

    module: str
    path: str
    line: int
    what: str
    index: int  # of the change among all of the module


def mutants(
    modules: Sequence[str], executed: Mapping[str, frozenset[int]], count: int, seed: int
) -> tuple[list[Mutant], int, int]:
    """`count` mutants drawn at random, how many there are on lines that run, and on lines that do not."""
    found: list[Mutant] = []
    dead = 0
    for name in modules:
        path = source_of(name)
        tree = ast.parse(Path(path).read_text(encoding="utf-8"))
        for index, (node, what) in enumerate(_places(tree)):
            if node.lineno in executed.get(path, frozenset()):
                found.append(Mutant(name, path, node.lineno, what, index))
            else:
                dead += 1
    return random.Random(seed).sample(found, min(count, len(found))), len(found), dead


_FLIPPED: Final[dict[type, type]] = {
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
_OTHER: Final[dict[type, type]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


_BOUND: Final = re.compile(r"_(?:MOST|LONGEST|DEEPEST)(?:_|$)")
_LARGE: Final = 40  # a bound from here on keeps absurd inputs out: one more is no fault
_ROUNDING: Final = 1e-6  # a number as small keeps rounding away from a comparison or a division
_SYMMETRIC: Final = {"minimum", "maximum", "min", "max", "hypot", "isclose", "allclose", "array_equal", "zip"}


def _places(tree: ast.Module) -> Iterator[tuple[Any, str]]:
    """Every place that can be changed, with the change. Left out, because nothing that runs can tell: annotations,
    docstrings, prose (texts with a blank, which are messages and help), assertions, what `raise` builds, guards
    against rounding, large bounds, the line 0 of a statement that gets its line later, and zip's `strict`."""
    skipped = _prose(tree) | _bounds(tree) | _lines_to_come(tree)
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in _FLIPPED:
            yield node, "a condition is negated"
        elif isinstance(node, ast.BoolOp):
            yield node, "and and or change places"
        elif isinstance(node, ast.BinOp) and type(node.op) in _OTHER and not _is_type(node):
            yield node, "an operator is the opposite one"
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
            yield node, "a sign or a not is dropped"
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
            yield node, "True and False change places"
        elif (
            isinstance(node, ast.Constant)
            and isinstance(node.value, int | float)
            and not isinstance(node.value, bool)
            and not 0.0 < abs(node.value) <= _ROUNDING
        ):
            yield node, "a number is another"
        elif (
            isinstance(node, ast.Call)
            and len(node.args) >= 2
            and not _is_symmetric(node)
            and not any(isinstance(a, ast.Starred) for a in node.args[:2])
            and ast.dump(node.args[0]) != ast.dump(node.args[1])
        ):
            yield node, "two arguments change places"
        elif (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)) or isinstance(
            node, ast.AugAssign
        ):
            yield node, "a statement is dropped"
        elif isinstance(node, ast.IfExp):
            yield node, "the two values of a choice change places"
        elif (
            isinstance(node, ast.Subscript)
            and isinstance(node.slice, ast.Constant)
            and isinstance(node.slice.value, str)
        ):
            yield node, "a key is another"


def _is_symmetric(call: ast.Call) -> bool:
    """Whether a call means the same with its first two arguments swapped: such a mutant is no fault."""
    return getattr(call.func, "id", getattr(call.func, "attr", "")) in _SYMMETRIC


def _is_type(node: ast.BinOp) -> bool:
    return isinstance(node.op, ast.BitOr)


def _bounds(tree: ast.Module) -> set[int]:
    """Large whole numbers that a module calls _MOST_…, _LONGEST or _DEEPEST, and `strict` of zip."""
    found: set[int] = set()
    for node in tree.body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        names = (
            [one.id for one in ast.walk(target) if isinstance(one, ast.Name)] if target is not None else []
        )
        if any(map(_BOUND.match, names)):
            found.update(
                id(one)
                for one in ast.walk(node)
                if isinstance(one, ast.Constant) and isinstance(one.value, int) and one.value >= _LARGE
            )
    strict = (one for one in ast.walk(tree) if isinstance(one, ast.keyword) and one.arg == "strict")
    return found | {id(one.value) for one in strict}


@functools.cache
def _statements() -> frozenset[str]:
    """The names of the classes whose first field is the line."""
    from olp.ir import program

    return frozenset(
        kind.__name__
        for kind in vars(program).values()
        if next(iter(getattr(kind, "__dataclass_fields__", ())), "") == "line"
    )


def _lines_to_come(tree: ast.Module) -> set[int]:
    """The 0 that a rule of a grammar gives a statement for its line; whoever calls the rule knows the line."""
    calls = (one for one in ast.walk(tree) if isinstance(one, ast.Call) and one.args)
    made = (one for one in calls if ast.unparse(one.func).removeprefix("st.") in _statements())
    return {
        id(one.args[0]) for one in made if isinstance(one.args[0], ast.Constant) and one.args[0].value == 0
    }


def _prose(tree: ast.Module) -> set[int]:
    found: set[int] = set()

    def skip(node: ast.AST | None) -> None:
        if node is not None:
            found.update(id(one) for one in ast.walk(node))

    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            skip(node.returns)
            for argument in [*node.args.args, *node.args.kwonlyargs, *node.args.posonlyargs]:
                skip(argument.annotation)
            for decorator in node.decorator_list:
                skip(decorator)
        elif isinstance(node, ast.AnnAssign):
            skip(node.annotation)
        elif isinstance(node, ast.Assert | ast.Raise | ast.JoinedStr | ast.ImportFrom | ast.Import) or (
            isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        ):
            skip(node)
        elif isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if name in ("lru_cache", "error", "warning", "info", "cast", "TypeVar", "dataclass", "field"):
                skip(node)
    return found


def _changed(tree: ast.Module, index: int) -> ast.Module:
    node, _what = list(_places(tree))[index]
    if isinstance(node, ast.Compare):
        node.ops[0] = _FLIPPED[type(node.ops[0])]()
    elif isinstance(node, ast.BoolOp | ast.BinOp):
        node.op = _OTHER[type(node.op)]()
    elif isinstance(node, ast.UnaryOp):
        _replace(tree, node, node.operand)
    elif isinstance(node, ast.Constant):
        node.value = not node.value if isinstance(node.value, bool) else _number(node.value)
    elif isinstance(node, ast.Call):
        node.args[0], node.args[1] = node.args[1], node.args[0]
    elif isinstance(node, ast.Expr | ast.AugAssign):
        _replace(tree, node, ast.Pass())
    elif isinstance(node, ast.IfExp):
        node.body, node.orelse = node.orelse, node.body
    elif isinstance(node, ast.Subscript):
        node.slice = ast.Constant(f"{node.slice.value}_")  # type: ignore[attr-defined]
    return ast.fix_missing_locations(tree)


def _number(value: float) -> float:
    return value + 1 if isinstance(value, int) else value * 1.5 + (0.5 if value == 0 else 0.0)


def _replace(tree: ast.Module, old: ast.AST, new: ast.AST) -> None:
    ast.copy_location(new, old)
    for parent in ast.walk(tree):
        for name, value in ast.iter_fields(parent):
            if value is old:
                setattr(parent, name, new)
            elif isinstance(value, list) and any(one is old for one in value):
                setattr(parent, name, [new if one is old else one for one in value])


class _Loader(importlib.abc.Loader):
    def __init__(self, spec: ModuleSpec, mutant: Mutant) -> None:
        self.spec, self.mutant = spec, mutant

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        text = Path(self.mutant.path).read_text(encoding="utf-8")
        tree = _changed(ast.parse(text), self.mutant.index)
        exec(compile(tree, self.mutant.path, "exec"), module.__dict__)


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        if name != self.mutant.module:
            return None
        sys.meta_path.remove(self)
        try:
            spec = importlib.util.find_spec(name)
        finally:
            sys.meta_path.insert(0, self)
        assert spec is not None
        spec.loader = _Loader(spec, self.mutant)
        return spec


def equivalent(mutant: Mutant) -> str:
    """Why a mutant is no fault; "" for one that may be."""
    text = Path(mutant.path).read_text(encoding="utf-8").splitlines()[mutant.line - 1].strip()
    return EQUIVALENT.get(("/".join(Path(mutant.path).parts[-2:]), text, mutant.what), "")


def as_fault(mutant: Mutant) -> tuple[str, Callable[[], Callable[[], bool]]]:
    """The member's module, imported anew with the change in it."""

    def plant() -> Callable[[], bool]:
        if mutant.module in sys.modules:
            raise NotPlantedError(f"{mutant.module} was imported before the fork: it would stay whole")
        sys.meta_path.insert(0, _Finder(mutant))
        return lambda: True

    place = "/".join(Path(mutant.path).parts[-2:])
    return f"{place}:{mutant.line}: {mutant.what}", plant


def executed_lines(
    modules: Sequence[str], check: Callable[[], None]
) -> tuple[Mapping[str, frozenset[int]], str]:
    """The lines of the modules that a run of the suite executes, and what the suite says of the whole member."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        os.write(writing, _traced(modules, check).encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        wrong, _, rows = pipe.read().decode().partition("\0")
    os.waitpid(child, 0)
    found: dict[str, set[int]] = {}
    for row in rows.split("\n"):
        path, _, lines = row.partition("\t")
        found[path] = {int(one) for one in lines.split()}
    return {path: frozenset(lines) for path, lines in found.items()}, wrong


def _traced(modules: Sequence[str], check: Callable[[], None]) -> str:
    lines: dict[str, set[int]] = {source_of(name): set() for name in modules}
    wrong = ""

    def local(frame: Any, event: str, _: Any) -> Any:
        if event == "line":
            lines[frame.f_code.co_filename].add(frame.f_lineno)
        return local

    def whole(frame: Any, event: str, _: Any) -> Any:
        if frame.f_code.co_filename not in lines:
            return None
        lines[frame.f_code.co_filename].add(frame.f_lineno)
        return local

    threading.settrace(whole)
    sys.settrace(whole)
    try:
        check()
    except BaseException:
        wrong = traceback.format_exc()[-1500:]
    sys.settrace(None)
    rows = [f"{path}\t{' '.join(map(str, sorted(found)))}" for path, found in lines.items()]
    return f"{wrong}\0" + "\n".join(rows)
