"""A robot's timing signature: learnt from recorded moves, kept in a readable file, used for every later prediction.

After N. Apostolovic, "An innovative method for improvement of robotic simulation cycle time accuracy", Memorial
University of Newfoundland, chapters 5 and 6 (method `factors`), and beyond it. docs/signature.md describes it.
"""

from olp.identification.signature.document import Signature
from olp.identification.signature.estimator import estimator_names
from olp.identification.signature.file import read_signature, write_signature
from olp.identification.signature.learn import calibrate
from olp.identification.signature.moveset import MoveSet, moves_of_recording
from olp.identification.signature.predict import Prediction, predict

__all__ = [
    "MoveSet",
    "Prediction",
    "Signature",
    "calibrate",
    "estimator_names",
    "moves_of_recording",
    "predict",
    "read_signature",
    "write_signature",
]
