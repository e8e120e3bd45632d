"""INFORM: the controller writes the lines; only blanks at their ends go."""

from __future__ import annotations

from olp.languages.layout import Layout


class InformLayout(Layout):
    """Indentation is the controller's: a blank and a tab per step."""


LAYOUT = InformLayout()
