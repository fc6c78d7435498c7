"""From the pooled matches of camera pairs to tracks: places that several cameras see. Pixels are full-size."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import evolve, field, frozen
from numpy.typing import NDArray

from mcsl_core.hooks import Correspondences

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

CELL_PX = 4.0  # matches within one cell are one place


@frozen
class CalibrationSettings:
    """Lengths in fractions of the picture's diagonal, so that they fit every size.

    focal_per_width: the focal lengths begun with, over the picture's width: views of 37, 53 and 26 degrees. off_line:
    how far a true match may lie off its epipolar line (2 px at 960x540). off_place: how far an observation may lie off
    its calibrated place. off_plane: how far matches may lie off the field's plane: more than any relief shifts them.
    """

    focal_per_width: tuple[float, ...] = field(default=(1.5, 1.0, 2.2))
    off_line: float = field(default=0.0018)
    off_place: float = field(default=0.004)
    off_plane: float = field(default=0.02)
    min_places: int = field(default=16)
    min_spread: float = field(default=0.015)  # share of the picture that a camera's places must span


@frozen(eq=False)
class Tracks:
    """What the cameras see of P places. camera, place: (M,) numbers; points: (M, 2) pixels, one a camera and place.

    weight: (P,), the matches' weight: that of the surgical field counts, that of the drapes hardly.
    """

    camera: Numbers
    place: Numbers
    points: Array
    weight: Array

    def of(self, camera: int) -> tuple[Numbers, Array]:
        """(places, points) that a camera sees."""
        own = self.camera == camera
        return self.place[own], self.points[own]

    def where(self, keep: NDArray[np.bool_]) -> Tracks:
        """Some of the observations; places that fewer than two cameras see then go too."""
        places = self.place[keep]
        lasting = np.bincount(places, minlength=len(self.weight)) >= 2
        keep = keep & lasting[self.place]
        return evolve(self, camera=self.camera[keep], place=self.place[keep], points=self.points[keep])


def true_matches(pair: Correspondences, diagonal: float, settings: CalibrationSettings) -> Correspondences | None:
    """The matches that obey one epipolar geometry; None when they are too few to tie two cameras."""
    import pycolmap  # see the package's docstring

    if len(pair) < settings.min_places:
        return None
    options = pycolmap.RANSACOptions(max_error=settings.off_line * diagonal, random_seed=0, max_num_trials=20000)
    found = pycolmap.estimate_fundamental_matrix(pair.a, pair.b, options)
    if found is None:
        return None
    kept = pair.where(np.asarray(found["inlier_mask"], bool))
    return kept if len(kept) >= settings.min_places else None


def build_tracks(pairs: Mapping[tuple[int, int], Correspondences]) -> Tracks:
    """Chains matches by the cells they share, strongest first; a chain never holds two cells of one camera."""
    rows = [
        (-float(weight), a, b, tuple(xa), tuple(xb))
        for (a, b), pair in sorted(pairs.items())
        for xa, xb, weight in zip(pair.a.tolist(), pair.b.tolist(), pair.weight, strict=True)
    ]
    chain_of: dict[tuple[int, int, int], int] = {}
    chains: dict[int, dict[int, tuple[int, int, int]]] = {}
    seen: dict[tuple[int, int, int], list[tuple[float, float]]] = {}
    weights: dict[int, float] = {}
    for minus, a, b, xa, xb in sorted(rows):
        ends = [(camera, int(x[0] // CELL_PX), int(x[1] // CELL_PX)) for camera, x in ((a, xa), (b, xb))]
        for end in ends:
            if end not in chain_of:
                chain_of[end] = len(chain_of)
                chains[chain_of[end]] = {end[0]: end}
                seen[end], weights[chain_of[end]] = [], 0.0
        one, other = (chain_of[end] for end in ends)
        if one != other:
            if chains[one].keys() & chains[other].keys():
                continue
            for end in chains.pop(other).values():
                chain_of[end] = one
                chains[one][end[0]] = end
            weights[one] = max(weights[one], weights.pop(other))
        weights[one] = max(weights[one], -minus)
        for end, x in zip(ends, (xa, xb), strict=True):
            seen[end].append(x)
    camera, place, points, weight = [], [], [], []
    for number, chain in sorted(chains.items()):
        if len(chain) < 2:
            continue
        for name, end in sorted(chain.items()):
            camera.append(name)
            place.append(len(weight))
            points.append(np.mean(seen[end], axis=0))
        weight.append(weights[number])
    return Tracks(
        np.array(camera, np.int64), np.array(place, np.int64), np.array(points).reshape(-1, 2), np.array(weight)
    )
