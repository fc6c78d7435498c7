"""What is centred when: the middle of the surgical field in each pose, or what viewers looked at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.edl import Edl
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.imaging.geometry import scaling

from .field import field_middle
from .gaze import Gaze, fixations
from .protocol import FieldPosition


def field_positions(solved: Sequence[SolvedPose], size: tuple[int, int]) -> list[FieldPosition]:
    """Where the field lies in each pose, in a programme of ``size`` (width, height)."""
    positions = []
    for one in solved:
        to_programme = np.array(one.pose.anchor) @ scaling(one.aligned.size, size)
        positions.append(FieldPosition(one.pose.range, field_middle(one.aligned.field, to_programme)))
    return positions


def gaze_positions(gaze: Sequence[Gaze], made: Edl) -> list[FieldPosition]:
    """Where viewers looked, in the programme of ``made``."""

    def to_programme(frame: int, camera: str) -> np.ndarray | None:
        matrix = placement_matrix(made, made.pose_at(frame), camera)
        return None if matrix is None else np.array(matrix)

    found = fixations(gaze, to_programme, frames=made.frames, size=made.size, rate=float(made.rate))
    return [FieldPosition(within, middle) for within, middle in found]
