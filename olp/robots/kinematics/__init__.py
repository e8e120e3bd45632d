"""Forward and inverse kinematics: joints to flange poses and back, for whole paths at once.

Poses are those of the flange in the robot base frame: origin at the height of axes S and L, the floor height
(`Geometry.base_height`) not added. `with_tool` and `without_tool` convert to the tool centre point and back.
"""

from olp.robots.kinematics.configuration import (
    Clearance,
    Singularity,
    clearance,
    configuration_of,
    forward,
    jacobian,
    joint_speeds,
    joints_to_pulses,
    pulses_to_joints,
    singularities,
    with_tool,
    within_limits,
    without_tool,
)
from olp.robots.kinematics.inverse import branches, inverse, nearest
from olp.robots.kinematics.tracking import track, track_branches, track_paths

__all__ = [
    "Clearance",
    "Singularity",
    "branches",
    "clearance",
    "configuration_of",
    "forward",
    "inverse",
    "jacobian",
    "joint_speeds",
    "joints_to_pulses",
    "nearest",
    "pulses_to_joints",
    "singularities",
    "track",
    "track_branches",
    "track_paths",
    "with_tool",
    "within_limits",
    "without_tool",
]
