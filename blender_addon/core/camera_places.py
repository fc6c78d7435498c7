# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a camera's picture is shown in a pose: the similarity of its homography, moved by a correction. No bpy."""

from __future__ import annotations

from mcsl_core.edl import Camera, Edl, Matrix, Pose
from mcsl_core.edl.placement import correction_of, fit_matrix, multiply
from mcsl_core.edl.resolve import offset_at

from .similarity import Transform, closest, fitted, matrix_of, transform_of


def planned_transform(edl: Edl, camera: Camera, pose: Pose) -> Transform:
    """The similarity nearest to the homography that takes a camera into the programme, without any correction.

    A weak camera, which has none, is shown upright and whole.
    """
    homography = pose.homographies.get(camera.name)
    if homography is None:
        return fitted(camera.size, edl.size)
    return closest(multiply(pose.anchor, homography), camera.size, edl.size, field_middle(edl, pose))


def corrected(edl: Edl, camera: Camera, pose: Pose, planned: Transform) -> Transform:
    """``planned`` moved by the correction that holds for the camera in ``pose``, if there is one."""
    # Not the similarity nearest to the corrected homography: the preview must move by just what the editor moved it.
    correction = correction_of(edl, pose, camera.name)
    if correction is None:
        return planned
    matrix = multiply(correction, base_matrix(edl, camera, pose, planned))
    exact = transform_of(matrix, camera.size, edl.size)
    return exact if exact is not None else closest(matrix, camera.size, edl.size, field_middle(edl, pose))


def base_matrix(edl: Edl, camera: Camera, pose: Pose, planned: Transform) -> Matrix:
    """The matrix to which a correction is applied in the preview.

    Returns
    -------
    Matrix
        Camera pixel -> programme pixel, affine. For a weak camera it is not what ``planned`` shows but what
        `placement_matrix` starts from: edge on edge.
    """
    if camera.name not in pose.homographies:
        return fit_matrix(camera.size, edl.size)
    return matrix_of(planned, camera.size, edl.size)


def field_middle(edl: Edl, pose: Pose) -> complex:
    """The surgical field's middle in programme pixels: centering moves it to the middle, so it stands that far off."""
    dx, dy = offset_at(edl.centering, (pose.range.start + pose.range.stop) / 2)
    return complex((edl.size[0] - 1) / 2 - dx, (edl.size[1] - 1) / 2 - dy)
