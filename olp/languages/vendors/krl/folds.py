"""What KUKA's editor writes into comments: folds, and the captions and parameters of its inline forms.

The name of a fold that a person made is a comment like any other, and so is what stands behind its end and is more than
that name. What only the editor reads is left out: the ends of folds, folds that it hides, the parameters of forms, the
captions of forms (the statements within say the same), and the folds that every program begins with.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from olp.ir.program import Comment, Statement

_FOLD: Final = re.compile(r"FOLD\b\s*(?P<name>.*?)\s*(?:;?\s*(?P<marks>%\{.*))?", re.IGNORECASE)
_END: Final = re.compile(r"ENDFOLD(?![^\W_])\s*(?P<text>.*)", re.IGNORECASE)
_BEGINNING: Final = re.compile(
    r"(?:(?:USER |\w+TECH )?INI|(?:USER |EXTERNAL )?DECL(?:ARATIONS?)?)", re.IGNORECASE
)
_HIDDEN: Final = re.compile(r"%\{h", re.IGNORECASE)
_FORM: Final = re.compile(r"%M\w|%V\w|%C\w")  # the technology package whose form it is
_PARAMETERS: Final = re.compile(r"Params\s+Ilf\w+\s*=", re.IGNORECASE)
_PLACEHOLDER: Final = "make your modifications here"


def without_folds(body: Iterable[Statement]) -> list[Statement]:
    """The statements with the comments that say something to a person."""
    rows: list[Statement] = []
    caption: Comment | None = None  # of the fold that the row before opened
    open_: list[str] = []  # the names of folds that are not closed
    for s in body:
        if not isinstance(s, Comment):
            rows.append(s)
            caption = None
            continue
        text = s.text.strip()
        fold, end = _FOLD.fullmatch(text), _END.fullmatch(text)
        if fold:
            open_.append(fold["name"])
        elif end and _says_more(end["text"], open_.pop() if open_ else ""):
            rows.append(replace(s, text=end["text"]))
        if caption is not None and (_PARAMETERS.match(text) or (fold and _is_hidden(fold))):
            rows.remove(caption)
            caption = None
        if fold and not _is_hidden(fold) and _is_told(fold):
            caption = replace(s, text=fold["name"])
            rows.append(caption)
        elif not fold and not _is_noise(text):
            rows.append(s)
            caption = None
    return rows


def _is_hidden(fold: re.Match[str]) -> bool:
    return _HIDDEN.match(fold["marks"] or "") is not None


def _is_told(fold: re.Match[str]) -> bool:
    """Whether the fold's name is neither a form's caption nor that of what every program begins with."""
    return (
        bool(fold["name"])
        and not _FORM.search(fold["marks"] or "")
        and not _BEGINNING.fullmatch(fold["name"])
    )


def _says_more(text: str, name: str) -> bool:
    """Whether what stands behind the end of a fold is more than its name again, with the brackets of KUKA's own."""
    said = text.strip("() \t").casefold()
    return said not in name.casefold() and not _BEGINNING.fullmatch(said)


def _is_noise(text: str) -> bool:
    return (
        _END.fullmatch(text) is not None
        or _PARAMETERS.match(text) is not None
        or text.casefold() == _PLACEHOLDER
    )
