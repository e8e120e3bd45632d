"""KUKA approximate positioning, $APO: where it begins is the program's, how the corner is passed is a parabola."""

from __future__ import annotations

from olp.timing.blending._parabola import ParabolicLaw


class Approximation(ParabolicLaw):
    """LIN and CIRC with C_DIS, C_VEL or C_ORI, PTP with C_PTP, each converted to one number: the distance at which
    the approximation begins.

    It begins "at the earliest" where the programmed criterion is met, and never before half of the move: the
    shortest of the criterion's distance and of the halves of both neighbours counts, on both sides (CP-CP
    approximation evaluates the smaller radius). KUKA's manuals draw the curve between as a parabola; they do not
    state its speed.
    """

    summary = "KUKA approximate positioning C_DIS, C_VEL, C_ORI, C_PTP: a parabola within the approximation distance"
    source = "KUKA mxAutomation and KSS manuals: APO structure (CPTP, CDIS, CORI, CVEL). Not measured"
    amount = "approximation distance [m], see olp/runtime/recorder.py"
