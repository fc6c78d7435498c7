"""The rig: the lamp and the cameras built into it.

World: mm, right-handed, z up, the table about z = 0, the surgical field about the origin. Camera: x right, y down,
z forward; a world point X is seen at K (R X + t), pixel centres at integers. Camera 0 is the reference.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .scenario import Scenario

LAMP_HEIGHT_MM = 1000.0
CAMERA_CIRCLE_MM = 300.0
FOCAL_PER_WIDTH = 1.85
"""Focal length over picture width: some 54 x 30 cm of the table from 1 m."""


@attrs.frozen(eq=False)
class PinholeCamera:
    """One camera at one time.

    Attributes
    ----------
    K
        (3, 3) intrinsics, pixels.
    R
        (3, 3) rotation, world to camera.
    t
        (3,) translation, mm.
    k1
        Radial distortion: a point at (x, y) of the plane z = 1 is seen at K (x, y) (1 + k1 r^2), r its distance from
        the axis.
    """

    K: NDArray
    R: NDArray
    t: NDArray
    k1: float = 0.0

    @property
    def centre_mm(self) -> NDArray:
        """(3,), in the world."""
        return -self.R.T @ self.t

    def project(self, points_mm: NDArray) -> NDArray:
        """(N, 3) world points to (N, 2) pixels."""
        if self.k1:
            local = points_mm @ self.R.T + self.t
            at = local[:, :2] / local[:, 2:]
            return at * (1 + self.k1 * (at * at).sum(1, keepdims=True)) @ self.K[:2, :2].T + self.K[:2, 2]
        homogeneous = (points_mm @ self.R.T + self.t) @ self.K.T
        return homogeneous[:, :2] / homogeneous[:, 2:]

    def undistorted(self, px: NDArray) -> NDArray:
        """Pixels (..., 2) as points (x, y) of the plane z = 1."""
        seen = (px - self.K[:2, 2]) @ np.linalg.inv(self.K[:2, :2]).T
        at = seen
        for _ in range(12 if self.k1 else 0):
            at = seen / (1 + self.k1 * (at * at).sum(-1, keepdims=True))
        return at

    def through_lens(self, k1: float) -> PinholeCamera:
        """The same with distortion, its picture's corners where they were: nothing outside the picture is seen."""
        if not k1:
            return self
        corner = self.K[:2, 2] / self.K[0, 0]
        K = self.K.copy()
        K[:2, :2] /= 1 + k1 * (corner @ corner)
        return PinholeCamera(K, self.R, self.t, k1)

    def rays(self, px: NDArray) -> NDArray:
        """World directions (not normalised) through pixels (..., 2)."""
        if self.k1:
            at = self.undistorted(px)
            return np.concatenate([at, np.ones((*at.shape[:-1], 1))], -1) @ self.R
        homogeneous = np.concatenate([px, np.ones((*px.shape[:-1], 1))], -1)
        return homogeneous @ (self.R.T @ np.linalg.inv(self.K)).T


@attrs.frozen(eq=False)
class LampPose:
    """Where the lamp is.

    Attributes
    ----------
    centre_mm
        (3,), in the world.
    aim_mm
        (3,): the point its axis is aimed at.
    turn_deg
        Its rotation about that axis.
    zoom
        Factor of the cameras' focal lengths.
    """

    centre_mm: NDArray
    aim_mm: NDArray
    turn_deg: float = 0.0
    zoom: float = 1.0

    def towards(self, other: LampPose, way: float) -> LampPose:
        """The pose ``way`` (0..1) between this one and ``other``."""
        return LampPose(
            self.centre_mm + way * (other.centre_mm - self.centre_mm),
            self.aim_mm + way * (other.aim_mm - self.aim_mm),
            self.turn_deg + way * (other.turn_deg - self.turn_deg),
            self.zoom + way * (other.zoom - self.zoom),
        )

    @property
    def axes(self) -> NDArray:
        """(3, 3), columns: the lamp's own x, y, z (up) directions in the world."""
        up = unit(self.centre_mm - self.aim_mm)
        turn = np.deg2rad(self.turn_deg)
        ahead = np.array([np.cos(turn), np.sin(turn), 0.0])
        x = unit(ahead - (ahead @ up) * up)
        return np.stack([x, cross(up, x), up], 1)


@attrs.frozen(eq=False)
class Rig:
    """The cameras as they are built into the lamp: on a circle, each turned against its neighbour.

    Attributes
    ----------
    size
        (width, height) of the pictures.
    azimuth_deg
        (cameras,): position on the circle.
    focal_px
        (cameras,): focal length.
    aim_error_mm
        (cameras, 2): how far from the lamp's aim the optical axis passes.
    roll_error_deg
        (cameras,): rotation about the optical axis.
    k1
        (cameras,): their lenses' radial distortion.
    """

    size: tuple[int, int]
    azimuth_deg: NDArray
    focal_px: NDArray
    aim_error_mm: NDArray
    roll_error_deg: NDArray
    k1: NDArray

    @classmethod
    def of(cls, scenario: Scenario) -> Rig:
        """The rig of a scenario."""
        rng = scenario.stream("rig")
        n = scenario.cameras
        width = scenario.size[0]
        return cls(
            scenario.size,
            -90.0 + 360.0 / n * np.arange(n) + rng.normal(0, 0.6, n),
            FOCAL_PER_WIDTH * width * (1 + rng.uniform(-0.035, 0.035, n)),
            rng.normal(0, 9.0, (n, 2)),
            rng.normal(0, 1.5, n),
            scenario.traits.k1 * scenario.stream("lens").uniform(0.5, 1.0, n),
        )

    def camera(self, camera: int, pose: LampPose) -> PinholeCamera:
        """Position and optics of ``camera`` while the lamp is at ``pose``, its lens's distortion included."""
        return self.pinhole(camera, pose).through_lens(float(self.k1[camera]))

    def pinhole(self, camera: int, pose: LampPose) -> PinholeCamera:
        """The same without distortion, as everything is drawn before the lens distorts it."""
        azimuth = np.deg2rad(self.azimuth_deg[camera])
        radial = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        at = CAMERA_CIRCLE_MM * radial
        axis = unit(np.array([*self.aim_error_mm[camera], -LAMP_HEIGHT_MM]) - at)
        # The top of each picture points to the lamp's axis, so neighbours are turned by the angle between them.
        roll = np.deg2rad(self.roll_error_deg[camera])
        up = -radial * np.cos(roll) + cross(axis, radial) * np.sin(roll)
        down = unit(-(up - (up @ axis) * axis))
        local = np.stack([cross(down, axis), down, axis])
        R = local @ pose.axes.T
        centre = pose.centre_mm + pose.axes @ at
        width, height = self.size
        focal = self.focal_px[camera] * pose.zoom
        K = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
        return PinholeCamera(K, R, -R @ centre)


def unit(v: NDArray) -> NDArray:
    """``v`` at length 1."""
    return v / np.sqrt(v @ v)


def cross(a: NDArray, b: NDArray) -> NDArray:
    """The cross product of two 3-vectors, without np.cross's generality, which costs 30 times as much."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
