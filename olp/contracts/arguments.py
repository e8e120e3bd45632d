"""What `check_command` gives to arguments, by what a command line calls them: a program for JOB, a robot for R.

A new command is held without being named here: its parser says what it takes. Arguments of one name that want
different files are told apart by their destination (`args.signature` is a signature, whatever FILE says).
"""

from __future__ import annotations

from argparse import Action
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from olp.languages.vendor import vendor_names
from olp.robots import RECORDED_ROBOT

SAMPLES: Final = Path(__file__).resolve().parents[2] / "samples"  # of a checkout
ROBOT: Final = RECORDED_ROBOT
_MOVES: Final = 8  # of the recording: enough for every command, and quick


class Given(NamedTuple):
    """Words for one argument. `good`: the first that works is taken. `bad`: each has to be refused."""

    good: tuple[str, ...]
    bad: tuple[str, ...] = ()


_GONE: Final = ("gone/nowhere.xyz",)
_JOBS: Final = Given(("cell", "cell/LOOP.JBI"), _GONE)
_JOB: Final = Given(("cell/LOOP.JBI", "cell/SECOND.JBI", "log/dx200.jbi"), _GONE)
_OLD: Final = Given(("cell/LOOP.JBI",), _GONE)
_NEW: Final = Given(("office/LOOP.JBI", "robot/LOOP.JBI"), _GONE)
_SIGNATURE: Final = Given(("one.signature.json", "other.signature.json"), (*_GONE, "olp.toml"))
_TEXT: Final = Given(("Höhe",))
_MADE: Final = Given(("made.txt", "made.csv", "made.svg", "made.toml", "made", "-"))
_TABLE: Final[Mapping[str, Given]] = {
    # by destination and by what it is called
    "old OLD": _OLD,
    "new NEW": _NEW,
    "files FILE": Given(("trace",), _GONE),
    # by destination
    "signature OUT": _MADE,
    "signature": _SIGNATURE,
    "assumptions": Given(("other.toml",), _GONE),
    "budgets": Given(("other.toml",), _GONE),
    "map": Given(("other.toml",), _GONE),
    "scheduler": Given((), ("nowhere",)),
    "routine": Given((), ("no-such-routine",)),
    "template": Given(("note.j2",), _GONE),
    "baseline": Given(("known.json",), _GONE),
    "store": Given(("olp.db",)),
    "method": Given(("constant", "factors"), ("no-such-method",)),
    "model": Given(("linear",), ("no-such-model",)),
    "accel_law": Given(("time_constant", "by_pose", "torque"), ("no-such-law",)),
    # by what it is called
    "A": Given(("777", "77"), ("-1", "much")),
    "PCT": Given(("50",), ("-5", "half")),
    "E": Given(("cp1252", "utf-8"), ("no-such-encoding",)),
    "F": Given(("json", "csv", "markdown"), ("no-such-format",)),
    "F=FILE": Given(("json=made.json",), ("json", "no-such-format=made.json")),
    "N": Given(("2", "1", "40"), ("-1", "many")),
    "S": Given(("99", "0.05"), ("-1", "soon")),
    "V": Given(("123", "300"), ("fast",)),
    "MM": Given(("2",), ("-1", "wide")),
    "R": Given((ROBOT, "yaskawa/ma2010"), ("nobody/no-such-robot",)),
    "ROBOT": Given((ROBOT, "yaskawa/ma2010"), ("nobody/no-such-robot",)),
    "JOB": _JOBS,
    "PATH": _JOBS,
    "job JOB": _JOB,
    "BASE": _OLD,
    "OURS": _NEW,
    "THEIRS": Given(("robot/LOOP.JBI",), _GONE),
    "OLD.json": _SIGNATURE,
    "NEW.json": Given(tuple(reversed(_SIGNATURE.good)), _SIGNATURE.bad),
    "RECORDING": Given(("recording",), _GONE),
    "FOLDER": Given(("office",), _GONE),
    "BACKUP": Given(("backup",), _GONE),
    "LOG": Given(("log/log.csv",), _GONE),
    "TOTALS.csv": Given(("totals.csv",), (*_GONE, "other.toml")),
    "VENDOR": Given(vendor_names(), ("no-such-language",)),
    "WHAT=N": Given(("position=900",), ("position", "taste=3", "position=far")),
    "LINE": Given(("19",), ("99999", "where")),
    "LINES": Given(("20", "19-22"), ("where",)),
    "GROUPS": Given(("20,21",), ("where",)),
    "CODES": Given(("W",), ("no-such-code",)),
    "C": Given(("krc4-8.5",), ("no-such-controller",)),
    "NAME=COLUMN": Given(("t_ms=Time",), ("Time",)),
    "A,B,…": Given(("a,b",)),
    "GROUP": Given(("R1",), ("R9",)),
    "MAKER/MODEL": Given(("nobody/x1",), ("///",)),
    "X0,X1,Y0,Y1,Z0,Z1": Given(("710,1350,0,700,100,740",), ("710,1350", "where")),
    "RX,RY,RZ": Given(("180,-90,0", "170,-80,5"), ("180", "where")),
    "X,Y,Z,RX,RY,RZ": Given(("0,0,50,0,0,0",), ("0,0", "where")),
    "TEXT": _TEXT,
    "T": _TEXT,
    "DIR": Given(("made",)),
    "OUT": _MADE,
    "FILE": _MADE,
    "FILE.json": Given(("made.json",)),
    "OUT.csv": Given(("made.csv",)),
}


def given(action: Action) -> Given | None:
    """What an argument may be given; None where its name says nothing of it."""
    if action.choices:
        return Given(tuple(map(str, action.choices)), ("no-such-choice",))
    if action.nargs == 0:
        return Given(("",))
    called = str(action.metavar)
    return next(
        (_TABLE[key] for key in (f"{action.dest} {called}", action.dest, called) if key in _TABLE), None
    )


# --- the files that the words name ------------------------------------------------------------------------------------

_LOOP: Final = ("NOP\n", "NOP\n*TOP\n'H\xf6he \xfcber Null\n")
_AGAIN: Final = ("\nEND\n", "\nJUMP *TOP\nEND\n")
_LATER: Final = ("JUMP", "MOVL C00001 V=300.0\nJUMP")
_REPOSITORY: Final = {
    ".git/HEAD": b"ref: refs/heads/main\n",
    ".git/config": b"[core]\n\trepositoryformatversion = 0\n",
    ".git/objects/info/none": b"",
    ".git/refs/heads/none": b"",
}


@lru_cache(maxsize=1)
def files() -> Mapping[str, bytes]:
    """Everything that the words name but what is learnt from it, by its path."""
    before, after = (
        next(SAMPLES.glob(f"*/touch-up/{when}/*.JBI")).read_text("utf-8").replace("\r\n", "\n")
        for when in ("before", "after")
    )
    settings = f'robot = "{ROBOT}"\n{{}}\n[[budget]]\nname = "cell"\nfiles = "*"\nlimit_s = {{}}\n'
    made = {
        "cell/LOOP.JBI": _text(before, _LOOP, _AGAIN),
        "cell/SECOND.JBI": _text(after, ("//NAME TOUCH-UP", "//NAME SECOND"), ("NOP\n", "NOP\n'\xfc\n")),
        "office/LOOP.JBI": _text(before, _LOOP, _AGAIN, _LATER),
        "robot/LOOP.JBI": _text(after, _LOOP, _AGAIN),
        "olp.toml": settings.format("", 2.0).encode(),
        "other.toml": settings.format("[motion]\naccel_mm_s2 = 333", 99.0).encode(),
        "note.j2": b"' {{ 'note' }}",
    }
    for folder, source in (("recording", "up20"), ("backup", "backup/dx200"), ("trace", "recordings/trace")):
        made |= {f"{folder}/{path.name}": path.read_bytes() for path in (SAMPLES / source).glob("*.*")}
    rows = made["recording/moves.csv"].splitlines(keepends=True)
    made["recording/moves.csv"] = b"".join([rows[0], *rows[1 :: len(rows) // _MOVES]])
    names = [name for name in made if name.startswith("recording/") and name.endswith(".JBI")]
    totals = [f"{name},{50 + 3 * k}\n".encode() for k, name in enumerate(sorted(names))]
    made["totals.csv"] = b"job,total_s\n" + b"".join(totals)
    log = SAMPLES / "recordings" / "dx200" / "log.csv"
    made["log/log.csv"] = log.read_bytes()
    made["log/dx200.jbi"] = next(SAMPLES.glob("*/generations/dx200.jbi")).read_bytes()
    return made | _REPOSITORY


def _text(text: str, *changes: tuple[str, str]) -> bytes:
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text.replace("\n", "\r\n").encode("cp1252")
