"""What is centred, stretch by stretch: the middle of the surgical field, or where viewers looked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.edl import Edl
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.imaging.geometry import scaling

from .field import field_middle
from .gaze import Gaze, fixations
from .protocol import FieldPlace


def field_places(solved: Sequence[SolvedPose], size: tuple[int, int]) -> list[FieldPlace]:
    """Where the field lies in each pose, in a programme of ``size`` (width, height)."""
    places = []
    for pose in solved:
        to_programme = np.array(pose.pose.anchor) @ scaling(pose.scene.size, size)
        places.append(FieldPlace(pose.pose.range, field_middle(pose.scene.field, to_programme)))
    return places


def gaze_places(looks: Sequence[Gaze], made: Edl) -> list[FieldPlace]:
    """Where viewers looked, in the programme of ``made``."""

    def place(frame: int, camera: str) -> np.ndarray | None:
        matrix = placement_matrix(made, made.pose_at(frame), camera)
        return None if matrix is None else np.array(matrix)

    found = fixations(looks, place, frames=made.frames, size=made.size, rate=float(made.rate))
    return [FieldPlace(piece, middle) for piece, middle in found]
