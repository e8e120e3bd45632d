"""Diagnoses that test the scorer: one that knows the answer, one that always says jerk, one that says nothing."""

from __future__ import annotations

from typing import Any

KINDS = ("oracle", "jerk", "nothing")


def diagnosis(kind: str, answer: dict[str, Any]) -> dict[str, Any]:
    """As `olp diagnose` would write it."""
    terms = {"oracle": answer["required"], "jerk": ["jerk"], "nothing": []}[kind]
    hidden = bool(answer["hidden"]) or answer["family"] == "outside"
    verdict = "explained" if terms else ("unexplained" if hidden and kind == "oracle" else "no-mismatch")
    floor = answer["noise_floor_s"]
    return {
        "schema": "olp.diagnosis/1",
        "verdict": verdict,
        "findings": [
            {
                "term": term,
                "moves": answer["moves"].get(term, {}).get("acts", []),
                "parameters": {
                    name: {"value": p["value"], "unit": p["unit"], "ci95": [p["value"], p["value"]]}
                    for name, p in answer["parameters"].get(term, {}).items()
                },
            }
            for term in terms
        ],
        "indistinguishable": [],
        "fit": {"heldout_after": {"rmse_s": floor if terms else 9 * floor}},
    }
