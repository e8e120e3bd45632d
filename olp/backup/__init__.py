"""Reading a Yaskawa controller's backup: tools, frames, variables, macros, parameters, system; KUKA's machine data."""

from olp.backup.backup import Backup, read_backup
from olp.backup.import_check import check_import
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
    "check_import",
    "read_backup",
    "robot_toml",
]
