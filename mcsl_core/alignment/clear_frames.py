"""Clear frames (the paper's t_hom): at which samples no camera is occluded more than the others.

The paper's section "Occlusion-Free Frame Detection"; its kind marks the field by hue (OpenCV hue 0-30 and 150-179).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.masks import hue_mask

from .aligned_views import Picture


def degree_of_occlusion(areas: Sequence[float]) -> float:
    """DOO = (max S - min S) / mean S over the cameras' field areas (the paper's equation for d_DOO).

    0: all cameras see the same area. NaN where fewer than two cameras or no camera shows any field: no data, not 0.
    """
    if len(areas) < 2 or (mean := sum(areas) / len(areas)) <= 0:
        return math.nan
    return (max(areas) - min(areas)) / mean


def field_area(picture: Picture) -> float:
    """S: the share of the BGR picture that has the field's hue, 0..1."""
    return float(np.count_nonzero(hue_mask(picture)) / (picture.shape[0] * picture.shape[1]))


@frozen
class ClearFrames:
    """Which samples are clear enough to solve homographies from (t_hom).

    threshold: DOO below it is clear (0.5 in the paper), ``run`` times in a row. wanted: so many are taken, one from
    each of as many equal stretches of the pose: hands and heads that rest in one have moved on in the next. (Three
    clear samples next to each other gave 1.8 times the best plane's error, twelve spread ones 1.1.)
    """

    threshold: float = field(default=0.5)
    run: int = field(default=3)
    wanted: int = field(default=12)

    def choose(self, doo: NDArray[np.float64]) -> tuple[NDArray[np.int64], bool]:
        """(rising indices into ``doo``, whether most of them are clear by the paper's rule)."""
        clear = np.nan_to_num(doo, nan=np.inf) < self.threshold
        # A run of `run` or more clear samples: opening the sequence with a window of that length.
        in_run = np.zeros(len(clear), bool)
        for start in range(len(clear) - self.run + 1):
            if clear[start : start + self.run].all():
                in_run[start : start + self.run] = True
        cost = np.nan_to_num(doo, nan=1e3) + np.where(in_run, 0, 1e4)
        stretches = np.array_split(np.arange(len(doo)), min(self.wanted, max(len(doo), 1)))
        chosen = np.array([part[np.argmin(cost[part])] for part in stretches if len(part)], np.int64)
        return chosen, bool(len(chosen)) and bool(in_run[chosen].mean() > 0.5)
