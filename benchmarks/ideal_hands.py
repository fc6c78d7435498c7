"""Where hands and instruments are in the cameras' pictures, by drawing the simulated scene without them."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.simulation import Truth
from mcsl_core.simulation.clocks import Clock
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.ideal import ideal_pictures
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.scene import Scene

_CODES = 6  # of luma: a hand, and the darker half of the shade that it casts
_MARGIN = 1 / 80  # of the picture's width: planes lay hands elsewhere than the truth does, by a few pixels
Mask = NDArray[np.bool_]


class Hands:
    """Masks of hands and instruments, their shade and a margin; heads and reaching arms are left out of account."""

    def __init__(self, truth: Truth) -> None:
        scene = Scene.of(truth.scenario)
        self._truth, self._ground = truth, Ground.of(truth.scenario, scene.surface, scene.rig)
        self._with = attrs.evolve(scene, scenario=attrs.evolve(truth.scenario, noise=0.0), persons=())
        self._without = attrs.evolve(self._with, crew=(), resting=())
        self._cameras: dict[int, tuple[CameraPictures, CameraPictures]] = {}

    def in_ideal(self) -> Iterator[Mask]:
        """By frame, in the ideal programme."""
        drawn = (ideal_pictures(scene, self._ground) for scene in (self._with, self._without))
        for one, other in zip(*drawn, strict=True):
            yield _apart(one.y, other.y)

    def in_camera(self, camera: int, frame: int) -> Mask | None:
        """In the picture that the camera of that index shows at a programme frame; None where it has none."""
        own = self._truth.own_frame(camera, frame)
        if own is None:
            return None
        if camera not in self._cameras:
            self._cameras = {camera: (self._pictures(self._with, camera), self._pictures(self._without, camera))}
        one, other = (pictures.frame(own)[0] for pictures in self._cameras[camera])
        return _apart(one.y, other.y)

    def _pictures(self, scene: Scene, camera: int) -> CameraPictures:
        clock: Clock = self._truth.clocks[camera]
        return CameraPictures(scene, self._ground, camera, clock)


def _apart(one: NDArray, other: NDArray) -> Mask:
    apart = (cv2.absdiff(one, other) > _CODES).astype(np.uint8)
    side = 2 * round(_MARGIN * one.shape[1]) + 1
    return np.asarray(cv2.dilate(apart, np.ones((side, side), np.uint8))) > 0
