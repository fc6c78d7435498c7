"""A pose's relief over programme pixels, and what the EDL has of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import evolve, frozen

from mcsl_core.edl import Relief
from mcsl_core.imaging.masks import Mask

from .foreign import ForeignColours
from .protocol import ReliefScene, ReliefSurface
from .resting_hands import with_rim
from .thin_plate import Nodes


@frozen(eq=False)
class PoseRelief:
    """A pose's relief over programme pixels.

    Attributes
    ----------
    scene : ReliefScene
        The pose's cameras, with what they show.
    surface : ReliefSurface
        Gamma at nodes over the programme's picture.
    foreign : mapping of str to ForeignColours
        Camera -> where its steady picture has the colours of what comes and goes.
    hands : (rows, columns) bool array
        The nodes of the surface where a hand rests all through the pose.
    over : (rows, columns) array
        Gamma with the hands, as the cameras see it.
    height : float
        See `height_of_gamma`; any without hands.
    """

    scene: ReliefScene
    surface: ReliefSurface
    foreign: Mapping[str, ForeignColours]
    hands: Mask
    over: Nodes
    height: float

    @property
    def seen(self) -> ReliefSurface:
        """The surface as far as it is seen, not carried on under hands."""
        return evolve(self.surface, confidence=np.where(with_rim(self.hands), 0.0, self.surface.confidence))

    def document(self) -> Relief:
        """As the EDL has it; of the cameras that the surface serves."""
        projections = {}
        for name, camera in self.scene.cameras.items():
            if name in self.surface.cameras:
                a, b, c = (tuple(float(v) for v in row) for row in camera.projection)
                projections[name] = (a, b, c)
        sure = np.round(100 * np.clip(self.surface.confidence, 0, 1)).astype(int)
        return Relief(
            projections,
            tuple(tuple(round(float(v), 3) for v in row) for row in self.surface.gamma),
            tuple(tuple(int(v) for v in row) for row in sure),
        )
