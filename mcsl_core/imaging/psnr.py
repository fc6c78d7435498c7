"""Peak signal-to-noise ratio of two pictures."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def psnr(a: NDArray, b: NDArray, mask: NDArray | None = None) -> float:
    """Peak signal-to-noise ratio in dB of two 8-bit pictures of one shape; infinite when they are equal.

    mask: (H, W), only pixels where it is non-zero count.
    """
    if a.shape != b.shape:
        raise ValueError(f"pictures of different shape: {a.shape} and {b.shape}")
    difference = a.astype(np.float64) - b
    if mask is not None:
        difference = difference[mask != 0]
    error = float(np.mean(difference**2)) if difference.size else math.nan
    return math.inf if error == 0 else 10 * math.log10(255**2 / error)
