"""RAPID: modules, routines and blocks indented."""

from __future__ import annotations

import re

from olp.languages.layout import BlockLayout

_CODE = re.compile(r'(?:[^!"]|"(?:[^"]|"")*"?)*')


class RapidLayout(BlockLayout):
    opens = re.compile(
        r"(?:MODULE\b|(?:LOCAL\s+)?(?:PROC|FUNC|TRAP|RECORD)\b|IF\b.*\bTHEN\s*(?:!.*)?$|FOR\b|WHILE\b|TEST\b)",
        re.IGNORECASE,
    )
    closes = re.compile(r"END(?:MODULE|PROC|FUNC|TRAP|RECORD|IF|FOR|WHILE|TEST)\b", re.IGNORECASE)
    between = re.compile(r"(?:ELSEIF|ELSE|CASE|DEFAULT|ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
    # An instruction without its semicolon goes on, unless the line is the head or the end of a block.
    open_end = re.compile(
        r"^(?!(?:MODULE|(?:LOCAL\s+)?(?:PROC|FUNC|TRAP|RECORD)|END\w+|ELSE|ERROR|UNDO|BACKWARD)\b)"
        r"(?!.*(?:;|:|\b(?:THEN|DO|FROM|TEST.*))\s*$).*\S\s*$",
        re.IGNORECASE,
    )
    kept = re.compile(r"%%%|VERSION:|LANGUAGE:")

    def bare(self, text: str) -> str:
        match = _CODE.match(text)
        return match[0].rstrip() if match else text


LAYOUT = RapidLayout()
