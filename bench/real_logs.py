"""`olp diagnose` on time series of real robots: a KUKA KR 300 and a UR10e, recorded and published by others.

    python bench/real_logs.py kr300 FOLDER     FOLDER holds traj_A.csv.gz, traj_B.csv.gz, traj_C.csv.gz
    python bench/real_logs.py ur10e FOLDER     FOLDER holds ur-20_01_22-joint_1.csv.gz … ur-20_01_31-unload.csv.gz

The files become recordings as docs/recording.md has them, in a temporary folder, and are read back from there.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.identification.diagnosis.logs import LogDiagnosis, diagnose_logs  # noqa: E402
from olp.identification.diagnosis.logs.effort import efforts  # noqa: E402
from olp.identification.diagnosis.logs.select import solve  # noqa: E402
from olp.identification.diagnosis.logs.series import kept, runs, whiten  # noqa: E402
from olp.identification.recording import Recording, read_recording  # noqa: E402

Floats = NDArray[np.float64]
APART = 12.0  # [s] between trajectories that are put into one log


def recording(folder: Path, logs: dict[str, dict[str, Floats]], robot: str = "") -> Recording:
    """Writes the columns of each log, one wait as moves, and reads it all back."""
    import pandas

    folder.mkdir()
    for name, columns in logs.items():
        pandas.DataFrame(columns).to_csv(folder / f"{name}.csv", index=False)
    time = logs["log"]["t_s"]
    rows = f"move,duration_s,type\n1,{time[-1] - time[0]:.3f},wait\n"
    (folder / "moves.csv").write_text(rows, encoding="utf-8")
    if robot:
        (folder / "recording.toml").write_text(f'robot = "{robot}"\n', encoding="utf-8")
    return read_recording(folder)


def tell(found: LogDiagnosis) -> None:
    print(f"verdict: {found.verdict}")
    for finding in found.findings:
        print(f"  {finding.term}: {finding.says}")
        for name, p in finding.parameters.items():
            print(f"      {name} = {p.value:.5g} {p.unit} ({p.low:.5g} to {p.high:.5g})")
    for e in found.evidence:
        where = f"axis {e.axis}" if e.axis else "all axes"
        rms = f"{e.heldout_before:.4g} to {e.heldout_after:.4g} {e.unit}"
        print(f"  {e.term} of {where} ({e.signal}): {rms}, p = {e.p_value:.1e}")
    for note in found.notes:
        print(f"  note: {note}")


def kr300_columns(folder: Path, name: str) -> dict[str, Floats]:
    """One trajectory in the columns of docs/recording.md."""
    import pandas

    table = pandas.read_csv(folder / f"traj_{name}.csv.gz")
    columns: dict[str, Floats] = {"t_s": table["t_s"].to_numpy()}
    theirs = {
        "q{}_deg": "act_pos_mot_deg_{}",
        "q{}_cmd_deg": "ref_pos_deg_{}",
        "qd{}_deg_s": "act_vel_mot_deg_per_s_{}",
        "tau{}_nm": "act_torque_abs_nm_{}",
    }
    for mine, other in theirs.items():
        for axis in range(1, 7):
            columns[mine.format(axis)] = table[other.format(axis)].to_numpy()
    for axis in (1, 2, 3):
        columns[f"q{axis}_link_deg"] = table[f"act_pos_se_deg_{axis}"].to_numpy()
    return columns


def joined(parts: list[dict[str, Floats]]) -> dict[str, Floats]:
    """Several trajectories in one log, `APART` seconds from start to start."""
    late = [{**part, "t_s": part["t_s"] + APART * i} for i, part in enumerate(parts)]
    return {name: np.concatenate([part[name] for part in late]) for name in late[0]}


def kr300(folder: Path, work: Path) -> None:
    parts = {name: kr300_columns(folder, name) for name in "ABC"}
    for name, part in parts.items():
        print(f"\ntrajectory {name}")
        tell(diagnose_logs(recording(work / name, {"log": part})))
    print("\nthe three together")
    whole = recording(work / "all", {"log": joined(list(parts.values()))})
    tell(diagnose_logs(whole))
    print("\naxes behind their reference, by speed alone [ms]; negative: ahead")
    for name, part in parts.items():
        print(f"{name:>4}" + "".join(f"{late * 1000:>9.1f}" for late in lateness(part)))
    print("\nfriction, one trajectory held out in turn: torque that is left [Nm, RMS]")
    names = f"{'axis':>4}{'held out':>10}{'spread':>10}{'without':>10}{'with':>10}"
    print(f"{names}{'viscous [Nm s/rad]':>20}{'Coulomb [Nm]':>14}")
    for axis, out, *torques, viscous, coulomb in held_out_trajectories(whole):
        left = "".join(f"{value:>10.4f}" for value in torques)
        print(f"{axis:>4}{'ABC'[int(out)]:>10}{left}{viscous:>20.2f}{coulomb:>14.3f}")


def lateness(part: dict[str, Floats]) -> list[float]:
    """[s] by which each axis is behind its reference: regression of the difference on the speed."""
    found = []
    for axis in range(1, 7):
        off = part[f"q{axis}_deg"] - part[f"q{axis}_cmd_deg"]
        speed = part[f"qd{axis}_deg_s"]
        columns = np.column_stack([np.ones(len(off)), -speed])[50:-50]
        found.append(float(np.linalg.lstsq(columns, off[50:-50], rcond=None)[0][1]))
    return found


def held_out_trajectories(whole: Recording) -> list[tuple[float, ...]]:
    """Axis, trajectory, spread of its torque, torque left without and with friction [Nm], the fitted numbers.

    Everything is fitted on the other two trajectories.
    """
    assert whole.log is not None
    log = whole.log
    found = efforts(log, None, np.ones(len(log), dtype=bool), None)
    assert found is not None
    number = np.floor((log.time - log.time[0]) / APART).astype(int)
    rows: list[tuple[float, ...]] = []
    for axis in found.axes:
        data = axis.data
        run = runs(log.time, data.use)
        keep = kept(run)
        white = whiten(np.column_stack([data.library, data.residual]), data.filter, keep)
        prior = np.diag(data.products.prior)
        base = tuple(range(data.library.shape[1] - 2))
        all_columns = tuple(range(data.library.shape[1]))
        for out in range(3):
            train = white[number[keep] != out]
            gram = train.T @ train + prior * len(train)
            test = data.use & (number == out)
            left = []
            for members in (base, all_columns):
                sizes = solve(gram, members)
                error = data.residual[test] - data.library[test][:, list(members)] @ sizes
                left.append(float(np.sqrt((error**2).mean())))
            spread = float(data.residual[test].std())
            rows.append((axis.axis + 1, out, spread, *left, float(sizes[-2]), float(sizes[-1])))
    return rows


def ur10e_columns(folder: Path, name: str) -> dict[str, Floats]:
    """One file; torques are measured currents times the axis' own ratio of desired torque to desired current."""
    import pandas

    table = pandas.read_csv(folder / f"{name}.csv.gz", header=None).to_numpy()
    columns: dict[str, Floats] = {"t_s": table[:, 0]}
    for axis in range(6):
        columns[f"q{axis + 1}_deg"] = np.degrees(table[:, 1 + axis])
        columns[f"qd{axis + 1}_deg_s"] = np.degrees(table[:, 7 + axis])
        columns[f"tau{axis + 1}_nm"] = table[:, 13 + axis] * RATIO[axis]
    return columns


RATIO = np.ones(6)  # [Nm/A], read off the files


def ratios(folder: Path) -> Floats:
    """[Nm/A] of every axis: desired torque over desired current at rest, where gravity alone is held.

    Axes that carry no weight (1, 5, 6) have the drives of axes 2 and 4: sizes 4, 4, 3, 2, 2, 2 (UR10e service manual).
    """
    import pandas

    tables = [pandas.read_csv(f, header=None).to_numpy() for f in sorted(folder.glob("ur-*.csv.gz"))]
    table = np.concatenate(tables)
    rest = np.abs(table[:, 7:13]).max(axis=1) < 1e-3
    found = []
    for axis in (1, 1, 2, 3, 3, 3):
        current, torque = table[rest, 19 + axis], table[rest, 25 + axis]
        found.append(float((current * torque).sum() / (current**2).sum()))
    return np.array(found)


def ur10e(folder: Path, work: Path) -> None:
    global RATIO
    RATIO = ratios(folder)
    print("desired torque over desired current [Nm/A]:", np.round(RATIO, 3))
    for axis in range(1, 7):
        print(f"\naxis {axis} up and down")
        columns = ur10e_columns(folder, f"ur-20_01_22-joint_{axis}")
        tell(diagnose_logs(recording(work / f"axis{axis}", {"log": columns}, "universal-robots/ur10e")))
    print("\nten points")
    columns = ur10e_columns(folder, "ur-20_01_17-ptp_10_points")
    tell(diagnose_logs(recording(work / "points", {"log": columns}, "universal-robots/ur10e")))
    load, bare = (ur10e_columns(folder, f"ur-20_01_31-{name}") for name in ("load", "unload"))
    print("\nwith a load, against the same motion without it")
    tell(diagnose_logs(recording(work / "load", {"log": load, "sim_log": bare}, "universal-robots/ur10e")))
    print("\nwithout a load, against the masses of the robot file")
    tell(diagnose_logs(recording(work / "bare", {"log": bare}, "universal-robots/ur10e")))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        {"kr300": kr300, "ur10e": ur10e}[sys.argv[1]](Path(sys.argv[2]), Path(place))
