"""KRL: blocks indented, the body of a routine not, as the controller's editor does."""

from __future__ import annotations

import re

from olp.languages.layout import BlockLayout


class KrlLayout(BlockLayout):
    opens = re.compile(
        r"(?:IF\b.*\bTHEN\b|FOR\b|WHILE\b|LOOP\b|REPEAT\b|SWITCH\b|SPLINE\b|PTP_SPLINE\b)", re.IGNORECASE
    )
    closes = re.compile(r"(?:ENDIF|ENDFOR|ENDWHILE|ENDLOOP|UNTIL|ENDSWITCH|ENDSPLINE)\b", re.IGNORECASE)
    between = re.compile(r"(?:ELSE|CASE|DEFAULT)\b", re.IGNORECASE)
    kept = re.compile(r"[&;]")  # records, comments and folds, which the controller's forms look for
    free_outside = True


LAYOUT = KrlLayout()
