"""What a relief estimator is given and gives.

A *perspective* is the pixel grid that gamma belongs to: full-size, centres at integers. A camera sees the scene at its
pixel (x, y) where its projection maps (x, y, 1, gamma), homogeneous.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import Picture
from mcsl_core.imaging.geometry import Array, Homography
from mcsl_core.imaging.masks import Mask


def _no_points() -> Array:
    return np.zeros((0, 3))


@frozen(eq=False)
class ReliefView:
    """What one camera shows steadily over some moments of a pose.

    Attributes
    ----------
    picture : (h, w, 3) uint8 array
        BGR, of any size: the commonest over those moments.
    steady : (h, w) bool array
        Where that can be believed.
    """

    picture: Picture
    steady: Mask


@frozen(eq=False)
class ReliefCamera:
    """One camera in one pose. In another pose, over the same perspective, it is another camera.

    Attributes
    ----------
    size : (int, int)
        Full width and height.
    projection : (3, 4) array
        (x, y, 1, gamma) of the perspective -> full-size camera pixel, homogeneous.
    plane : (3, 3) array
        Perspective pixel -> full-size camera pixel by the pose's plane, which the camera falls back to.
    views : tuple of ReliefView
        Of several groups of moments, that of all moments among them: what rests in one group and not in the others
        is outvoted. One is enough.
    """

    size: tuple[int, int]
    projection: Array
    plane: Homography
    views: tuple[ReliefView, ...]


@frozen(eq=False)
class ReliefSurface:
    """A relief.

    Attributes
    ----------
    gamma : (rows, columns) float array
        At nodes spread evenly over the perspective, from its first to its last pixel centre.
    confidence : (rows, columns) float array
        0..1: how well the pictures support it there. Where it is 0 nothing is known, and the plane holds.
    cameras : frozenset of str
        The cameras that it serves at least as well as their planes do; the others keep their planes.
    """

    gamma: NDArray[np.float64]
    confidence: NDArray[np.float64]
    cameras: frozenset[str]


@frozen(eq=False)
class ReliefScene:
    """What is known about a perspective before its relief is.

    Attributes
    ----------
    size : (int, int)
        The perspective's full width and height.
    cameras : mapping of str to ReliefCamera
        By any names, of one pose or several.
    points : (N, 3) array
        x, y and gamma of matched points, where there are any: they are searched about.
    before : ReliefSurface, optional
        What the perspective's first pose showed: a prior, which holds where these pictures say little.
    """

    size: tuple[int, int]
    cameras: Mapping[str, ReliefCamera]
    points: Array = field(factory=_no_points)
    before: ReliefSurface | None = None


class ReliefEstimator(Protocol):
    """Finds the relief that all cameras of a perspective share."""

    @property
    def name(self) -> str: ...

    def estimate(self, scene: ReliefScene) -> ReliefSurface | None:
        """Finds the relief.

        Parameters
        ----------
        scene : ReliefScene
            The cameras and what they show.

        Returns
        -------
        ReliefSurface or None
            None where the plane is to stay.
        """
        ...


@frozen
class PlaneRelief:
    """No relief: every pose stays one plane."""

    name = "plane"

    def estimate(self, scene: ReliefScene) -> ReliefSurface | None:
        return None
