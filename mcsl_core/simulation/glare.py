"""Glare: the lamp mirrored by what is wet, in a place of its own for each camera, wandering as the lamp's light and
the tissue do."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .ground import Ground
from .paint import smoothstep
from .rig import CAMERA_CIRCLE_MM, LAMP_HEIGHT_MM

WHITE = np.array([235, 128, 128], np.float32)
HARD = 170.0


class Glare:
    """Highlights over the field's cut-out for one camera.

    Parameters
    ----------
    ground
        What is mirrored upon.
    camera
        Its index.
    azimuth_deg
        Of the camera on the lamp's circle.
    """

    def __init__(self, ground: Ground, camera: int, azimuth_deg: float) -> None:
        scenario = ground.scenario
        rng = scenario.stream("glare", camera)
        azimuth = np.deg2rad(azimuth_deg)
        lens = np.array([CAMERA_CIRCLE_MM * np.cos(azimuth), CAMERA_CIRCLE_MM * np.sin(azimuth), LAMP_HEIGHT_MM])
        self._lens = lens / np.linalg.norm(lens)
        self._light = rng.uniform(0, 2 * np.pi) + np.array([0.0, 2.4])
        self._rates, self._phases = rng.uniform(0.2, 0.6, 4), rng.uniform(0, 6.28, 4)
        small = max(1.0, 1.2 / ground.pitch_mm)
        rows, columns = ground.normal.shape[:2]
        self._size = (columns, rows)
        shrink = (round(columns / small), round(rows / small))
        # The film of fluid is smoother than what it lies on.
        smooth = cv2.GaussianBlur(ground.normal, (0, 0), 2.0 / ground.pitch_mm)
        normal = cv2.resize(smooth, shrink, interpolation=cv2.INTER_AREA)
        self._normal = normal / np.linalg.norm(normal, axis=2, keepdims=True)
        wet = cv2.resize(ground.tissue.wet * ground.tissue.opening, shrink, interpolation=cv2.INTER_AREA)
        self._wet = scenario.traits.glare * (0.25 + 0.75 * smoothstep(0.1, 0.6, wet)) * (wet > 0.02)

    def over(self, field: NDArray, seconds: float) -> NDArray:
        """The cut-out (h, w, 4 layer) as it shines after so many seconds."""
        total = np.zeros(self._wet.shape, np.float32)
        for n, towards in enumerate(self._light):
            a, b = np.sin(self._rates[2 * n : 2 * n + 2] * seconds + self._phases[2 * n : 2 * n + 2])
            at = towards + 1.4 * a
            lamp = np.array([(180 + 130 * b) * np.cos(at), (180 + 130 * b) * np.sin(at), LAMP_HEIGHT_MM])
            half = self._lens + lamp / np.linalg.norm(lamp)
            facing = self._normal @ (half / np.linalg.norm(half)).astype(np.float32)
            total += np.exp(HARD * (np.clip(facing, 0, 1) - 1))
        share = cv2.resize(np.minimum(1.5 * total * self._wet, 1.0), self._size, interpolation=cv2.INTER_LINEAR)
        rows, columns = np.flatnonzero((share > 0.01).any(1)), np.flatnonzero((share > 0.01).any(0))
        if not len(rows):
            return field
        window = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
        shining = field.copy()
        part = shining[window][..., :3]
        mixed = part + share[window][..., None] * (WHITE - part)
        part[...] = np.clip(mixed + 0.5, 0, 255).astype(np.uint8)
        return shining
