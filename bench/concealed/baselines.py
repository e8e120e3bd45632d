"""What the usual selectors name on the same moves: BIC on raw residuals, LASSO, STLSQ, one term at a time.

They choose among plain columns (seconds per move and unit of effect) that any engineer would write down; nothing of
`olp` is in them. Each column carries the name of its term.
"""

from __future__ import annotations

import csv
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.concealed.fake import diagnosis
from bench.concealed.judge import Judgement, judge
from bench.concealed.tables import figures, markdown

Floats = NDArray[np.float64]
Columns = dict[str, Floats]


def table(folder: Path, names: list[str], answers: dict[str, dict[str, Any]]) -> str:
    """Issue 5's figures of every baseline, side by side, on the cases without logs."""
    names = [n for n in names if "-log-" not in n]
    rows: dict[str, list[str]] = {}
    for choose in (bic, lasso, stlsq, singly):
        judged = [_judged(folder, n, answers[n], choose) for n in names]
        for what, asked, measured, _ in figures(judged):
            if "CPU" not in what and "intervals" not in what and "held-out" not in what and "F1" not in what:
                rows.setdefault(what, [asked]).append(measured)
    header = ("figure", "asked", "BIC, raw residuals", "LASSO, BIC", "STLSQ", "one term at a time")
    return markdown(header, [(what, *cells) for what, cells in rows.items()])


def _judged(folder: Path, name: str, answer: dict[str, Any], choose: Any) -> Judgement:
    residual, columns = library(folder / "cases" / name / "moves.csv")
    said = diagnosis("nothing", answer)
    said["findings"] = [{"term": t, "moves": [], "parameters": {}} for t in choose(residual, columns)]
    said["verdict"] = "explained" if said["findings"] else "unexplained"
    if not said["findings"] and answer["family"] != "outside":
        said["verdict"] = "no-mismatch"
    return judge(name, said, answer, 0.0, "")


def library(path: Path) -> tuple[Floats, Columns]:
    """Residual (n,) [s] and the columns by term, unit mean square, of one recording."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def number(name: str) -> Floats:
        return np.array([float(r.get(name) or 0) for r in rows])

    real, sim = number("duration_s"), number("sim_s")
    start = np.stack([number(f"{a}_start_mm") for a in "xyz"], axis=1) / 1000
    end = np.stack([number(f"{a}_end_mm") for a in "xyz"], axis=1) / 1000
    length = np.linalg.norm(end - start, axis=1)
    speed = np.maximum(number("speed_mm_s") / 1000, 1e-3)
    moving = number("speed_mm_s") > 0
    cruise = np.where(moving, np.minimum(length / speed, sim), 0.0)
    ramp = np.where(moving, np.maximum(sim - cruise, 0.0), 0.0)
    climb = np.where(length > 0, (end - start)[:, 2] / np.maximum(length, 1e-9), 0.0)
    reach = np.hypot(*((start + end) / 2)[:, :2].T)
    clock = np.cumsum(real)
    stop = (number("blend_mm") == 0) * 1.0
    columns = {
        "dispatch": np.ones(len(real)), "settling": stop, "blending": 1 - stop, "acceleration": ramp,
        "speed-scale": cruise, "gravity": ramp * climb**2, "reach-inertia": ramp * reach**2,
        "payload": ramp * number("payload_kg"), "payload-inertia": ramp * number("payload_inertia_kg_m2"),
        "jerk": (length > 0) * 1.0 * np.sqrt(np.maximum(ramp, 0)), "viscous-friction": ramp * speed,
        "speed-clamp": cruise * np.maximum(speed / np.quantile(speed, 0.7) - 1, 0),
        "warm-up": sim * np.exp(-clock / (0.2 * clock[-1])), "clock": sim,
        "orientation-limit": _turned(number),
    }  # fmt: skip
    keep = {t: c / np.sqrt(np.mean(c**2)) for t, c in columns.items() if np.any(c)}
    seen: Columns = {}
    for term, column in keep.items():
        if all(abs(column @ other) / len(column) < 0.9999 for other in seen.values()):
            seen[term] = column
    return real - sim, seen


def _turned(number: Any) -> Floats:
    return np.abs(number("rz_end_deg") - number("rz_start_deg")) / 180


def _fit(y: Floats, X: Floats) -> tuple[Floats, float]:
    beta = np.linalg.lstsq(X, y, rcond=None)[0] if X.shape[1] else np.zeros(0)
    gap = y - X @ beta
    return beta, float(gap @ gap)


def _score(y: Floats, X: Floats) -> float:
    n = len(y)
    return n * float(np.log(max(_fit(y, X)[1], 1e-18) / n)) + X.shape[1] * float(np.log(n))


def _ordered(y: Floats, columns: Columns, terms: list[str]) -> list[str]:
    """The chosen terms, the one with the largest share of the residual first."""
    X = np.stack([columns[t] for t in terms], axis=1) if terms else np.zeros((len(y), 0))
    beta = _fit(y, X)[0]
    return [t for _, t in sorted(zip(-np.abs(beta), terms, strict=True))]


def bic(y: Floats, columns: Columns) -> list[str]:
    """Every set of up to three columns by BIC, as if residuals were white."""
    terms = list(columns)
    sets = [c for k in range(4) for c in combinations(terms, k)]
    best = min(
        sets,
        key=lambda c: _score(y, np.stack([columns[t] for t in c], axis=1) if c else np.zeros((len(y), 0))),
    )
    return _ordered(y, columns, list(best))


def lasso(y: Floats, columns: Columns) -> list[str]:
    """Coordinate descent along a path of penalties; the support with the best BIC."""
    terms = list(columns)
    X = np.stack([columns[t] for t in terms], axis=1)
    n = len(y)
    gram, beta = X.T @ X / n, np.zeros(len(terms))
    best, chosen = _score(y, X[:, :0]), []
    right = X.T @ y / n
    for penalty in np.abs(right).max() * np.exp(-np.linspace(0, 6, 40)):
        for _ in range(60):
            for j in range(len(terms)):
                z = right[j] - gram[j] @ beta + gram[j, j] * beta[j]
                beta[j] = np.sign(z) * max(abs(z) - penalty, 0.0) / gram[j, j]
        support = np.nonzero(beta)[0]
        score = _score(y, X[:, support])
        if score < best:
            best, chosen = score, [terms[j] for j in support]
    return _ordered(y, columns, chosen)


def stlsq(y: Floats, columns: Columns) -> list[str]:
    """Sequentially thresholded least squares; threshold by five-fold cross-validation, one standard error."""
    terms = list(columns)
    X = np.stack([columns[t] for t in terms], axis=1)
    fold = np.arange(len(y)) % 5
    levels = np.std(y) * np.exp(np.linspace(-5, 0.5, 15))
    errors = np.array([[_heldout(y, X, fold == f, level) for f in range(5)] for level in levels])
    mean = errors.mean(axis=1)
    k = int(np.argmin(mean))
    allowed = mean[k] + errors[k].std() / np.sqrt(5)
    level = levels[max(np.nonzero(mean <= allowed)[0])]
    return _ordered(y, columns, [terms[j] for j in _threshold(y, X, level)])


def _threshold(y: Floats, X: Floats, level: float) -> NDArray[np.intp]:
    keep = np.arange(X.shape[1])
    for _ in range(10):
        beta, _ = _fit(y, X[:, keep])
        left = keep[np.abs(beta) >= level]
        if len(left) == len(keep):
            break
        keep = left
    return keep


def _heldout(y: Floats, X: Floats, out: NDArray[np.bool_], level: float) -> float:
    keep = _threshold(y[~out], X[~out], level)
    beta, _ = _fit(y[~out], X[~out][:, keep])
    gap = y[out] - X[out][:, keep] @ beta
    return float(np.mean(gap**2))


def singly(y: Floats, columns: Columns) -> list[str]:
    """The column with the best correlation, then the best with what is left, while p < 0.01."""
    chosen: list[str] = []
    left = y.copy()
    for _ in range(4):
        gains = {t: (c @ left) ** 2 / (c @ c) for t, c in columns.items() if t not in chosen}
        term = max(gains, key=lambda t: gains[t])
        rest = max(float(left @ left) - gains[term], 1e-18)
        if gains[term] / (rest / max(len(y) - 1, 1)) < 6.63:
            break
        chosen.append(term)
        left = left - columns[term] * (columns[term] @ left) / (columns[term] @ columns[term])
    return chosen
