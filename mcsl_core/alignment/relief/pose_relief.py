"""A pose's relief over programme pixels, and what the EDL has of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import evolve, frozen

from mcsl_core.edl import Relief
from mcsl_core.imaging.geometry import Array, to_edl_projection
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
        See `height_of_gamma`; its sign is a guess where the cameras do not know which way is up, and no hand is found.
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
        served = {n: c.projection for n, c in self.scene.cameras.items() if n in self.surface.cameras}
        return relief_document(served, self.surface.gamma, self.surface.confidence)


def relief_document(projections: Mapping[str, Array], gamma: Nodes, confidence: Nodes) -> Relief:
    """A relief as the EDL has it.

    Parameters
    ----------
    projections : mapping of str to (3, 4) array
        Camera -> programme pixel and gamma to its pixel.
    gamma, confidence : (rows, columns) array
        At nodes over the programme's picture; confidence 0..1.
    """
    sure = np.round(100 * np.clip(confidence, 0, 1)).astype(int)
    return Relief(
        {name: to_edl_projection(p / p[2, 2]) for name, p in projections.items()},
        tuple(tuple(round(float(v), 3) for v in row) for row in gamma),
        tuple(tuple(int(v) for v in row) for row in sure),
    )
