"""A pose's scene tied to that of a pose before: one projective transformation of space, by all cameras together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import scipy
from attrs import frozen

from mcsl_core.imaging.geometry import Array, project, scaling, size_at_columns, transform_points
from mcsl_core.imaging.masks import Mask
from mcsl_core.imaging.relief import between_nodes

from ..dense_matching import AlignedCamera, DenseSettings, match_densely, pixels_of
from .matching import BY_PLANE, BY_RELIEF, WIDTH
from .protocol import ReliefCamera, ReliefScene, ReliefSurface

_SCALES = ((6 / 960, 1 / 960), (1 / 960,))  # widths; of each round's loss
_LEAST = 400  # matches of all cameras
# How far matches may lie off, median, of the width: laid by planes 12 px off, optical flow errs by a pixel that is gone
# in the second round.
_FITS = (3.0 / 960, 1.0 / 960)
_TIES = 0.3  # confidence of the surface from which it ties: where it has less it may be the plane, and not the scene


def tie_scene(before: ReliefScene, surface: ReliefSurface, own: ReliefScene, to_own: Array) -> Array | None:
    """How one scene lies in another.

    Parameters
    ----------
    before : ReliefScene
        Of the pose that began the perspective, over the programme's pixels.
    surface : ReliefSurface
        Its surface.
    own : ReliefScene
        This pose's, over pixels of its own; the same cameras by the same names.
    to_own : (4, 4) array
        Programme pixel and gamma -> own pixel and gamma, by the plane, to some 5 % of a diagonal.

    Returns
    -------
    (4, 4) array or None
        The same by the relief; None where too little of the scene is seen in both.

    Notes
    -----
    Two scenes that cameras alone have found differ by a projective transformation of space, 15 numbers. A camera's view
    before, laid by its relief, says where the scene point lies; its view now says where that is seen: laid by the plane
    first, by the relief then.
    """
    grid = _Grid.over(before, surface)
    names = [name for name in own.cameras if name in before.cameras]
    laid = {name: transform_points(own.cameras[name].plane, grid.scene[:, :2]) for name in names}
    found: Array | None = None
    for settings, scales, fits in zip((BY_PLANE, BY_RELIEF), _SCALES, _FITS, strict=True):
        matches = {name: grid.matched(before.cameras[name], own.cameras[name], laid[name], settings) for name in names}
        if sum(len(seen) for _, seen in matches.values()) < _LEAST:
            return None
        found = _fitted(matches, own, to_own if found is None else found, scales, fits)
        if found is None:
            return None
        laid = {name: project(own.cameras[name].projection @ found, grid.scene) for name in names}
    return found


@frozen(eq=False)
class _Grid:
    """The scene before at every pixel of the reduced programme picture.

    size: its width and height. full: the programme's. scene: (H * W, 3), programme pixels and gamma. known: (H, W),
    where the surface is.
    """

    size: tuple[int, int]
    full: tuple[int, int]
    scene: Array
    known: Mask

    @classmethod
    def over(cls, before: ReliefScene, surface: ReliefSurface) -> _Grid:
        size = size_at_columns(before.size, WIDTH)
        pixels = transform_points(scaling(size, before.size), pixels_of(size))
        nodes = np.stack([surface.gamma, surface.confidence], axis=-1)
        gamma, confidence = between_nodes(nodes, before.size, pixels).T
        known = (confidence > _TIES).reshape(size[::-1])
        return cls(size, before.size, np.column_stack([pixels, gamma]), known)

    def matched(
        self, then: ReliefCamera, now: ReliefCamera, laid: Array, settings: DenseSettings
    ) -> tuple[Array, Array]:
        """((N, 3) scene points, (N, 2) where the camera, laid so, sees them now)."""
        shape = (self.size[1], self.size[0], 2)
        pictures = []
        for camera, at in ((then, project(then.projection, self.scene)), (now, laid)):
            view = camera.views[0]
            reduced = scaling(camera.size, (view.picture.shape[1], view.picture.shape[0]))
            x, y = transform_points(reduced, at).astype(np.float32).T.reshape(2, *shape[:2])
            steady = cv2.remap(view.steady.view(np.uint8), x, y, cv2.INTER_NEAREST) > 0
            pictures.append((cv2.remap(view.picture, x, y, cv2.INTER_LINEAR), steady))
        own = self.scene[:, :2].reshape(shape).astype(np.float32)
        cameras = {
            key: AlignedCamera([picture], own, self.full, [steady])
            for key, (picture, steady) in zip(("then", "now"), pictures, strict=True)
        }
        matches = match_densely(cameras, self.known, settings).get(("then", "now"))
        if matches is None:
            return np.zeros((0, 3)), np.zeros((0, 2))
        from_full = scaling(self.full, self.size)
        x, y = np.round(transform_points(from_full, matches.a)).astype(int).T
        to = transform_points(from_full, matches.b).astype(np.float32)
        at = laid.reshape(shape).astype(np.float32)
        seen = cv2.remap(at, to[None, :, 0], to[None, :, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0]
        return self.scene.reshape(*shape[:2], 3)[y, x], seen.astype(np.float64)


def _fitted(
    matches: Mapping[str, tuple[Array, Array]], own: ReliefScene, start: Array, scales: Sequence[float], fits: float
) -> Array | None:
    """The transformation by all matches, in widths of the cameras; None where their median is ``fits`` off or more."""
    middle = np.concatenate([points for points, _ in matches.values()])
    wide = np.abs(np.insert(middle, 2, 1.0, axis=1)).mean(axis=0) + 1e-12
    numbers = (start / start[2, 2] * wide).ravel()
    fixed = 10  # of the 16 numbers: [2, 2]

    def moved(x: Array) -> Array:
        return np.insert(x, fixed, numbers[fixed]).reshape(4, 4) / wide

    def off(x: Array) -> Array:
        to_own = moved(x)
        parts = []
        for name, (points, seen) in matches.items():
            if len(points):
                camera = own.cameras[name]
                parts.append((project(camera.projection @ to_own, points) - seen).ravel() / camera.size[0])
        return np.concatenate(parts)

    x = np.delete(numbers, fixed)
    for scale in scales:
        x = scipy.optimize.least_squares(off, x, loss="cauchy", f_scale=scale, x_scale="jac", max_nfev=40).x
    left = np.hypot(*off(x).reshape(-1, 2).T)
    return moved(x) if np.median(left) < fits else None
