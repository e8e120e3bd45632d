"""What a vendor's language is to the rest of olp, and how the vendors are found."""

from __future__ import annotations

from abc import ABC, abstractmethod
from importlib import import_module
from typing import ClassVar

from olp.diagnostic import OlpError, error
from olp.program import Program
from olp.registry import file_names
from olp.source import Source


class Vendor(ABC):
    """One language. A package or module `olp.vendors.<name>` holds one instance, called `VENDOR`.

    `data_suffixes`: those of `suffixes` whose files hold data of the programs beside them and nothing that runs.
    `list_suffixes`: of files beside the programs that hold data and are known by their text alone. `folders_beside`:
    seen from a program's folder, where the files stand that the controller loads with it.
    `comment_prefix`: what opens a comment on a line of its own. `trailing_comment_prefix`: what opens one after an
    instruction, blanks included. `comment_length`: characters that the controller keeps, without the prefix.
    `shares_names`: whether a file sees the variables and routines of all others beside it. `blending`: the law in
    `olp/blending` that the maker's blends follow.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]]
    data_suffixes: ClassVar[tuple[str, ...]] = ()
    list_suffixes: ClassVar[tuple[str, ...]] = ()
    folders_beside: ClassVar[tuple[str, ...]] = ()
    comment_prefix: ClassVar[str]
    trailing_comment_prefix: ClassVar[str]
    comment_length: ClassVar[int]
    comment_suffix: ClassVar[str] = ""  # what closes a comment on a line of its own
    newline: ClassVar[str] = "\r\n"
    shares_names: ClassVar[bool] = True
    case_sensitive: ClassVar[bool] = False
    blending: ClassVar[str] = "radius"

    def comment_of(self, line: bytes) -> bytes | None:
        """What a comment on a line of its own says, without what opens and closes it; None for any other line."""
        prefix, suffix = self.comment_prefix.encode("ascii"), self.comment_suffix.encode("ascii")
        if not line.startswith(prefix):
            return None
        return line[len(prefix) :].rstrip(b" \t\r\n").removesuffix(suffix)

    @abstractmethod
    def sniff(self, source: Source) -> bool:
        """Whether the text looks like this language, whatever its file is called."""

    @abstractmethod
    def read(self, source: Source) -> Program:
        """The program. Never raises on bad text: what is wrong stands in `Program.diagnostics`."""


def vendor_names() -> tuple[str, ...]:
    """The names of all vendors, sorted."""
    return file_names(Vendor)


def vendor_suffixes() -> tuple[str, ...]:
    """The suffixes of program files of all vendors, lower case, sorted: what folders are searched for."""
    vendors = [find_vendor(name) for name in vendor_names()]
    return tuple(sorted({s for one in vendors for s in one.suffixes if s not in one.data_suffixes}))


def find_vendor(name: str) -> Vendor:
    """The vendor called `name`. Raises OlpError (P003) that lists the known ones."""
    if name not in vendor_names():
        known = ", ".join(vendor_names())
        raise OlpError(error("P003", f"unknown vendor '{name}'", help=f"known vendors: {known}"))
    vendor = import_module(f"olp.vendors.{name}").VENDOR
    assert isinstance(vendor, Vendor)
    return vendor


def recognise(source: Source) -> Vendor | None:
    """The vendor whose language `source` is: by the file's suffix, else by its text; None when no one knows it."""
    vendors = [find_vendor(name) for name in vendor_names()]
    path = source.path.lower()
    by_suffix = [vendor for vendor in vendors if path.endswith(vendor.suffixes)]
    if len(by_suffix) == 1:
        return by_suffix[0]
    return next((vendor for vendor in by_suffix or vendors if vendor.sniff(source)), None)


def language_of(vendor: str) -> str:
    """How people call a vendor's language: INFORM, TP."""
    return find_vendor(vendor).title.split()[-1]
