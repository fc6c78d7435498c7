"""The field's own surface, for the plane that serves it best: near its points theirs, elsewhere a smooth bend's.

A limb falls away where no match reaches, under a head's edge or an arm's shadow: carried on level, its sides were 20 px
off and the planes twice the best one's error. Heights are parallax in pixels of 960, of the camera that gamma moves
most, towards the cameras.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array, project
from mcsl_core.imaging.masks import Mask, mask_at

from .interpolation import gamma_map

# What fields do over their own radius, standard deviations of tilt and bend, against points that say as much as
# _INDEPENDENT of a noise of _NOISE: without that, what lies beyond the points is anything.
_TILT, _BEND, _NOISE, _INDEPENDENT = 60.0, 25.0, 3.0, 30
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
_LOWER = 0.25  # of the points below the bend that it starts from: hands stand above the field
_OFF = 10.0  # how far off the bend a point still counts, nearly
_ABOVE, _MOST_OFF = 15.0, 30.0  # what stands so high above it is a hand, however high
_LEAST = 20  # points, with fewer the field's surface is that of its surroundings
# How much of the points' heights the bend must say before it is believed where there are none. Of limbs it says 0.5 to
# 0.8; of an open wound 0.2, and carried on from there planes went from 1.02 to 4 times the best one's error.
_SAYS_NOTHING, _SAYS_ALL = 0.35, 0.45
_AGREED = 0.5  # of the cameras' leaning, by sum over the sum of sizes: once it was 0.36, and the sign wrong; else 0.57


def height_of_gamma(projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]], at: Array) -> float:
    """How high gamma 1 stands above gamma 0 at a reference pixel.

    Parameters
    ----------
    projections : mapping of str to (3, 4) array
        The reference's first.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    at : (2,) array
        Full-size reference pixel.

    Returns
    -------
    float
        In pixels of 960, of the camera that it moves most; negative where gamma falls towards the cameras.

    Notes
    -----
    The images alone do not tell which way is up. But a lamp's cameras lean towards each other: each has the reference
    in front of it, and there gamma is infinite. So depth grows with gamma if gamma rises towards the cameras.
    """
    _, *others = projections
    ends = np.array([[*at, 0.0], [*at, 1e-3]])
    moved = (float(np.hypot(*np.diff(project(projections[n], ends), axis=0)[0])) / sizes[n][0] for n in others)
    high = max(moved) / 1e-3 * 960
    return high if sum(_leaning(projections, sizes)) > 0 else -high


def knows_up(projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]) -> bool:
    """Whether two cameras or more agree about the sign of `height_of_gamma`; parameters as it has them."""
    leaning = _leaning(projections, sizes)
    return len(leaning) > 1 and 0 < _AGREED * sum(map(abs, leaning)) <= abs(sum(leaning))


def _leaning(projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]) -> list[float]:
    """Of every camera but the reference: above 0 where gamma rises towards the cameras."""
    _, *others = projections.items()
    return [float(p[2, 3] / np.linalg.norm(p[:2, 3])) * sizes[name][0] for name, p in others]


def field_gamma(points: Array, field: Mask, height: float) -> NDArray[np.float32]:
    """Gamma all over a picture, for its field.

    Parameters
    ----------
    points : (N, 3) array
        x and y in pixels of the picture, and gamma; one at least.
    field : (H, W) bool array
        Where the field lies.
    height : float
        Pixels of 960 that gamma 1 stands above gamma 0; see `height_of_gamma`.

    Returns
    -------
    (H, W) float32 array
        That of all points where the field has few of its own, or no bend says how they lie.
    """
    size = (field.shape[1], field.shape[0])
    own = points[mask_at(field, points[:, :2])]
    if len(own) < _LEAST:
        return gamma_map(points, size)
    rows, columns = np.nonzero(field)
    middle, radius = np.array([columns.mean(), rows.mean()]), float(np.sqrt(field.sum() / np.pi))
    heights = own[:, 2] * height
    bend = _bend((own[:, :2] - middle) / radius, heights)
    left = heights - _terms((own[:, :2] - middle) / radius) @ bend
    without = max(float(np.abs(heights - np.median(heights)).mean()), 1e-9)
    said = 1 - float(np.minimum(np.abs(left), _MOST_OFF).mean()) / without
    share = float(np.clip((said - _SAYS_NOTHING) / (_SAYS_ALL - _SAYS_NOTHING), 0, 1))
    level = gamma_map(points, size)
    low = left < _ABOVE
    if not share or not low.any():
        return level
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    base = _terms((np.stack([x, y], axis=-1) - middle) / radius) @ bend
    around = gamma_map(np.column_stack([own[low, :2], left[low]]), size, far=0.0)
    return (share * (base + around) / height + (1 - share) * level).astype(np.float32)


def _terms(places: Array) -> Array:
    """(..., 6)"""
    return np.stack([places[..., 0] ** i * places[..., 1] ** j for i, j in _POWERS], axis=-1)


def _bend(places: Array, heights: Array) -> Array:
    """(6,): of the terms, by most of the points; places in radii of the field."""
    terms = _terms(places)
    held = np.diag([{0: 1e-6, 1: _TILT**-2, 2: _BEND**-2}[i + j] for i, j in _POWERS])
    share = min(1.0, _INDEPENDENT / len(heights)) / _NOISE**2
    weight, bend = np.ones(len(heights)), np.zeros(len(_POWERS))

    def solved() -> Array:
        weighed = terms.T * (share * weight)
        return np.asarray(np.linalg.solve(weighed @ terms + held, weighed @ heights), np.float64)

    for _ in range(30):  # the lower quantile
        bend = solved()
        off = heights - terms @ bend
        weight = np.where(off > 0, _LOWER, 1 - _LOWER) * _NOISE / np.maximum(np.abs(off), 2.0)
    for narrower in (4, 3, 2, 1.5, 1, 1, 1, 1):  # Geman and McClure's loss
        weight = 1 / (1 + ((heights - terms @ bend) / (narrower * _OFF)) ** 2) ** 2
        bend = solved()
    return bend
