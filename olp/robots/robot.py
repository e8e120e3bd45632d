"""Everything about robots that other modules need: the types, the library of robot files, and the reader."""

from olp.robots.library import candidates_for_pulses, load_robot, robot_names
from olp.robots.model import Axis, Body, Drive, Dynamics, Geometry, Joint, Links, PulseFit, Robot
from olp.robots.reader import read_robot

__all__ = [
    "Axis",
    "Body",
    "Drive",
    "Dynamics",
    "Geometry",
    "Joint",
    "Links",
    "PulseFit",
    "Robot",
    "candidates_for_pulses",
    "load_robot",
    "read_robot",
    "robot_names",
]
