"""Routines that KUKA's controllers and options bring with them, which stand in no archive of programs.

Names as they stand in the inline forms and templates that KUKA's own software writes into programs ("Operating and
Programming Instructions for System Integrators", KSS 8; ArcTech, GripperTech, SpotTech, conveyor options).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_GRIPPER: Final = "a gripper's routine of KUKA.GripperTech"
_SPOT: Final = "a spot welding routine of KUKA.SpotTech"
_ARC: Final = "an arc welding routine of KUKA.ArcTech"
_EXTERNAL: Final = "KUKA's routine for automatic external"
_SYSTEM: Final = "a routine of KUKA's controller"

_CONTROLLER: Final = """
    bas delmens ir_stopm set_cd_params use_cm_pro_values masref_main self_test msgnotify msgquit msgdialog
    set_krlmsg set_krldlg clear_krlmsg exists_krlmsg exists_krldlg krl_fprintf krl_fopen krl_fclose krl_fscanf
    krl_fgets eki_init eki_open eki_close eki_clear eki_send eki_getint eki_getreal eki_getbool eki_getstring
    eki_getframe eki_setint eki_setreal eki_setbool eki_setstring eki_setframe eki_checkbuffer rsi_create rsi_on
    rsi_off rsi_movecorr rsi_delete
"""
KNOWN_ROUTINES: Final[Mapping[str, str]] = {
    **dict.fromkeys(("user_grp", "grp", "h50"), _GRIPPER),
    **dict.fromkeys(("userspot", "spot"), _SPOT),
    **dict.fromkeys(("arc10", "arc20", "a10_ini", "a20_ini", "a10", "a20", "h70"), _ARC),
    "p00": _EXTERNAL,
    **dict.fromkeys(_CONTROLLER.split(), _SYSTEM),
}
