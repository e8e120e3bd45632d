"""How two moves join where the program does not stop: the time that the corner saves, its speed, and its distance
from the corner point.

One file per controller family; its name is the law's.
"""

from olp.timing.blending.law import BlendingLaw, Corners, Passage, law_names, load_law

__all__ = ["BlendingLaw", "Corners", "Passage", "law_names", "load_law"]
