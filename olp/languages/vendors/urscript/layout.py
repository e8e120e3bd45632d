"""URScript: everything between a head and its `end` indented."""

from __future__ import annotations

import re

from olp.languages.layout import BlockLayout


class UrscriptLayout(BlockLayout):
    opens = re.compile(r"(?:def|thread|sec|if|while)\b.*:\s*(?:#.*)?$")
    closes = re.compile(r"end\b")
    between = re.compile(r"(?:elif|else)\b")
    open_end = re.compile(r"[-+*/%=<>,(\[]\s*$")
    kept = re.compile(r"\$|\{\{|\{%")

    def bare(self, text: str) -> str:
        return text.partition("#")[0].rstrip() if '"' not in text else text


LAYOUT = UrscriptLayout()
