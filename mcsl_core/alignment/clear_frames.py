"""Clear frames (the paper's t_hom): at which samples no camera is occluded more than the others.

The paper's kind marks the field by hue (OpenCV hue 0-30 and 150-179).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.masks import hue_mask

from .aligned_views import Picture


@frozen
class ClearFrames:
    """Which samples are clear enough to solve homographies from (t_hom).

    Attributes
    ----------
    threshold : float
        A sample is clear where its degree of occlusion lies below (the paper's tau_DOO, 0.5) ...
    run : int
        ... so many times in a row (the paper's n).
    wanted : int
        How many samples are taken, one from each of as many equal parts of the pose.

    Notes
    -----
    Hands and heads that rest in one part have moved on in the next. Three clear samples next to each other gave 1.8
    times the best plane's error, twelve spread ones 1.1.

    References
    ----------
    The paper's section "Occlusion-Free Frame Detection".
    """

    threshold: float = field(default=0.5)
    run: int = field(default=3)
    wanted: int = field(default=12)

    def choose(self, doo: NDArray[np.float64]) -> tuple[NDArray[np.int64], bool]:
        """Chooses among the samples of a pose.

        Parameters
        ----------
        doo : (N,) float array
            The degree of occlusion of each sample in order of time, 0 or more, NaN where it is not known.

        Returns
        -------
        chosen : (M,) int array
            Rising indices into ``doo``; M is the lesser of N and ``wanted``.
        clear : bool
            Whether most of them are clear by the paper's rule.
        """
        clear = np.nan_to_num(doo, nan=np.inf) < self.threshold
        in_run = np.zeros(len(clear), bool)  # in a run of `run` or more clear samples
        for start in range(len(clear) - self.run + 1):
            if clear[start : start + self.run].all():
                in_run[start : start + self.run] = True
        cost = np.nan_to_num(doo, nan=1e3) + np.where(in_run, 0, 1e4)
        parts = np.array_split(np.arange(len(doo)), min(self.wanted, max(len(doo), 1)))
        chosen = np.array([part[np.argmin(cost[part])] for part in parts if len(part)], np.int64)
        return chosen, bool(len(chosen)) and bool(in_run[chosen].mean() > 0.5)


def degree_of_occlusion(areas: Sequence[float]) -> float:
    """The degree of occlusion (DOO) of one sample: how differently much of the field the cameras show.

    Parameters
    ----------
    areas : sequence of float
        Every camera's field area S, in any unit.

    Returns
    -------
    float
        (max S - min S) / mean S: 0 where all cameras see the same area. NaN, no data and not 0, where there are fewer
        than two cameras or none shows any field.

    References
    ----------
    The paper's equation for d_DOO, in "Occlusion-Free Frame Detection".
    """
    if len(areas) < 2:
        return math.nan
    mean = sum(areas) / len(areas)
    return (max(areas) - min(areas)) / mean if mean > 0 else math.nan


def field_area(picture: Picture) -> float:
    """The field area S of one picture.

    Parameters
    ----------
    picture : (H, W, 3) uint8 array
        BGR.

    Returns
    -------
    float
        The share of the picture that has the field's hue, 0..1.
    """
    return float(np.count_nonzero(hue_mask(picture)) / (picture.shape[0] * picture.shape[1]))
