"""The types and functions of VAL3: from memory of the "VAL3 reference manual" (versions 5 to 8)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

POSES: Final = frozenset(("pointRx", "pointRs", "point", "trsf", "frame", "tool"))
JOINTS: Final = frozenset(("jointRx", "jointRs", "joint"))
# Of members of a project's own types.
MEMBER_TYPES: Final[Mapping[str, str]] = {
    "num": "real",
    "bool": "boolean",
    "string": "string",
    **dict.fromkeys(POSES, "position"),
    **dict.fromkeys(JOINTS, "joints"),
}
_TEXT_NO_ARGUMENTS: Final = """
    clock disablePower enablePower esStatus getMonitorSpeed herej isCompliant isEmpty isPowered isSettled restartMove
    stopMove waitEndMove
"""
_TEXT_ONE_ARGUMENT: Final = """
    abs acos aioGet asin atan chr close config cos delay dioGet exp isInRange len ln log open round roundDown roundUp
    setMonitorSpeed sin sqrt tan taskKill taskStatus taskSuspend wait
"""
_TEXT_TWO_ARGUMENTS: Final = """
    aioSet align appro asc dioSet distance find here left max min position power right taskResume toString watch
"""
_TEXT_THREE_ARGUMENTS: Final = "compose jointToPoint limit mid movej movel sel toNum"
_TEXT_FOUR_ARGUMENTS: Final = "movec pointToJoint replace setFrame"
# At least and at most.
ARGUMENTS: Final[Mapping[str, tuple[int, int]]] = {
    name: (count, count)
    for count, text in enumerate(
        (
            _TEXT_NO_ARGUMENTS,
            _TEXT_ONE_ARGUMENT,
            _TEXT_TWO_ARGUMENTS,
            _TEXT_THREE_ARGUMENTS,
            _TEXT_FOUR_ARGUMENTS,
        )
    )
    for name in text.split()
} | {
    "autoConnectMove": (0, 1),
    "cls": (0, 1),
    "getKey": (0, 1),
    "gotoxy": (2, 3),
    "isKeyPressed": (1, 2),
}
# Their number of arguments differs from version to version.
_TEXT_OTHERS: Final = """
    aioLink alter alterBegin alterEnd alterMovej alterMovel alterMovec alterStopTime append bAnd bNot bOr bXor
    clearBuffer codeAscii delete dioLink first get getData getDate getDisplayLen getJointForce getLatch getMoveId
    getProfile getPositionErr getSpeed getVersion hibernateRobot insert interpolateC interpolateL ioBusStatus ioStatus
    isCalibrated isDefined isGravity last libDelete libExist libList libLoad libPath libSave link logMsg movejSync
    movejc movejf movelf next nrand popUpMsg prev put putln rand resetMotion resetTurn resize setLatch setMoveId
    setMutex setProfile setTextMode sioCtrl sioGet sioLink sioSet size stopApp timeToNum title toBinary fromBinary
    userPage workingMode encode decode
"""
FUNCTIONS: Final = ARGUMENTS.keys() | frozenset(_TEXT_OTHERS.split())

KNOWN_FUNCTIONS: Final[Mapping[str, str]] = {
    name.casefold(): "a function of VAL3" for name in sorted(FUNCTIONS)
}
# What reaches outside the arm, or computes with texts: another controller can do the same by a routine that a person
# writes for it.
_TEXT_REPLACEABLE: Final = """
    asc chr cls codeAscii find fromBinary getDate getDisplayLen getKey getVersion gotoxy ioBusStatus ioStatus
    isKeyPressed left libExist libList libLoad libPath libSave len logMsg mid popUpMsg put putln replace right
    setTextMode sioCtrl sioGet sioLink sioSet title toBinary toNum toString userPage encode decode
"""
REPLACEABLE: Final = frozenset(name.casefold() for name in _TEXT_REPLACEABLE.split())
# What their values are, where no number: a variable for one of them is of this type.
_TEXT_RESULTS: Final = "getDate getVersion left libPath mid replace right toString"
_STATE_RESULTS: Final = "isKeyPressed libExist"
RESULT_TYPES: Final[Mapping[str, str]] = {
    name.casefold(): type_
    for type_, names in (("string", _TEXT_RESULTS), ("boolean", _STATE_RESULTS))
    for name in names.split()
}
# Which arguments they give values.
FILLING: Final[Mapping[str, tuple[int, ...]]] = {
    **dict.fromkeys(
        (
            "aiolink",
            "append",
            "delete",
            "diolink",
            "get",
            "getjointforce",
            "getlatch",
            "getprofile",
            "insert",
            "iobusstatus",
            "link",
            "resize",
            "setmutex",
            "siolink",
        ),
        (0,),
    ),
    **dict.fromkeys(("getdata", "liblist", "sioget"), (1,)),
    **dict.fromkeys(("frombinary", "pointtojoint", "setframe", "tobinary"), (3,)),
    "tonum": (1, 2),
}
