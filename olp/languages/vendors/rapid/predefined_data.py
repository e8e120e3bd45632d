"""The names that every ABB controller has: predefined data with their values, types, and instructions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

from olp.ir.expressions import Expression, Number, PositionLiteral, RecordLiteral, SignalState, Text

NOT_CONNECTED: Final = 9e9  # an external axis that does not exist

# [v_tcp mm/s, v_ori deg/s, v_leax mm/s, v_reax deg/s] (technical reference manual, speeddata).
_TRAVEL = (
    5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000,
    6000, 7000,
)  # fmt: skip
FASTEST: Final = 5000.0  # [mm/s] vmax: the manual leaves it to the robot; 5000 is what most of them have
SPEEDS: Final[Mapping[str, tuple[float, float, float, float]]] = {
    **{f"v{n}": (n, 500, 5000, 1000) for n in _TRAVEL},
    "vmax": (FASTEST, 500, 5000, 1000),
    **{f"vrot{n}": (0, 0, 0, n) for n in (1, 2, 5, 10, 20, 50, 100)},
    **{f"vlin{n}": (0, 0, n, 0) for n in (10, 20, 50, 100, 200, 500, 1000)},
}


class ZoneData(NamedTuple):
    """Zonedata: pzone_tcp, pzone_ori, pzone_eax [mm], zone_ori [deg], zone_leax [mm], zone_reax [deg]."""

    fine: bool
    values: tuple[float, float, float, float, float, float]


ZONES: Final[Mapping[str, ZoneData]] = {
    "fine": ZoneData(True, (0, 0, 0, 0, 0, 0)),
    "z0": ZoneData(False, (0.3, 0.3, 0.3, 0.03, 0.3, 0.03)),
    "z1": ZoneData(False, (1, 1, 1, 0.1, 1, 0.1)),
    "z5": ZoneData(False, (5, 8, 8, 0.8, 8, 0.8)),
    "z10": ZoneData(False, (10, 15, 15, 1.5, 15, 1.5)),
    "z15": ZoneData(False, (15, 23, 23, 2.3, 23, 2.3)),
    "z20": ZoneData(False, (20, 30, 30, 3, 30, 3)),
    "z30": ZoneData(False, (30, 45, 45, 4.5, 45, 4.5)),
    "z40": ZoneData(False, (40, 60, 60, 6, 60, 6)),
    "z50": ZoneData(False, (50, 75, 75, 7.5, 75, 7.5)),
    "z60": ZoneData(False, (60, 90, 90, 9, 90, 9)),
    "z80": ZoneData(False, (80, 120, 120, 12, 120, 12)),
    "z100": ZoneData(False, (100, 150, 150, 15, 150, 15)),
    "z150": ZoneData(False, (150, 225, 225, 23, 225, 23)),
    "z200": ZoneData(False, (200, 300, 300, 30, 300, 30)),
}

# Neutral type of a declaration by RAPID's word; all others keep their word.
TYPES: Final[Mapping[str, str]] = {
    "num": "real",
    "dnum": "real",
    "byte": "integer",
    **dict.fromkeys(("btnres", "buttondata", "icondata", "dionum", "errnum"), "real"),
    "bool": "boolean",
    "string": "string",
    "robtarget": "position",
    "pose": "position",
    "pos": "position",
    "orient": "position",
    "jointtarget": "joints",
    "tooldata": "tool",
    "wobjdata": "frame",
    "speeddata": "speed",
    "zonedata": "zone",
    **dict.fromkeys(("signaldi", "signaldo", "signalgi", "signalgo", "signalai", "signalao"), "signal"),
}
# Members of the structures that the manual defines, each with its type.
RECORDS: Final[Mapping[str, tuple[tuple[str, str], ...]]] = {
    "robjoint": tuple((f"rax_{n}", "num") for n in range(1, 7)),
    "extjoint": tuple((f"eax_{c}", "num") for c in "abcdef"),
    "confdata": (("cf1", "num"), ("cf4", "num"), ("cf6", "num"), ("cfx", "num")),
    "speeddata": (("v_tcp", "num"), ("v_ori", "num"), ("v_leax", "num"), ("v_reax", "num")),
    "zonedata": (
        ("finep", "bool"),
        ("pzone_tcp", "num"),
        ("pzone_ori", "num"),
        ("pzone_eax", "num"),
        ("zone_ori", "num"),
        ("zone_leax", "num"),
        ("zone_reax", "num"),
    ),
    "loaddata": (
        ("mass", "num"),
        ("cog", "pos"),
        ("aom", "orient"),
        ("ix", "num"),
        ("iy", "num"),
        ("iz", "num"),
    ),
    "tooldata": (("robhold", "bool"), ("tframe", "pose"), ("tload", "loaddata")),
    "wobjdata": (
        ("robhold", "bool"),
        ("ufprog", "bool"),
        ("ufmec", "string"),
        ("uframe", "pose"),
        ("oframe", "pose"),
    ),
}
# Answers, buttons and pictures of dialogs, and ends of files (technical reference manual: btnres, buttondata, icondata,
# ReadNum, ReadBin).
CONSTANTS: Final[Mapping[str, float]] = {
    "resunkwn": 0, "resok": 1, "resabort": 2, "resretry": 3, "resignore": 4, "rescancel": 5, "resyes": 6, "resno": 7,
    "btnnone": -1, "btnok": 0, "btnabrtrtryign": 1, "btnokcancel": 2, "btnretrycancel": 3, "btnyesno": 4,
    "btnyesnocancel": 5, "iconnone": 0, "iconinfo": 1, "iconwarning": 2, "iconerror": 3, "eof_bin": -1,
    "eof_num": 9.998e36, "socket_created": 1, "socket_connected": 2, "socket_bound": 3, "socket_listening": 4,
    "socket_closed": 5,
}  # fmt: skip
SIGNAL_TYPES: Final[Mapping[str, str]] = {
    "signaldi": "in",
    "signaldo": "out",
    "signalgi": "in-group",
    "signalgo": "out-group",
    "signalai": "analog-in",
    "signalao": "analog-out",
}
# Signals by the word that uses them first: instructions and functions.
SIGNAL_USERS: Final[Mapping[str, str]] = {
    "waitdi": "in", "waitdo": "out", "setdo": "out", "set": "out", "reset": "out", "pulsedo": "out",
    "invertdo": "out", "setgo": "out-group", "setao": "analog-out", "waitgi": "in-group", "waitgo": "out-group",
    "waitai": "analog-in", "waitao": "analog-out", "doutput": "out", "dinput": "in", "testdi": "in",
    "ginput": "in-group", "goutput": "out-group", "ainput": "analog-in", "aoutput": "analog-out",
    "gidnum": "in-group", "ginputdnum": "in-group", "isignaldi": "in", "isignaldo": "out",
}  # fmt: skip

# Functions of numbers and texts that have a neutral name.
FUNCTIONS: Final[Mapping[str, str]] = {
    "abs": "abs", "sqrt": "sqrt", "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos",
    "atan": "atan", "atan2": "atan2", "exp": "exp", "pow": "power", "round": "round", "trunc": "trunc",
    "max": "max", "min": "min", "strlen": "length-of-text", "strpart": "part-of-text", "posemult": "pose-product",
    "poseinv": "pose-inverse", "offs": "pose-offset",
}  # fmt: skip

LEAST_ARGUMENTS: Final[Mapping[str, int]] = {
    "atan2": 2, "pow": 2, "max": 2, "min": 2, "strpart": 3, "posemult": 2, "offs": 4,
}  # fmt: skip

# Instructions without a neutral meaning; everything else that is no routine of the file is called as one.
_PROCESS: Final = """
    accset actevbuffer actunit add aliasio bitclear bitset bookerrno brakecheck calldata cancelload checkprogref
    circlepathmode cirpathmode clearallbuffers clearbuffer cleariobuff clearpath clearrawbytes clkreset clkstart clkstop
    close closedir cnvact confj confl contactl copyfile copyrawbytes corrclear corrcon corrdiscon corrwrite cyclebreak
    cycleread deactevbuffer deactunit debugbreak dropsensor dropwobj egmactjoint egmactmove egmactpose egmgetid egmreset
    egmrunjoint egmrunpose egmsetupai egmsetupao egmsetupgi egmsetupltapp egmsetupuc egmstop egmstreamstart
    egmstreamstop eoffsoff eoffson eoffsset erasemodule errlog errraise errwrite exitcycle fcact fcdeact fcload
    fitcircle fricidactl fricidcurve getdatavalue getsysdata gettorquemargin gettrapdata gripload hollowwristreset
    iobusstart iobusstate iodisable ioenable iplarm loadload load loadid makedir manloadid manualaxis mechunitload
    movepnp motionplannermode motionsup mtoolrotcalib offslimit open opendir packdnheader packrawbytes
    pathaccelleration pathaccel pathacclim pathlengthreset pathlengthstart pathlengthstop
    pathreclock pathrecmovebwd pathrecmovefwd pathrecstart pathrecstop pathresol pathtohome perspos procerrrecovery
    puls readanybin readblock readcfgdata readerrdata readrawbytes readvar readvarararr removeall removeallcycbool
    removedir removefile renamefile resetaxisdistance resetaxismovetime resetppmoved resetretrycount resettorquemargin
    restopath resetatoolchange rewind rmqemptyqueue rmqfindslot rmqgetmessage rmqgetmsgdata rmqgetmsgheader
    rmqreadwait rmqsendmessage rmqsendwait safetycontrollersetuptool save saveconfig scload scwrite searchextj
    setallDataVal setalldataval setdatasearch setdataval setleadthrough setsysdata setupcycbool setupsuperv singarea
    skipwarn socketaccept socketbind socketclose socketconnect socketcreate socketlisten socketreceive
    socketreceivefrom socketsend socketsendto softact softdeact softelbow speedlimaxis speedlimcheckpoint speedrefresh
    spcread spyspan spystart spystop stackreset startload startmove startmoveretry steptolerance stepbwdpath
    stopmove stopmovereset storepath strdigcalc sydiscon sysstopaction synctosensor systemstopaction
    syncmoveoff syncmoveon syncmoveresume syncmovesuspend syncmoveundo taskreset tcpframe testsigndefine
    testsignreset textget textgetinstall texttabinstall timestamp toolratecorr tperase tpreaddnum tpreadfk tpreadnum
    tpshow triggcheckio triggdatacopy triggdatareset triggequip triggint triggio triggrampao triggspeed triggstopproc
    tryint tunereset tuneservo uiMsgBox uimsgbox uimsgwrite uimsgwriteabort uishow uneload unload unpackrawbytes
    vectorcorr waitload waitrob waitsensor waitsynctask waittestandset waitungracefully waitwobj warmstart
    weldgeton worldaccLim worldacclim write writeanybin writebin writeblock writecfgdata writerawbytes writestrbin
    writevar wzboxdef wzcyldef wzdisable wzdoset wzenable wzfree wzhomejointdef wzlimjointdef wzlimsup wzsphdef
    pdispset errlogw iwaituntil restart indamove indcmove inddmove indrmove indreset signalchange cap capapTrSetup
    readpathdata setgapsync weldon weldoff
    moveextj camflush camgetloadedjob camgetparameter camgetresult camloadjob camreqimage camsetexposure
    camsetparameter camsetprogrammode camsetrunmode camstartloadjob camwaitloadjob ditheract ditherdeact egmwaitcond
    motionprocessmodeset mtooltcpcalib raisetouser siclose siconnect sigetcyclic sisetcyclic stcalib stclose stopen
    stoolrotcalib stooltcpcalib sttune sttunereset supsyncsensoroff supsyncsensoron"""
PROCESS: Final = frozenset(_PROCESS.lower().split())
_INTERRUPTS: Final = """
    isignaldi isignaldo isignalgi isignalgo isignalai isignalao itimer ipers ierror ivarvalue ipathpos irmqmessage
    ivarvalue icap idelete idisable ienable isleep iwatch isyncsignal"""
INTERRUPTS: Final = frozenset(_INTERRUPTS.split())


# --- Predefined ---
# Speeds, zones, tool0 and wobj0 as values: where they are passed on instead of named by a move.

_HERE: Final = PositionLiteral("pose", (0.0,) * 6)


def as_number(value: float) -> Number:
    """A literal without a point where it needs none."""
    return Number(int(value) if value == int(value) else value)


def _record(kind: str, values: tuple[Expression, ...]) -> RecordLiteral:
    names = (name for name, _ in RECORDS[kind])
    return RecordLiteral(kind, tuple(zip(names, values, strict=True)))


_COG: Final = PositionLiteral("pose", (0.0, 0.0, 1e-6, 0.0, 0.0, 0.0))
_LOAD: Final = _record("loaddata", (as_number(0.001), _COG, _HERE, as_number(0), as_number(0), as_number(0)))
PREDEFINED: Final[Mapping[str, RecordLiteral]] = {
    **{name: _record("speeddata", tuple(map(as_number, values))) for name, values in SPEEDS.items()},
    **{
        name: _record("zonedata", (SignalState(zone.fine), *map(as_number, zone.values)))
        for name, zone in ZONES.items()
    },
    "tool0": _record("tooldata", (SignalState(True), _HERE, _LOAD)),
    "wobj0": _record("wobjdata", (SignalState(False), SignalState(True), Text(""), _HERE, _HERE)),
    "load0": _LOAD,
}
PREDEFINED_NAMES: Final[Mapping[tuple[str, tuple[tuple[str, Expression], ...]], str]] = {
    (value.type, value.members): name for name, value in PREDEFINED.items() if name not in ("vmax", "load0")
}
