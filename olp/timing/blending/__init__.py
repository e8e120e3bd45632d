"""How two moves join where the program does not stop: what the corner saves, how fast and how near it is
passed.

One file per controller family; its name is the law's.
"""

from olp.timing.blending.law import BlendingLaw, Corners, Passage, law_names, load_law

__all__ = ["BlendingLaw", "Corners", "Passage", "law_names", "load_law"]
