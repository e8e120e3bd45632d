"""The entry point for all languages: what can be read, and what is refused, with one exception only."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from inform_jobs import job

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read, read_source
from olp.languages.vendor import Vendor, find_vendor, recognise, vendor_names, vendor_suffixes

TEXT = "\r\n".join(job(["'Ölstand", "TIMER T=0.35"])) + "\r\n"


def refusal(action: object, *arguments: object, **options: object) -> list[str]:
    assert callable(action)
    with pytest.raises(OlpError) as raised:
        action(*arguments, **options)
    return [d.render() for d in raised.value.diagnostics]


def test_a_job_is_recognised_by_its_suffix_whatever_its_case(tmp_path: Path) -> None:
    for name in ("a.jbi", "B.JBI", "c.Jbi"):
        (tmp_path / name).write_bytes(TEXT.encode("cp1252"))
        program = read(tmp_path / name)
        assert program.vendor == "inform"
        assert program.path == str(tmp_path / name)
        assert program.to_bytes() == TEXT.encode("cp1252")


def test_a_job_with_another_suffix_is_recognised_by_its_text(tmp_path: Path) -> None:
    (tmp_path / "job.txt").write_bytes(TEXT.encode())
    assert read(tmp_path / "job.txt").vendor == "inform"


def test_text_of_no_language_is_refused_with_the_languages_that_are_known(tmp_path: Path) -> None:
    (tmp_path / "poem.txt").write_text("Shall I compare thee\n")
    (text,) = refusal(read, tmp_path / "poem.txt")
    vendors = map(find_vendor, vendor_names())
    known = ", ".join(f"{vendor.title} ({' '.join(vendor.suffixes)})" for vendor in vendors)
    assert text == (
        f"error[P002]: this is not a robot program that olp knows\n  --> {tmp_path / 'poem.txt'}\n"
        f"help: olp reads {known}"
    )


def test_a_language_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.jbi").write_bytes(TEXT.encode())
    (text,) = refusal(read, tmp_path / "a.jbi", vendor="klingon")
    assert text == f"error[P003]: unknown vendor 'klingon'\nhelp: known vendors: {', '.join(vendor_names())}"


def test_a_file_that_is_not_there_is_refused_with_its_path(tmp_path: Path) -> None:
    (text,) = refusal(read, tmp_path / "no.jbi")
    assert text == (
        f"error[P004]: cannot read the file: No such file or directory\n  --> {tmp_path / 'no.jbi'}\n"
        "help: check the path"
    )
    (text,) = refusal(read, tmp_path)
    assert text.startswith("error[P004]: cannot read the file: this is not a plain file")


def test_an_encoding_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.jbi").write_bytes(TEXT.encode())
    (text,) = refusal(read, tmp_path / "a.jbi", encoding="klingon")
    assert text.startswith("error[P005]: unknown encoding 'klingon'")


def test_an_encoding_that_is_given_is_not_guessed(tmp_path: Path) -> None:
    (tmp_path / "a.jbi").write_bytes(TEXT.encode("cp1252"))
    program = read(tmp_path / "a.jbi", encoding="cp437")
    assert program.source.encoding == "cp437"
    assert program.to_bytes() == TEXT.encode("cp1252")


def test_mistakes_in_the_text_do_not_raise() -> None:
    program = read_source(decode(b"/JOB\r\n//NAME A\r\n", "a.jbi"))
    assert {d.code for d in program.diagnostics} == {"P007"}
    assert {d.file for d in program.diagnostics} == {"a.jbi"}


def test_every_vendor_says_what_the_base_class_asks_for() -> None:
    for name in vendor_names():
        vendor = find_vendor(name)
        assert isinstance(vendor, Vendor)
        assert vendor.name == name
        assert vendor.title
        assert all(suffix.startswith(".") and suffix == suffix.lower() for suffix in vendor.suffixes)
        assert set(vendor.suffixes) - set(vendor.data_suffixes) <= set(vendor_suffixes())
        assert set(vendor.data_suffixes) <= set(vendor.suffixes)
        assert not set(vendor.data_suffixes) & set(vendor_suffixes())
        assert vendor.comment_prefix
        assert vendor.comment_length > 0


def test_no_vendor_claims_an_empty_text() -> None:
    assert recognise(decode(b"", "nothing")) is None


def test_the_garbage_collector_is_left_as_it_was() -> None:
    source = decode(TEXT.encode(), "a.jbi")
    for enable in (gc.enable, gc.disable):
        enable()
        state = gc.isenabled()
        read_source(source)
        assert gc.isenabled() == state
    gc.enable()
