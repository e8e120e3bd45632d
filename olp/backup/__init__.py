"""Reading a Yaskawa controller's backup: tools, frames, variables, macros, parameters, system."""

from olp.backup.backup import Backup, read_backup
from olp.backup.macro_dat import read_macro_dat
from olp.backup.parameters import GroupParameters, Layout
from olp.backup.robot_file import robot_toml
from olp.backup.system_sys import ControlGroup, SystemInfo
from olp.backup.tool_cnd import ToolData
from olp.backup.uframe_cnd import UserFrame
from olp.backup.var_dat import PositionVariable, Variables

__all__ = [
    "Backup",
    "ControlGroup",
    "GroupParameters",
    "Layout",
    "PositionVariable",
    "SystemInfo",
    "ToolData",
    "UserFrame",
    "Variables",
    "read_backup",
    "read_macro_dat",
    "robot_toml",
]
