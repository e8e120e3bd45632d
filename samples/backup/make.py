"""Writes the two synthetic backups beside it: `python samples/backup/make.py`.

No controller wrote these files and no such arms exist: the layouts are those of published backups, the numbers are
invented. The taught points of the user frames are whole pulses; the frames are computed from them here, with code of
its own, so that reading them back and computing them again is a test.
"""

from __future__ import annotations

from math import ceil, copysign, cos, radians, sin
from pathlib import Path

import numpy as np

DX200 = {
    "robot": "OX01840-A0*",
    "code": 84,
    "links": (163_000, 837_000, 187_500, 1_019_250, 107_000),  # a1 a2 a3 d4 d6 [um]
    "ratios": ((1489, 11), (1181, -7), (1663, 12), (937, -9), (1109, 13), (6143, -139)),
    "upper": (172, 147, 163, 193, 131.5, 371),  # [deg]
    "lower": (-172, -98, -79.4, -193, -123, -371),
    "speed": (201, 187, 223, 397, 413, 617),  # [deg/s]
    "times": (460, 510, 370, 230, 250, 170),  # [ms]
    "zones": (12_500, 25_000, 50_000, 100_000, 200_000, 300_000, 400_000, 500_000),  # [um]
}
YRC1000 = {
    "robot": "1-06VXO18-A0*(OX1790) STANDARD",
    "code": 200,
    "links": (147_000, 781_000, 203_000, 1_063_000, 93_500),
    "ratios": ((1777, 13), (2011, -12), (1429, 9), (1553, -15), (1361, 16), (9001, -211)),
    "upper": (178, 151, 157, 199, 146, 449),
    "lower": (-178, -102, -83, -199, -141, -449),
    "speed": (207, 213, 229, 431, 427, 691),
    "times": (340, 490, 360, 250, 230, 130),
    "zones": (25_000, 50_000, 100_000, 150_000, 200_000, 300_000, 400_000, 500_000),
}
STATION = {
    "robot": "TURN-2",
    "code": 0,
    "links": (0, 0, 0, 0, 0),
    "ratios": ((1297, 11), (1459, 9)),
    "upper": (123, 197),
    "lower": (-117, -203),
    "speed": (83, 151),
    "times": (710, 530),
    "zones": (0,) * 8,
}
# The first slots of each list, as olp/robots/backup/parameters.py explains them.
DX = {
    "values": 1700,
    "upper": 924,
    "lower": 932,
    "speed": 956,
    "below": 972,
    "above": 980,
    "times": (900, 908),
}
YRC = {
    "values": 3000,
    "upper": 1030,
    "lower": 1040,
    "speed": 1070,
    "below": 1090,
    "above": 1100,
    "times": (1290,),
}
TOOLS = {
    0: ("TORCH 35", (-71.345, 2.118, 403.907, 1.7312, -38.4409, -5.2076), (-21.4, 3.7, 178.2), 2.915),
    3: ("TASTKOPF GRÜN", (11.237, -46.81, 219.405, -2.3318, 17.9071, 93.114), (4.1, -17.9, 88.6), 1.374),
}
FRAMES = {
    1: ("TISCH", 0, ((-17_204, 31_377, -24_118, 2_209, -52_003, 811), (9_117, 31_804, -23_642, -1_733, -51_211, 402),
                     (-16_355, 47_209, -9_806, 2_417, -55_640, 917))),
    7: ("FIXTURE B", 3, ((61_902, 12_455, -31_870, -7_151, -40_208, 13_377),
                         (80_313, 21_117, -22_904, -9_930, -41_777, 15_001),
                         (57_448, 30_006, -14_411, -6_602, -47_195, 12_210))),
}  # fmt: skip
# (direction at zero, offset from the axis before) of S L U R B T, as the published AR2010 is built.
DIRECTIONS = ((0, 0, 1), (0, 1, 0), (0, -1, 0), (-1, 0, 0), (0, -1, 0), (-1, 0, 0))
FLANGE = np.array(((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)))


def pulses_per_degree(arm: dict) -> list[float]:
    return [4096 * above / abs(below) / 360 for above, below in arm["ratios"]]


def outward(degrees: float, per_degree: float) -> int:
    """Whole pulses, rounded away from zero as controllers do."""
    return int(copysign(ceil(abs(degrees) * per_degree - 1e-9), degrees))


def section(head: str, values: list[int]) -> list[str]:
    return [head] + [",".join(map(str, values[i : i + 10])) for i in range(0, len(values), 10)]


def group_section(number: int, arm: dict | None, slots: dict) -> list[str]:
    """`///RCnG`."""
    values = [0] * slots["values"]
    if arm is not None:
        values[0] = arm["code"]
        for slot, link in zip((1, 3, 5, 8, 12), arm["links"], strict=True):
            values[slot] = link
        for axis, per_degree in enumerate(pulses_per_degree(arm)):
            above, below = arm["ratios"][axis]
            values[slots["upper"] + axis] = outward(arm["upper"][axis], per_degree)
            values[slots["lower"] + axis] = outward(arm["lower"][axis], per_degree)
            values[slots["speed"] + axis] = outward(arm["speed"][axis], per_degree)
            values[slots["below"] + axis], values[slots["above"] + axis] = below, above
            for first in slots["times"]:
                values[first + axis] = arm["times"][axis]
    return section(f"///RC{number}G", values)


def zone_section(number: int, arm: dict | None, count: int) -> list[str]:
    """`///S1CnG`: speed presets (VJ, V, VR), then the zones of PL 1 to 8."""
    values = [0] * count
    if arm is not None:
        values[2:10] = [78, 156, 312, 625, 1250, 2500, 5000, 10000]
        values[10:18] = [110, 230, 460, 930, 1870, 3750, 7500, 15000]
        values[18:26] = [20, 60, 120, 240, 480, 960, 1920, 3840]
        values[33:41] = arm["zones"]
    return section(f"///S1C{number}G", values)


def rotation(direction: tuple[float, ...], angle: float) -> np.ndarray:
    x, y, z = direction
    cross = np.array(((0, -z, y), (z, 0, -x), (-y, x, 0)))
    return np.eye(3) + sin(angle) * cross + (1 - cos(angle)) * cross @ cross


def tool_point(arm: dict, pulses: tuple[int, ...], tool: tuple[float, ...]) -> np.ndarray:
    """[mm] in the base frame."""
    a1, a2, a3, d4, d6 = (link / 1000 for link in arm["links"])
    offsets = ((0, 0, 0), (a1, 0, 0), (0, 0, a2), (0, 0, a3), (d4, 0, 0), (d6, 0, 0))
    turned, place = np.eye(3), np.zeros(3)
    for direction, offset, pulse, per in zip(
        DIRECTIONS, offsets, pulses, pulses_per_degree(arm), strict=True
    ):
        place = place + turned @ np.array(offset)
        turned = turned @ rotation(direction, radians(pulse / per))
    return place + turned @ FLANGE @ np.array(tool[:3])


def frame_row(origin: np.ndarray, on_x: np.ndarray, on_xy: np.ndarray) -> str:
    """x, y, z [mm], Rx, Ry, Rz [deg] of a three-point frame."""
    x = (on_x - origin) / np.linalg.norm(on_x - origin)
    z = np.cross(x, on_xy - origin)
    z /= np.linalg.norm(z)
    y = np.cross(z, x)
    angles = np.degrees((np.arctan2(y[2], z[2]), -np.arcsin(x[2]), np.arctan2(x[1], x[0])))
    return ",".join([f"{v:.3f}" for v in origin] + [f"{v:.4f}" for v in angles])


def tool_cnd(crc: bool) -> list[str]:
    rows = []
    for number in range(8):
        name, pose, centre, mass = TOOLS.get(number, ("", (0.0,) * 6, (0.0,) * 3, 0.0))
        rows += [f"//TOOL {number}"] + ["///CRC 1894208062"] * crc + [f"///NAME {name}".rstrip()]
        rows += [",".join([f"{v:.3f}" for v in pose[:3]] + [f"{v:.4f}" for v in pose[3:]])]
        rows += [",".join(f"{v:.3f}" for v in centre), f"{mass:.3f}"]
        rows += ["0.013,0.017,0.011" if mass else "0.000,0.000,0.000", f"0.000,0,{2 if mass else 1}"]
    return rows


def uframe_cnd(arm: dict) -> list[str]:
    rows = []
    for number, (name, tool, points) in FRAMES.items():
        rows += [f"//UFRAME {number}", f"///NAME {name}", f"///TOOL {tool}", "///GROUP 1" + ",0" * 31]
        rows += ["///BASICFRM 1,16,0", "///BASEP 0.000,0.000,0.000,0.0000,0.0000,0.0000", "///PULSE"]
        for index, (label, pulses) in enumerate(zip(("RORG", "RXX", "RXY"), points, strict=True)):
            rows += [f"////{label} C{index:03d}={','.join(map(str, pulses))},0,0,0"]
        rows += ["////BUSER " + frame_row(*(tool_point(arm, pulses, TOOLS[tool][1]) for pulses in points))]
    return rows


def var_dat() -> list[str]:
    rows = ["//VAR", "///PFNUM 6,1,2,1", "///SHARE 20,20,20,20,6,5,3,3"]
    rows += ["///B", "0,17,0,3,0,0,0,0,0,255", "1,0,0,0,0,0,0,0,0,0"]
    rows += ["///I", "0,-1207,0,0,33,0,0,0,0,0", "0,0,0,0,0,0,0,0,0,411"]
    rows += ["///D", "0,0,731904,0,0,0,0,0,0,0", "0,0,0,0,0,0,-22817,0,0,0"]
    rows += ["///R", "0.000000,1.734000,0,0,0,0,0,0,0,0", "0,0,0,0,0,0,0,0,-2.5E-3,0"]
    rows += ["///S", "", "TEIL 17", "", "", "mm/s", ""]
    rows += ["///P", '"UNUSED"', '"PULSE",0,0,-1203,20417,-33120,512,-41877,902', '"UNUSED"']
    rows += ['"RECTAN",16,0,412.310,-87.045,33.120,178.4410,-12.0071,91.3300', '"UNUSED"']
    rows += ["///BP", '"UNUSED"', '"PULSE",0,0,87611', '"UNUSED"']
    return [*rows, "///EX", '"PULSE",0,0,-1746,8820', '"UNUSED"', '"UNUSED"']


def macro_dat() -> list[str]:
    rows = [
        "//MACRO1 0",
        "///ATTR 0",
        "///JOB1 ARC-START",
        "///ARGSET 2,0,0,0",
        "///ARGTYPE KB,KB,,",
        "///COMMENT1",
    ]
    rows += ["welding file", "", "//MACRO1 4", "///ATTR 0", "///JOB1 CLEAN TIP", "///ARGSET 0,0,0,0"]
    return [*rows, "//MACRO1 5", "///ATTR 0", "///JOB1", "///ARGSET 0,0,0,0"]


def system_sys(software: str, groups: list[str]) -> list[str]:
    rows = [
        "/SYSTEM 8",
        "//DATE      : 2026/03/02 14:07:31",
        f"//SYSTEM NO : {software}",
        "//PARAM  NO : 2.06",
    ]
    rows += [
        "//APPLI     : ARC WELDING     ",
        "//LANGUAGE  :  2.27-00-00",
        "//REVISION",
        "YPP      2.21-00, 1.03-00",
    ]
    return [*rows, "//ROBOT NAME", *groups, "//CONTROL POWER", "TOTAL : 2025/01/02 12:11,02004:23'29"]


def group_name(name: str, model: str, bits: str) -> str:
    return f"{name} : {model:<46}{bits}"


def write(folder: Path, files: dict[str, list[str]]) -> None:
    folder.mkdir(exist_ok=True)
    for name, rows in files.items():
        (folder / name).write_bytes(("\r\n".join(rows) + "\r\n").encode("cp1252"))


def main(here: Path) -> None:
    six, one, two = "0011_1111", "0000_0001", "0000_0011"
    track = {
        **STATION,
        "robot": "RECT-X",
        "ratios": ((7, 3),),
        "upper": (4000,),
        "lower": (-11,),
        "speed": (90,),
    }
    arms = [DX200, {**track, "times": (900,)}, STATION, None]
    everything = ["/ALL DN", "//RC DN", *section("///RCD", [20, 100, 1, 0, 0, 90, 1, 1, 1, 0])]
    for number, arm in enumerate(arms, 1):
        everything += group_section(number, arm, DX)
    everything += ["//SC DN"]
    for number, arm in enumerate(arms, 1):
        everything += zone_section(number, arm, 800)
    groups = [
        group_name("R1", DX200["robot"], six) + ",  " + group_name("B1", "RECT-X", one),
        group_name("S1", "TURN-2", two),
    ]
    write(
        here / "dx200",
        {
            "ALL.PRM": everything,
            "TOOL.CND": tool_cnd(crc=False),
            "UFRAME.CND": uframe_cnd(DX200),
            "VAR.DAT": var_dat(),
            "MACRO.DAT": macro_dat(),
            "SYSTEM.SYS": system_sys("DN2.27.00A(US/PL)-00", groups),
        },
    )
    arms = [YRC1000, STATION]
    parameters = ["//RC YAS", *section("///RCD", [20, 100, 1, 0, 0, 90, 1, 1, 0, 0])]
    zones = ["//SC YAS"]
    for number, arm in enumerate(arms, 1):
        parameters += group_section(number, arm, YRC)
        zones += zone_section(number, arm, 2800)
    groups = [group_name("R1", YRC1000["robot"], six), group_name("S1", "TURN-2", two)]
    write(
        here / "yrc1000",
        {
            "RC.PRM": [*parameters, "///RC3G"],
            "SC.PRM": zones,
            "TOOL.CND": tool_cnd(crc=True),
            "UFRAME.CND": uframe_cnd(YRC1000),
            "SYSTEM.SYS": system_sys("YAS5.25.00A(EN)-00", groups),
        },
    )


if __name__ == "__main__":
    main(Path(__file__).parent)
