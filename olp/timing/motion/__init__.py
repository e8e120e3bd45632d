"""Motion models: duration of a move and its speed over time. One file per model; the file's name is the model's
name.
"""

from olp.timing.motion._durations import durations
from olp.timing.motion._profile import Problem, Profile, RequestedMoves
from olp.timing.motion.model import ModelParameter, MotionModel, load_model, model_names

__all__ = [
    "ModelParameter",
    "MotionModel",
    "Problem",
    "Profile",
    "RequestedMoves",
    "durations",
    "load_model",
    "model_names",
]

# What these were called in earlier versions.
Parameter = ModelParameter
Moves = RequestedMoves
