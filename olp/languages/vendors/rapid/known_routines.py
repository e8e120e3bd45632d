"""What a RAPID controller brings with it and olp does not model: a call of it is passed over as what it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import replace
from typing import Final, NamedTuple, TypeVar

from olp.ir.expressions import CallValue, Expression, NamedArgument, Number, Text
from olp.ir.program import Call, Declare, Parameter, Process, Program, Statement
from olp.ir.transformer import calls_nothing, expressions_of, mapped

# --- Standard names ---
# Names that every RAPID controller knows, whatever is loaded: what a program may call and name without declaring it.
#
# From the tables of contents of ABB's "Technical reference manual: RAPID Instructions, Functions and Data types"
# (3HAC050917, RobotWare 6) and the list of reserved words in "RAPID kernel" (3HAC050946). Options add further names:
# a name that is not here need not be wrong. The last of both tables, ActEventBuffer to TryInt and CamGetMode to
# SafetyControllerGet…, are from memory of the manual; GetJointData is called in rpiRobotics/abb_motion_program_exec.

_RESERVED: Final = """
    alias and backward case connect const default div do else elseif endfor endfunc endif endmodule endproc
    endrecord endtest endtrap endwhile error exit false for from func goto if inout local mod module nostepin
    not noview or pers proc raise readonly record retry return step sysmodule test then to trap true trynext
    undo var viewonly while with xor
"""
RESERVED: Final = frozenset(_RESERVED.split())

_INSTRUCTIONS: Final = """
    accset actunit add alias aliasio aliasioreset arcc arccend arccstart arcl arclend arclstart bitclear bitset
    bookerrno break callbyvar camflush camgetparameter camgetresult camloadjob camreqimage camsetexposure
    camsetparameter camsetprogrammode camsetrunmode camstartloadjob camwaitloadjob cancelload capaptrsetup capc
    caplset caprefresh checkprogref cirpathmode clear cleariobuff clearpath clearrawbytes clkreset clkstart
    clkstop close closedir confj confl contactl copyfile copyrawbytes corrclear corrcon corrdiscon corrwrite
    deactunit decr dispc displ dropsensor dropwobj egmactjoint egmactmove egmactpose egmgetid egmmovec egmmovel
    egmreset egmrunjoint egmrunpose egmsetupai egmsetupao egmsetupgi egmsetupltapp egmsetupuc egmstop
    egmstreamstart egmstreamstop egmwaitcond eoffsoff eoffson eoffsset erasemodule erraise erriodisable errlog
    errrestart errwrite exit exitcycle fcact fccalib fccondforce fccondorient fccondpos fccondreorispeed
    fccondtcpspeed fccondtorque fccondwaitwhile fcdeact fcpress1lstart fcpressc fcpressend fcpressl fcrefcircle
    fcrefforce fcrefline fcrefmoveframe fcrefrot fcrefspiral fcrefsprngforward fcrefstart fcrefstop
    fcresetdampingtune fcresetlpfiltertune fcsetdampingtune fcsetlpfiltertune fcsetlptune fcspdchgact
    fcspdchgdeact fcspdchgtunreset fcspdchgtunset fcsupvforce fcsupvorient fcsupvpos fcsupvreorispeed
    fcsupvtcpspeed fcsupvtorque fricidevaluate fricidinit fricidsetfriclevels g_blowoff1 g_blowoff2 g_blowon1
    g_blowon2 g_calibrate g_gripin g_gripout g_init g_jogin g_jogout g_moveto g_setforce g_setmaxspd g_stop
    g_vacuumoff1 g_vacuumoff2 g_vacuumon1 g_vacuumon2 getdataval getsysdata gettrapdata goto gripload
    hand_calibrate hand_gripinward hand_gripoutward hand_initialize hand_joginward hand_jogoutward hand_moveto
    hand_setholdforce hand_setmaxspeed hand_stop hand_turnoffblow1 hand_turnoffblow2 hand_turnoffvacuum1
    hand_turnoffvacuum2 hand_turnonblow1 hand_turnonblow2 hand_turnonvacuum1 hand_turnonvacuum2
    hand_waitmovingcompleted hollowwristreset idelete idisable ienable ierror incr indamove indcmove inddmove
    indreset indrmove invertdo iobusstart iobusstate iodisable ioenable ipers irmqmessage isignalai isignalao
    isignaldi isignaldo isignalgi isignalgo isleep itimer ivarvalue iwatch load loadid makedir mandatoryload
    manloadidproc mechunitload motionprocessmodeset motionsup moveabsj movec movecao movecdo movecgo movecsync
    moveextj movej movejao movejdo movejgo movejsync movel movelao moveldo movelgo movelsync mtoolrotcalib
    mtooltcpcalib open opendir packdnheader packrawbytes paintc paintl pathacclim pathrecmovebwd pathrecmovefwd
    pathrecstart pathrecstop pathresol pdispoff pdispon pdispset procerrrecovery prxactivandstorerecord
    prxactivrecord prxdbgstorerecord prxdeactrecord prxresetpos prxresetrecords prxsetposoffset
    prxsetrecordsampletime prxsetsyncalarm prxstartrecord prxstoprecord prxstorerecord prxusefilerecord pulsedo
    raise raisetouser readanybin readblock readcfgdata readerrdata readrawbytes readvararr removeallcyclicbool
    removecyclicbool removedir removefile renamefile reset resetaxisdistance resetaxismovetime resetppmoved
    resetretrycount resettorquemargin restopath retry return rewind rmqemptyqueue rmqfindslot rmqgetmessage
    rmqgetmsgdata rmqgetmsgheader rmqreadwait rmqsendmessage rmqsendwait safetycontrollersyncrequest save
    savecfgdata searchc searchextj searchl sensdevice set setalldataval setao setdatasearch setdataval setdo
    setgo setleadthrough setsysdata setupcyclicbool sifm singarea skipwarn socketaccept socketbind socketclose
    socketconnect socketcreate socketlisten socketreceive socketreceivefrom socketsend socketsendto softact
    softdeact speedlimaxis speedlimcheckpoint speedrefresh spotj spotl spotmj spotml spystart spystop startload
    startmove startmoveretry stcalib stclose stindgun stindgunreset stop stopen stopmove stopmovereset storepath
    sttune sttunereset supsyncsensoroff supsyncsensoron syncmoveoff syncmoveon syncmoveresume syncmovesuspend
    syncmoveundo synctosensor systemstopaction testsigndefine testsignreset texttabinstall tperase tpreaddnum
    tpreadfk tpreadnum tpshow tpwrite triggabsj triggc triggcheckio triggequip triggint triggio triggj triggjios
    triggl trigglios triggrampao triggspeed triggstopproc trynext tunereset tuneservo uimsgbox uimsgwrite
    uimsgwriteabort uishow unload unpackrawbytes velset waitai waitao waitdi waitdo waitgi waitgo waitload
    waitrob waitsensor waitsynctask waittestandset waittime waituntil waitwobj warmstart worldacclim write
    cornerpathwarning arcrefresh recoverymenu recoveryposreset recoveryposset setwrprocname ackitmtgt flushitmsrc
    getitmtgt nextitmtgt qstartitmsrc qstopitmsrc resetflowcount resetmaxusagetime usereachabletargets setforce
    calibrate indgunmove indgunmovereset openhighlift closehighlift recalctcp removesuperv setupsuperv
    cyclicbrakecheck setbrush cssact cssdeact cssdeactmovel cssforceoffsetact
    writeanybin writebin writeblock writecfgdata writerawbytes writestrbin writevar writevararr wzboxdef
    wzcyldef wzdisable wzdoset wzenable wzfree wzhomejointdef wzlimjointdef wzlimsup wzsphdef
    acteventbuffer aliascamera camstartsetparameter capcondsetdo capequidist capl caplatrsetup capnoprocess
    capweavesync deacteventbuffer ditheract ditherdeact errraise fitcircle getgroupsignalinfo getjointdata
    gettorquemargin ioctrlaxis_refsync ioctrlaxis_refsyncoff ioctrlaxis_refsyncon ipathpos pathlengthreset
    pathlengthstart pathlengthstop siclose siconnect sigetcyclic sisetcyclic softelbow stepbwdpath
    triggdatacopy triggdatareset tryint
"""
INSTRUCTIONS: Final = frozenset(_INSTRUCTIONS.split())

_FUNCTIONS: Final = """
    abs absdnum acos acosdnum ainput aoutput argname asin asindnum atan atan2 atan2dnum atandnum bitand
    bitanddnum bitcheck bitcheckdnum bitlsh bitlshdnum bitneg bitnegdnum bitor bitordnum bitrsh bitrshdnum
    bitxor bitxordnum bytetostr calcjointt calcrobt calcrotaxframez calcrotaxisframe caljointt camgetexposure
    camgetloadedjob camgetname camnumberofresults cdate cjointt clkread corrread cos cosdnum cpos crobt
    cspeedoverride ctask ctime ctool cwobj dectohex defaccframe defdframe defframe dim dinput distance dnumtonum
    dnumtostr dotprod doutput egmgetstate euler eulerzyx eventtype exechandler execlevel exp fcgetforce
    fcgetprocessdata fcisforcemode fcloadid filesize filetime filetimednum fssize g_getpos g_iscalibrated
    getaxisdistance getaxismovetime getmaxnumberofcyclicbool getmecunitname getmodalpayloadmode getmotortorque
    getnextcyclicbool getnextmechunit getnextsym getnumberofcyclicbool getserviceinfo getsignalorigin getsysinfo
    gettaskname gettime ginput ginputdnum goutput goutputdnum hand_getactualpos hand_getvacuumpressure1
    hand_iscalibrated hand_isgrippermoving hextodec indinpos indspeed iounitstate isbrakecheckactive
    iscyclicbool isfile isleadthrough ismechunitactive ispers isstopmoveact isstopstateevent issyncmoveon isvar
    maxextlinearspeed maxextreorispeed maxrobreorispeed maxrobspeed mirpos moddnum modexist modtime modtimednum
    motionplannerno nonmotionmode norient numtodnum numtostr offs opmode orientzyx orobt paridposvalid
    paridrobvalid pathlengthget pathlevel pathrecvalidbwd pathrecvalidfwd pfrestart poseinv posemult posevect
    pow powdnum ppmovedinmanmode present quad quaddnum rawbyteslen readbin readdir readmotor readnum readstr
    readstrbin readvar reltool remainingretries rmqgetslotname robname robos round rounddnum runmode sin sindnum
    socketgetstatus socketpeek sqrt sqrtdnum stcalcforce stcalctorque stiscalib stisclosed stisindgun stisopen
    strdigcalc strdigcmp strfind strformat
    strlen strmap strmatch strmemb strorder strpart strtobyte strtoval tan tandnum
    taskisactive taskisexecuting taskruninsyncedmode taskrunmec taskrunrob tasksinsync testandset testdi
    testsignread textget texttabfreetouse texttabget triggdatavalid trunc truncdnum type uialphaentry
    uiclientexist uidnumentry uidnumtune uilistview uimessagebox uinumentry uinumtune validio valtostr vectmagn
    camgetmode capgetfailsigs crossprod gettspstatus getuasusername issysid maxextreorientspeed
    maxrobreorientspeed progmemfree prxgetmaxrecordpos safetycontrollergetchecksum
    safetycontrollergetopmodepincode safetycontrollergetswversion safetycontrollergetuserchecksum
"""
FUNCTIONS: Final = frozenset(_FUNCTIONS.split())

_TYPES: Final = """
    aiotrigg arcdata beaddata bool btnres busstate buttondata byte cameradev cameraextdata camerasortdata
    cameratarget capdata caplatrackdata capspeeddata capweavedata cfgdomain clock confdata corrdescr datapos
    dionum dir dnum egm_minmax egmfilter egmframetype egmident egmmeasuremode egmstate egmstopmode equipdata
    errdomain errnum errstr errtype event_type exec_level extjoint fcboxvol fccondstatus fccylindervol fcdamping
    fcforcevector fcframe fclindir fcplane fcprocessdata fcrotdir fcspeedvector fcspherevol fcxyznum
    flystartdata gundata handler_type icondata identno intnum iodev iounit_state jointtarget listitem loaddata
    loadidnum loadsession mecunit motionprocessmode motsetdata num o_extjoint o_jointtarget o_robjoint
    o_robtarget opcalc opnum orient paridnum paridvalidnum pathrecid pos pose processtimes progdisp rawbytes
    restartdata rmqheader rmqmessage rmqslot robjoint robtarget seamdata sensor sensorstate shapedata signalai
    signalao signaldi signaldo signalgi signalgo signalorigin simdata socketdev socketstatus speeddata spotdata
    stoppoint stoppointdata string stringdig supervtimeouts supervtype switch symnum syncident taskid tasks
    testsignal tooldata tpnum trackdata tracktdata trapdata triggdata triggios triggiosdnum triggstrgo
    tsp_status tunetype uishownum weavedata welddata wobjdata wzstationary wztemporary zonedata
"""
TYPES: Final = frozenset(_TYPES.split())


class RoutineSignature(NamedTuple):
    """What a routine takes besides options, by type ("" where several types will do), and what a function returns.

    `options`: None where not all of them are listed here.
    """

    result: str
    takes: tuple[str, ...]
    options: frozenset[str] | None = None


# A line each: the type of a function's result or "-", the name, the types of its arguments ("?": of several types, or a
# signal or unit of the configuration), and behind a bar its options, where all are listed.
_TEXT_SIGNATURES: Final = """
    - movej robtarget speeddata zonedata tooldata | conc id v t z inpos wobj corr tload
    - movel robtarget speeddata zonedata tooldata | conc id v t z inpos wobj corr tload
    - moveabsj jointtarget speeddata zonedata tooldata | conc id noeoffs v t z inpos wobj tload
    - movec robtarget robtarget speeddata zonedata tooldata | conc id v t z inpos wobj corr tload
    - movejdo robtarget speeddata zonedata tooldata ? ?
    - moveldo robtarget speeddata zonedata tooldata ? ?
    - movecdo robtarget robtarget speeddata zonedata tooldata ? ?
    - movejsync robtarget speeddata zonedata tooldata string
    - movelsync robtarget speeddata zonedata tooldata string
    - movecsync robtarget robtarget speeddata zonedata tooldata string
    - triggj robtarget speeddata ? zonedata tooldata
    - triggl robtarget speeddata ? zonedata tooldata
    - triggc robtarget robtarget speeddata ? zonedata tooldata
    - searchl ? robtarget robtarget speeddata tooldata
    - searchc ? robtarget robtarget robtarget speeddata tooldata
    - set ?
    - reset ?
    - invertdo ?
    - pulsedo ? | high plength
    - setdo ? ? | sdelay sync
    - setgo ? ? | sdelay
    - setao ? num
    - waitdi ? ?
    - waitdo ? ?
    - waitgi ? ?
    - waitai ? ?
    - waituntil bool
    - waittime num | inpos
    - add num num
    - incr num
    - decr num
    - clear num
    - accset num num | finepointramp
    - velset num num
    - gripload loaddata
    - pdispset pose
    - pdispon robtarget tooldata | rot exep wobj
    - pdispoff
    - clkreset clock
    - clkstart clock
    - clkstop clock
    - isignaldi ? ? intnum | single singlesafe
    - isignaldo ? ? intnum | single singlesafe
    - isignalgi ? intnum | single singlesafe
    - itimer ? intnum | single singlesafe
    - ipers ? intnum | single singlesafe
    - idelete intnum
    - iwatch intnum
    - isleep intnum
    - ienable
    - idisable
    - stopmove
    - startmove
    - exitcycle
    - confj | on off
    - confl | on off
    - singarea | wrist lockaxis4 off
    - tperase
    - tpshow ?
    - tpwrite string | num bool pos orient dnum
    - tpreadnum ? string
    - tpreadfk ? string string string string string string
    - errwrite string string | w i rl2 rl3 rl4
    - open ? iodev
    - close iodev
    - write iodev string | num bool pos orient dnum nonewline
    - socketcreate socketdev | udp
    - socketbind socketdev string num
    - socketlisten socketdev
    - socketaccept socketdev socketdev | clientaddress time
    - socketconnect socketdev string num | time
    - socketsend socketdev | str rawdata data noofbytes
    - socketreceive socketdev | str rawdata data readnoofbytes norecbytes time
    - socketclose socketdev
    robtarget offs robtarget num num num
    robtarget reltool robtarget num num num | rx ry rz
    robtarget calcrobt jointtarget tooldata
    jointtarget calcjointt robtarget tooldata
    pose posemult pose pose
    pose poseinv pose
    pos posevect pose pos
    num distance pos pos
    num vectmagn pos
    num dotprod pos pos
    num eulerzyx orient | x y z
    orient orientzyx num num num
    orient norient orient
    num abs ?
    num sqrt num
    num exp num
    num sin num
    num cos num
    num tan num
    num atan2 num num
    num pow num num
    num dim ? num
    num clkread clock | highres
    num strlen string
    num strfind string num string
    num strmatch string num string
    string strpart string num num
    string numtostr num num
    string valtostr ?
    bool strtoval string ?
    bool isfile string
"""


def _signatures() -> Iterator[tuple[str, RoutineSignature]]:
    for line in _TEXT_SIGNATURES.strip().splitlines():
        head, bar, options = line.partition("|")
        result, name, *takes = head.split()
        types = tuple("" if type_ == "?" else type_ for type_ in takes)
        yield name, RoutineSignature(result.strip("-"), types, frozenset(options.split()) if bar else None)


SIGNATURES: Final[Mapping[str, RoutineSignature]] = dict(_signatures())

# --- Known routines ---

KNOWN_ROUTINES: Final[Mapping[str, str]] = {
    **dict.fromkeys(INSTRUCTIONS, "an instruction of RAPID"),
    **dict.fromkeys(FUNCTIONS, "a function of RAPID"),
}

# --- What reaches outside the arm, or computes with texts ---
# Another controller can do the same by a routine that a person writes for it.

_OUTSIDE: Final = """
    camflush camgetexposure camgetloadedjob camgetname camgetparameter camgetresult camloadjob
    camnumberofresults camreqimage camsetexposure camsetparameter camsetprogrammode camsetrunmode camstartloadjob
    camwaitloadjob cdate cleariobuff close closedir copyfile ctime filesize filetime fssize getsysinfo gettime isfile
    makedir open opendir readanybin readbin readdir readnum readstr readstrbin removedir removefile renamefile rewind
    socketaccept socketbind socketclose socketconnect socketcreate socketgetstatus socketlisten socketpeek
    socketreceive socketreceivefrom socketsend socketsendto tpreadfk tpreadnum uialphaentry uiclientexist uidnumentry
    uidnumtune uilistview uimessagebox uimsgbox uimsgwrite uimsgwriteabort uinumentry uinumtune uishow write
    writeanybin writebin writestrbin
"""
_TEXTS: Final = """
    bytetostr dectohex hextodec strdigcalc strdigcmp strfind strformat strmap strmemb strorder strtobyte strtoval
"""
# Bytes that are put together for a bus or a socket.
_BYTES: Final = """
    clearrawbytes copyrawbytes packdnheader packrawbytes rawbyteslen readrawbytes unpackrawbytes writerawbytes
"""
REPLACEABLE: Final = frozenset(
    {
        *_OUTSIDE.split(),
        *_TEXTS.split(),
        *_BYTES.split(),
        *(n for n in INSTRUCTIONS | FUNCTIONS if n.startswith(("g_", "hand_"))),
    }
)
_TEXT_RESULTS: Final = """
    bytetostr cdate ctime dectohex getsysinfo hextodec readdir readstr readstrbin strdigcalc strformat strmap
    uialphaentry
"""
_STATE_RESULTS: Final = "isfile strdigcmp strmemb strorder strtoval uiclientexist"
RESULT_TYPES: Final[Mapping[str, str]] = {
    **dict.fromkeys(FUNCTIONS & REPLACEABLE, "real"),
    **dict.fromkeys(_TEXT_RESULTS.split(), "string"),
    **dict.fromkeys(_STATE_RESULTS.split(), "boolean"),
}
CALLED: Final = "called"  # the argument of a process instruction that holds it as a call
_D = TypeVar("_D", Declare, Parameter)
_HANDLES: Final = ("socketdev", "iodev", "dir", "rawbytes")  # types of data that only such routines use


def with_outside_calls(program: Program) -> Program:
    """The program with calls in the place of instructions that reach outside the arm, and numbers for their handles.

    Routines that it does not declare get their options as further arguments: nobody knows what these are called there.
    """
    own = frozenset(r.name.casefold() for r in program.routines)
    if not any(_is_outside(s, own) for s in program.statements()):
        return program
    routines = [
        replace(
            r,
            body=tuple([_as_call(s, own) for s in r.body]),
            parameters=tuple(map(_as_number, r.parameters)),
        )
        for r in program.routines
    ]
    return replace(program, routines=tuple(routines), data=tuple(map(_as_number, program.data)))


def _is_outside(s: Statement, own: Set[str]) -> bool:
    if isinstance(s, Process):
        return any(name == CALLED for name, _ in s.arguments)
    if isinstance(s, Call) and s.routine.casefold() not in own:
        return True
    return not calls_nothing(s) and any(
        isinstance(e, CallValue) and e.routine.casefold() not in own for e in expressions_of(s)
    )


def _as_call(s: Statement, own: Set[str]) -> Statement:
    if isinstance(s, Declare):
        return _as_number(s)
    called = dict(s.arguments).get(CALLED) if isinstance(s, Process) else None
    if isinstance(s, Process) and isinstance(called, CallValue):
        s = Call(s.line, called.routine, called.arguments, comment=s.comment)
    if isinstance(s, Call) and s.routine.casefold() not in own:
        s = replace(s, arguments=_in_order(s.arguments))

    def positional(e: Expression) -> Expression:
        if isinstance(e, CallValue) and e.routine.casefold() not in own:
            return replace(e, arguments=_in_order(e.arguments))
        return e

    return s if calls_nothing(s) else mapped(s, positional)


def _in_order(arguments: tuple[Expression, ...]) -> tuple[Expression, ...]:
    """Options as further arguments, a switch as its name."""
    return tuple((a.value or Text(a.name)) if isinstance(a, NamedArgument) else a for a in arguments)


def _as_number(d: _D) -> _D:
    if d.type not in _HANDLES:
        return d
    if isinstance(d, Parameter):
        return replace(d, type="integer", native="")
    return replace(d, type="integer", native="num", value=None if d.sizes else Number(0))
