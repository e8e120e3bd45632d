"""Acceleration laws: the acceleration that a controller really uses. One file per law; the file's name is the law's
name.
"""

from olp.timing.acceleration.law import AccelerationLaw, law_names, load_law

__all__ = ["AccelerationLaw", "law_names", "load_law"]
