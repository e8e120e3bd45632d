"""System variables that say how moves are made, case folded, and what each of them says."""

from __future__ import annotations

from typing import Final

MANNERS: Final = {
    "$cnfg_care": "in which posture the arm reaches a place",
    "$turn_care": "how many turns the axes keep",
    "$jnt_mturn": "how many turns the axes keep",
    "$sing_care": "what happens near a singularity",
    "$ornt_type": "how the tool turns on its way",
    "$term_type": "how still the arm has to stand at an end",
    "$tol_fine": "how still the arm has to stand at an end",
    "$tol_coars": "how still the arm has to stand at an end",
    "$fly_type": "how a corner is passed",
    "$fly_traj": "how a corner is passed",
    "$fly_per": "how a corner is passed",
    "$stress_per": "how a corner is passed",
    "$tool_cntr": "the load",
    "$tool_mass": "the load",
    "$tool_inertia": "the load",
}
