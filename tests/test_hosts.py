"""The hosts that olp runs on: pre-commit, GitHub, GitLab, pytest; each in a real run, with a budget that breaks."""

from __future__ import annotations

import ast
import importlib.util
import json
import os
import re
import shutil
import stat
import subprocess
import sys
from importlib import resources
from itertools import takewhile
from pathlib import Path

import jsonschema
import pytest
import yaml
from guard_cells import CELL, cell
from host_runners import quiet_environment, run

import olp
from olp.languages.vendor import vendor_suffixes

pytest_plugins = ["pytester"]
ROOT = Path(__file__).parent.parent
BUDGET = "[[budget]]\nname = 'promise'\njob = 'MAIN'\nlimit_s = 4.5\n"
PAGE = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")


def block(heading: str, kind: str, number: int = 0) -> str:
    """A fenced block of docs/ci.md, word for word."""
    part = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return re.findall(rf"```{kind}\n(.*?)```", part, re.S)[number]


def schema(name: str) -> dict[str, object]:
    """A published schema that check-jsonschema brings along."""
    file = resources.files("check_jsonschema") / "builtin_schemas" / "vendor" / f"{name}.json"
    return json.loads(file.read_text(encoding="utf-8"))


def validate(whole: object, name: str) -> None:
    known = schema(name)
    jsonschema.validators.validator_for(known)(known).validate(whole)


@pytest.fixture
def environment(tmp_path) -> dict[str, str]:
    """With an `olp` on the path that is this one, and git's answers not those of this machine."""
    tools = tmp_path / "tools"
    tools.mkdir()
    olp = tools / "olp"
    olp.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m olp "$@"\n')
    olp.chmod(olp.stat().st_mode | stat.S_IEXEC)
    path = f"{tools}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return quiet_environment() | {"PATH": path, "PYTHONPATH": str(ROOT)}


@pytest.fixture
def repository(tmp_path, environment) -> Path:
    root = tmp_path / "robots"
    cell(root / "cell", BUDGET)
    (root / ".gitignore").write_text(".olp-cache\n")
    run(["git", "init", "-q", "-b", "main"], root, environment)
    run(["git", "add", "-A"], root, environment)
    run(["git", "commit", "-qm", "a cell that holds its budget"], root, environment)
    return root


def slow_down(root: Path) -> int:
    """A change that breaks the budget; the line it is in."""
    path = root / "cell" / "MAIN.JBI"
    lines = path.read_bytes().split(b"\r\n")
    line = next(n for n, text in enumerate(lines) if text.startswith(b"TIMER"))
    lines[line] = b"TIMER T=9.00"
    path.write_bytes(b"\r\n".join(lines))
    return line + 1


# pre-commit


HOOKS = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))


def test_the_hooks_are_valid_and_know_every_language(environment, tmp_path):
    run(
        [sys.executable, "-m", "pre_commit", "validate-manifest", str(ROOT / ".pre-commit-hooks.yaml")],
        tmp_path,
        environment,
    )
    for hook in HOOKS:
        for suffix in vendor_suffixes():
            assert re.search(hook["files"], f"cells/4/MAIN{suffix}")
            assert re.search(hook["files"], f"cells/4/MAIN{suffix.upper()}")
        assert not re.search(hook["files"], "README.md")
    assert re.search(HOOKS[0]["files"], "cells/olp.toml")


def test_the_page_names_hooks_that_there_are():
    (repo,) = yaml.safe_load(block("Before each commit", "yaml"))["repos"]
    assert {hook["id"] for hook in repo["hooks"]} == {hook["id"] for hook in HOOKS}


# GitHub


ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))


def inputs(given: dict[str, str]) -> dict[str, str]:
    """The environment that the last step of the action hands to its entry."""
    values = {name: given.get(name, told["default"]) for name, told in ACTION["inputs"].items()}
    assert set(given) <= set(values)
    step = ACTION["runs"]["steps"][-1]
    return {
        name: re.sub(r"\$\{\{ inputs\.([\w-]+) \}\}", lambda m: values[m[1]], text).replace(
            "${{ github.action_path }}", str(ROOT)
        )
        for name, text in step["env"].items()
    }


def act(repository: Path, environment: dict[str, str], status: int, **given: str) -> str:
    entry = ACTION["runs"]["steps"][-1]["run"]
    return run(["bash", "-e", "-c", entry], repository, environment | inputs(given), status)


def test_the_action_is_valid_and_its_entry_can_be_executed():
    validate(ACTION, "github-actions")
    assert os.access(ROOT / "hosts" / "github" / "run.sh", os.X_OK)


def test_the_workflow_of_the_page_is_valid_and_uses_inputs_that_there_are():
    workflow = yaml.safe_load(block("GitHub", "yaml"))
    workflow["on"] = workflow.pop(True, workflow.get("on"))  # YAML 1.1 takes the word for a truth
    validate(workflow, "github-workflows")
    (step,) = (
        s for s in workflow["jobs"]["cycle-time"]["steps"] if s.get("uses", "").startswith("OWNER/olp")
    )
    assert set(step["with"]) <= set(ACTION["inputs"])


def test_a_checkout_without_its_base_is_told_and_the_rest_is_judged(repository, environment):
    told = act(repository, environment | {"GITHUB_BASE_REF": "main"}, 0, lint="")
    assert "fetch-depth" in told


def test_the_action_takes_the_worst_status_and_leaves_reports(repository, environment):
    (repository / "cell" / "olp.toml").write_text(BUDGET + "\n[[budget]]\nlimt_s = 3\n")
    act(repository, environment, 2, sarif="reports")
    for name, code in (("check", "M001"), ("lint", "W014")):
        (run_of,) = json.loads((repository / "reports" / f"{name}.sarif").read_text())["runs"]
        assert code in {rule["id"] for rule in run_of["tool"]["driver"]["rules"]}


@pytest.mark.slow
def test_mistakes_that_are_known_leave_the_action_green(repository, environment):
    path = repository / "cell" / "MAIN.JBI"
    path.write_bytes(path.read_bytes().replace(b"*START", b"CALL JOB:NOWHERE"))
    assert "::error" in act(repository, environment, 1, check="")
    run(["olp", "lint", "--write-baseline", "known.json"], repository, environment)
    assert "::error" not in act(repository, environment, 0, check="", baseline="known.json")


# GitLab


TEMPLATE = ROOT / "hosts" / "gitlab" / "olp.gitlab-ci.yml"


def test_the_template_and_what_includes_it_are_valid():
    validate(yaml.safe_load(TEMPLATE.read_text(encoding="utf-8")), "gitlab-ci")
    validate(yaml.safe_load(block("GitLab", "yaml")), "gitlab-ci")
    assert TEMPLATE.name in block("GitLab", "yaml")


# Anywhere else


def test_the_commands_of_the_page_do_what_they_say(repository, environment):
    slow_down(repository)
    run(["git", "commit", "-qam", "a touch-up at night"], repository, environment)
    commands = block("Anywhere else", "sh").strip().splitlines()
    assert len(commands) == 3
    for command, status in zip(commands, (1, 0, 1), strict=True):
        run(["sh", "-c", command], repository, environment, status)
    for name in ("budgets.xml", "lint.sarif", "times.md"):
        assert (repository / name).stat().st_size


# pytest


@pytest.fixture
def cells(pytester) -> Path:
    """A project with a cell, as its owner has it."""
    cell(pytester.path / "cells" / "4", BUDGET + "\n[[budget]]\nroutine = 'GRIP'\nlimit_s = 9\n")
    pytester.makeini("[pytest]\n")
    return pytester.path / "cells" / "4"


@pytest.fixture
def alone(monkeypatch) -> None:
    """pytest loads olp's plugin and no other that happens to be installed, which takes seconds."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTEST_PLUGINS", "olp.pytest_plugin")


def outcomes(pytester, *words: str):
    # pytest-asyncio wants a setting of every project, whether it has coroutines or not.
    # In this process it would leave modules behind half forgotten, and later tests with two of every class.
    return pytester.runpytest_subprocess(*words, "-p", "no:cacheprovider", "-p", "no:asyncio")


def test_each_budget_is_a_test(pytester, cells, monkeypatch):
    """With pytest as it is installed, in which olp's plugin is one of many."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    command, *words = block("With pytest", "sh").split()
    assert command == "pytest"
    found = outcomes(pytester, *words, "-v")
    found.assert_outcomes(passed=2)
    found.stdout.fnmatch_lines(["*olp.toml::promise*MAIN.JBI* PASSED*", "*olp.toml::GRIP PASSED*"])


@pytest.mark.usefixtures("alone")
def test_a_budget_that_breaks_fails_with_its_line(pytester, cells):
    path = cells / "MAIN.JBI"
    path.write_bytes(path.read_bytes().replace(b"T=0.70", b"T=9.70"))
    found = outcomes(pytester, *block("With pytest", "sh").split()[1:])
    found.assert_outcomes(passed=1, failed=1)
    found.stdout.fnmatch_lines(["*MAIN.JBI:*over the budget of 4.5 s*", "*MAIN.JBI:*9.700 s*"])


@pytest.mark.usefixtures("alone")
def test_without_the_option_budgets_are_no_tests(pytester, cells):
    assert "no tests ran" in str(outcomes(pytester, "cells").stdout)


@pytest.mark.usefixtures("alone")
def test_budgets_that_say_nonsense_or_hold_nowhere_fail(pytester, cells):
    (cells / "olp.toml").write_text("[[budget]]\nlimit_s = -1\n\n[[budget]]\nlimit_s = 1\njob = 'NOBODY'\n")
    found = outcomes(pytester, "--olp", "cells")
    found.assert_outcomes(failed=2)
    found.stdout.fnmatch_lines(["*M001*", "*holds for no program below*"])


@pytest.mark.usefixtures("alone")
def test_two_budgets_of_one_name_are_two_tests(pytester, cells):
    (cells / "olp.toml").write_text(BUDGET + BUDGET.replace("4.5", "0.5"))
    outcomes(pytester, "--olp", "cells").assert_outcomes(passed=1, failed=1)


@pytest.mark.usefixtures("alone")
def test_a_junit_report_holds_predicted_seconds(pytester, cells):
    outcomes(
        pytester, "--olp", "cells", "--junitxml", "out.xml", "-o", "junit_family=xunit1"
    ).assert_outcomes(passed=2)
    told = re.findall(r'name="predicted_s" value="(.*?)"', (pytester.path / "out.xml").read_text())
    assert float(told[0]) == pytest.approx(olp.read(cells / "MAIN.JBI").plan().time().duration_s.sum())


@pytest.mark.usefixtures("alone")
def test_the_fixture_times_a_program_as_the_page_shows(pytester, cells):
    example = block("With pytest", "python")
    assert 'robot="yaskawa/gp25"' in example
    pytester.makepyfile(example)
    outcomes(pytester).assert_outcomes(passed=1)
    shutil.rmtree(cells)
    cell(cells, jobs=CELL | {"GRIP": "TIMER T=3.00"})
    outcomes(pytester).assert_outcomes(failed=1)


def test_the_plugin_costs_nothing_where_it_is_not_used():
    code = (
        "import olp.pytest_plugin, sys; print([m for m in sys.modules if m in ('numpy', 'pandas', 'lark')])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True
    )
    assert done.stdout.strip() == b"[]"


IN_CI = re.compile(r"# In CI: \S")
HOSTS = sorted(folder.name for folder in (ROOT / "hosts").iterdir() if folder.is_dir())


@pytest.mark.parametrize("host", HOSTS)
def test_a_host_has_a_page_and_a_test_of_its_own(host):
    folder = ROOT / "hosts" / host
    assert (folder / "README.md").read_text(encoding="utf-8").startswith("# ")
    assert (folder / "test").read_text(encoding="utf-8").startswith("#!/bin/sh\n# ")


def head_of(script: Path) -> list[str]:
    """The comments that a script begins with."""
    return [*takewhile(lambda line: line.startswith("#"), script.read_text(encoding="utf-8").splitlines())]


@pytest.mark.parametrize("host", HOSTS)
def test_what_a_host_imports_of_olp_is_there(host):
    """Hosts are not typed, and some run seldom: a module that has moved must be seen at once."""
    for path in (ROOT / "hosts" / host).rglob("*.py"):
        if "node_modules" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "olp":
                module = importlib.import_module(node.module)
                for name in node.names:
                    whole = f"{node.module}.{name.name}"
                    assert hasattr(module, name.name) or importlib.util.find_spec(whole), f"{path}: {whole}"


@pytest.fixture
def house(tmp_path) -> Path:
    """A repository with the runner and three hosts: one for CI, one that fails, one that cannot be set up."""
    (tmp_path / "scripts").mkdir()
    shutil.copy(ROOT / "scripts" / "test-hosts", tmp_path / "scripts")
    setup = tmp_path / "scripts" / "setup"
    setup.write_text(f"#!/bin/sh\necho {sys.executable}\n")
    setup.chmod(0o755)
    for name, rest in {
        "editor": '# It works.\n# In CI: nothing.\nset -e\ntouch "$OLP_HOSTS/seen"\n',
        "broken": "# It fails.\necho '# In CI: not in its head'\nexit 1\n",
        "absent": "# It is not there.\nexit 75\n",
    }.items():
        (tmp_path / "hosts" / name).mkdir(parents=True)
        (tmp_path / "hosts" / name / "test").write_text(f"#!/bin/sh\n{rest}")
    return tmp_path


def hosts_run(house: Path, *words: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name != "OLP_HOSTS"}
    command = ["sh", str(house / "scripts" / "test-hosts"), *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


def test_ci_runs_the_hosts_that_say_so_in_their_own_head(house):
    done = hosts_run(house, "--ci")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.findall(r"(?m)^(\w+): (\w+)", done.stdout) == [("editor", "held")]
    assert (house / ".hosts" / "seen").exists()


def test_without_names_all_hosts_run_and_each_verdict_is_told(house):
    done = hosts_run(house)
    assert done.returncode == 1
    verdicts = dict(re.findall(r"(?m)^(\w+): (.*), \d+ s$", done.stdout))
    assert verdicts["editor"] == "held"
    assert verdicts["broken"] == "FAILED"
    assert "could not be installed" in verdicts["absent"]


def test_a_host_that_there_is_none_of_is_refused_before_any_runs(house):
    done = hosts_run(house, "editor", "nobody")
    assert (done.returncode, done.stdout) == (2, "")
    assert "no hosts/nobody/test; there are: absent broken editor" in done.stderr


def test_ci_runs_tests_and_hosts_and_some_host_says_that_it_runs_there():
    whole = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert re.findall(r'(?m)^"\$scripts/(.*?) \|\| status=1', whole) == ['test"', 'test-hosts" --ci']
    declared = [h for h in HOSTS if any(map(IN_CI.match, head_of(ROOT / "hosts" / h / "test")))]
    assert declared


@pytest.mark.parametrize(
    ("update", "install", "says"),
    [
        (100, 100, "Debian's package index did not answer"),
        (0, 100, "apt-get install failed"),
        (0, 0, "the package was installed and has no such command"),
    ],
)
def test_a_package_that_cannot_be_had_is_told_with_its_cause(tmp_path, update, install, says):
    script = f'#!/bin/sh\n[ "$1" = update ] && exit {update}\nexit {install}\n'
    for name, text in {"apt-get": script, "id": "#!/bin/sh\necho 0\n", "sudo": "#!/bin/sh\nexit 1\n"}.items():
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    command = ["sh", str(ROOT / "scripts" / "need"), "no-such-command", "no-such-package"]
    done = subprocess.run(command, env={**os.environ, "PATH": path}, capture_output=True, text=True)
    assert done.returncode == 75
    assert f"no-such-command is missing and could not be installed: {says}" in done.stderr
