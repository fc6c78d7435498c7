"""Where hands, and where heads and arms are in the cameras' pictures, by drawing the simulated scene without them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from benchmarks.ideal_geometry import shown_frame
from mcsl_core.edl import Edl
from mcsl_core.simulation import Truth
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.ideal import ideal_pictures
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.scene import Placement, Scene

_CODES = 6  # of luma: a hand, and the darker half of the shade that it casts
_MARGIN = 1 / 80  # of the picture's width: planes lay hands elsewhere than the truth does, by a few pixels
Mask = NDArray[np.bool_]


class _HandsAlone(Scene):
    def placements(self, t: float) -> Iterator[Placement]:
        return (placement for placement in super().placements(t) if placement.kind != "head")


class _Nobody(Scene):
    def placements(self, t: float) -> Iterator[Placement]:
        return iter(())


@frozen(eq=False)
class InTheWay:
    """Masks of a picture, each with shade and a margin.

    Attributes
    ----------
    hands
        (H, W): hands and instruments at work and at rest.
    all
        (H, W): those, heads, shoulders and reaching arms.
    """

    hands: Mask
    all: Mask


class Hands:
    """Masks of who is in the way, by a scene's truth."""

    def __init__(self, programme: Edl, truth: Truth) -> None:
        scene = Scene.of(truth.scenario)
        self._edl, self._truth, self._ground = programme, truth, Ground.of(truth.scenario, scene.surface, scene.rig)
        values = {field.name: getattr(scene, field.name) for field in attrs.fields(Scene)}
        values["scenario"] = attrs.evolve(truth.scenario, noise=0.0)
        self._scenes = Scene(**values), _HandsAlone(**values), _Nobody(**values)
        self._cameras: tuple[int, list[CameraPictures]] | None = None

    def in_ideal(self, frames: Sequence[int]) -> dict[int, Mask]:
        """Hands by frame, in the ideal programme; frames in rising order."""
        drawn = (ideal_pictures(scene, self._ground, frames) for scene in self._scenes[1:])
        return {frame: _apart(one.y, other.y) for frame, one, other in zip(frames, *drawn, strict=True)}

    def in_camera(self, camera: str, frame: int) -> InTheWay | None:
        """In the picture that a camera shows at a programme frame; None where it has none."""
        own, index = shown_frame(self._edl, self._truth, camera, frame), self._truth.camera_index(camera)
        if own is None:
            return None
        if self._cameras is None or self._cameras[0] != index:
            clock = self._truth.clocks[index]
            self._cameras = index, [CameraPictures(scene, self._ground, index, clock) for scene in self._scenes]
        everybody, hands, nobody = (pictures.frame(own)[0].y for pictures in self._cameras[1])
        return InTheWay(_apart(hands, nobody), _apart(everybody, nobody))


def _apart(one: NDArray, other: NDArray) -> Mask:
    apart = (cv2.absdiff(one, other) > _CODES).astype(np.uint8)
    side = 2 * round(_MARGIN * one.shape[1]) + 1
    return np.asarray(cv2.dilate(apart, np.ones((side, side), np.uint8))) > 0
