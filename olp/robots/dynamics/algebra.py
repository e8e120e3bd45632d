"""Sums and products of numbers that may be constants: a constant 0 or 1 costs nothing.

In a robot most components are zero for ever: joints turn about coordinate axes, offsets lie along them, the base
stands still. Python floats are the constants, arrays are values of many samples; the recursion is written for the
general case, and what is constant falls out of it by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Term: TypeAlias = float | Array  # exactly `float` for a constant: numpy's own scalars count as arrays
Triple: TypeAlias = tuple[Term, Term, Term]
Matrix: TypeAlias = tuple[Triple, Triple, Triple]


def times(a: Term, b: Term) -> Term:
    """a b"""
    if type(a) is float:
        a, b = b, a
    if type(b) is float:
        if b == 0.0:
            return 0.0
        if b == 1.0:
            return a
        if b == -1.0:
            return -a
    return a * b


def plus(a: Term, b: Term) -> Term:
    """a + b"""
    if type(a) is float and a == 0.0:
        return b
    return a if type(b) is float and b == 0.0 else a + b


def minus(a: Term, b: Term) -> Term:
    """a - b"""
    if type(a) is float and a == 0.0:
        return -b
    return a if type(b) is float and b == 0.0 else a - b


def dot(a: Sequence[Term], b: Sequence[Term]) -> Term:
    """a · b"""
    return plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))


def cross(a: Triple, b: Triple) -> Triple:
    """a × b"""
    return (
        minus(times(a[1], b[2]), times(a[2], b[1])),
        minus(times(a[2], b[0]), times(a[0], b[2])),
        minus(times(a[0], b[1]), times(a[1], b[0])),
    )


def add(a: Triple, b: Triple) -> Triple:
    return plus(a[0], b[0]), plus(a[1], b[1]), plus(a[2], b[2])


def scale(a: Triple, factor: Term) -> Triple:
    return times(a[0], factor), times(a[1], factor), times(a[2], factor)


def apply(matrix: Matrix, vector: Triple) -> Triple:
    """matrix · vector"""
    return dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)


def turn(vector: Triple, axis: tuple[float, float, float], sine: Term, cosine: Term) -> Triple:
    """`vector` turned about the unit vector `axis` by the angle of that sine and cosine."""
    for i in range(3):
        if abs(axis[i]) == 1.0:
            # A turn about a negative axis is one about the positive axis with u and v exchanged.
            u, v = ((i + 1) % 3, (i + 2) % 3)[:: 1 if axis[i] > 0.0 else -1]
            result = [vector[i]] * 3
            result[u] = minus(times(vector[u], cosine), times(vector[v], sine))
            result[v] = plus(times(vector[u], sine), times(vector[v], cosine))
            return result[0], result[1], result[2]
    along = times(dot(vector, axis), minus(1.0, cosine))
    return add(add(scale(vector, cosine), scale(cross(axis, vector), sine)), scale(axis, along))
