"""Semi-global matching (Hirschmueller 2008): the levels of a cost volume that fit their neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Volume = NDArray[np.float32]


def aggregated(cost: Volume, *, step: float, jump: float) -> Volume:
    """Sums the cheapest paths that lead to every pixel from left, right, above and below.

    Parameters
    ----------
    cost : (levels, H, W) float32 array
        Of every level at every pixel.
    step : float
        What a step to the next level costs.
    jump : float
        What any larger one does.

    Returns
    -------
    (levels, H, W) float32 array
        Over the four paths.
    """
    by_rows = np.ascontiguousarray(cost.transpose(1, 0, 2))
    by_columns = np.ascontiguousarray(cost.transpose(2, 0, 1))
    total = (_along(by_rows, step, jump) + _along(by_rows[::-1], step, jump)[::-1]).transpose(1, 0, 2)
    sideways = _along(by_columns, step, jump) + _along(by_columns[::-1], step, jump)[::-1]
    return np.ascontiguousarray(total + sideways.transpose(1, 2, 0), np.float32)


def _along(cost: Volume, step: float, jump: float) -> Volume:
    """(N, levels, M): the paths along the first axis, all M at once."""
    out = np.empty_like(cost)
    before = out[0] = cost[0]
    for n in range(1, len(cost)):
        least = before.min(axis=0)
        best = np.minimum(before, least + np.float32(jump))
        nearer = before + np.float32(step)
        np.minimum(best[1:], nearer[:-1], out=best[1:])
        np.minimum(best[:-1], nearer[1:], out=best[:-1])
        best -= least
        np.add(best, cost[n], out=out[n])
        before = out[n]
    return out
