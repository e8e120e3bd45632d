"""Makes the repository's own virtual environment hold what is asked for, once per pyproject.toml.

`environment.py run` installs olp with the light extras; `dev` adds the tools and oracles of the tests.
Prints the path of the environment's Python. Standard library only: it runs before anything is installed.
"""

import hashlib
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
WINDOWS = sys.platform == "win32"
PYTHON = VENV / ("Scripts/python.exe" if WINDOWS else "bin/python")
PROJECT = ROOT / "pyproject.toml"
PAGES = "completion,excel,plot,ros,serve,watch"  # extras of `scripts/olp`: what its pages show runs


def stamp() -> str:
    """What an environment was made for: this folder (a moved one points elsewhere) and these requirements."""
    return f"{ROOT}\n{hashlib.sha256(PROJECT.read_bytes()).hexdigest()}\n"


def is_ready(kind: str) -> bool:
    """Whether the environment holds `kind`; a developer's environment also runs olp."""
    markers = (VENV / f"olp-{name}.stamp" for name in {kind, "dev"})
    return PYTHON.exists() and any(marker.exists() and marker.read_text() == stamp() for marker in markers)


@contextmanager
def only_one() -> Generator[None]:
    """Two first runs at once: the second waits for the first."""
    VENV.mkdir(exist_ok=True)
    with (VENV / "olp.lock").open("w") as lock:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(lock.fileno(), msvcrt.LK_LOCK, 1)
        else:
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def requirements(kind: str) -> list[str]:
    """What pip or uv is asked to install."""
    if kind == "run":
        return ["--editable", f"{ROOT}[{PAGES}]"]
    import tomllib

    # pip knows dependency groups only since 25.1.
    group: list[str] = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["dependency-groups"]["dev"]
    return ["--editable", str(ROOT), *group]


def call(*command: str) -> None:
    """Runs a command in silence; if it fails, shows all it said and ends with status 2."""
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    if done.returncode:
        print(done.stdout, f"olp: could not set up {VENV}: {' '.join(command)}", sep="\n", file=sys.stderr)
        sys.exit(2)


def install(kind: str) -> None:
    """Creates the environment where there is none (or half a one) and installs `kind`."""
    print(f"olp: setting up {VENV} (once)", file=sys.stderr)
    pip = (str(PYTHON), "-m", "pip", "--disable-pip-version-check", "--no-input")
    if not PYTHON.exists() or subprocess.run((*pip, "--version"), capture_output=True).returncode:
        call(str(getattr(sys, "_base_executable", sys.executable)), "-m", "venv", str(VENV))
    if kind != "dev" or not installed_by_uv(pip):
        call(*pip, "install", "--quiet", *requirements(kind))
    (VENV / f"olp-{kind}.stamp").write_text(stamp())


def installed_by_uv(pip: tuple[str, ...]) -> bool:
    """Whether uv could install what developers need: an eighth of pip's time, but it reads no pip.conf."""
    if subprocess.run((*pip, "install", "--quiet", "uv"), capture_output=True).returncode:
        return False
    uv = (str(PYTHON), "-m", "uv", "pip", "install", "--quiet", "--compile-bytecode", "--python", str(PYTHON))
    return not subprocess.run((*uv, *requirements("dev")), capture_output=True).returncode


def main(kind: str) -> None:
    try:
        if not is_ready(kind):
            with only_one():
                if not is_ready(kind):
                    install(kind)
    except OSError as problem:
        sys.exit(f"olp: could not set up {VENV}: {problem}")
    except KeyboardInterrupt:
        sys.exit(f"olp: {VENV} is not finished; the next run goes on")
    print(PYTHON)


if __name__ == "__main__":
    main(sys.argv[1])
