"""What is in the way: clear frames for solving, and the visible share of the surgical field for choosing.

The paper's kind marks the field by hue (OpenCV hue 0-30 and 150-179), section "Occlusion-Free Frame Detection".
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .images import hue_mask
from .scene import Mask, Picture, Scene, View


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


def field_from_hue(pictures: Sequence[Picture]) -> Mask:
    """(h, w) bool: where most of a still camera's pictures have the field's hue, its main region only."""
    votes = np.mean([hue_mask(p) > 0 for p in pictures], axis=0)
    return main_region(votes > 0.5)


def main_region(mask: Mask, *, least: float = 0.004) -> Mask:
    """The largest connected region and those at least a fifth as large, closed; empty if below ``least`` of all."""
    size = max(3, round(0.012 * mask.shape[1]) | 1)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel)
    closed = cv2.morphologyEx(closed, cv2.MORPH_CLOSE, kernel)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(closed)
    if count < 2:
        return np.zeros(mask.shape, bool)
    areas = stats[1:, cv2.CC_STAT_AREA]
    if areas.max() < least * mask.size:
        return np.zeros(mask.shape, bool)
    keep = np.flatnonzero(areas >= max(areas.max() / 5, least * mask.size)) + 1
    return np.isin(labels, keep)


@frozen
class HueArea:
    """The paper's kind of score: the share of the field's pixels that have the field's hue in that view.

    Blind to what has the field's own colour (a bare hand, a face); see `consensus` for the one that is not.
    """

    name = "hue-area"

    def scorer(self, scene: Scene, moments: Sequence[Sequence[View]]) -> HueScorer:
        """A scorer for a pose; ``moments`` are not needed."""
        return HueScorer(scene.field)


@frozen(eq=False)
class HueScorer:
    """Scores the moments of one pose."""

    field: Mask

    def score(self, views: Sequence[View]) -> Mapping[str, float]:
        """camera -> visible share of the field, 0..1."""
        area = max(int(self.field.sum()), 1)
        return {
            view.camera: float(np.count_nonzero((hue_mask(view.aligned) > 0) & self.field & view.inside)) / area
            for view in views
        }
