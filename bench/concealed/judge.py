"""One diagnosis against one sealed answer.

A name is right when it, or a member of a group that the diagnosis itself declared indistinguishable, was hidden.
A name picked without saying that another one would do as well is right only if it is the hidden one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

UNITS = {
    "m/s": ("speed", 1.0), "mm/s": ("speed", 1e-3), "m/s^2": ("acceleration", 1.0), "m/s²": ("acceleration", 1.0),
    "mm/s^2": ("acceleration", 1e-3), "mm/s²": ("acceleration", 1e-3), "m/s^3": ("jerk", 1.0), "m/s³": ("jerk", 1.0),
    "s": ("time", 1.0), "ms": ("time", 1e-3), "kg": ("mass", 1.0), "kg m^2": ("inertia", 1.0),
    "kg m²": ("inertia", 1.0), "kg*m^2": ("inertia", 1.0), "kg·m²": ("inertia", 1.0), "rad/s": ("turning", 1.0),
    "deg/s": ("turning", 0.017453292519943295), "1": ("share", 1.0), "": ("share", 1.0), "%": ("share", 0.01),
    "1/kg": ("per mass", 1.0), "1/(kg m^2)": ("per inertia", 1.0), "1/(kg m²)": ("per inertia", 1.0),
    "1/s": ("rate", 1.0), "N m": ("torque", 1.0), "Nm": ("torque", 1.0), "N·m": ("torque", 1.0),
    "N m s/rad": ("damping", 1.0), "Nm s/rad": ("damping", 1.0),
    "rad": ("angle", 1.0), "deg": ("angle", 0.017453292519943295), "Hz": ("frequency", 1.0),
}  # fmt: skip

_AGREES, _EXPLAINED = 2.001, 1.501  # times the floor
# A step of all durations at a time is one of these from that time on.
SCALES = {"speed-scale", "clock"}
# Effects that identical.py does not play in place of others.
UNCOMPARED = {"clock", "external-wait", "warm-up"}


@dataclass(slots=True)
class Judgement:
    """`first`: the first name is right. `wrong`: names that are not. `missed`: required ones nobody named."""

    name: str
    family: str
    answer: dict[str, Any]
    verdict: str = ""
    named: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    undeclared: list[str] = field(default_factory=list)  # wrong, though no data could have told
    wide: list[str] = field(default_factory=list)  # groups wider than the data are
    first: bool = False
    f1: float | None = None
    heldout: float | None = None  # of the noise floor
    covered: list[tuple[str, str, bool, float, float]] = field(default_factory=list)
    cpu: float = 0.0
    error: str = ""
    contradictions: list[str] = field(default_factory=list)  # of the answer with its own numbers

    @property
    def exact(self) -> bool:
        return not self.wrong and not self.missed and not self.error

    @property
    def size(self) -> float:
        sizes = [self.answer["size"][t] for t in self.answer["required"] if t in self.answer["size"]]
        return min(sizes, default=max(self.answer["size"].values(), default=0.0))


def judge(
    name: str, diagnosis: dict[str, Any] | None, answer: dict[str, Any], cpu: float, error: str
) -> Judgement:
    """Compares; `error`: what the tool said instead of an answer."""
    result = Judgement(name, answer["family"], answer, cpu=cpu, error=error)
    if diagnosis is None:
        result.missed = list(answer["required"])
        result.error = error or "no answer"
        return result
    findings = diagnosis.get("findings", [])
    result.verdict = diagnosis.get("verdict", "")
    result.named = [f["term"] for f in findings]
    groups = {t: _group(t, diagnosis.get("indistinguishable", [])) for t in result.named}
    true = set(answer["required"]) | set(answer["allowed"])
    if answer.get("confounded_with") == "step" and any(
        "time" in (f.get("condition") or "") for f in findings
    ):
        true |= SCALES
    result.wrong = [t for t in result.named if not groups[t] & true]
    same = {s for t in true for s in answer["same"].get(t, [])}
    result.undeclared = [t for t in result.wrong if t in same]
    near = same | {s for t in true for s in answer["near"].get(t, [])} | true
    result.wide = [t for t in result.named if groups[t] - near - {t} - UNCOMPARED]
    result.missed = _missed(answer["required"], result.named, groups, _beside(findings))
    if findings:
        result.first = bool(groups[result.named[0]] & true)
    result.f1 = _f1(findings, answer, groups)
    after = diagnosis.get("fit", {}).get("heldout_after", {}).get("rmse_s")
    if after is not None and answer["noise_floor_s"] > 0:
        result.heldout = after / answer["noise_floor_s"]
    result.covered = _covered(findings, answer)
    result.contradictions = _contradictions(diagnosis) if not answer["family"].startswith("log-") else []
    return result


def _contradictions(diagnosis: dict[str, Any]) -> list[str]:
    """What no answer may say, whatever was hidden."""
    verdict, findings = diagnosis.get("verdict"), diagnosis.get("findings", [])
    floor = diagnosis.get("data", {}).get("noise_floor_s") or 0.0
    left = diagnosis.get("unexplained", {}).get("rmse_s") or 0.0
    unseen = [
        (f["evidence"]["heldout_rmse_before_s"], f["evidence"]["heldout_rmse_after_s"])
        for f in findings
        if "evidence" in f
    ]
    rules = {
        "no mismatch above twice the floor": verdict == "no-mismatch" and left > _AGREES * floor,
        "explained above 1.5 times the floor": verdict == "explained" and left > _EXPLAINED * floor,
        "a name that does not lower the unseen error": any(None not in pair and pair[1] >= pair[0] for pair in unseen),
        "names without an explanation": bool(findings) != (verdict in ("explained", "partly-explained")),
    }  # fmt: skip
    return [said for said, broken in rules.items() if broken]


def _group(term: str, declared: list[list[str]]) -> set[str]:
    return {term}.union(*(set(g) for g in declared if term in g))


def _beside(findings: list[dict[str, Any]]) -> set[str]:
    """Terms that the diagnosis declares beside a plainer law of a name: both together are what the name says alone."""
    return {a["term"] for f in findings for a in f.get("alternatives", []) if a.get("beside")}


def _missed(
    required: list[str], named: list[str], groups: dict[str, set[str]], beside: set[str]
) -> list[str]:
    """Required terms that no name stands for; one name stands for one term, and for one declared `beside` it."""
    free = list(named)
    left = []
    for term in required:
        if term in beside and any(term in groups[name] and name in required for name in named):
            continue
        if term in free:
            free.remove(term)
        else:
            left.append(term)
    missed = []
    for term in left:
        other = next((n for n in free if term in groups[n]), None)
        if other is None:
            missed.append(term)
        else:
            free.remove(other)
    return missed


def _f1(findings: list[dict[str, Any]], answer: dict[str, Any], groups: dict[str, set[str]]) -> float | None:
    """Of the moves in which the rare effect acts; moves where it stays below the noise do not count."""
    if answer["family"] != "rare" or not answer["required"]:
        return None
    term = answer["required"][0]
    true = set(answer["moves"][term]["acts"])
    skipped = set(answer["moves"][term]["little"])
    said: set[int] = set()
    for finding in findings:
        if term in groups[finding["term"]]:
            said |= set(finding.get("moves", []))
    said -= skipped
    right = len(said & true)
    return 2 * right / max(len(said) + len(true), 1)


def _covered(
    findings: list[dict[str, Any]], answer: dict[str, Any]
) -> list[tuple[str, str, bool, float, float]]:
    result = []
    for finding in findings:
        for name, truth in answer["parameters"].get(finding["term"], {}).items():
            found = _parameter(finding.get("parameters", {}), name, truth["unit"])
            if found is None or found.get("ci95") is None or None in found["ci95"]:
                continue
            factor = _unit(found.get("unit", ""))[1]
            low, high = (factor * v for v in found["ci95"])
            value = _unit(truth["unit"])[1] * truth["value"]
            result.append((finding["term"], name, low <= value <= high, factor * found["value"], value))
    return result


def _parameter(given: dict[str, Any], name: str, unit: str) -> dict[str, Any] | None:
    """By its name, else the only one of that dimension."""
    kind = _unit(unit)[0]
    plain = {k.replace(" of axis ", "_"): v for k, v in given.items()}
    alike = {k: v for k, v in plain.items() if _unit(v.get("unit", ""))[0] == kind}
    if name in alike:
        return dict(alike[name])
    return dict(next(iter(alike.values()))) if len(alike) == 1 else None


def _unit(text: str) -> tuple[str, float]:
    """Dimension, and factor to SI; a unit not in the list is a dimension of its own."""
    return UNITS.get(text, (text, 1.0))
