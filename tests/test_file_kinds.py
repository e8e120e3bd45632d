"""A file of another kind is called what it is."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import olp
from olp.__main__ import main

LOG = "".join(f"2024-01-05 10:00:{n:02} INFO step {n}\n" for n in range(9)).encode()
SUFFIXES = (".mod", ".src", ".ls", ".jbi", ".script")
KINDS = {
    "PNG": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(64),
    "PDF": b"%PDF-1.4\n1 0 obj\n",
    "ZIP": b"PK\x03\x04" + bytes(40),
    "GZIP": b"\x1f\x8b\x08\0" + bytes(40),
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
    assert ("unpack it, and give the folder" if kind.endswith("ZIP") else "text") in found.help


def test_every_sample_is_a_program() -> None:
    samples = Path(__file__).parent.parent / "samples"
    programs = [p for p in samples.rglob("*") if p.suffix.lower() in SUFFIXES and "broken" not in p.parts]
    assert programs
    for path in programs:
        olp.read(path)


def test_a_file_where_a_translation_needs_a_folder_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    samples = Path(__file__).parent.parent / "samples"
    taken = tmp_path / "Übersetzung 1"
    taken.write_text("mine")
    wanted = ["convert", str(samples / "krl" / "handling.src"), "--to", "rapid", "--robot", "kuka/kr16-2"]
    assert main([*wanted, "-o", str(taken)]) == 2
    assert "a file is where a folder has to be: name another folder" in capsys.readouterr().err
    assert taken.read_text() == "mine"
