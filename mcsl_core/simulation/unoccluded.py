"""The scene without people, as wide as one likes: what a filled programme is compared with."""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from mcsl_core.imaging.planes import Planes

from .backdrop import Backdrop
from .ground import Ground
from .layers import Picture
from .render import sensor, vignette
from .rig import PinholeCamera
from .scenario import Scenario
from .scene import Scene


class UnoccludedScene:
    """Pictures of all that lies still, from where the reference camera stands in the first pose.

    The image plane goes on beyond that camera's picture; colours and darker corners are that camera's; no heads, no
    hands, no grain, a lens without distortion, exposure and white balance as they should be. So it is the truth of a
    programme in the first pose's perspective, however far that is shifted.
    """

    def __init__(self, scenario: Scenario) -> None:
        scene = Scene.of(attrs.evolve(scenario, heads=0, hands=0))
        _, gains, self._corner = sensor(scenario, 0)
        self._pinhole, self._size = scene.rig.pinhole(0, scene.path.poses[0]), scenario.size
        self._backdrop = Backdrop(scene, Ground.of(scenario, scene.surface, scene.rig), 0, gains)

    def at(self, t: float, offset: tuple[float, float] = (0.0, 0.0)) -> Planes:
        """The picture at programme time ``t`` in seconds; what the camera has at pixel p lies at p + ``offset``."""
        shift = np.array([[1.0, 0, offset[0]], [0, 1.0, offset[1]], [0, 0, 1]])
        picture = self._backdrop.picture_from(
            t, PinholeCamera(shift @ self._pinhole.K, self._pinhole.R, self._pinhole.t)
        )
        luma = cv2.multiply(picture.y, vignette(self._size, self._corner, offset), scale=1 / 255)
        return Picture(luma, picture.u, picture.v).planes()
