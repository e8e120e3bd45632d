"""Controllers set to German write German keywords: they are turned into the English ones, outside names and comments.

Read from published listings of German controllers: other languages are not documented, and stay as they are.
"""

from __future__ import annotations

import re
from typing import Final

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
