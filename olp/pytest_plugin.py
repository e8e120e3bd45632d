"""`pytest --olp`: every budget of every olp.toml is a test. The fixture `olp_time` times a program in any test.

pytest loads this file in every run, so everything else of olp is imported when it is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from olp.checks.guard.budget import Budget
    from olp.checks.guard.run import JudgedFile
    from olp.reports.outcome.model import JudgedItem
    from olp.timing.result import Timing


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("olp")
    group.addoption("--olp", action="store_true", help="test the cycle-time budgets of every olp.toml found")


def pytest_collect_file(parent: pytest.Collector, file_path: Path) -> pytest.Collector | None:
    if parent.config.getoption("--olp") and file_path.name == "olp.toml":
        return BudgetFile.from_parent(parent, path=file_path)
    return None


class BudgetFile(pytest.File):
    """An olp.toml."""

    def collect(self) -> Iterator[pytest.Item]:
        from olp.checks.guard.budget import budgets_for

        (read,) = budgets_for(str(self.path), str(self.path))
        for told in read.diagnostics:
            yield BudgetTest.from_parent(self, name=f"{told.code}:{told.line}", says=told.render())
        programs = self._programs() if read.budgets else []
        covered = {path: tuple(b for b in read.budgets if b.covers(path)) for path in programs}
        judge = _Judge(covered)
        for budget in read.budgets:
            paths = [path for path in programs if budget in covered[path]]
            if budget.anywhere:
                yield BudgetTest.from_parent(self, name=budget.name, budget=budget, paths=paths, judge=judge)
                continue
            for path in paths:
                name = f"{budget.name}[{Path(path).relative_to(self.path.parent).as_posix()}]"
                yield BudgetTest.from_parent(self, name=name, budget=budget, paths=[path], judge=judge)
            if not paths:
                says = f"the budget {budget.name!r} holds for no program below"
                yield BudgetTest.from_parent(self, name=budget.name, says=says)

    def _programs(self) -> list[str]:
        from olp.core.diagnostic import OlpError
        from olp.languages.vendor import program_files

        try:
            return [str(path) for path in program_files([self.path.parent])]
        except OlpError:
            return []  # a folder without programs


class BudgetTest(pytest.Item):
    """A budget and the programs that it holds for. `says`: why it cannot be judged at all."""

    def __init__(
        self,
        *,
        says: str = "",
        budget: Budget | None = None,
        paths: list[str] | None = None,
        judge: _Judge | None = None,
        **more: Any,
    ) -> None:
        super().__init__(**more)
        self.funcargs: dict[str, Any] = {}  # as all items of pytest have it: plugins read it unasked
        self.says, self.budget, self.paths, self.judge = says, budget, paths or [], judge

    def runtest(self) -> None:
        from olp.reports.outcome.model import Status

        if self.budget is None or self.judge is None:
            raise BudgetError(self.says)
        items = [item for path in self.paths for item in self.judge(path, self.budget)]
        if not items:
            raise BudgetError(f"the budget {self.budget.name!r} holds for no program below")
        worst = max(items, key=lambda item: item.seconds or 0.0)
        self.user_properties += [("predicted_s", worst.seconds), ("limit_s", worst.limit_s)]
        bad = [item for item in items if item.status in (Status.FAILED, Status.UNKNOWN)]
        if bad:
            raise BudgetError("\n".join(_told(item) for item in bad))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        if isinstance(excinfo.value, BudgetError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        line = self.budget.line - 1 if self.budget is not None and self.budget.line else None
        return self.path, line, self.name


class BudgetError(Exception):
    """A budget that does not hold, or cannot be judged."""


class _Judge:
    """Times each program once, whatever number of budgets holds for it."""

    def __init__(self, covered: dict[str, tuple[Budget, ...]]) -> None:
        self.covered = covered
        self.known: dict[str, JudgedFile] = {}

    def __call__(self, path: str, budget: Budget) -> list[JudgedItem]:
        from olp.checks.guard.run import judge
        from olp.reports.batch import Job

        if path not in self.known:
            # Two budgets may have one name: the place in olp.toml tells them apart.
            own = tuple(replace(b, name=f"{b.line}:{b.name}") for b in self.covered[path])
            self.known[path] = judge(path, own, Job())
        mark = f"{budget.line}:{budget.name}"
        return [replace(item, name=budget.name) for item in self.known[path].items if item.name == mark]


def _told(item: JudgedItem) -> str:
    place = f"{item.file}:{item.line}" if item.line else item.file
    return "\n".join(filter(None, (f"{place}: {item.message}", item.details)))


@pytest.fixture
def olp_time(request: pytest.FixtureRequest) -> Callable[..., Timing]:
    """`olp_time(path, robot=…, signature=…)` reads, runs and times a program and returns its `Timing`.

    Paths are seen from pytest's root folder; further words are those of `olp.reports.batch.Job`. Raises OlpError.
    """
    from olp.identification.timing_job import plan_and_time
    from olp.reports.batch import Job

    root = request.config.rootpath

    def time(path: str | Path, **settings: Any) -> Timing:
        return plan_and_time(str(root / path), Job(**settings))

    return time
