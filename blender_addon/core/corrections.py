# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera strips moved, turned or scaled by hand -> the EDL's corrections of where a camera's picture lies. No bpy.

A strip is judged against what it would show as the EDL has it now. Where they agree, nothing was decided. Where they do
not, the correction is the map of programme pixels that takes the picture from its automatic place to where it was put;
exact pictures move by the same map, after homography and anchor and before centering. It holds for the whole
pose, in every file of the camera.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import attrs
from attrs import frozen

from mcsl_core.edl import Correction, Edl, Matrix, Pose
from mcsl_core.edl.placement import multiply
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange, without

from .camera_places import base_matrix, corrected
from .similarity import Transform, invert, matrix_of, project

UNNOTICED_PX = 0.05  # of the picture's corners: fifty times Blender's float32 rounding, a twentieth of what can be seen


@frozen
class FoundCamera:
    """A camera strip as found.

    Attributes
    ----------
    start, stop
        The programme frames [start, stop) that it covers.
    transform
        As it stands.
    planned
        Its transform without any correction, kept in the strip when it was built. Without the two the strip says
        nothing about alignment.
    """

    camera: str
    channel: int
    start: int
    stop: int
    name: str = ""
    transform: Transform | None = None
    planned: Transform | None = None


def read_corrections(edl: Edl, found: Iterable[FoundCamera]) -> tuple[Correction, ...]:
    """The EDL's corrections after the editor's work: the same where no strip was touched.

    A strip set back to its automatic place takes the correction away.

    Raises
    ------
    InputError
        Two strips of a camera stand differently in one pose, or one is mirrored or scaled to nothing.
    """
    strips = [s for s in found if s.transform is not None and s.planned is not None]
    corrections = edl.corrections
    for camera in edl.cameras:
        own = sorted((s for s in strips if s.camera == camera.name), key=lambda s: s.start)
        for pose in edl.poses:
            touched = [s for s in own if _speaks_for(s, pose, edl) and _is_touched(edl, pose, s)]
            if not touched:
                continue
            _check_agree(edl, touched)
            matrix = _correction(edl, pose, touched[0])
            corrections = _with(corrections, edl.poses, pose, camera.name, matrix)
    return corrections


def _speaks_for(strip: FoundCamera, pose: Pose, edl: Edl) -> bool:
    """Whether the strip's place is the camera's in ``pose``: it lies there for the most part, or over most of it."""
    shared = _overlap(strip, pose)
    return shared > 0 and (2 * shared > len(pose.range) or shared == max(_overlap(strip, p) for p in edl.poses))


def _overlap(strip: FoundCamera, pose: Pose) -> int:
    return max(0, min(strip.stop, pose.range.stop) - max(strip.start, pose.range.start))


def _is_touched(edl: Edl, pose: Pose, strip: FoundCamera) -> bool:
    assert strip.transform is not None
    assert strip.planned is not None
    return not _same_place(edl, strip, strip.transform, corrected(edl, edl.camera(strip.camera), pose, strip.planned))


def _same_place(edl: Edl, strip: FoundCamera, a: Transform, b: Transform) -> bool:
    """Whether the picture's corners lie in the same place under both."""
    size = edl.camera(strip.camera).size
    first, second = matrix_of(a, size, edl.size), matrix_of(b, size, edl.size)
    return _apart(first, second, size) < UNNOTICED_PX


def _apart(a: Matrix, b: Matrix, size: tuple[int, int]) -> float:
    """The largest distance between the corners of a picture of ``size`` under two affine maps, programme pixels."""
    corners = [complex(x, y) for x in (0, size[0] - 1) for y in (0, size[1] - 1)]
    return max(abs((project(a, corner) or 0) - (project(b, corner) or 0)) for corner in corners)


def _check_agree(edl: Edl, touched: Sequence[FoundCamera]) -> None:
    first = touched[0]
    for other in touched[1:]:
        assert first.transform is not None
        assert other.transform is not None
        if not _same_place(edl, first, first.transform, other.transform):
            raise InputError(
                f"stand differently in one pose (from frames {first.start + 1} and {other.start + 1})",
                where=f"strips {first.name!r} and {other.name!r} of {first.camera}",
                remedy="A correction holds for the whole pose: give both the same transform, or set one back",
            )


def _correction(edl: Edl, pose: Pose, strip: FoundCamera) -> Matrix | None:
    """Programme pixel -> programme pixel, from the automatic place to where the strip stands; None where it is that."""
    assert strip.transform is not None
    assert strip.planned is not None
    camera = edl.camera(strip.camera)
    if _same_place(edl, strip, strip.transform, strip.planned):
        return None
    if min(strip.transform.scale, strip.transform.height_scale) < 1e-3:
        raise InputError(
            "is mirrored or scaled to nothing",
            where=f"strip {strip.name!r} of {strip.camera}, frame {strip.start + 1}",
            remedy="Set its scale in the strip's transform",
        )
    stands = matrix_of(strip.transform, camera.size, edl.size)
    new = multiply(stands, invert(base_matrix(edl, camera, pose, strip.planned)))
    return new[0], new[1], (0.0, 0.0, 1.0)


def _with(
    corrections: tuple[Correction, ...], poses: Sequence[Pose], pose: Pose, camera: str, matrix: Matrix | None
) -> tuple[Correction, ...]:
    """``corrections`` with ``matrix`` (None: none) holding for ``camera`` in ``pose``, and as before elsewhere."""
    result: list[Correction] = []
    place, note = None, ""
    for correction in corrections:
        if correction.camera != camera or not _holds(correction.range, pose):
            result.append(correction)
            continue
        place, note = len(result), correction.note
        for piece in without([correction.range], [pose.range]):
            if any(_holds(piece, other) for other in poses):
                result.append(attrs.evolve(correction, range=piece))
    if matrix is not None:
        result.insert(len(result) if place is None else place, Correction(pose.range, camera, matrix, note))
    return tuple(result)


def _holds(piece: FrameRange, pose: Pose) -> bool:
    """Whether a correction of that range holds in ``pose``: as `correction_of` has it."""
    shared = piece.intersection(pose.range)
    return shared is not None and 2 * len(shared) > len(pose.range)
