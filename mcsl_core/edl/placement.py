"""Placement: where a camera's picture lies in the programme. Homography, anchor, correction by hand, still ranges.

Plain tuples, no numpy: Blender's side uses it too. Conventions as in `edl.schema`.
"""

from __future__ import annotations

from collections.abc import Sequence

from mcsl_core.timing import FrameRange

from .schema import Edl, Matrix, Movement, Pose


def multiply(a: Matrix, b: Matrix) -> Matrix:
    """The matrix product a @ b."""
    rows = [tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3)]
    return rows[0], rows[1], rows[2]  # pyright: ignore[reportReturnType]


def correction_of(edl: Edl, pose: Pose, camera: str) -> Matrix | None:
    """The correction by hand that holds for ``camera`` in ``pose``, programme pixel -> programme pixel, or None.

    It is the last in the list that holds over more than half of the pose: a new analysis may move the pose's ends.
    """
    for correction in reversed(edl.corrections):
        shared = correction.range.intersection(pose.range)
        if correction.camera == camera and shared is not None and 2 * len(shared) > len(pose.range):
            return correction.matrix
    return None


def placement_matrix(edl: Edl, pose: Pose, camera: str) -> Matrix | None:
    """Camera pixel -> programme pixel in ``pose`` before centering: correction @ anchor @ homography.

    None where nothing is known: for a weak camera that nobody has corrected by hand.
    """
    homography = pose.homographies.get(camera)
    correction = correction_of(edl, pose, camera)
    if homography is not None:
        matrix = multiply(pose.anchor, homography)
    elif correction is not None:
        matrix = fit_matrix(edl.camera(camera).size, edl.size)
    else:
        return None
    return matrix if correction is None else multiply(correction, matrix)


def fit_matrix(size: tuple[int, int], to: tuple[int, int]) -> Matrix:
    """Pixel of a picture of ``size`` (width, height) -> pixel of one of size ``to`` that it is stretched to.

    Edges, not centres, coincide: pixel x spans [x - 0.5, x + 0.5).

    Examples
    --------
    >>> fit_matrix((100, 100), (200, 200))[0]
    (2.0, 0.0, 0.5)
    """
    x, y = to[0] / size[0], to[1] / size[1]
    return (x, 0.0, (x - 1) / 2), (0.0, y, (y - 1) / 2), (0.0, 0.0, 1.0)


def still_range(edl: Edl, pose: Pose) -> FrameRange:
    """The frames of ``pose`` in which the lamp stands still; all of them where it never does."""
    return still_part(pose.range, edl.movements)


def still_part(piece: FrameRange, movements: Sequence[Movement]) -> FrameRange:
    """``piece`` without what movements take of its ends; all of it where that leaves nothing."""
    start, stop = piece.start, piece.stop
    for movement in movements:
        if start in movement.range:
            start = movement.range.stop
        if stop - 1 in movement.range:
            stop = movement.range.start
    return FrameRange(start, stop) if start < stop else piece


def other_poses(edl: Edl, pose_index: int) -> tuple[int, ...]:
    """The other poses of the perspective of pose ``pose_index``: earlier ones, the latest first, then later ones."""
    same = [i for i, pose in enumerate(edl.poses) if pose.perspective == edl.poses[pose_index].perspective]
    return (*(i for i in reversed(same) if i < pose_index), *(i for i in same if i > pose_index))


def first_of_perspective(edl: Edl, pose_index: int) -> int:
    """The first pose of that pose's perspective with a placement of the reference camera; the pose itself without.

    The perspective is that camera's in it: what lies off the plane is right in its picture, and displaced in others.
    """
    pose = edl.poses[pose_index]
    same = (i for i, other in enumerate(edl.poses) if other.perspective == pose.perspective)
    return next((i for i in same if placement_matrix(edl, edl.poses[i], edl.reference) is not None), pose_index)
