"""The lines of /MN as instructions: numbers and semicolons taken off, continued lines joined, P-SPS blocks told."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

NUMBERED: Final = re.compile(r"\s*(\d*)\s*:(?!:)")
_BLOCK_END = re.compile(r"\s*-{3,}\s*;?\s*")
_MOST_JOINED = 60  # lines of one instruction


class TpLine(NamedTuple):
    """One instruction. `closed`: it ended with a semicolon. `lines`: source lines that it takes."""

    number: int  # of its first source line
    text: str
    closed: bool = True
    lines: int = 1
    block_end: bool = False  # the ------ that ends a P-SPS block


def instructions(lines: tuple[str, ...], first: int, stop: int) -> Iterator[TpLine]:
    """The instructions in source lines `first` .. `stop` - 1 (from 1), blank lines left out."""
    number = first
    while number < stop:
        text = lines[number - 1]
        if not text.strip():
            number += 1
            continue
        if _BLOCK_END.fullmatch(text):
            yield TpLine(number, "", block_end=True)
            number += 1
            continue
        body = _body(text)
        if body.endswith(";"):
            yield TpLine(number, body[:-1].rstrip())
            number += 1
            continue
        line = _joined(lines, number, stop, body)
        yield line
        number += line.lines


def _body(text: str) -> str:
    """The text behind the line's number, without the blanks around it."""
    match = NUMBERED.match(text)
    return (text[match.end() :] if match else text).strip(" \t\x1a\x00")


def _joined(lines: tuple[str, ...], number: int, stop: int, body: str) -> TpLine:
    """An instruction that its first line does not close: what follows belongs to it, up to a semicolon."""
    parts, count = [body], 1
    while number + count < stop and count < _MOST_JOINED:
        text = lines[number + count - 1]
        match = NUMBERED.match(text)
        if not text.strip() or _BLOCK_END.fullmatch(text) or (match is not None and match[1]):
            break
        parts.append(_body(text))
        count += 1
        if parts[-1].endswith(";"):
            parts[-1] = parts[-1][:-1].rstrip()
            return TpLine(number, " ".join(parts).strip(), lines=count)
    if count == 1 or not body.startswith(("C ", "L ", "J ", "A ", "S ")):
        return TpLine(number, body, closed=False)
    return TpLine(number, " ".join(parts).strip(), closed=False, lines=count)


# --- German keywords ---
# Controllers set to German write German keywords: they are turned into the English ones, outside names and comments.
#
# Read from published listings of German controllers: other languages are not documented, and stay as they are.

# /ATTR: German -> English.
ATTRIBUTES: Final = {
    "EIGN.": "OWNER",
    "KOMMENTAR": "COMMENT",
    "ERSTELL": "CREATE",
    "DATEI_NAME": "FILE_NAME",
    "ZEILEN": "LINE_COUNT",
    "SPEICHERGR.": "MEMORY_SIZE",
    "SCHUTZ": "PROTECT",
    "DEFAULT_GRUP": "DEFAULT_GROUP",
    "KONTROLLCODE": "CONTROL_CODE",
}
# The umlauts of these came through many code pages.
_ATTRIBUTE_FORMS: Final = (
    (re.compile(r"PROG_GR.{1,4}E"), "PROG_SIZE"),
    (re.compile(r"GE.{1,2}NDERT"), "MODIFIED"),
)
_VALUES: Final = {"LESEN_SCHREIB": "READ_WRITE", "LESEN": "READ"}

_WORDS: Final = {
    "WENN": "IF",
    "DANN": "THEN",
    "SONST": "ELSE",
    "AUFRUF": "CALL",
    "SPRUNG": "JMP",
    "WARTE": "WAIT",
    "LABEL": "LBL",
    "AN": "ON",
    "AUS": "OFF",
    "ENDE": "END",
    "FEIN": "FINE",
    "BENUTZER_NUM": "UFRAME_NUM",
    "WKZ_NUM": "UTOOL_NUM",
    "TRAGLST": "PAYLOAD",
    "FB-PSPS": "TC_ONLINE",
    "ZEIT VOR": "TB",
    "ZEIT NACH": "TA",
    "WEG VOR": "DB",
    "Sek": "sec",
    "sek": "sec",
    "[&]": "AND",
    "[+]": "OR",
    "gA[": "GO[",
    "gE[": "GI[",
    "A[": "DO[",
    "E[": "DI[",
    "i[": "R[",
}
_GERMAN_HEAD: Final = re.compile(
    r"^(?:EIGN\.|KOMMENTAR|ERSTELL|SCHUTZ|ZEILEN|KONTROLLCODE)\s*=", re.MULTILINE
)
_PLAIN = "|".join(re.escape(word) for word in sorted(_WORDS, key=len, reverse=True) if word[-1].isalnum())
# Either something to leave alone (texts, comments in brackets, names of programs) or a word to replace.
_TOKENS: Final = re.compile(
    r"(\"[^\"]*\"|'[^']*'|:[^\]\[;]*\]|(?<=AUFRUF )\s*\w+|MESSAGE\[.*)"
    rf"|(\[&\]|\[\+\]|(?<![A-Za-z0-9_$.])g?[AEi]\[|(?<![A-Za-z_$])(?:{_PLAIN})(?![A-Za-z0-9_]))"
)


def is_german(text: str) -> bool:
    """Whether the header of a listing is in German."""
    return _GERMAN_HEAD.search(text) is not None


def in_english(text: str) -> str:
    """One instruction with its German keywords replaced."""
    return _TOKENS.sub(lambda match: match[1] or _WORDS[match[2]], text)


def attribute(word: str) -> str:
    """The English name of an attribute of the header."""
    for form, name in _ATTRIBUTE_FORMS:
        if form.fullmatch(word):
            return name
    return ATTRIBUTES.get(word, word)


def attribute_value(text: str) -> str:
    """The value of an attribute: dates and protection in English."""
    text = _VALUES.get(text.strip(), text)
    return re.sub(r"\bTAG (\d\d-\d\d-\d\d)(\s+)ZEIT ", r"DATE \1\2TIME ", text)
