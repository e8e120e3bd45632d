"""A controller that a simulator steps: targets in, one step per interpolation cycle out; also behind a socket."""

from olp.servers.controller.controller import DEFAULT_CYCLE, Controller, State, Step
from olp.servers.controller.target import Target

__all__ = ["DEFAULT_CYCLE", "Controller", "State", "Step", "Target"]
