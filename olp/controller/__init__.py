"""A controller that a simulator steps: targets in, one step per interpolation cycle out; also behind a socket."""

from olp.controller.controller import DEFAULT_CYCLE, Controller
from olp.controller.step import State, Step
from olp.controller.target import Target

__all__ = ["DEFAULT_CYCLE", "Controller", "State", "Step", "Target"]
