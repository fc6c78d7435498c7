"""Masks of a simulated camera's pictures, by truth: what somebody would paint who knows what is what."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from mcsl_learned_occlusion.model import CLASSES
from numpy.typing import NDArray

from mcsl_core.imaging.masks import close_gaps
from mcsl_core.simulation import Scenario
from mcsl_core.simulation.clocks import clocks
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.layers import Box, Overlay, Picture
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.rig import PinholeCamera
from mcsl_core.simulation.scene import Placement, Scene

EDGE_PX = 2  # nobody paints up to the very edge


class Painter(CameraPictures):
    """Draws a camera's pictures and keeps what it drew over the ground."""

    @staticmethod
    @lru_cache(maxsize=5)
    def of(scenario: Scenario, camera: int) -> Painter:
        simulated, ground = _staged(scenario)
        return Painter(simulated, ground, camera, clocks(scenario)[camera])

    def labels(self, own_frame: int, shape: tuple[int, int]) -> NDArray[np.int8]:
        """(h, w) of the camera's own frame at that size: the index into `CLASSES`, -1 near edges."""
        width, height = self._size
        self._hidden = np.zeros((height, width), np.uint8)
        self.frame(own_frame)
        t = self._clock.programme(own_frame / float(self._scene.scenario.rate))
        _, pinhole = self._backdrop.at(t)
        points = np.rint(pinhole.project(self._scene.surface.visibility_points_mm)).astype(int)
        points = points[((points >= 0) & (points < self._size)).all(axis=1)]
        field = np.zeros((height, width), np.uint8)
        field[points[:, 1], points[:, 0]] = 1
        field = close_gaps(cv2.morphologyEx(field, cv2.MORPH_CLOSE, np.ones((9, 9), np.uint8)) > 0)
        labels = np.full((height, width), CLASSES.index("elsewhere"), np.uint8)
        labels[field] = CLASSES.index("field")
        labels[self._hidden > 127] = CLASSES.index("in the way")
        true = pinhole.through_lens(self._k1)
        if true.k1:
            x, y = self._optics.drawn_at(true, pinhole, self._size)
            labels = cv2.remap(labels, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
            field = cv2.remap(field.astype(np.uint8), x, y, cv2.INTER_NEAREST) > 0
        labels = cv2.resize(labels, (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST)
        around = np.ones((2 * EDGE_PX + 1, 2 * EDGE_PX + 1), np.uint8)
        plain = cv2.erode(labels, around) == cv2.dilate(labels, around)
        # The truth's points keep clear of the drapes' edge: the skin beyond them is not painted.
        wide = cv2.dilate(field.astype(np.uint8), np.ones((width // 32 | 1, width // 32 | 1), np.uint8))
        rim = cv2.resize(wide - field, (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST) > 0
        plain &= ~(rim & (labels == CLASSES.index("elsewhere")))
        return np.where(plain, labels.astype(np.int8), np.int8(-1))

    def _draw(
        self, target: Picture | Overlay, placement: Placement, pinhole: PinholeCamera
    ) -> tuple[Box, NDArray] | None:
        drawn = super()._draw(target, placement, pinhole)
        if drawn is not None:
            (x0, y0, _, _), alpha = drawn
            scale = target.scale if isinstance(target, Overlay) else 1
            large = cv2.resize(alpha, None, fx=scale, fy=scale, interpolation=cv2.INTER_LINEAR)
            window = self._hidden[y0 * scale : y0 * scale + large.shape[0], x0 * scale : x0 * scale + large.shape[1]]
            np.maximum(window, large[: window.shape[0], : window.shape[1]], out=window)
        return drawn


@lru_cache(maxsize=1)
def _staged(scenario: Scenario) -> tuple[Scene, Ground]:
    simulated = Scene.of(scenario)
    return simulated, Ground.of(scenario, simulated.surface, simulated.rig)
