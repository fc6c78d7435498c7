"""Whether a surface serves a camera at least as well as its plane: by what the pictures look like, laid by either."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from .cost_volume import Field, SweptCamera

_BLOCK = 9  # working pixels of some 240 columns
_CONTRAST = 3.0  # grey levels: least standard deviation of a block that is compared
_SHOWN = 0.9  # share of a block that must be steady in both pictures
_ENOUGH = 20  # blocks that a camera is judged by, at least
# A camera is served worse if its mean gain in correlation lies so many standard errors below 0, and so far at least.
_WORSE, _CLEARLY = 3.0, 0.01


def unserved(cameras: Mapping[str, SweptCamera], gamma: Field) -> str | None:
    """The camera that the surface serves worst, if worse than its plane.

    Parameters
    ----------
    cameras : mapping of str to SweptCamera
        For the working pixels of ``gamma``.
    gamma : (H, W) float32 array
        The surface.

    Returns
    -------
    str or None
        None where all are served, or cannot be judged.

    Notes
    -----
    By blocks: the mean gain in zero-mean normalised cross-correlation with the other cameras.
    """
    by_surface = {name: _commonest(camera, gamma, camera.projection) for name, camera in cameras.items()}
    by_plane = {name: _commonest(camera, np.zeros_like(gamma), camera.plane) for name, camera in cameras.items()}
    gains: dict[str, list[NDArray[np.float32]]] = {name: [] for name in cameras}
    for a, b in combinations(cameras, 2):
        found, could = _correlation(by_surface[a], by_surface[b])
        before, could_before = _correlation(by_plane[a], by_plane[b])
        gain = (found - before)[could & could_before]
        gains[a].append(gain)
        gains[b].append(gain)
    judged = {name: np.concatenate(own) for name, own in gains.items() if sum(map(len, own)) >= _ENOUGH}
    # Neighbouring blocks and pairs say much the same: four of them count for one.
    sure = {name: g.mean() / (2 * g.std() / np.sqrt(len(g)) + 1e-9) for name, g in judged.items()}
    worse = [name for name, g in judged.items() if g.mean() < -_CLEARLY and sure[name] < -_WORSE]
    return min(worse, key=lambda name: judged[name].mean()) if worse else None


def _commonest(camera: SweptCamera, gamma: Field, matrix: Field) -> tuple[Field, Field]:
    """A camera's picture, the mean of its views by weight, and 1 where there is any."""
    pictures, weights = camera.laid(gamma, matrix)
    total = weights.sum(axis=0, dtype=np.float32)
    mean = (pictures * weights.astype(np.float32)).sum(axis=0) / np.maximum(total, 1)
    return mean, (total > 0).astype(np.float32)


def _correlation(a: tuple[Field, Field], b: tuple[Field, Field]) -> tuple[Field, NDArray[np.bool_]]:
    """Per block the correlation of two pictures, and whether both show enough there to compare."""
    (p, shown_p), (q, shown_q) = a, b

    def mean(values: Field) -> Field:
        blocks = cv2.blur(values, (_BLOCK, _BLOCK))
        return np.asarray(blocks, np.float32)[_BLOCK // 2 :: _BLOCK, _BLOCK // 2 :: _BLOCK]

    mean_p, mean_q = mean(p), mean(q)
    spread_p = np.sqrt(np.maximum(mean(p * p) - mean_p**2, 0))
    spread_q = np.sqrt(np.maximum(mean(q * q) - mean_q**2, 0))
    alike = (mean(p * q) - mean_p * mean_q) / np.maximum(spread_p * spread_q, 1e-6)
    comparable = (mean(shown_p * shown_q) > _SHOWN) & (np.minimum(spread_p, spread_q) > _CONTRAST)
    return alike.astype(np.float32), comparable
