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
    bas delmens ir_stopm set_cd_params use_cm_pro_values masref_main self_test msgnotify msgquit
    set_krlmsg clear_krlmsg exists_krlmsg rsi_create rsi_on rsi_off rsi_movecorr rsi_delete
"""
# What reaches outside the arm: another controller can do the same by a routine that a person writes for it.
_OUTSIDE: Final = """
    msgdialog set_krldlg exists_krldlg krl_fprintf krl_fopen krl_fclose krl_fscanf krl_fgets krl_fputs
    eki_init eki_open eki_close eki_clear eki_send eki_getint eki_getreal eki_getbool eki_getstring
    eki_getframe eki_getintarray eki_getrealarray eki_getboolarray eki_setint eki_setreal eki_setbool eki_setstring
    eki_setframe eki_checkbuffer eki_clearbuffer eki_lock eki_unlock
    copen cclose cread cwrite cioctl sread swrite cast_to cast_from
    strcomp strfind strtobool strtoint strtoreal strtostring strtoframe strtopos strtoe6pos strtoaxis strtoe6axis
    err_clear err_raise p00 user_grp grp h50 userspot spot arc10 arc20 a10_ini a20_ini a10 a20 h70
    arcmainng arcgetdelay arcgetpath glueonup
"""
REPLACEABLE: Final = frozenset(_OUTSIDE.split())
# Functions and commands of the language itself: "KRL Syntax", "CREAD/CWRITE" (KSS 8).
_LANGUAGE: Final = """
    abs acos asin atan atan2 bas cast_from cast_to cclose check_pidoncpc cioctl clear_krlmsg copen cos cread cwrite
    delete_backward_buffer emi_actpos emi_endpos emi_startpos err_clear err_raise exists_krldlg exists_krlmsg forward
    frame_conv get_decl_place get_msgbuffer get_sig_inf inv_pos inverse m_comment mastergrav mbx_rec md_asgn md_getstate
    md_setstate mod on_error_proceed pulse reset_torque_limits round sacc_cp sacc_joint sapo sapo_ptp sbase
    set_brake_delay set_cd_params set_krldlg set_krldlganswer set_krlmsg set_system_data set_torque_limits
    sgear_jerk sin sipo_mode sjerk sload sori_typ sqrt sread stool2 stradd strclear strcomp strcopy strdeclen
    strfind strlen strtoaxis strtobool strtoe6axis strtoe6pos strtofram strtoint strtopos strtoreal
    strtostring svel_cp svel_joint swrite tan trunc use_cm_pro_values usecm varstate
"""
FUNCTIONS: Final = frozenset(_LANGUAGE.split())
KNOWN_ROUTINES: Final[Mapping[str, str]] = {
    **dict.fromkeys((*_CONTROLLER.split(), *REPLACEABLE), _SYSTEM),
    **dict.fromkeys(FUNCTIONS, "a function of KRL"),
    **dict.fromkeys((*_CONTROLLER.split(), "set_krldlg", "exists_krldlg"), _SYSTEM),
    **dict.fromkeys(("user_grp", "grp", "h50"), _GRIPPER),
    **dict.fromkeys(("userspot", "spot"), _SPOT),
    **dict.fromkeys(("arc10", "arc20", "a10_ini", "a20_ini", "a10", "a20", "h70"), _ARC),
    **dict.fromkeys(("arcmainng", "arcgetdelay", "arcgetpath"), _ARC),
    "glueonup": "a dispensing routine of KUKA.GlueTech",
    "p00": _EXTERNAL,
}
