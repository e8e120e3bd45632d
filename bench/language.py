"""How fast the language server answers: `python bench/language.py [--keys N] [--only LANGUAGE]`.

A client types at random places of generated programs, over standard input and output, as an editor does: after every
keystroke it asks for the hints of the lines that are seen, and the clock runs until these and the findings have come.
Then the same for the hints of the whole text. Prints asked and measured; exit status 1 when a figure is missed. The
processor time that the server took says how much of it was waiting for a busy machine.
"""

from __future__ import annotations

import argparse
import json
import os
import queue
import random
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple

from language_programs import PROGRAMS

ROOT = Path(__file__).resolve().parent.parent
ROBOT = "yaskawa/ma2010"
SEEN = 50  # lines of a window
LETTERS = "0123456789 .\n"
# Lines, language -> median and worst [ms] that were asked.
RUNS = [(2000, "inform"), (2000, "krl"), (2000, "rapid"), (2000, "tp"), (2000, "urscript"), (20000, "inform")]
ASKED = {2000: (50.0, 120.0), 20000: (300.0, 300.0)}
ASKED_START = 1.5  # [s]


class Key(NamedTuple):
    """One keystroke [ms]: by the clock, and the processor time that the server took (nan where no kernel says so)."""

    clock: float
    server: float


class Times(NamedTuple):
    seen: list[Key]
    whole: list[Key]


class Client:
    """Speaks with one server; messages come with the time of their arrival."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "olp", "lsp"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        self.inbox: queue.Queue[tuple[float, bytes]] = queue.Queue()
        self.number = 0
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        while header := self.process.stdout.readline():
            length = int(header.split(b":")[1])
            while self.process.stdout.readline().strip():
                pass
            body = self.process.stdout.read(length)
            self.inbox.put((time.perf_counter(), body))

    def send(self, **message: Any) -> None:
        assert self.process.stdin is not None
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        self.process.stdin.flush()

    def ask(self, method: str, params: Any) -> int:
        self.number += 1
        self.send(id=self.number, method=method, params=params)
        return self.number

    def wait(self, number: int, version: int = 0) -> float:
        """When the answer, and the findings of that version, had both come."""
        answered, told = False, not version
        while not (answered and told):
            when, body = self.inbox.get(timeout=120)
            message = json.loads(body)
            answered |= message.get("id") == number and "method" not in message
            params = message.get("params") or {}
            told |= (
                message.get("method") == "textDocument/publishDiagnostics"
                and params.get("version", 0) >= version
            )
        return when

    def worked(self) -> float:
        """[ms] of processor time that the server has taken so far."""
        try:
            tasks = Path(f"/proc/{self.process.pid}/task").iterdir()
            return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks) / 1e6
        except OSError:
            return float("nan")

    def close(self) -> None:
        self.wait(self.ask("shutdown", None))
        self.send(method="exit")
        self.process.wait(20)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keys", type=int, default=200, help="keystrokes per program (default: 200)")
    parser.add_argument("--only", choices=list(PROGRAMS), help="one language")
    chosen = parser.parse_args()
    missed = False
    print(
        "| program | median | worst | asked | server alone | worst | whole text | worst | start to first hints |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for lines, language in RUNS:
        if chosen.only in (None, language):
            missed |= not report(lines, language, chosen.keys)
    print(
        f"\n{sys.version.split()[0]}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} while measuring"
    )
    return 1 if missed else 0


def report(lines: int, language: str, keys: int) -> bool:
    """One row of the table; False where a figure is missed."""
    name, make = PROGRAMS[language]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        text = make(lines)
        path.write_bytes(text.encode())
        (Path(folder) / "olp.toml").write_text(f'robot = "{ROBOT}"\n')
        start, times = measure(path, text, keys)
    clock, server = [key.clock for key in times.seen], [key.server for key in times.seen]
    whole = [key.clock for key in times.whole]
    median, worst = statistics.median(clock), max(clock)
    most, least = ASKED[lines]
    held = median <= most and worst <= least and (lines > 2000 or start <= ASKED_START)
    asked = f"{most:g}, {least:g} ms" if most != least else f"{most:g} ms"
    print(
        f"| {lines:,} lines of {language} | {median:.0f} ms | {worst:.0f} ms | {asked} "
        f"| {statistics.median(server):.0f} ms | {max(server):.0f} ms "
        f"| {statistics.median(whole):.0f} ms | {max(whole):.0f} ms | {start:.2f} s "
        f"|{'' if held else ' **missed**'}",
        flush=True,
    )
    return held


def measure(path: Path, text: str, keys: int) -> tuple[float, Times]:
    """Seconds from the start of the process to its first hints, and the times of `keys` keystrokes."""
    begin = time.perf_counter()
    client = Client()
    client.wait(client.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {}}))
    client.send(method="initialized", params={})
    uri = path.as_uri()
    opened = {"uri": uri, "languageId": "", "version": 1, "text": text}
    client.send(method="textDocument/didOpen", params={"textDocument": opened})
    lines = text.split("\n")
    start = (
        client.wait(client.ask("textDocument/inlayHint", hints(uri, len(lines) - SEEN, len(lines)))) - begin
    )
    typist = Typist(client, uri, [line.rstrip("\r") for line in lines])
    # What is imported at the first mistake, and the first pause, belong to no keystroke.
    for _ in range(10):
        typist.key(SEEN)
    times = Times([typist.key(SEEN) for _ in range(keys)], [typist.key(len(lines)) for _ in range(keys // 4)])
    client.close()
    return start, times


class Typist:
    """Types letters at random places and takes most of them back; keeps the text as the server has it."""

    def __init__(self, client: Client, uri: str, lines: list[str]) -> None:
        self.client, self.uri, self.lines = client, uri, lines
        self.version = 1
        self.chance = random.Random(3)
        self.undo: tuple[dict[str, Any], str] | None = None

    def key(self, seen: int) -> Key:
        """From one keystroke to hints and findings; `seen`: lines in the window."""
        # Now and then somebody thinks, and the rules begin to run.
        time.sleep(0.6 if self.chance.random() < 0.05 else self.chance.uniform(0.02, 0.12))
        line, edit = self._edit()
        first = max(0, line - seen // 2)
        self.version += 1
        known = {"uri": self.uri, "version": self.version}
        before, begin = self.client.worked(), time.perf_counter()
        self.client.send(
            method="textDocument/didChange", params={"textDocument": known, "contentChanges": [edit]}
        )
        asked = self.client.ask("textDocument/inlayHint", hints(self.uri, first, first + seen))
        clock = 1e3 * (self.client.wait(asked, self.version) - begin)
        return Key(clock, self.client.worked() - before)

    def _edit(self) -> tuple[int, dict[str, Any]]:
        if self.undo is not None:
            edit, _ = self.undo
            self.undo = None
            return edit["range"]["start"]["line"], edit
        line = self.chance.randrange(len(self.lines) - 1)
        column = self.chance.randrange(len(self.lines[line]) + 1)
        letter = self.chance.choice(LETTERS)
        place = {"line": line, "character": column}
        after = (
            {"line": line + 1, "character": 0} if letter == "\n" else {"line": line, "character": column + 1}
        )
        self.undo = ({"range": {"start": place, "end": after}, "text": ""}, letter)
        return line, {"range": {"start": place, "end": place}, "text": letter}


def hints(uri: str, first: int, last: int) -> dict[str, Any]:
    """The parameters of a question for the hints of some lines."""
    ends = {"start": {"line": max(first, 0), "character": 0}, "end": {"line": last, "character": 0}}
    return {"textDocument": {"uri": uri}, "range": ends}


if __name__ == "__main__":
    sys.exit(main())
