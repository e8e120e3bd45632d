"""How long a move takes and how fast it is when. One file per motion model; its name is the model's."""

from olp.timing.motion._durations import durations
from olp.timing.motion._profile import Moves, Problem, Profile
from olp.timing.motion.model import MotionModel, Parameter, load_model, model_names

__all__ = [
    "MotionModel",
    "Moves",
    "Parameter",
    "Problem",
    "Profile",
    "durations",
    "load_model",
    "model_names",
]
