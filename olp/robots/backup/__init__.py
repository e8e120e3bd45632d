"""Reading a Yaskawa controller's backup: tools, frames, variables, macros, parameters, system; KUKA's machine data."""

from olp.robots.backup.backup import Backup, read_backup
from olp.robots.backup.cnd_files import ToolData, UserFrame
from olp.robots.backup.parameters import BackupControlGroup, GroupParameters, ParameterLayout, SystemInfo
from olp.robots.backup.robot_file import check_import, robot_toml
from olp.robots.backup.var_dat import PositionVariable, Variables

__all__ = [
    "Backup",
    "BackupControlGroup",
    "GroupParameters",
    "ParameterLayout",
    "PositionVariable",
    "SystemInfo",
    "ToolData",
    "UserFrame",
    "Variables",
    "check_import",
    "read_backup",
    "robot_toml",
]
