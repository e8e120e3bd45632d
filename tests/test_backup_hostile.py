"""Controller files that are huge, cut, garbled or made to hurt: findings, never an exception, never long."""

import random
from contextlib import suppress
from pathlib import Path

import pytest
from cpu_time import cpu_time_below

from olp.core.diagnostic import OlpError
from olp.robots.backup import read_backup, robot_toml
from olp.robots.backup.controller_text import MAX_BYTES, MAX_FINDINGS, MAX_ROWS

SAMPLES = Path(__file__).parent.parent / "samples" / "backup"
FILES = sorted(path for cell in ("dx200", "yrc1000") for path in (SAMPLES / cell).iterdir())


def garbled(data: bytes, chance: random.Random) -> bytes:
    """One to three mutations: a byte changed, a piece cut out, rows swapped, the end lost, rubbish put in."""
    for _ in range(chance.randint(1, 3)):
        place, kind = chance.randrange(len(data) + 1), chance.randrange(5)
        if kind == 0:
            data = data[:place] + bytes([chance.randrange(256)]) + data[place + 1 :]
        elif kind == 1:
            data = data[:place] + data[place + chance.randint(1, 40) :]
        elif kind == 2:
            rows = data.split(b"\r\n")
            first, second = chance.randrange(len(rows)), chance.randrange(len(rows))
            rows[first], rows[second] = rows[second], rows[first]
            data = b"\r\n".join(rows)
        elif kind == 3:
            data = data[:place]
        else:
            rubbish = chance.choice([b"-", b",,", b"1e999", b"9" * 400, b"/", b'"', b"nan", b"\x00", b"0x1F"])
            data = data[:place] + rubbish + data[place:]
    return data


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_no_mutation_raises_anything_but_diagnostics(path: Path, tmp_path: Path) -> None:
    chance = random.Random(f"{path.parent.name}/{path.name}")
    for other in path.parent.iterdir():
        (tmp_path / other.name).write_bytes(other.read_bytes())
    data = path.read_bytes()
    for _ in range(60):
        (tmp_path / path.name).write_bytes(garbled(data, chance))
        backup = read_backup(tmp_path)
        assert len(backup.diagnostics) <= 8 * (MAX_FINDINGS + 1)
        for group in ("R1", "S1"):
            with suppress(OlpError):
                robot_toml(backup, group)


@pytest.mark.parametrize("name", ["TOOL.CND", "UFRAME.CND", "VAR.DAT", "MACRO.DAT", "SYSTEM.SYS", "ALL.PRM"])
@pytest.mark.parametrize(
    "data",
    [
        b"\n" * (MAX_ROWS + 1),
        b"1," * (MAX_BYTES // 2 + 1),
        b"1," * (MAX_BYTES // 2 - 8),
        b"//TOOL 1\n//UFRAME 1\n//MACRO1 1\n///RC1G\n///P\nx\n" * (MAX_ROWS // 6),
        b"/" * 1_000_000,
        bytes(range(256)) * 4_000,
    ],
    ids=["rows", "bytes", "one row", "heads", "slashes", "binary"],
)
def test_hostile_files_are_answered_soon_and_briefly(name: str, data: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with cpu_time_below(4.0):
        backup = read_backup(tmp_path)
    assert backup.diagnostics
    assert len(backup.diagnostics) <= MAX_FINDINGS + 1
    assert max(len(d.source_line) for d in backup.diagnostics) <= 2_000


def test_findings_beyond_the_limit_are_counted(tmp_path: Path) -> None:
    (tmp_path / "TOOL.CND").write_text("".join(f"//TOOL x{n}\n" for n in range(MAX_FINDINGS + 23)))
    found = read_backup(tmp_path).diagnostics
    assert len(found) == MAX_FINDINGS + 1
    assert found[-1].is_error
    assert found[-1].message.startswith("24 more")
