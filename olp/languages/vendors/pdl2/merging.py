"""What may be changed independently in a PDL2 program."""

from __future__ import annotations

import re

from olp.languages.merging import MergeRules


class Pdl2Merging(MergeRules):
    comments = ("--",)
    has_variables = ignores_case = True
    data = re.compile(r"\s*(\w+(?:\[\d+\])?)\s*:=\s*(?:POS\s*\(|\{)", re.IGNORECASE)
    loose_data = False  # an assignment runs where it stands
    scope = re.compile(r"\s*ROUTINE\s+(\w+)|\s*END\s+\w+()\s*$", re.IGNORECASE)


MERGING = Pdl2Merging()
