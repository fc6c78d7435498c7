"""Least squares of many numbers of which every block of residuals depends on a few, with a loss that bears outliers.

Of the Jacobian only the blocks that are not zero are made, and of them only the normal equations are kept: time grows
with the blocks' number and not, as by a singular value decomposition of the whole, with the cube of the numbers'.
Numbers that no residual has in common with one another are eliminated before the rest is solved (Schur complement).

References
----------
B. Triggs, P. McLauchlan, R. Hartley, A. Fitzgibbon: Bundle adjustment, a modern synthesis. Vision algorithms 1999.
H. B. Nielsen: Damping parameter in Marquardt's method. Technical University of Denmark 1999.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from attrs import frozen

from mcsl_core.imaging.geometry import Array

_DAMPED = 1e-3  # of the normal equations' diagonal, at first
_MOST_DAMPED = 1e12
_FARTHEST = 1.0  # that a step goes in any number: for logarithms, radians and distances that are near 1
_STILL = 1e-8  # of the cost and of the numbers: a step that changes less is the last


class Blocks(Protocol):
    """What is minimised, in blocks of N residuals each."""

    def off(self, numbers: Array) -> Array:
        """(B N,): the residuals."""
        ...

    def slopes(self, numbers: Array) -> Iterable[tuple[list[int], Array]]:
        """B times the positions of the K numbers that a block depends on, and its derivatives by them (N, K)."""
        ...


@frozen(eq=False)
class _Normal:
    """The normal equations: `matrix` (P, P), the cost's `slope` (P,)."""

    matrix: Array
    slope: Array

    def step(self, damping: Array, shared: int, size: int) -> Array:
        """(P,): down the slope; the numbers after the first `shared` are blocks of `size` that no residual joins."""
        matrix = self.matrix + np.diag(damping)
        later = (len(matrix) - shared) // size
        corner, across = matrix[:shared, :shared], matrix[shared:, :shared].reshape(later, size, shared)
        at = np.arange(shared, len(matrix)).reshape(later, size)
        own = matrix[at[:, :, None], at[:, None, :]]
        known = np.concatenate([across, -self.slope[at][..., None]], axis=2)
        solved = np.linalg.solve(own, known)
        reduced = np.einsum("bij,bik->jk", across, solved)
        first = np.linalg.solve(corner - reduced[:, :shared], -self.slope[:shared] - reduced[:, shared])
        return np.concatenate([first, (solved[..., shared] - solved[..., :shared] @ first).ravel()])


def minimum(problem: Blocks, start: Array, scale: float, shared: int, size: int, most: int = 60) -> tuple[float, Array]:
    """The numbers of least cost near a start, by Levenberg and Marquardt's method.

    Parameters
    ----------
    problem : Blocks
        Whose residuals count by the loss 2 (sqrt(1 + r^2) - 1), scipy's ``soft_l1``.
    start : (P,) array
        Numbers to start from.
    scale : float
        The residual where the loss grows slower.
    shared : int
        How many of the numbers, the first, residuals may have in common with any others.
    size : int
        The others come in blocks of so many; no residual depends on two blocks.
    most : int
        Steps that are tried.

    Returns
    -------
    (float, (P,) array)
        The cost, and the numbers; those that residuals tell nothing of are where they started.

    Raises
    ------
    numpy.linalg.LinAlgError
        If no step can be worked out.
    """
    numbers, off = start, problem.off(start)
    cost, normal = _cost(off, scale), _normal(problem, start, off, scale)
    largest, damped, faster = np.diag(normal.matrix).copy(), _DAMPED, 2.0
    largest[largest == 0] = 1
    for _ in range(most):
        step = normal.step(damped * largest, shared, size)
        while np.abs(step).max() > _FARTHEST:
            damped *= 2
            step = normal.step(damped * largest, shared, size)
        with np.errstate(all="ignore"):  # a step too far costs without end, and is not taken
            off = problem.off(numbers + step)
        tried, hoped = _cost(off, scale), 0.5 * float(step @ (damped * largest * step - normal.slope))
        still = np.linalg.norm(step) < _STILL * (_STILL + np.linalg.norm(numbers))
        if tried < cost:
            gain = (cost - tried) / hoped
            still |= cost - tried < _STILL * cost and gain > 0.25
            numbers, cost = numbers + step, tried
            if still:
                break
            normal = _normal(problem, numbers, off, scale)
            largest = np.maximum(largest, np.diag(normal.matrix))
            damped, faster = damped * max(1 / 3, 1 - (2 * gain - 1) ** 3), 2.0
        elif still or damped > _MOST_DAMPED:
            break
        else:
            damped, faster = damped * faster, faster * 2
    return cost, numbers


def _cost(off: Array, scale: float) -> float:
    return float(scale**2 * np.sum(np.hypot(1, off / scale) - 1))


def _normal(problem: Blocks, numbers: Array, off: Array, scale: float) -> _Normal:
    """The loss bends as it grows slower, which the matrix is told (Triggs et al., section 4.3)."""
    weight = 1 / np.hypot(1, off / scale)
    pulled, bent = weight * off, weight**3
    matrix, slope, at = np.zeros((len(numbers), len(numbers))), np.zeros(len(numbers)), 0
    for columns, slopes in problem.slopes(numbers):
        rows = slice(at, at := at + len(slopes))
        matrix[np.ix_(columns, columns)] += slopes.T @ (bent[rows, None] * slopes)
        slope[columns] += slopes.T @ pulled[rows]
    return _Normal(matrix, slope)
