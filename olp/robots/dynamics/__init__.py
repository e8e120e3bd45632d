"""Rigid-body dynamics of a robot: torques of motions, and motions that the torques allow."""

from olp.robots.dynamics.limits import (
    AccelerationInterval,
    MoveAcceleration,
    PathTorque,
    acceleration_interval,
    move_acceleration,
    path_acceleration,
    path_torque,
)
from olp.robots.dynamics.torques import (
    STANDARD_GRAVITY,
    DynamicModel,
    Mounting,
    bias_forces,
    dynamic_model,
    gravity_of,
    gravity_torques,
    inertia_forces,
    inverse_dynamics,
    mass_matrix,
    payload_of,
)
from olp.robots.model import Body

__all__ = [
    "STANDARD_GRAVITY",
    "AccelerationInterval",
    "Body",
    "DynamicModel",
    "Mounting",
    "MoveAcceleration",
    "PathTorque",
    "acceleration_interval",
    "bias_forces",
    "dynamic_model",
    "gravity_of",
    "gravity_torques",
    "inertia_forces",
    "inverse_dynamics",
    "mass_matrix",
    "move_acceleration",
    "path_acceleration",
    "path_torque",
    "payload_of",
]

# What these were called in earlier versions.
Model = DynamicModel
