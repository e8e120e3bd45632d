"""Runners of GitHub and GitLab as small as they can be: a workflow or pipeline is done step by step, as it is written.

What the network would bring is beside: olp as its owner would publish it, and an environment in which pip finds what
olp needs. No container is started; each run has a folder, a Python and a home of its own.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sysconfig
import venv
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parent.parent
_PUBLISHED = ("olp", "grammars", "templates", "hosts", "pyproject.toml", "README.md", "LICENSE", "action.yml")
_WORD = re.compile(r"'(?:[^']|'')*'|&&|\|\||[!=]=|[!()]|[\w.-]+(?:\(\))?")
_OPERATORS = {"&&": "and", "||": "or", "!": "not", "==": "==", "!=": "!=", "(": "(", ")": ")"}
_COMMAND = re.compile(r"^::(error|warning|notice) (.*?)::(.*)$", re.M)


def quiet_environment() -> dict[str, str]:
    """This one without what a forge or a user has set, so that git answers as on a fresh machine."""
    foreign = ("GITHUB_", "GIT_", "OLP_", "CI_", "PIP_", "PRE_COMMIT")
    return {
        **{k: v for k, v in os.environ.items() if not k.startswith(foreign)},
        "GIT_CONFIG_GLOBAL": os.devnull,
        "GIT_CONFIG_NOSYSTEM": "1",
        **{
            f"GIT_{who}_{what}": "a@b.example"
            for who in ("AUTHOR", "COMMITTER")
            for what in ("NAME", "EMAIL")
        },
    }


def run(command: list[str], folder: Path, environment: dict[str, str], status: int = 0) -> str:
    """What a command says on both streams; it must end with `status`."""
    done = subprocess.run(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert done.returncode == status, done.stdout
    return done.stdout


def publish(home: Path, environment: dict[str, str]) -> Path:
    """A repository of olp as it is here, with a branch `main` and the release that the pages name."""
    home.mkdir()
    for name in (*_PUBLISHED, ".pre-commit-hooks.yaml"):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, home / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(ROOT / name, home / name)
    for words in ("init -q -b main", "add -A", "commit -q -m olp", "tag v0.1.0"):
        run(["git", *words.split()], home, environment)
    (home.parent / f"{home.name}.git").symlink_to(home)  # forges give it under either name
    return home


def at_home(environment: dict[str, str], published: Path) -> dict[str, str]:
    """`environment` of a machine that has only git and a shell; the addresses of the pages lead to `published`."""
    kept = {k: v for k, v in environment.items() if k != "PYTHONPATH"}
    addresses = ("https://HOST/olp", "https://github.com/OWNER/olp")
    for n, address in enumerate(addresses):
        kept[f"GIT_CONFIG_KEY_{n}"] = f"url.{published.as_uri()}.insteadOf"
        kept[f"GIT_CONFIG_VALUE_{n}"] = address
    return kept | {
        "GIT_CONFIG_COUNT": str(len(addresses)),
        "PATH": "/usr/local/bin:/usr/bin:/bin",
        # What olp needs, and what builds it, is here already: see `python_at`.
        "PIP_NO_INDEX": "1",
        "PIP_NO_DEPS": "1",
        "PIP_NO_BUILD_ISOLATION": "0",
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "PIP_COMPILE": "0",  # what runs is compiled when it runs: a part of it
    }


def python_at(folder: Path) -> Path:
    """A Python of its own that has all packages of this one but olp; its folder of programs."""
    venv.create(folder, symlinks=True, with_pip=False)
    own = sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)})
    (Path(own) / "packages.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin"


@dataclass
class Result:
    """What is seen of a run. `annotations`: (level, {file, line, …}, text)."""

    log: str = ""
    success: bool = True
    summary: str = ""
    said: list[str] = field(default_factory=list)  # what `gh` was called with

    @property
    def annotations(self) -> list[tuple[str, dict[str, str], str]]:
        return [
            (level, dict(pair.split("=", 1) for pair in places.split(",")), text)
            for level, places, text in _COMMAND.findall(self.log)
        ]


class Github:
    """One job on a runner of its own. `event`: push or pull_request; of the latter `base` is where it goes to."""

    def __init__(self, home: Path, environment: dict[str, str], published: Path, event: str, base: str = ""):
        self.home, self.published = home, published
        self.work, self.tools = home / "work", home / "tools"
        for folder in (self.work, self.tools):
            folder.mkdir(parents=True)
        self.result = Result()
        number = "7" if event == "pull_request" else ""
        self.ref = f"refs/pull/{number}/merge" if number else "refs/heads/main"
        self.github = {
            "event_name": event, "base_ref": base, "event.number": number, "token": "t", "sha": "s",
        }  # fmt: skip
        self.environment = at_home(environment, published) | {
            "GITHUB_ACTIONS": "true",
            "GITHUB_EVENT_NAME": event,
            "GITHUB_BASE_REF": base,
            "GITHUB_WORKSPACE": str(self.work),
            "GITHUB_STEP_SUMMARY": str(home / "summary.md"),
            "RUNNER_TEMP": str(home),
        }
        (self.tools / "gh").write_text(f'#!/bin/sh\necho "$@" >>"{home}/gh"\n')
        (self.tools / "gh").chmod(0o755)
        self._on_path(self.tools)

    def run(self, workflow: dict[str, Any], origin: Path) -> Result:
        self.origin = origin
        (job,) = workflow["jobs"].values()
        assert job["runs-on"].startswith("ubuntu")
        for step in job["steps"]:
            self._step(step, {"github": self.github}, self.work)
        summary, said = self.home / "summary.md", self.home / "gh"
        self.result.summary = summary.read_text(encoding="utf-8") if summary.exists() else ""
        self.result.said = said.read_text().splitlines() if said.exists() else []
        return self.result

    def _step(self, step: dict[str, Any], contexts: dict[str, dict[str, str]], action: Path) -> None:
        condition = str(step.get("if", "success()"))
        if "()" not in condition:
            condition = f"success() && ({condition})"
        if not self._value(condition, contexts):
            return
        given = {key: self._filled(value, contexts) for key, value in step.get("with", {}).items()}
        if "uses" in step:
            self._use(step["uses"], given)
            return
        own = {key: self._filled(value, contexts) for key, value in step.get("env", {}).items()}
        script = self.home / "step.sh"
        script.write_text(self._filled(step["run"], contexts))
        shell = ["bash", "--noprofile", "--norc", "-eo", "pipefail"] if "shell" in step else ["bash", "-e"]
        self._done([*shell, str(script)], self.environment | own)

    def _use(self, name: str, given: dict[str, str]) -> None:
        match name:
            case "actions/checkout@v4":
                self._check_out(given)
            case "actions/setup-python@v5":
                assert re.fullmatch(r"3\.\d+", given["python-version"])
                self._on_path(python_at(self.home / "python"))
            case "actions/cache@v4":
                assert {"path", "key"} <= set(given)  # the first run of a repository finds nothing
            case "OWNER/olp@main":
                self._composite(given)
            case _:
                raise AssertionError(f"nobody knows the action {name}")

    def _composite(self, given: dict[str, str]) -> None:
        action = self.home / "olp"
        self._done(["git", "clone", "-q", "-b", "main", "https://github.com/OWNER/olp", str(action)])
        told = yaml.safe_load((action / "action.yml").read_text(encoding="utf-8"))
        assert set(given) <= set(told["inputs"])
        inputs = {name: given.get(name, about["default"]) for name, about in told["inputs"].items()}
        contexts = {"inputs": inputs, "github": self.github | {"action_path": str(action)}}
        for step in told["runs"]["steps"]:
            assert "uses" in step or step["shell"]  # GitHub asks for it in composite actions
            self._step(step, contexts, action)

    def _check_out(self, given: dict[str, str]) -> None:
        whole = given.get("fetch-depth") == "0"
        wanted = [f"+{self.ref}:refs/remotes/checkout"]
        wanted += ["+refs/heads/*:refs/remotes/origin/*"] if whole else []
        self._done(["git", "init", "-q"])
        self._done(["git", "remote", "add", "origin", self.origin.as_uri()])
        self._done(["git", "fetch", "-q", *([] if whole else ["--depth=1"]), "origin", *wanted])
        self._done(["git", "checkout", "-q", "--detach", "refs/remotes/checkout"])

    def _done(self, command: list[str], environment: dict[str, str] | None = None) -> None:
        done = subprocess.run(
            command,
            cwd=self.work,
            env=environment or self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.result.log += done.stdout
        self.result.success = self.result.success and done.returncode == 0

    def _on_path(self, folder: Path) -> None:
        self.environment["PATH"] = f"{folder}{os.pathsep}{self.environment['PATH']}"

    def _filled(self, text: object, contexts: dict[str, dict[str, str]]) -> str:
        return re.sub(r"\$\{\{(.*?)\}\}", lambda found: str(self._value(found[1], contexts)), str(text))

    def _value(self, expression: str, contexts: dict[str, dict[str, str]]) -> object:
        """An expression of workflows. Raises KeyError for what it names and nobody knows."""
        functions = {"always()": True, "success()": self.result.success, "failure()": not self.result.success}
        words = []
        for word in _WORD.findall(expression):
            if word in _OPERATORS:
                words.append(_OPERATORS[word])
            elif word.startswith("'"):
                words.append(repr(word[1:-1].replace("''", "'")))
            else:
                context, _, key = word.partition(".")
                words.append(repr(functions[word] if word.endswith("()") else contexts[context][key]))
        return eval(" ".join(words), {"__builtins__": {}})  # nothing but literals and operators


class Gitlab:
    """Jobs of a pipeline, one after the other in one checkout."""

    def __init__(self, home: Path, environment: dict[str, str], published: Path, settings: dict[str, Any]):
        self.environment = at_home(environment, published)
        self.environment["PATH"] = f"{python_at(home)}{os.pathsep}{self.environment['PATH']}"
        include = settings["include"]
        (address,) = [include] if isinstance(include, str) else [one["remote"] for one in include]
        template = published / address.removeprefix("https://HOST/olp/")
        self.whole = yaml.safe_load(template.read_text(encoding="utf-8"))
        self.variables = self.whole["variables"] | settings.get("variables", {})
        self.prepared = False

    def run(self, name: str, checkout: Path, **given: str) -> tuple[int, str]:
        """Exit status and log of a job; every report that it names is there afterwards."""
        job = self.whole[name]
        job = self.whole[job["extends"]] | job
        # Every job begins with the same preparation: it is done once here.
        script = [] if self.prepared else job["before_script"]
        self.prepared = True
        variables = {k: str(v) for k, v in (self.variables | job.get("variables", {})).items()}
        done = subprocess.run(
            ["bash", "-eo", "pipefail", "-c", "\n".join([*script, *job["script"]])],
            cwd=checkout,
            env=self.environment | variables | given,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        artifacts = job["artifacts"]
        for file in (*artifacts.get("reports", {}).values(), *artifacts.get("paths", ())):
            assert (checkout / file).stat().st_size, f"{file} is missing\n{done.stdout}"
        return done.returncode, done.stdout
