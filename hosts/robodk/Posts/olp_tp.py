"""Post-processor of RoboDK: FANUC TP, written and timed by olp."""

from olp_robodk.post import Post


class RobotPost(Post):
    VENDOR = "tp"
    PROG_EXT = "ls"
    ROBOT = ""  # a name of `olp robots`, or a robot file; empty: by RoboDK's name of the robot
    AXIS_SPEED_DEG_S = (
        0.0  # rated speed of the axes of a robot that olp does not know; joint speeds are shares of it
    )
    SIGNATURE = ""  # the robot's timing signature, made by `olp calibrate`; empty: none
