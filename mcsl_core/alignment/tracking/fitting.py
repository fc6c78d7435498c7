"""Where the lamp stands, from places of the background that its cameras see at one instant: robust least squares."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from attrs import frozen

from mcsl_core.imaging.geometry import Array, project

from .lamp import LampView

_SCALES = (16.0 / 960, 8.0 / 960, 4.0 / 960, 2.0 / 960, 1.0 / 960, 1.0 / 960)  # of the loss, of the width, in turn
_STEP = 1e-5  # of numbers, for derivatives
_HELD = 0.01  # standard deviation of each number about what was foreseen: for what the places do not tell
_INLIER = 3.0 / 960  # of the width

Project = Callable[[str, LampView], Array]


@frozen(eq=False)
class Sighting:
    """What one camera sees at an instant.

    Attributes
    ----------
    camera : str
        Its name.
    width : int
        Of its full-size picture.
    scene : (N, 3) array
        Scene points.
    seen : (N, 2) array
        Where it sees them, full-size pixels; some of them wrong.
    """

    camera: str
    width: int
    scene: Array
    seen: Array


@frozen(eq=False)
class Fit:
    """Where the lamp stands.

    Attributes
    ----------
    view : LampView
        Where.
    inliers : int
        How many places of all cameras agree with it.
    share : float
        0..1, of all.
    """

    view: LampView
    inliers: int
    share: float


def fit_view(sightings: Sequence[Sighting], projection: Project, foreseen: LampView) -> Fit:
    """The lamp's place and zoom at one instant.

    Parameters
    ----------
    sightings : sequence of Sighting
        Of its cameras.
    projection : callable
        Camera and view -> (3, 4), how the camera sees then.
    foreseen : LampView
        About where it stands.

    Notes
    -----
    Geman and McClure's loss, its scale narrowed from 16 to 1 pixel of 960; each camera weighs by its places.
    """
    numbers, start = foreseen.numbers, foreseen.numbers
    if not any(len(s.scene) for s in sightings):
        return Fit(foreseen, 0, 0.0)
    for scale in _SCALES:
        off = _off(sightings, projection, numbers)
        weight = 1 / (1 + (np.hypot(*off.T) / scale) ** 2) ** 2
        slopes = np.stack(
            [(_off(sightings, projection, numbers + _STEP * way) - off) / _STEP for way in np.eye(7)], axis=-1
        )
        a = np.einsum("n,nik,nil->kl", weight, slopes, slopes) / scale**2
        b = np.einsum("n,nik,ni->k", weight, slopes, off) / scale**2
        held = np.eye(7) / _HELD**2
        numbers = numbers - np.linalg.solve(a + held, b + held @ (numbers - start))
    left = np.hypot(*_off(sightings, projection, numbers).T)
    inliers = int((left < _INLIER).sum())
    return Fit(LampView.of(numbers), inliers, inliers / len(left))


def _off(sightings: Sequence[Sighting], projection: Project, numbers: Array) -> Array:
    """(N, 2), widths."""
    view = LampView.of(numbers)
    return np.concatenate(
        [(project(projection(s.camera, view), s.scene) - s.seen) / s.width for s in sightings if len(s.scene)]
    )
