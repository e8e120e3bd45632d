"""Faults in the reader and the writer of INFORM."""

from typing import Final

from fault_rows import Fault

FAULTS: Final = (
    Fault("positions.py", "scale[:3] = mm", "scale[:2] = mm", "Z of a pose read in degrees"),
    Fault(
        "positions.py",
        "mm if store is Store.BASE else deg",
        "deg if store is Store.BASE else mm",
        "slides read in degrees, axes in mm",
    ),
    Fault(
        "positions.py",
        '"BASE": "base", "ROBOT": "robot"',
        '"BASE": "robot", "ROBOT": "base"',
        "POSTYPE BASE and ROBOT swapped",
    ),
    Fault(
        "positions.py",
        'if number is not None and word == "TOOL":',
        'if number is not None and word == "USER":',
        "///TOOL and ///USER swapped",
    ),
    Fault(
        "values.py", '"V": (SpeedUnit.TRAVEL, mm, ', '"V": (SpeedUnit.TRAVEL, mm / 6.0, ', "V= read as cm/min"
    ),
    Fault(
        "values.py", "SpeedUnit.TRAVEL, mm, 0.1 * mm", "SpeedUnit.TRAVEL, mm, mm", "V=I003 ten times as fast"
    ),
    Fault("values.py", "percent, 0.01 * percent", "1.0, 0.01", "VJ= in percent taken as a fraction"),
    Fault(
        "values.py",
        "SpeedUnit.TURN, deg, 0.1 * deg",
        "SpeedUnit.TURN, 1.0, 0.1",
        "VR= in deg/s read as rad/s",
    ),
    Fault("values.py", "(1.0, 0.01)  # [s]", "(0.001, 0.01)  # [s]", "TIMER and WAIT in ms"),
    Fault(
        "values.py",
        '"C": Store.ROBOT, "BC": Store.BASE, "EC": Store.STATION, "E"',
        '"C": Store.ROBOT, "BC": Store.STATION, "EC": Store.BASE, "E"',
        "external axes BC and EC swapped",
    ),
    Fault(
        "statements.py",
        "st.Blend(st.BlendKind.RADIUS, values",
        "st.Blend(st.BlendKind.LEVEL, values",
        "CR= read as a level",
    ),
    Fault("statements.py", 'if word[0] == "S":', 'if word[0] == "R":', "SMOVL no longer coordinated"),
    Fault("statements.py", 'if word == "IMOV":', 'if word == "REFP":', "IMOV read as an absolute move"),
    Fault("statements.py", 'state == "ON", time', 'state == "OFF", time', "SRCH waits for the other state"),
    Fault("statements.py", "start, stop, step[1] if step else None", "start, stop, None", "STEP of FOR lost"),
    Fault(
        "statements.py",
        "tuple(arguments), suffix.condition, jump=jump",
        "tuple(reversed(arguments)), suffix.condition, jump=jump",
        "arguments of CALL swapped",
    ),
    Fault(
        "statements.py",
        "return st.Jump(0, name, suffix.condition, spelling",
        "return st.Jump(0, name, None, spelling",
        "JUMP … IF always jumps",
    ),
    Fault("instructions.py", 'parts, comment or "")', 'parts, "")', "comment behind a move lost"),
    Fault("writer.py", '("VJ", 2)', '("VJ", 0)', "VJ= written without decimals"),
    Fault(
        "writer.py",
        'Path.CIRCULAR: "C", st.Path.SPLINE: "S"',
        'Path.CIRCULAR: "S", st.Path.SPLINE: "C"',
        "MOVC and MOVS swapped",
    ),
    Fault("writer.py", 'found.append(f"ACC={', 'found.append(f"DEC={', "ACC= written as DEC="),
    Fault("writer.py", 'return f"CR={', 'return f"PL={', "a radius in mm written as a level"),
    Fault("writer.py", "words.append(self._blend(s.blend))", "pass", "blend dropped"),
    Fault("writer.py", 'return "IMOV"', 'return "MOVL"', "relative move written as absolute"),
    Fault(
        "writer.py",
        "np.arange(width) < lengths, mm, deg",
        "np.arange(width) < lengths, 1.0, deg",
        "coordinates written in metres",
    ),
    Fault(
        "writer.py",
        'wanted["TOOL"] = str(state.tool)',
        'wanted["TOOL"] = str(state.user or 0)',
        "///TOOL holds the user frame's number",
    ),
    Fault(
        "writer.py",
        "filled = tuple(min(abs(flag), 1) for flag in flags[:6])",
        "filled = (0,) * 6",
        "arm configuration lost on the way from another language",
    ),
    Fault("write_values.py", 'states = ("OFF", "ON")', 'states = ("ON", "OFF")', "outputs inverted"),
    Fault(
        "writer.py",
        "TO {stop}{step: STEP= {}}",
        "TO {stop}",
        "STEP of FOR not written",
    ),
    Fault(
        "writer.py",
        'time = "" if s.timeout is None else f" T=',
        'time = "" if s.timeout is not None else f" T=',
        "the limit of WAIT not written",
    ),
    Fault(
        "writer.py",
        'st.Default: "DEFAULT"',
        'st.Default: "ENDSWITCH"',
        "cases without a default",
    ),
    Fault("writer.py", 'comment_form = "  //{}"', 'comment_form = ""', "comments dropped"),
    Fault("__init__.py", 'name = "inform"', 'name = "inform"\n    newline = "\\n"', "line ends LF"),
)
