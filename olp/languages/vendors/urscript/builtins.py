"""The words of the script manual: what a call means, and which calls olp keeps without modelling them."""

from __future__ import annotations

from typing import Final

# Arguments of the moves in the manual's order. Defaults are the manual's, too (script manual, "Module motion").
MOVES: Final[dict[str, tuple[str, ...]]] = {
    "movej": ("q", "a", "v", "t", "r"),
    "movel": ("pose", "a", "v", "t", "r"),
    "movep": ("pose", "a", "v", "r"),
    "movec": ("pose_via", "pose_to", "a", "v", "r", "mode"),
    "optimovej": ("q", "a", "v", "r"),
    "optimovel": ("pose", "a", "v", "r"),
}
JOINT_DEFAULTS: Final = (1.4, 1.05)  # [rad/s²], [rad/s] of the leading axis
PATH_DEFAULTS: Final = (1.2, 0.25)  # [m/s²], [m/s]
OPTIMAL_DEFAULTS: Final = (0.3, 0.3)  # fractions of what the robot can do

# Calls that take positions of the axes: argument by place and by name.
JOINT_ARGUMENTS: Final = {
    "movej": (0, "q"),
    "movel": (0, "pose"),
    "movep": (0, "pose"),
    "optimovej": (0, "q"),
    "optimovel": (0, "pose"),
    "servoj": (0, "q"),
    "get_forward_kin": (0, "q"),
    "get_inverse_kin": (1, "qnear"),
    "get_inverse_kin_has_solution": (1, "qnear"),
}

# (bus, index first) of what reads and switches a signal.
INPUTS: Final = {
    "get_digital_in": "in",
    "get_standard_digital_in": "in",
    "get_digital_out": "out",
    "get_standard_digital_out": "out",
    "get_configurable_digital_in": "configurable-in",
    "get_configurable_digital_out": "configurable-out",
    "get_tool_digital_in": "tool-in",
    "get_tool_digital_out": "tool-out",
    "get_analog_in": "analog-in",
    "get_standard_analog_in": "analog-in",
    "get_analog_out": "analog-out",
    "get_standard_analog_out": "analog-out",
    "get_tool_analog_in": "tool-analog-in",
    "get_flag": "flag",
    "olp_digital_in": "counted-in",
    "olp_digital_out": "counted-out",
}
OUTPUTS: Final = {
    "set_digital_out": "out",
    "set_standard_digital_out": "out",
    "set_configurable_digital_out": "configurable-out",
    "set_tool_digital_out": "tool-out",
    "set_analog_out": "analog-out",
    "set_standard_analog_out": "analog-out",
    "set_flag": "flag",
    "olp_set_digital_out": "counted-out",
}
# Older functions, which count the tool's signals behind the box's: first and last of these, and what they are (the
# script manual of e-Series on each: "n: 8-9 go to the tool digital inputs").
COUNTED_ON: Final = {
    "get_digital_in": (8, 9, "tool-in"),
    "get_digital_out": (8, 9, "tool-out"),
    "set_digital_out": (8, 9, "tool-out"),
    "get_analog_in": (2, 3, "tool-analog-in"),
}
INPUT_WORDS: Final = {
    "in": "get_standard_digital_in",
    "out": "get_standard_digital_out",
    "configurable-in": "get_configurable_digital_in",
    "configurable-out": "get_configurable_digital_out",
    "tool-in": "get_tool_digital_in",
    "tool-out": "get_tool_digital_out",
    "analog-in": "get_standard_analog_in",
    "analog-out": "get_standard_analog_out",
    "tool-analog-in": "get_tool_analog_in",
    "flag": "get_flag",
    "counted-in": "olp_digital_in",
    "counted-out": "olp_digital_out",
}
NO_TIME: Final = "no time"  # `Move.other`: a time that is written and never above 0
OUTPUT_WORDS: Final = {
    "out": "set_standard_digital_out",
    "configurable-out": "set_configurable_digital_out",
    "tool-out": "set_tool_digital_out",
    "analog-out": "set_standard_analog_out",
    "flag": "set_flag",
    "counted-out": "olp_set_digital_out",
}

# URScript -> neutral, same arguments and no units.
FUNCTIONS: Final = {
    "sqrt": "sqrt",
    "floor": "floor",
    "ceil": "ceil",
    "pow": "power",
    "pose_trans": "pose-product",
    "pose_inv": "pose-inverse",
    "pose_add": "pose-add",
    "pose_sub": "pose-subtract",
    "interpolate_pose": "pose-interpolate",
    "to_str": "text-of-value",
    "to_num": "value-of-text",
    "str_cat": "joined-text",
    "str_len": "length-of-text",
}
FUNCTION_WORDS: Final = {neutral: word for word, neutral in FUNCTIONS.items()}
FROM_ANGLE: Final = ("sin", "cos", "tan")  # take radians
TO_ANGLE: Final = ("asin", "acos", "atan", "atan2")  # give radians
CURRENT_POSE: Final = frozenset({"get_actual_tcp_pose", "get_target_tcp_pose", "get_target_waypoint"})
CURRENT_JOINTS: Final = frozenset(
    {"get_actual_joint_positions", "get_target_joint_positions", "get_joint_positions"}
)

# What calls give, as `Declare.type`; those that are missing are not known.
RESULTS: Final = {
    **dict.fromkeys(("pose_trans", "pose_inv", "pose_add", "pose_sub", "interpolate_pose"), "position"),
    **dict.fromkeys(("get_forward_kin", "get_tcp_offset", "get_actual_tool_flange_pose"), "position"),
    **dict.fromkeys(CURRENT_POSE, "position"),
    **dict.fromkeys(("get_inverse_kin", *CURRENT_JOINTS), "joints"),
    **dict.fromkeys(("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "pow", "log"), "real"),
    **dict.fromkeys(
        ("d2r", "r2d", "norm", "point_dist", "pose_dist", "random", "get_steptime", "to_num"), "real"
    ),
    **dict.fromkeys(("floor", "ceil", "length", "get_list_length", "str_len", "str_find"), "integer"),
    **dict.fromkeys(
        ("to_str", "str_cat", "str_sub", "str_at", "socket_read_string", "socket_read_line"), "string"
    ),
    **dict.fromkeys(("socket_open", "get_inverse_kin_has_solution", "is_steady", "str_empty"), "boolean"),
    **dict.fromkeys(
        ("socket_send_byte", "socket_send_int", "socket_send_line", "socket_send_string"), "boolean"
    ),
    **dict.fromkeys(
        ("read_input_boolean_register", "read_output_boolean_register", "read_port_bit"), "boolean"
    ),
    **dict.fromkeys(("read_input_integer_register", "read_output_integer_register"), "integer"),
    **dict.fromkeys(("read_port_register", "socket_get_var"), "integer"),
    **dict.fromkeys(("read_input_float_register", "read_output_float_register"), "real"),
    **dict.fromkeys(("socket_read_ascii_float", "wrench_trans"), "list:real"),
    **dict.fromkeys(("socket_read_binary_integer", "socket_read_byte_list"), "list:integer"),
    **{word: "real" if "analog" in word else "boolean" for word in INPUTS},
}

# Motion that no plan can hold: it follows sensors, other threads or people.
SENSED_MOTION: Final = frozenset((
    "conveyor_pulse_decode", "direct_torque", "force_mode", "freedrive_mode", "path_offset_enable",
    "path_offset_set", "screw_driving", "servoc", "servoj", "servop", "speedj", "speedl", "teach_mode",
    "track_conveyor_circular", "track_conveyor_linear",
))  # fmt: skip

# The rest of the manual: known words that are kept with their arguments.
OTHERS: Final = frozenset((
    "add_frame", "assert", "attach_frame", "backdrive_mode", "binary_list_to_integer", "bool_to_str",
    "calculate_payload", "clear_interpreter", "close_popup", "collision_detection_set", "convert_pose",
    "conveyor_pulse_decode", "d2r", "dashboard_send", "delete_frame", "detach_frame", "direct_torque",
    "enable_external_ft_sensor", "encoder_enable_pulse_decode", "encoder_enable_set_tick_count",
    "encoder_get_tick_count", "encoder_set_tick_count", "encoder_unwind_delta_tick_count",
    "end_backdrive_mode", "end_force_mode", "end_freedrive_mode", "end_interpreter", "end_screw_driving",
    "end_teach_mode",
    "enter_critical", "exit_critical", "force", "force_mode", "force_mode_set_damping",
    "force_mode_set_gain_scaling", "frame_add", "frame_attach", "frame_detach", "freedrive_mode",
    "freedrive_mode_no_incorrect_payload_check", "ft_rtde_input_enable", "get_actual_joint_currents",
    "get_actual_joint_positions_history", "get_actual_joint_speeds", "get_actual_tcp_speed",
    "get_actual_tool_flange_pose", "get_base_acceleration", "get_controller_temp",
    "get_conveyor_tick_count", "get_coriolis_and_centrifugal_torques", "get_euromap_input",
    "get_euromap_output", "get_flag", "get_forward_kin", "get_freedrive_status", "get_gravity",
    "get_inverse_kin", "get_inverse_kin_has_solution", "get_jacobian", "get_jacobian_time_derivative",
    "get_joint_positions", "get_joint_temp", "get_joint_torques", "get_list_length", "get_mass_matrix",
    "get_physical_joint_robot_conf", "get_pose", "get_robot_software_version", "get_steptime",
    "get_target_joint_accelerations", "get_target_joint_speeds", "get_target_payload",
    "get_target_payload_cog", "get_target_payload_inertia", "get_target_tcp_speed", "get_target_waypoint",
    "get_tcp_force", "get_tcp_offset", "get_tool_accelerometer_reading", "get_tool_current", "halt",
    "integer_to_binary_list", "interpreter_mode", "inv", "is_steady",
    "is_within_safety_limits", "length", "log", "make_list",
    "modbus_add_rtu_signal", "modbus_add_signal", "modbus_delete_signal", "modbus_get_error",
    "modbus_get_signal_status", "modbus_get_time_since_signal_invalid", "modbus_reset_connection",
    "modbus_send_custom_command", "modbus_set_digital_input_action", "modbus_set_output_register",
    "modbus_set_output_signal", "modbus_set_runstate_dependent_choice",
    "modbus_set_signal_update_frequency", "modbus_set_signal_watchdog", "move_frame", "norm", "normalize",
    "path_offset_disable", "path_offset_enable", "path_offset_get", "path_offset_set",
    "path_offset_set_alpha_filter", "path_offset_set_max_offset", "performance_set", "point_dist",
    "popup", "pose_dist", "position_deviation_warning", "powerdown", "protective_stop", "r2d", "random",
    "read_input_boolean_register", "read_input_float_register", "read_input_integer_register",
    "read_output_boolean_register", "read_output_float_register", "read_output_integer_register",
    "read_port_bit", "read_port_register", "request_boolean_from_primary_client",
    "request_float_from_primary_client", "request_integer_from_primary_client",
    "request_string_from_primary_client", "reset_revolution_counter", "reset_world_model", "rotate",
    "rotvec2rpy", "rpc_factory", "rpy2rotvec",
    "rtde_input_enable", "rtde_set_watchdog", "runstate_dependent_choice", "screw_driving",
    "servoc", "servoj", "servop", "set_analog_inputrange", "set_analog_out_domain",
    "set_analog_outputdomain", "set_baselight_iec", "set_baselight_off", "set_baselight_solid",
    "set_configurable_digital_input_action", "set_conveyor_tick_count", "set_euromap_output",
    "set_euromap_runstate_dependent_choice", "set_external_ft_sensor", "set_flag",
    "set_friction_compensation", "set_gravity", "set_gripper_force", "set_input_actions_to_default",
    "set_joint_limits", "set_max_joint_speed", "set_payload", "set_payload_cog", "set_payload_mass",
    "set_runstate_configurable_digital_output_to_value", "set_runstate_configurable_digital_outputs",
    "set_runstate_gp_boolean_output_to_value", "set_runstate_standard_analog_output_to_value",
    "set_runstate_standard_digital_output_to_value", "set_runstate_standard_digital_outputs",
    "set_runstate_tool_digital_output_to_value", "set_safety_mode_transition_hardness",
    "set_servo_setpoint_filter", "set_standard_analog_input_domain", "set_standard_digital_input_action",
    "set_target_payload", "set_tcp", "set_tool_analog_input_domain", "set_tool_communication",
    "set_tool_digital_input_action", "set_tool_digital_output_mode", "set_tool_output_mode",
    "set_tool_voltage", "set_watchdog", "size", "sleep", "socket_close", "socket_get_var", "socket_init",
    "socket_open", "socket_read_ascii_float", "socket_read_binary_integer", "socket_read_byte_list",
    "socket_read_line", "socket_read_string", "socket_send_byte", "socket_send_int", "socket_send_line",
    "socket_send_string", "socket_set_var", "speedj", "speedl", "splice", "start_teach_mode",
    "stop_conveyor_tracking", "stopj", "stopl", "str_at", "str_cat", "str_empty", "str_find", "str_len",
    "str_sub", "struct", "sync", "teach_mode", "textmsg", "time", "to_num", "to_str", "tool_contact",
    "torque_command", "trace", "track_conveyor_circular", "track_conveyor_linear", "transpose",
    "unlock_protective_stop", "wrench_trans", "write_output_boolean_register",
    "write_output_float_register", "write_output_integer_register", "write_port_bit",
    "write_port_register", "zero_ftsensor",
))  # fmt: skip
KNOWN: Final = (
    frozenset(MOVES) | frozenset(INPUTS) | frozenset(OUTPUTS) | frozenset(FUNCTIONS) | frozenset(FROM_ANGLE)
    | frozenset(TO_ANGLE) | CURRENT_POSE | CURRENT_JOINTS | SENSED_MOTION | OTHERS
)  # fmt: skip
