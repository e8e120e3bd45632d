"""A new user's way: a fresh repository, the blocks of the pages copied word for word, a commit that breaks the budget.

The workflow is done step by step by a small runner; the action, the template and the hooks are fetched from a
repository of olp and installed by pip.
"""

from __future__ import annotations

import os
import re
import sys
import sysconfig
from pathlib import Path

import pytest
import yaml
from guard_cells import cell
from host_runners import Github, Gitlab, Result, at_home, publish, quiet_environment, run
from test_hosts import validate

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")


def block(file: str) -> str:
    """The block of docs/ci.md that is to be copied to `file`, word for word."""
    return re.search(r"```\w+\n(.*?)```", PAGE.partition(f"`{file}`")[2], re.S)[1]


WORKFLOW = ".github/workflows/robots.yml"
FILES = {name: block(name) for name in ("olp.toml", WORKFLOW, ".gitlab-ci.yml", ".pre-commit-config.yaml")}


@pytest.fixture(scope="module")
def environment() -> dict[str, str]:
    return quiet_environment()


@pytest.fixture(scope="module")
def published(tmp_path_factory, environment) -> Path:
    return publish(tmp_path_factory.mktemp("forge") / "olp", environment)


@pytest.fixture
def repository(tmp_path, environment) -> Path:
    """A cell of robots and what docs/ci.md says, committed."""
    root = tmp_path / "robots"
    cell(root / "cell4")
    for name, text in FILES.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    (root / ".gitignore").write_text(".olp-cache\n")
    for words in ("init -q -b main", "add -A", "commit -q -m robots"):
        run(["git", *words.split()], root, environment)
    return root


def slow_down(root: Path) -> int:
    """A touch-up that breaks the budget; its line."""
    path = root / "cell4" / "MAIN.JBI"
    lines = path.read_bytes().split(b"\r\n")
    line = lines.index(b"TIMER T=0.70")
    lines[line] = b"TIMER T=60.00"
    path.write_bytes(b"\r\n".join(lines))
    return line + 1


def pull_request(root: Path, environment: dict[str, str]) -> int:
    """A branch with the touch-up, and the merge with `main` that the forge checks out; the line."""
    run(["git", "checkout", "-q", "-b", "touch-up"], root, environment)
    line = slow_down(root)
    run(["git", "commit", "-qam", "a touch-up at night"], root, environment)
    run(["git", "checkout", "-q", "--detach", "main"], root, environment)
    run(["git", "merge", "-q", "--no-ff", "-m", "merge", "touch-up"], root, environment)
    run(["git", "update-ref", "refs/pull/7/merge", "HEAD"], root, environment)
    run(["git", "checkout", "-q", "main"], root, environment)
    return line


def github(home: Path, environment, published, repository, text: str, event: str, base: str = "") -> Result:
    workflow = yaml.safe_load(text)
    validate(
        {**{k: v for k, v in workflow.items() if k is not True}, "on": workflow[True]}, "github-workflows"
    )
    assert event in workflow[True]  # YAML 1.1 takes the word "on" for a truth
    return Github(home, environment, published, event, base).run(workflow, repository)


def test_a_push_that_holds_the_budget_is_green(tmp_path, environment, published, repository):
    done = github(tmp_path / "runner", environment, published, repository, FILES[WORKFLOW], "push")
    assert done.success, done.log
    assert not [told for told in done.annotations if told[0] == "error"]
    assert "| held | cell 4 |" in done.summary


def test_a_pull_request_that_breaks_the_budget_is_red_and_says_which_line_and_why(
    tmp_path, environment, published, repository
):
    line = pull_request(repository, environment)
    done = github(
        tmp_path / "runner", environment, published, repository, FILES[WORKFLOW], "pull_request", "main"
    )
    assert not done.success
    (told,) = (told for told in done.annotations if told[0] == "error")
    assert (told[1]["file"], told[1]["line"]) == ("cell4/MAIN.JBI", str(line)), done.log
    assert "over the budget of 42 s" in told[2]
    row = f"| {line} | TIMER T=60.00 | 0.700 | 60.000 | +59.300 | wait |"
    assert row in done.summary
    assert row in (tmp_path / "runner" / "work" / "olp-diff.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("event", "comments"), [("pull_request", 1), ("push", 0)])
def test_the_workflow_of_the_page_comments_on_a_pull_request_though_it_is_red(
    tmp_path, environment, published, repository, event, comments
):
    workflow = yaml.safe_load(FILES[WORKFLOW])
    steps = workflow["jobs"]["cycle-time"]["steps"]
    (at,) = (n for n, step in enumerate(steps) if step.get("uses") == "OWNER/olp@main")
    # What the action does has a test of its own; here it leaves its comment and fails.
    steps[at] = {"run": "echo changed > olp-diff.md; exit 1"}
    pull_request(repository, environment)
    done = Github(tmp_path / "runner", environment, published, event, "main").run(workflow, repository)
    assert not done.success
    assert done.said == ["pr comment 7 --edit-last --create-if-none --body-file olp-diff.md"] * comments


@pytest.mark.slow
def test_a_merge_request_that_breaks_the_budget_is_red_and_its_reports_say_which_line(
    tmp_path, environment, published, repository
):
    settings = yaml.safe_load(FILES[".gitlab-ci.yml"])
    validate(settings, "gitlab-ci")
    pipeline = Gitlab(tmp_path / "python", environment, published, settings)
    base = run(["git", "rev-parse", "HEAD"], repository, environment).strip()
    status, told = pipeline.run("olp-check", repository)
    assert status == 0, told
    line = slow_down(repository)
    run(["git", "commit", "-qam", "a touch-up at night"], repository, environment)
    status, told = pipeline.run("olp-check", repository)
    assert status == 1, told
    (first, *_) = yaml.safe_load((repository / "olp-check.json").read_text(encoding="utf-8"))
    assert first["location"] == {"path": "cell4/MAIN.JBI", "lines": {"begin": line}}
    assert f"cell4/MAIN.JBI:{line}" in (repository / "olp-check.xml").read_text(encoding="utf-8")
    assert pipeline.run("olp-lint", repository)[0] == 0
    assert pipeline.run("olp-diff", repository, CI_MERGE_REQUEST_DIFF_BASE_SHA=base)[0] == 1  # a budget broke
    assert f"| {line} | TIMER T=60.00 |" in (repository / "olp-diff.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_commit_that_breaks_the_budget_is_refused_and_says_which_line(
    tmp_path, environment, published, repository
):
    here = at_home(environment, published) | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PRE_COMMIT_HOME": str(tmp_path / "pre-commit"),
        "PYTHONPATH": sysconfig.get_path(
            "purelib"
        ),  # what olp needs, for the environment that pre-commit makes
    }
    run([sys.executable, "-m", "pre_commit", "install"], repository, here)
    line = slow_down(repository)
    told = run(["git", "commit", "-am", "a touch-up at night"], repository, here, status=1)
    assert re.search(r"cycle-time budgets\.+Failed", told), told
    assert re.search(r"motion mistakes\.+Passed", told), told
    assert f"cell4/MAIN.JBI:{line}" in told.replace("\\", "/")
    assert "TIMER T=60.00" in told
    run(["git", "checkout", "-q", "--", "cell4"], repository, here)
    (repository / "cell4" / "README.md").write_text("robots\n")
    run(["git", "add", "-A"], repository, here)
    assert "Skipped" in run(["git", "commit", "-m", "words"], repository, here)
