"""What a RAPID controller brings with it and olp does not model: a call of it is passed over as what it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from olp.languages.vendors.rapid.standard_names import FUNCTIONS, INSTRUCTIONS

KNOWN_ROUTINES: Final[Mapping[str, str]] = {
    **dict.fromkeys(INSTRUCTIONS, "an instruction of RAPID"),
    **dict.fromkeys(FUNCTIONS, "a function of RAPID"),
}
