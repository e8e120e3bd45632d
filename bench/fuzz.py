"""Fuzzes everything that reads: eight languages, TOML, CSV and JSON files, and the language service behind editors.

    python bench/fuzz.py                                runs the kept inputs again (tests/test_hostile.py does, too)
    python bench/fuzz.py TARGET… --minutes 30           guided by coverage; needs `pip install atheris`
    python bench/fuzz.py TARGET… --found DIR --keep     adds to the kept inputs what runs lines that none of them runs
    python bench/fuzz.py TARGET… --seconds 60           blindly changed inputs, drawn by --seed; CI draws by its commit

A target gets bytes and raises when a promise is broken: anything but OlpError, a warning of NumPy's, other bytes than
were read, more than a second of CPU time for up to 64 kB. Fuzzing goes on after a finding; each is written to DIR
once, and run again afterwards without the instruments, which make everything slower. The kept inputs are in
`fuzz_kept`, a file per target, a JSON string per line whose characters are bytes. Exit status 1 when anything is
left.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple, NoReturn

ROOT = Path(__file__).resolve().parent.parent
KEPT = Path(__file__).with_name("fuzz_kept")
SAMPLES = ROOT / "samples"
LONGEST = 65_536  # [bytes]
LIMIT = 1.0  # [s] CPU
GIVEN_UP = 20  # [s] CPU after which an input hangs
_STEPS = 1_000  # of a program that are run
_LONGEST_KEPT = 1_200  # [bytes]
_MOST_KEPT = 40  # inputs of one target


class BrokenPromiseError(AssertionError):
    """What an input must never do to olp."""


class Hang(BaseException):
    """Raised by the clock; no `except Exception` catches it."""


Target = Callable[[bytes, Path], None]


# --- Targets ---


def reader(vendor: str, suffix: str) -> Target:
    """Reads, writes back, runs and times a program."""

    def target(data: bytes, folder: Path) -> None:
        from olp.core.diagnostic import OlpError
        from olp.core.source import decode
        from olp.fluent import read_source
        from olp.timing.timing import time_plan

        with suppress(OlpError):
            program = read_source(decode(data, f"p{suffix}"), vendor=vendor)
            if program.to_bytes() != data:
                raise BrokenPromiseError("other bytes are written than were read")
            time_plan(program.plan(max_steps=_STEPS))

    return target


def file_reader(name: str, read: Callable[[Path], object], **beside: str) -> Target:
    """Reads a file called `name`; files `beside` it (their dots written as _) stand there with their texts."""

    def target(data: bytes, folder: Path) -> None:
        from olp.core.diagnostic import OlpError

        (folder / name).write_bytes(data)
        for other, text in beside.items():
            (folder / other.replace("_", ".")).write_text(text, encoding="utf-8")
        with suppress(OlpError):
            read(folder / name)

    return target


def _assumptions(path: Path) -> None:
    from olp.runtime.assumptions import load_assumptions

    load_assumptions(path)


def _budgets(path: Path) -> None:
    from olp.checks.guard import budget

    budget._read.cache_clear()
    budget.budgets_for(str(path.parent / "P.JBI"), str(path))


def _lint(path: Path) -> None:
    from olp.checks.lint.run import RuleChoice, rules_for

    rules_for(str(path.parent / "P.JBI"), RuleChoice())


def _robot(path: Path) -> None:
    from olp.robots.robot import read_robot

    read_robot(path)


def _mapping(path: Path) -> None:
    from olp.transpile.context import read_mapping

    read_mapping(path)


def _recording(path: Path) -> None:
    from olp.identification.recording import read_recording

    read_recording(path.parent)


def _log(path: Path) -> None:
    from olp.identification.recording.log_reader import read_log

    read_log(path)


def _totals(path: Path) -> None:
    from olp.identification.signature.partial_programs import read_totals

    read_totals(path)


def _signature(path: Path) -> None:
    from olp.identification.signature import read_signature

    read_signature(path)


def _baseline(path: Path) -> None:
    from olp.checks.lint.run import read_baseline

    read_baseline(path)


def _report(path: Path) -> None:
    from olp.reports.page import _earlier

    _earlier(path.read_text(encoding="utf-8", errors="replace"))


def controller(data: bytes, folder: Path) -> None:
    """A session of the stepping controller."""
    from olp.servers.controller.server import Session

    session = Session()
    for line in data.split(b"\n")[:20]:
        json.loads(session.answer(line).line)


_EDITED = (".jbi", ".src", ".mod", ".ls", ".script", ".pgx", ".pdl", ".as")
_EDIT = 6  # bytes of one edit


def editor(data: bytes, folder: Path) -> None:
    """What an editor does: opens a text, asks for everything, and types; edits stand behind two NULs."""
    from olp.servers.language.actions import actions, formatting, hints, lenses
    from olp.servers.language.document import OpenDocument, Place, TextChange
    from olp.servers.language.service import ProgramService, marks, rule_runs
    from olp.servers.language.symbols import completion, hover, names

    head, text, typed = data[:1], *(data[1:].partition(b"\0\0")[::2])
    service, path = ProgramService(), f"p{_EDITED[(head or b' ')[0] % len(_EDITED)]}"
    document = service.open(path, text.decode("utf-8", "replace"))
    edits = [typed[at : at + _EDIT] for at in range(0, min(len(typed), 4 * _EDIT), _EDIT)]
    for edit in [b"", *edits]:
        row, column, more, *put = (*edit, 0, 0, 0)
        if edit:
            start, stop = Place(row, column), Place(row + more % 4, column + more // 4)
            change = TextChange(start, stop, bytes(put[:-3]).decode("latin-1"))
            service.change(path, [change], document.version + 1)
            if document.raw != OpenDocument(path, document.text).raw:
                raise BrokenPromiseError("lines and text have come apart")
        analysis = service.current(path, whole=False)
        assert analysis is not None
        for _ in rule_runs(service):
            pass
        told = marks(service.analyses[path])
        if any(mark.code == "C016" for mark in told):
            raise BrokenPromiseError(next(mark.message for mark in told if mark.code == "C016"))
        number = min(max(row, 1), max(len(analysis.source.lines), 1))
        names(analysis), hints(analysis), lenses(analysis), formatting(analysis)
        actions(service.analyses[path], 1, 1 << 30)
        hover(service, analysis, number, column + 1)
        completion(analysis, analysis.source.line(number), number, column + 1)


_MOVES = "move,duration_s\n0,1.0\n"
TARGETS: dict[str, Target] = {
    "inform": reader("inform", ".jbi"),
    "krl": reader("krl", ".src"),
    "rapid": reader("rapid", ".mod"),
    "tp": reader("tp", ".ls"),
    "urscript": reader("urscript", ".script"),
    "pdl2": reader("pdl2", ".pdl"),
    "val3": reader("val3", ".pgx"),
    "as": reader("as", ".as"),
    "urp": reader("urscript", ".urp"),
    "assumptions": file_reader("olp.toml", _assumptions),
    "budgets": file_reader("olp.toml", _budgets),
    "lint": file_reader("olp.toml", _lint),
    "robot": file_reader("robot.toml", _robot),
    "mapping": file_reader("map.toml", _mapping),
    "settings": file_reader("recording.toml", _recording, moves_csv=_MOVES),
    "moves": file_reader("moves.csv", _recording),
    "log": file_reader("log.csv", _log),
    "totals": file_reader("totals.csv", _totals),
    "signature": file_reader("signature.json", _signature),
    "baseline": file_reader("baseline.json", _baseline),
    "report": file_reader("report.html", _report),
    "controller": controller,
    "editor": editor,
}
_SEEDS: dict[str, tuple[str, ...]] = {
    "inform": ("inform/**/*.[jJ][bB][iI]",),
    "krl": ("krl/*.src", "krl/*.dat"),
    "rapid": ("rapid/*.*",),
    "tp": ("tp/*.ls",),
    "urscript": ("urscript/*.script",),
    "pdl2": ("pdl2/*.pdl",),
    "val3": ("val3/**/*.pgx", "val3/**/*.dtx", "val3/**/*.pjx"),
    "as": ("as/*.as",),
    "assumptions": ("**/olp.toml",),
    "budgets": ("**/olp.toml",),
    "lint": ("**/olp.toml",),
    "robot": ("../olp/robots/yaskawa/*.toml",),
    "settings": ("**/recording.toml",),
    "moves": ("**/moves.csv",),
    "log": ("**/log.csv",),
}
_WRITTEN: dict[str, tuple[str, ...]] = {
    "budgets": (
        '[[budget]]\nname = "a"\nfiles = ["*.jbi"]\nlimit_s = 4.5\ntolerance_pct = 2\nwarn_pct = 9\nlevel = "warn"\n'
        'of = "motion"\n[[budget]]\nfrom = "*A"\nto = "LBL[3]"\nlimit_s = 1\non = "upper"\nsignature = "s.json"\n',
    ),
    "lint": ('[lint]\nselect = ["L101"]\nignore = ["L2"]\n[lint.limits]\nspeed_mm_s = 250\n',),
    "mapping": (
        'set_values = false\n[tools]\n"1" = "grip"\n[signals]\n"out 3" = "7"\n[routines]\nA = "b"\n',
    ),
    "log": ("t_s,q1_deg,q2_deg,q3_deg\n" + "".join(f"{n / 50},{n % 7},2.5,-{n}\n" for n in range(40)),),
    "totals": ("job,total_s\nA.JBI,12.5\nA.JBI,12.6\nB.JBI,3\n",),
    "signature": (
        '{"schema":"olp-signature","version":1,"robot":"yaskawa/up20","controller":"XRC","tool_mm_deg":null,"'
        'payload_kg":null,"recording":{"name":"samples/up20","sha256":"660a3c8337fb4777a562ea603ca1ca7d14fd22'
        '2bc06fa9420d160f77a018870f","moves":146,"time_resolution_s":0.01},"method":"factors","parameters":{"'
        'nominal":{"value":400.0,"unit":"mm/s\\u00b2","sd":null},"tables":{"value":[{"plane":"horizontal","sen'
        'se":-1,"start_mm":[1350.0,700.0,100.0],"angle_deg":[-0.0,4.4671571,8.8806567],"factor":[1.480263158,'
        '1.441846984,1.386880392]}],"unit":"mm, deg, 1","sd":null},"mass_reference":{"value":null,"unit":"kg"'
        ',"sd":null},"configuration_reference":{"value":"","unit":"","sd":null},"orientations":{"value":[[0.0'
        ',-0.0,1.0,0.0,-1.0,-0.0,1.0,0.0,-0.0]],"unit":"1","sd":null},"mass_factors":{"value":[],"unit":"leve'
        'l, 1","sd":[]},"orientation_factors":{"value":[],"unit":"level, 1","sd":[]},"configuration_factors":'
        '{"value":[],"unit":"level, 1","sd":[]}},"errors_s2_per_m":{"near":{"half":0.078,"shared":0.003,"own"'
        ':0.04,"groups":9},"far":{"half":0.299,"shared":0.093,"own":0.136,"groups":9}},"domain":{"speed_mm_s"'
        ':[300.0,300.0],"length_mm":[640.0,1064.0018797],"payload_kg":null,"near_mm":50.0,"far_mm":280.0,"mov'
        'es_mm_deg":[[1350.0,700.0,100.0,710.0,700.0,100.0,180.0,-90.0,0.0]]},"held_out_percent":{"factors":{'
        '"moves":0.260881714012,"starts":1.04441803952,"directions":4.50671984716}},"olp":"0.1.0"}',
    ),
    "baseline": ('{"version": 1, "findings": [{"fingerprint": "0123456789abcdef", "count": 2}]}',),
    "report": ('<html><script type="application/json" id="summary">{"A.JBI": 12.5}</script></html>',),
    "controller": (
        '{"do": "hello"}\n{"do": "robot", "name": "yaskawa/gp25", "cycle_s": 0.01, "accel_mm_s2": 900}\n'
        '{"do": "tool", "pose_mm_deg": [0, 0, 90, 0, 0, 0]}\n{"do": "position", "joints_deg": [0, 1, 2, 3, 4, 5]}\n'
        '{"do": "target", "path": "joint", "joints_deg": [9, 1, 2, 3, 4, 5], "speed_pct": 50, "zone_mm": 4}\n'
        '{"do": "wait", "seconds": 0.1}\n{"do": "step", "count": 50}\n{"do": "end"}\n{"do": "step"}\n{"do": "bye"}\n',
    ),
}


def seeds(name: str) -> list[bytes]:
    """What a target starts from: the kept inputs, the project's samples, and a few texts."""
    found = [*kept(name), *(text.encode() for text in _WRITTEN.get(name, ()))]
    for pattern in _SEEDS.get(name, ()):
        paths = sorted(SAMPLES.glob(pattern)) if not pattern.startswith("..") else _robots()
        found += [path.read_bytes() for path in paths if path.is_file() and path.stat().st_size <= LONGEST]
    if name == "editor":
        texts = [seeds(language)[-1] for language in list(TARGETS)[:8]]
        found += [bytes([n]) + text + b"\0\0\x05\x04\x01 A\n" for n, text in enumerate(texts)]
    if name == "urp":
        found += _urp()
    return found or [b""]


def _robots() -> list[Path]:
    return sorted((ROOT / "olp" / "robots").glob("*/*.toml"))[::20]


def _urp() -> list[bytes]:
    import gzip

    move = '<Move motionType="MoveJ"><children><Waypoint type="Fixed"/></children></Move>'
    row = f"<MainProgram><children>{move}</children>"
    text = f'<?xml version="1.0"?><URProgram name="p"><children>{row}</MainProgram></children></URProgram>'
    return [gzip.compress(text.encode(), mtime=0), text.encode()]


def kept(name: str) -> list[bytes]:
    """The inputs of a target that earlier runs have left."""
    path = KEPT / f"{name}.jsonl"
    if not path.is_file():
        return []
    return [json.loads(row).encode("latin-1") for row in path.read_text(encoding="ascii").splitlines()]


# --- One input ---


class Fault(NamedTuple):
    """`what`: the promise; `where`: the exception and the innermost line of olp, the same for the same cause."""

    what: str
    where: str


@contextmanager
def clock() -> Iterator[None]:
    """Raises Hang in what takes too long, by CPU time."""

    def ring(number: int, frame: FrameType | None) -> NoReturn:
        raise Hang

    before = signal.signal(signal.SIGVTALRM, ring)
    signal.setitimer(signal.ITIMER_VIRTUAL, GIVEN_UP)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def fault(name: str, data: bytes, folder: Path, limit: float = LIMIT) -> Fault | None:
    """What is wrong with olp, given these bytes."""
    began = time.process_time()
    try:
        with clock(), warnings.catch_warnings():
            warnings.simplefilter(
                "error"
            )  # NumPy's, of numbers that it cannot hold: they would reach the user
            TARGETS[name](data, folder)
    except Hang as problem:
        return Fault("hang", _where(problem))
    except Exception as problem:
        return Fault("promise" if isinstance(problem, BrokenPromiseError) else "exception", _where(problem))
    seconds = time.process_time() - began
    return Fault("slow", f"{seconds:.1f} s") if seconds > limit else None


def _where(problem: BaseException) -> str:
    frames = traceback.extract_tb(problem.__traceback__)
    inner = next((f for f in reversed(frames) if "/olp/" in f.filename), frames[-1])
    says = re.sub(r"\d+|'[^']*'|\"[^\"]*\"", "_", str(problem))[:80]
    return f"{type(problem).__name__} at {inner.filename.rpartition('/olp/')[2]}:{inner.lineno} {says}"


def warm(name: str, folder: Path) -> None:
    """Imports and compiles what the target needs, so that no input is blamed for it."""
    for data in seeds(name)[-2:]:
        fault(name, data, folder)


# --- Blind changes ---

_EXTREMES = (
    b"1e308",
    b"-1e-308",
    b"9e99",  # the most that readers take
    b"-1e-99",
    b"9" * 99 + b".9",  # where no exponents are read
    b"0." + b"0" * 90 + b"1",
    b"9" * 40,
    b"0",
    b"-1",
    b"nan",
    b"1e999",
    b"\0",
    b"\xff\xfe",
    b"\x83\x5c",
    b"(" * 300,
)
_NUMBER = re.compile(rb"\d+(\.\d+)?([eE][-+]?\d+)?")


def changed(name: str, seconds: float, seed: int) -> Run:
    """Kept inputs and samples with one to four random changes each, for so many seconds of CPU."""
    drawn, began, count = random.Random(f"{name} {seed}"), time.process_time(), 0
    inputs = [*kept(name), *(data[:LONGEST] for data in seeds(name))]
    faults: dict[str, tuple[Path | None, Fault]] = {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        warm(name, folder)
        while not count or time.process_time() - began < seconds:
            data = drawn.choice(inputs)
            for _ in range(drawn.randint(1, 4)):
                data = _change(data, drawn.choice(inputs), drawn)
            count += 1
            problem = fault(name, data, folder)
            if problem is not None and problem.what == "slow":
                problem = fault(name, data, folder)  # it is not blamed for what it is the first to need
            if problem is not None and problem.where not in faults:
                save(Path("fuzz-found"), name, data)
                faults[problem.where] = (Path("fuzz-found"), problem)
    return Run(name, count, (time.process_time() - began) / 60, "-", tuple(faults.values()))


def _change(data: bytes, other: bytes, drawn: random.Random) -> bytes:
    """A part left out, doubled, taken from another input, or made another byte, word or number."""
    if drawn.random() < 0.3 and (numbers := [found.span() for found in _NUMBER.finditer(data)]):
        return _with_absurd_numbers(data, numbers, drawn)
    low, high = sorted(drawn.choices(range(len(data) + 1), k=2))
    high = min(high, low + drawn.choice((1, 8, 200, LONGEST)))
    begin = drawn.randrange(len(other) + 1)
    part = drawn.choice(
        (
            b"",
            2 * data[low:high],
            other[begin : begin + high - low],
            drawn.choice(_EXTREMES),
            bytes([drawn.randrange(256)]),
        )
    )
    return (data[:low] + part + data[high:])[:LONGEST]


def _with_absurd_numbers(data: bytes, numbers: list[tuple[int, int]], drawn: random.Random) -> bytes:
    """One to four of the numbers, or a quarter of all, made ones that no arm, clock or variable has."""
    count = drawn.choice((1, 1, 2, 4, len(numbers) // 4 + 1))
    for low, high in sorted(drawn.sample(numbers, min(len(numbers), count)), reverse=True):
        data = data[:low] + drawn.choice(_EXTREMES) + data[high:]
    return data[:LONGEST]


# --- Guided by coverage ---


def drive(name: str, corpus: Path, found: Path, seconds: int) -> None:
    """Runs libFuzzer in this process, which ends with it."""
    import atheris  # type: ignore[import-not-found, unused-ignore]

    with atheris.instrument_imports(include=["olp"]):
        import olp.__main__
        import olp.fluent  # noqa: F401

        folder = Path(tempfile.mkdtemp(prefix="olp-fuzz-"))
        warm(name, folder)  # what is imported where it is used is instrumented, too
    seen: Counter[str] = Counter()

    def once(data: bytes) -> None:
        problem = fault(name, data, folder, 3 * LIMIT)
        if problem is None:
            return
        seen[problem.what if problem.what == "slow" else problem.where] += 1
        if seen[problem.what if problem.what == "slow" else problem.where] <= 3:
            save(found, name, data)

    words = {word for data in seeds(name)[:40] for word in re.findall(rb"[A-Za-z_$#&]{2,24}", data)}
    dictionary = corpus.parent / f"{name}.dict"
    listed = sorted(words)[:600] or [b"null"]  # libFuzzer takes no dictionary without a word
    dictionary.write_text("".join(f'"{word.decode()}"\n' for word in listed), encoding="ascii")
    arguments = [
        f"-max_len={LONGEST}",
        f"-max_total_time={seconds}",
        "-rss_limit_mb=6000",  # half an hour of inputs: the instruments keep some 15 kB of each
        f"-timeout={10 * GIVEN_UP}",
        f"-dict={dictionary}",
        f"-artifact_prefix={found}/{name}-died-",
        "-print_final_stats=1",
        "-verbosity=1",
        str(corpus),
    ]
    atheris.Setup([sys.argv[0], *arguments], once)
    atheris.Fuzz()


def save(folder: Path, name: str, data: bytes) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}-{sha256(data).hexdigest()[:12]}").write_bytes(data)


class Run(NamedTuple):
    """One target: how many inputs, in how many minutes of CPU, and the inputs at fault after all."""

    name: str
    inputs: int
    minutes: float
    covered: str
    faults: tuple[tuple[Path | None, Fault], ...]


def fuzz(name: str, minutes: float, found: Path) -> Run:
    """Fuzzes a target in a process of its own, then runs what it found again without instruments."""
    corpus = found / "corpora" / name
    corpus.mkdir(parents=True, exist_ok=True)
    for data in seeds(name):
        save(corpus, "seed", data)
    words = ["--drive", name, "--found", str(found), "--minutes", str(minutes)]
    before = _cpu_s()
    ran = subprocess.run(
        [sys.executable, __file__, *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    (found / f"{name}.log").write_text(ran.stdout + ran.stderr, encoding="utf-8")
    inputs = re.search(r"stat::number_of_executed_units:\s*(\d+)", ran.stderr)
    covered = re.findall(r"cov: (\d+)", ran.stderr)
    if inputs is None:
        print(ran.stderr[-2_000:], file=sys.stderr)
    spent = (_cpu_s() - before) / 60
    faults = again(name, sorted(found.glob(f"{name}-*")))
    return Run(name, int(inputs[1]) if inputs else 0, spent, covered[-1] if covered else "?", faults)


def _cpu_s() -> float:
    """Of the processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def again(name: str, paths: list[Path]) -> tuple[tuple[Path | None, Fault], ...]:
    """Those of the inputs that are at fault without instruments, one for each cause."""
    faults: dict[str, tuple[Path | None, Fault]] = {}
    with tempfile.TemporaryDirectory() as temporary:
        warm(name, Path(temporary))
        for path in paths:
            data = path.read_bytes()
            problem = fault(name, data, Path(temporary))
            if problem is not None:
                faults.setdefault(problem.where, (path, problem))
    return tuple(faults.values())


# --- What is kept ---


def keep(name: str, found: Path) -> tuple[int, int]:
    """Keeps inputs that run the most lines that none before runs, and those of faults: (before, after)."""
    faults = [path.read_bytes() for path in sorted(found.glob(f"{name}-*"))]
    before = list(dict.fromkeys([*kept(name), *(data for data in faults if len(data) <= _LONGEST_KEPT)]))
    corpus = found / "corpora" / name
    grown = {path.read_bytes() for path in corpus.iterdir() if path.stat().st_size <= _LONGEST_KEPT}
    with tempfile.TemporaryDirectory() as temporary:
        warm(name, Path(temporary))
        rest = {data: lines_of(name, data, Path(temporary)) for data in sorted(grown - set(before))}
        lines = {line for data in before for line in lines_of(name, data, Path(temporary))}
    chosen = [*before]
    while rest and len(chosen) < _MOST_KEPT:
        best = max(rest, key=lambda data: (len(rest[data] - lines), -len(data), data))
        new = rest.pop(best)
        if new <= lines:
            break
        chosen.append(best)
        lines |= new
    write_kept(name, chosen)
    return len(before), len(chosen)


def write_kept(name: str, inputs: list[bytes]) -> None:
    KEPT.mkdir(exist_ok=True)
    rows = "".join(f"{json.dumps(data.decode('latin-1'))}\n" for data in inputs)
    (KEPT / f"{name}.jsonl").write_text(rows, encoding="ascii")


def lines_of(name: str, data: bytes, folder: Path) -> set[tuple[str, int]]:
    """The lines of olp that an input runs."""
    found: set[tuple[str, int]] = set()
    home = str(ROOT / "olp")

    def trace(frame: FrameType, event: str, argument: Any) -> Any:
        if not frame.f_code.co_filename.startswith(home):
            return None
        if event == "line":
            found.add((frame.f_code.co_filename, frame.f_lineno))
        return trace

    sys.settrace(trace)
    try:
        fault(name, data, folder)
    finally:
        sys.settrace(None)
    return found


# --- Command line ---


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(TARGETS)} (all)")
    parser.add_argument(
        "--minutes", type=float, default=0.0, help="of fuzzing per target (0: the kept inputs)"
    )
    parser.add_argument("--seconds", type=float, default=0.0, help="of blind changes per target")
    parser.add_argument("--seed", type=int, default=0, help="of the blind changes")
    parser.add_argument("--found", type=Path, default=Path("fuzz-found"), metavar="DIR")
    parser.add_argument("--keep", action="store_true", help="add to the kept inputs from DIR/corpora")
    parser.add_argument("--drive", help=argparse.SUPPRESS)
    args = parser.parse_args(arguments)
    if args.drive:
        drive(args.drive, args.found / "corpora" / args.drive, args.found, max(1, round(60 * args.minutes)))
        return 0
    names = args.targets or list(TARGETS)
    if unknown := [name for name in names if name not in TARGETS]:
        parser.error(f"no such target: {unknown[0]}")
    if args.keep:
        for name in names:
            if (args.found / "corpora" / name).is_dir():
                print(f"{name}: kept {' -> '.join(map(str, keep(name, args.found)))}")
        return 0
    if args.seconds:
        return print_runs([changed(name, args.seconds, args.seed) for name in names])
    runs = [fuzz(name, args.minutes, args.found) if args.minutes else replay(name) for name in names]
    return print_runs(runs)


def replay(name: str) -> Run:
    """The kept inputs of a target."""
    began, faults = time.process_time(), []
    inputs = kept(name)
    with tempfile.TemporaryDirectory() as temporary:
        warm(name, Path(temporary))
        for data in inputs:
            problem = fault(name, data, Path(temporary))
            if problem is not None:
                faults.append((None, problem))
    return Run(name, len(inputs), (time.process_time() - began) / 60, "-", tuple(faults))


def print_runs(runs: list[Run]) -> int:
    print(f"{'target':12} {'inputs':>9} {'CPU min':>8} {'covered':>8} {'faults':>7}")
    for run in runs:
        print(f"{run.name:12} {run.inputs:9,} {run.minutes:8.2f} {run.covered:>8} {len(run.faults):7}")
        for path, problem in run.faults:
            print(f"    {problem.what}: {problem.where} {path or ''}")
    return int(any(run.faults for run in runs))


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main(sys.argv[1:]))
