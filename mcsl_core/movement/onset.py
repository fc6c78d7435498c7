"""Onset of a curve: the instant at which a lamp begins to move or, backwards in time, comes to rest.

A lamp that is pushed eases in: half a second after the start of a slow turn it has moved a tenth of a pixel. So the
start is not where the displacement is seen, but where the curve that is seen later comes from.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POWERS = {1.0: 0.0, 1.5: 0.0, 2.0: 0.0, 3.0: 6.0}
"""How displacement may grow after the start: evenly, or from rest by a force that comes at once or rises. The value is
by how much, in squared noise, it must explain the curve better than the others: a square with noise passes for a cube
that begins 0.4 s sooner."""
SIGNIFICANT = 25.0
"""By how much, in squared noise, growth must explain the curve better than rest does."""


def onset(times: Array, curve: Array, *, noise: float) -> float:
    """The instant at which ``curve``, at rest before, begins to grow.

    Parameters
    ----------
    times
        (N,), rising.
    curve
        (N,) displacement in pixels, NaN where there is no data.
    noise
        Standard deviation of the curve, pixels.

    Returns
    -------
    float
        On the scale of ``times``; the last of them where ``noise`` explains the growth.

    Notes
    -----
    Fitted by least squares is b + a (t - t0)^p after t0 and b before, for t0 over all instants and p of `POWERS`; no
    simulated or real profile is assumed.
    """
    known = ~np.isnan(curve)
    t, d = times[known], curve[known]
    if len(t) < 2:
        return float(times[-1])
    # Every displacement counts by its own size too: what is large is known to a tenth of it (parallax, a new light).
    weight = 1 / (noise**2 + (0.05 * d) ** 2)
    flat = float((weight * (d - np.average(d, weights=weight)) ** 2).sum())
    best = (flat - SIGNIFICANT, float(times[-1]))
    for start in np.linspace(t[0] - (t[-1] - t[0]) * 0.25, t[-1], 4 * len(t) + 1)[:-1]:
        for power, price in POWERS.items():
            grown = np.maximum(t - start, 0.0) ** power
            mean_g, mean_d = np.average(grown, weights=weight), np.average(d, weights=weight)
            spread = float((weight * (grown - mean_g) ** 2).sum())
            if spread <= 0:
                continue
            slope = float((weight * (grown - mean_g) * (d - mean_d)).sum()) / spread
            if slope <= 0:
                continue
            left = float((weight * (d - mean_d - slope * (grown - mean_g)) ** 2).sum()) + price
            if left < best[0] - 1e-9:
                best = (left, float(start))
    return best[1]
