"""`python -m olp.contracts NAME [PROMISE]`: what a language breaks of the contracts of its reader and its writer."""

from __future__ import annotations

import sys

from olp.contracts import vendors, writers
from olp.contracts.promises import ContractError, sentence
from olp.core.diagnostic import OlpError
from olp.languages.limits import writable
from olp.languages.vendor import find_vendor


def main(words: list[str]) -> int:
    """Prints every broken promise, or with PROMISE that one; the exit status is 1 where there is any."""
    name, only = words[0], words[1] if len(words) > 1 else ""
    try:
        vendor = find_vendor(name)
    except OlpError as unknown:
        print(unknown)
        return 2
    suites = [(vendors.check_vendor, vendors.PROMISES)]
    if name in writable():
        suites.append((writers.check_writer, writers.PROMISES))  # type: ignore[arg-type]
    asked = [check for check, promises in suites if only in ("", *(one.__name__ for one in promises))]
    if not asked:
        print(f"'{only}' is no promise of {name}; these are:")
        print(*(f"{one.__name__}: {sentence(one)}" for _, promises in suites for one in promises), sep="\n")
        return 2
    status = 0
    for check in asked:
        try:
            check(vendor, only=only)
        except ContractError as broken:
            print(broken)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) if len(sys.argv) > 1 else __doc__)
