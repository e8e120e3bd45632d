"""The acceleration a controller really uses. One file per law; its name is the law's."""

from olp.timing.acceleration.law import AccelerationLaw, law_names, load_law

__all__ = ["AccelerationLaw", "law_names", "load_law"]
