"""A file of another kind is called what it is."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import olp

LOG = "".join(f"2024-01-05 10:00:{n:02} INFO step {n}\n" for n in range(9)).encode()
SUFFIXES = (".mod", ".src", ".ls", ".jbi", ".script")
KINDS = {
    "PNG": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(64),
    "PDF": b"%PDF-1.4\n1 0 obj\n",
    "ZIP": b"PK\x03\x04" + bytes(40),
    "web page": b"<html><body>MODULE</body></html>",
    "a log": LOG,
    "JSON": b'{"robot": "gp25", "steps": [1, 2]}',
    "encrypted": random.Random(4711).randbytes(3000),
}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("kind", KINDS)
def test_a_file_of_another_kind_is_called_what_it_is(tmp_path: Path, kind: str, suffix: str) -> None:
    path = tmp_path / f"program{suffix}"
    path.write_bytes(KINDS[kind])
    with pytest.raises(olp.OlpError) as refused:
        olp.read(path)
    (found,) = refused.value.diagnostics
    assert found.code == "P044"
    assert kind in found.message
    assert "text" in found.help


def test_every_sample_is_a_program() -> None:
    samples = Path(__file__).parent.parent / "samples"
    programs = [p for p in samples.rglob("*") if p.suffix.lower() in SUFFIXES and "broken" not in p.parts]
    assert programs
    for path in programs:
        olp.read(path)
