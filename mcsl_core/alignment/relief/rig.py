"""The rig is rigid: how its cameras lie to each other in one pose says how they lie in another.

Projections are known but for the plane and the scale of gamma, so a pose's are another's but for four numbers:
``P' = P [[I, 0], [m, s]]``, each up to a factor. Those are fitted to the cameras that both poses know well, and tell
where a camera lies that a head hid all the while. A zoom in between does not fit, and nothing is told.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mcsl_core.imaging.geometry import Array, project

_FITS = 1.5 / 960  # of the width: medians of the cameras that both know. A zoom of 1 % leaves 2 px of 960
_LEAST = 2  # cameras beside the reference


def moved_rig(
    known: Mapping[str, Array],
    sure: Mapping[str, Array],
    points: Array,
    reference: str,
    sizes: Mapping[str, tuple[int, int]],
) -> dict[str, Array] | None:
    """The projections of one pose in terms of another's.

    Parameters
    ----------
    known : mapping of str to (3, 4) array
        Camera -> its projection in a pose that knows them all.
    sure : mapping of str to (3, 4) array
        Camera -> its projection in this pose, of those that can be relied on.
    points : (N, 3) array
        This pose's scene points: full-size reference pixels and gamma.
    reference : str
        The reference camera.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.

    Returns
    -------
    dict of str to (3, 4) array or None
        ``known``, each camera of it, over this pose's plane and scale. None where fewer than two cameras are common, or
        the rig does not fit them.
    """
    common = sorted((known.keys() & sure.keys()) - {reference})
    if len(common) < _LEAST or len(points) < 10:
        return None
    scene = np.column_stack([points[:, :2], np.ones(len(points)), points[:, 2]])
    scale = np.abs(scene).mean(axis=0) + 1e-12
    moved, off = dict(known), np.zeros((len(common), len(points)))
    for _ in range(8):
        weight = 1 / (1 + (off / _FITS) ** 2) ** 2
        rows, right = [], []
        for own, name in zip(weight, common, strict=True):
            a, b = _linear(known[name], project(sure[name], points), scene / scale, scene[:, :3])
            size = np.sqrt(own)[:, None] / sizes[name][0]
            rows.append((a * size[..., None]).reshape(-1, 4))
            right.append((b * size).ravel())
        numbers = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0] / scale
        moved = {name: _moved(projection, numbers) for name, projection in known.items()}
        apart = [(project(moved[n], points) - project(sure[n], points)) / sizes[n][0] for n in common]
        off = np.linalg.norm(np.stack(apart), axis=2)
    return None if np.median(off, axis=1).max() > _FITS else moved


def _linear(projection: Array, seen: Array, scene: Array, pixels: Array) -> tuple[Array, Array]:
    """What the four numbers must fulfil, ((N, 2, 4), (N, 2)): A x + t (numbers . scene) lies where it is seen."""
    base = pixels @ projection[:, :3].T
    t = projection[:, 3]
    depth = base[:, 2]
    along = (t[:2] - seen * t[2]) / depth[:, None]
    return along[..., None] * scene[:, None], seen - base[:, :2] / depth[:, None]


def _moved(projection: Array, numbers: Array) -> Array:
    own = np.column_stack([projection[:, :3] + np.outer(projection[:, 3], numbers[:3]), projection[:, 3] * numbers[3]])
    return own / own[2, 2]
