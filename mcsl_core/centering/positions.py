"""What is centred when: the middle of the surgical field in each pose, or what viewers looked at."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from functools import cache

import numpy as np

from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.edl import Edl
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.imaging.geometry import scaling

from .field import field_middle
from .gaze import Gaze, ToProgramme, fixations
from .protocol import FieldPosition


def field_positions(solved: Sequence[SolvedPose], size: tuple[int, int]) -> list[FieldPosition]:
    """Where the field lies in each part of each pose, in a programme of ``size`` (width, height)."""
    positions = []
    for one in solved:
        to_programme = np.array(one.pose.anchor) @ scaling(one.aligned.size, size)
        positions += [FieldPosition(piece, field_middle(mask, to_programme)) for piece, mask, _ in one.fields()]
    return positions


def gaze_positions(gaze: Sequence[Gaze], made: Edl) -> list[FieldPosition]:
    """Where viewers looked, in the programme of ``made``."""
    found = fixations(gaze, _placement(made), frames=made.frames, size=made.size, rate=float(made.rate))
    return [FieldPosition(within, middle) for within, middle in found]


def looks_unplaced(gaze: Sequence[Gaze], made: Edl) -> int:
    """How many looks are at cameras of which nobody knows how they lie in the programme then."""
    to_programme = _placement(made)
    return sum(look.camera is not None and to_programme(int(look.frame), look.camera) is None for look in gaze)


def _placement(made: Edl) -> ToProgramme:
    starts = [pose.range.start for pose in made.poses]

    @cache
    def matrix_in(pose_index: int, camera: str) -> np.ndarray | None:
        matrix = placement_matrix(made, made.poses[pose_index], camera)
        return None if matrix is None else np.array(matrix)

    return lambda frame, camera: matrix_in(bisect_right(starts, frame) - 1, camera)
