"""What a UR controller rejects when it loads a script: calls of functions that it does not have, or with a number of
arguments that they do not take, and variables that nothing sets. The installation may set some: only what is nearly
the name of another is told.

Names and parameters: "URScript Programming Language", the script manual for e-Series SW 5, as github.com/ahernguo/
urscript-extension lists its functions (`src/*Functions.json`). Where versions differ, what any of them takes is taken.
From memory: `set_tcp` takes up to 2, `get_inverse_kin` from 1, `str_sub` from 2.
From Universal Robots' examples: `eip_…_factory`. What PolyScope writes and no manual lists, such as `tool_pose`: the
list of the controller's words in RoboDK's post processor for Elite robots, which take UR's scripts.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic, Span
from olp.core.source import Source
from olp.languages.findings import Findings
from olp.languages.loading import LoadedCell, LoadFindings, Loading, is_near
from olp.languages.vendors.urscript.builtins import KNOWN
from olp.languages.vendors.urscript.lines import Broken, Mark, UrscriptLine, UrscriptLineReader
from olp.languages.vendors.urscript.scopes import Outliner, UrscriptPart
from olp.languages.vendors.urscript.syntax import (
    Assignment,
    Instruction,
    Invocation,
    UrscriptName,
    expressions,
    simple_of,
    walk,
)

_TEXT_NO_ARGUMENTS: Final = """
    end_force_mode end_freedrive_mode end_screw_driving end_teach_mode force get_actual_joint_accelerations
    get_actual_joint_positions get_actual_joint_speeds get_actual_tcp_pose get_actual_tcp_speed
    get_actual_tool_flange_pose get_controller_temp get_gravity get_joint_torques get_steptime
    get_target_joint_accelerations get_target_joint_positions get_target_joint_speeds get_target_payload
    get_target_payload_cog get_target_payload_inertia get_target_tcp_pose get_target_tcp_speed get_target_waypoint
    get_tcp_force get_tcp_offset get_tool_accelerometer_reading get_tool_current get_tool_temp is_steady powerdown
    random sync teach_mode zero_ftsensor
"""
_TEXT_ONE_ARGUMENT: Final = """
    acos asin atan binary_list_to_integer ceil cos d2r floor get_analog_in get_analog_out get_configurable_digital_in
    get_configurable_digital_out get_digital_in get_digital_out get_flag get_joint_temp get_list_length
    get_standard_analog_in get_standard_analog_out get_standard_digital_in get_standard_digital_out
    get_tool_analog_in get_tool_digital_in get_tool_digital_out integer_to_binary_list inv length norm normalize
    pose_inv r2d read_input_boolean_register read_input_float_register read_input_integer_register
    read_output_boolean_register read_output_float_register read_output_integer_register read_port_bit
    read_port_register set_gravity set_payload_cog set_payload_mass set_tool_voltage sin size sleep sqrt str_empty
    str_len tan to_num to_str transpose
"""
_TEXT_TWO_ARGUMENTS: Final = """
    atan2 log point_dist pose_add pose_dist pose_sub pose_trans pow rpc_factory set_analog_out
    set_configurable_digital_out set_digital_out set_flag set_standard_analog_out set_standard_digital_out
    set_tool_digital_out str_at str_cat wrench_trans write_output_boolean_register write_output_float_register
    write_output_integer_register write_port_bit write_port_register
"""
# How many arguments a function needs, and how many it takes at most.
_ARGUMENTS: Final[Mapping[str, tuple[int, int]]] = {
    **dict.fromkeys(_TEXT_NO_ARGUMENTS.split(), (0, 0)),
    **dict.fromkeys(_TEXT_ONE_ARGUMENT.split(), (1, 1)),
    **dict.fromkeys(_TEXT_TWO_ARGUMENTS.split(), (2, 2)),
    **dict.fromkeys(("movej", "movel"), (1, 5)),
    **dict.fromkeys(("movep", "optimovej", "optimovel"), (1, 4)),
    "movec": (2, 6),
    "force_mode": (5, 5),
    "freedrive_mode": (0, 2),
    "get_forward_kin": (0, 2),
    "get_inverse_kin": (1, 5),
    "get_inverse_kin_has_solution": (1, 5),
    "interpolate_pose": (3, 3),
    "popup": (1, 5),
    "set_tcp": (1, 2),
    "set_tool_communication": (6, 6),
    "socket_close": (0, 1),
    "socket_open": (2, 3),
    **dict.fromkeys(
        ("socket_send_byte", "socket_send_int", "socket_send_line", "socket_send_string"), (1, 2)
    ),
    "str_find": (2, 3),
    "str_sub": (2, 3),
    "textmsg": (1, 2),
}
# Functions of newer versions, and of Ethernet/IP, which Universal Robots' own examples call.
_TEXT_NEWER: Final = """
    delete_all_frames eip_reader_factory eip_writer_factory estimate_payload force_mode_get_damping
    force_mode_get_gain_scaling frame_tracking_disable frame_tracking_enable get_children get_frame_parent
    get_rtde_value get_target_tcp_pose_along_path get_target_tcp_speed_along_path high_holding_torque_disable
    high_holding_torque_enable is_frame jerk_gain_scaling_get jerk_gain_scaling_set modbus_add_rw_signal
    motion_version_get motion_version_set pause_on_error_code ros_action_client_factory ros_publisher_factory
    ros_service_client_factory ros_subscriber_factory rotvec2rpy rpy2rotvec set_base_acceleration
    set_gp_boolean_input_action set_mass_properties set_payload_from_attached_frames set_pos
    tool_wrench_limit_disable tool_wrench_limit_set
"""
# Words that no call is believed to mean.
_TEXT_UNLISTED: Final = """
    assert_equals blocking_usleep cma_avg cma_max cma_min cma_reset cma_tick cma_tock debugmsg end_joint_torque_mode
    get_joint_speeds get_max_torque_fraction get_numerical_inverse_kin get_robot_power get_tcp_power get_tcp_speed
    get_tool_digital_output_mode get_tool_output_mode joint_torque_mode jump_to_label labelmsg
    modbus_request_update_signal_value movel_rel pathj read_register rpc_stub script_stop
    send_joint_regulation_parameter servol set_configurable_digital_in set_digital_in set_joint_param
    set_max_torque_fraction set_runstate_output_to_value set_runstate_outputs set_runstate_standard_analog_outputs
    set_runstate_tool_digital_outputs set_standard_digital_in set_tcp_wrench set_tool_digital_in socket_send_byte_list
    tool_pose tracka varmsg write_register
"""
_UNLISTED: Final = frozenset(_TEXT_UNLISTED.split())
_FUNCTIONS: Final = KNOWN | _ARGUMENTS.keys() | frozenset(_TEXT_NEWER.split())
_NODE: Final = re.compile(r'\s*\$ \d+ "')  # PolyScope's mark of a program node
_PACKED: Final = (b"\x1f\x8b", b"<")  # a `.urp` program, which PolyScope itself writes


class ScriptCall(NamedTuple):
    """A call of a function by its name. `given`: arguments."""

    part: UrscriptPart
    line: UrscriptLine
    name: str
    given: int


def check(source: Source, cell: LoadedCell) -> list[Diagnostic]:
    """What a controller rejects in one script."""
    if source.raw.startswith(_PACKED):
        return []
    found = LoadFindings(source)
    root, unsure = _outline(source)
    names = Counter(_names(root))
    for other in cell.sources[1:]:
        if not other.raw.startswith(_PACKED):
            names.update(_names(_outline(other)[0]))
    # PolyScope writes all that a program needs into its export, what URCaps add, too.
    whole = any(_NODE.match(line) for line in source.lines)
    spellings = {name.casefold(): name for name in names.keys() | _FUNCTIONS}
    for call in _calls(root):
        own = call.part.find(call.name)
        if own is not None and names[call.name] == 1 and own.kind == "def" and own.line not in unsure:
            least = sum(default is None for _, default in own.parameters)
            found.arguments(call.name, _at(found, call), (least, len(own.parameters)), call.given)
        elif call.name in names:
            continue
        elif call.name in _ARGUMENTS:
            found.arguments(call.name, _at(found, call), _ARGUMENTS[call.name], call.given)
        elif call.name in _FUNCTIONS | _UNLISTED:
            continue
        elif call.name.casefold() in spellings:
            says = f"the function {call.name[:60]} is declared nowhere: upper and lower case differ"
            help = f"write {spellings[call.name.casefold()]}"
            found.undeclared(says, _at(found, call), help, whole)
        else:
            found.unknown.append((call.name, _at(found, call), "the function"))
    for line, name in _reads(root):
        known = name in names or name in _FUNCTIONS or name in _UNLISTED
        if not known and any(is_near(one.casefold(), name.casefold()) for one in names):
            found.doubtful.append((name, _place(found, line, name), "the variable"))
    return found.finish(names.keys() | _FUNCTIONS, whole, shared=True)


def _outline(source: Source) -> tuple[UrscriptPart, set[int]]:
    """The parts of a script, and its lines that have an error, which the reader tells."""
    findings = Findings(source)
    root = Outliner(findings).read(UrscriptLineReader(findings).read())
    return root, {one.line for one in findings.result() if one.is_error}


def _instructions(root: UrscriptPart) -> Iterator[tuple[UrscriptPart, UrscriptLine, Instruction]]:
    for part in root.all():
        for line, _ in part.lines:
            if not isinstance(line.content, (Mark, Broken)):
                yield part, line, line.content


def _names(root: UrscriptPart) -> Iterator[str]:
    """All that a call may name: functions and threads, parameters and variables."""
    for part in root.all():
        yield part.name
        yield from (name for name, _ in part.parameters)
    for _, _, instruction in _instructions(root):
        simple = simple_of(instruction)
        if isinstance(simple, Assignment) and isinstance(simple.target, UrscriptName):
            yield simple.target.text


def _calls(root: UrscriptPart) -> Iterator[ScriptCall]:
    for part, line, instruction in _instructions(root):
        for expression in expressions(instruction):
            for node in walk(expression):
                if isinstance(node, Invocation) and isinstance(node.function, UrscriptName):
                    yield ScriptCall(part, line, node.function.text, len(node.arguments))


def _reads(root: UrscriptPart) -> Iterator[tuple[UrscriptLine, str]]:
    """The variables that are read."""
    for _, line, instruction in _instructions(root):
        for expression in expressions(instruction):
            nodes = list(walk(expression))
            called = {id(node.function) for node in nodes if isinstance(node, Invocation)}
            yield from (
                (line, node.text)
                for node in nodes
                if isinstance(node, UrscriptName) and id(node) not in called
            )


def _at(found: LoadFindings, call: ScriptCall) -> Span:
    return _place(found, call.line, call.name, r"\s*\(")


def _place(found: LoadFindings, line: UrscriptLine, name: str, behind: str = "") -> Span:
    """Where a name stands, before what `behind` matches: a statement may go over several lines."""
    for number in range(line.number, line.last + 1):
        place = re.search(rf"\b{re.escape(name)}\b{behind}", found.source.line(number))
        if place is not None:
            return Span(number, place.start() + 1, place.start() + 1 + len(name))
    return Span(line.number, 1, 1)


LOAD: Final = Loading(("polyscope-5",), check)
