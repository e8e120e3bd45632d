"""What may be changed independently in a URScript program."""

from __future__ import annotations

import re

from olp.languages.merging import MergeRules


class UrScriptMerging(MergeRules):
    comments = ("#",)
    data = re.compile(r"\s*(?:global\s+|local\s+)?(\w+)\s*=\s*p?\[")
    loose_data = False  # an assignment runs where it stands
    scope = re.compile(r"\s*(?:def|thread|sec)\s+(\w+)\s*\(")


MERGING = UrScriptMerging()
