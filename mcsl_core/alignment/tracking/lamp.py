"""The lamp as a rigid body: how its cameras are mounted, and where it stands."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen

from mcsl_core.imaging.geometry import Array


@frozen(eq=False)
class LampView:
    """Where the lamp stands, against where it stood in the pose that views count from.

    Attributes
    ----------
    turn : (3,) array
        Rotation vector of the scene before the reference camera, radians.
    shift : (3,) array
        Its translation after that, in distances from the reference camera to the field.
    zoom : float
        Natural logarithm of the focal lengths' common factor.
    """

    turn: Array
    shift: Array
    zoom: float

    @classmethod
    def of(cls, numbers: Array) -> LampView:
        """Of the seven `numbers`."""
        return cls(np.array(numbers[:3]), np.array(numbers[3:6]), float(numbers[6]))

    @property
    def numbers(self) -> Array:
        """(7,)"""
        return np.array([*self.turn, *self.shift, self.zoom])

    @property
    def motion(self) -> Array:
        """(4, 4): of the scene, before the reference camera."""
        found = np.eye(4)
        found[:3, :3] = rotation(self.turn)
        found[:3, 3] = self.shift
        return found


AT_REST = LampView(np.zeros(3), np.zeros(3), 0.0)


@frozen(eq=False)
class Lamp:
    """A calibrated rig.

    Attributes
    ----------
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    focal : mapping of str to float
        Focal lengths in pixels, in the pose that views count from.
    mounts : mapping of str to (3, 4) array
        Rotation and translation of each camera in the reference camera's frame.
    to_metric : (4, 4) array
        Programme pixel and gamma, (x, y, 1, gamma), to a point before the reference camera in that pose, homogeneous;
        lengths in distances to the field.
    """

    sizes: Mapping[str, tuple[int, int]]
    focal: Mapping[str, float]
    mounts: Mapping[str, Array]
    to_metric: Array

    def projection(self, camera: str, view: LampView) -> Array:
        """(3, 4): programme pixel and gamma -> the camera's pixel, while the lamp stands so."""
        focal = self.focal[camera] * np.exp(view.zoom)
        found = intrinsics(focal, self.sizes[camera]) @ self.mounts[camera] @ view.motion @ self.to_metric
        return found / found[2, 2]


def intrinsics(focal: float, size: tuple[int, int]) -> Array:
    """(3, 3): of square pixels, the axis through the middle of the picture."""
    return np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1]])


def rotation(vector: Array) -> Array:
    """(3, 3): of a rotation vector, radians."""
    return np.asarray(cv2.Rodrigues(vector)[0], np.float64)
