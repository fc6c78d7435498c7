# SPDX-License-Identifier: GPL-3.0-or-later
"""The closest similarity of a homography, as Blender's strip transform understands it. No bpy.

Pixels in are OpenCV's: x right, y down, centres at integers. Blender's strip transform moves the picture's middle
by (offset_x, offset_y) pixels of the render, x right and y up, turns it counter-clockwise by ``rotation`` radians
and scales it about its middle; the middle of w pixels is (w - 1) / 2 here and w / 2 there, which is the same spot.
Checked by rendering against a picture resampled without Blender: tests/blender/sequencer/test_transform.py.
"""

from __future__ import annotations

import cmath
from math import atan2, cos, exp, hypot, sin

from attrs import frozen

from mcsl_core.edl import Matrix

GRID = 17  # points a side; a similarity has four unknowns, 289 points leave no doubt about the mean
SHEAR = 1e-6  # cosine between the axes, and part of the scale: under it is rounding, a thousandth of a pixel
SPREAD = 0.3  # weight falls to exp(-1/2) at this part of the picture's width from the field's middle


@frozen
class Transform:
    """A strip's transform as Blender has it.

    Attributes
    ----------
    offset_x, offset_y
        Of the picture's middle from the render's, in render pixels, y up.
    scale
        Render pixels a camera pixel.
    rotation
        Radians, counter-clockwise.
    scale_y
        Scale of the height where it is another, which only an editor's hand makes.
    """

    offset_x: float
    offset_y: float
    scale: float
    rotation: float
    scale_y: float | None = None

    @property
    def height_scale(self) -> float:
        return self.scale if self.scale_y is None else self.scale_y


def matrix_of(transform: Transform, camera_size: tuple[int, int], programme_size: tuple[int, int]) -> Matrix:
    """What Blender shows of a strip: its picture scaled about its middle, turned, moved.

    Parameters
    ----------
    camera_size, programme_size
        Width and height in pixels.

    Returns
    -------
    Matrix
        Camera pixel -> programme pixel, affine.
    """
    c, s = cos(transform.rotation), sin(transform.rotation)
    (a, b), (d, e) = (
        (c * transform.scale, s * transform.height_scale),  # clockwise: y points down here
        (-s * transform.scale, c * transform.height_scale),
    )
    x, y = (camera_size[0] - 1) / 2, (camera_size[1] - 1) / 2
    u = (programme_size[0] - 1) / 2 + transform.offset_x
    v = (programme_size[1] - 1) / 2 - transform.offset_y
    return (a, b, u - a * x - b * y), (d, e, v - d * x - e * y), (0.0, 0.0, 1.0)


def transform_of(matrix: Matrix, camera_size: tuple[int, int], programme_size: tuple[int, int]) -> Transform | None:
    """The transform that shows just ``matrix`` (camera pixel -> programme pixel): the inverse of `matrix_of`.

    Returns
    -------
    Transform or None
        None where no transform does: the matrix shears, mirrors or has perspective.
    """
    (a, b, _), (d, e, _), (g, h, _) = matrix
    scale, scale_y = hypot(a, d), hypot(b, e)
    if abs(g) + abs(h) > 0 or abs(a * b + d * e) > SHEAR * scale * scale_y or a * e - b * d <= 0:
        return None
    middle = project(matrix, complex((camera_size[0] - 1) / 2, (camera_size[1] - 1) / 2))
    assert middle is not None  # an affine map has no horizon
    return Transform(
        offset_x=middle.real - (programme_size[0] - 1) / 2,
        offset_y=(programme_size[1] - 1) / 2 - middle.imag,
        scale=scale,
        rotation=atan2(-d, a),
        scale_y=None if abs(scale_y - scale) < SHEAR * scale else scale_y,
    )


def invert(m: Matrix) -> Matrix:
    """The inverse, by cofactors.

    Raises
    ------
    ZeroDivisionError
        The matrix is singular; the EDL refuses such ones.
    """
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return (
        ((e * i - f * h) / det, (c * h - b * i) / det, (b * f - c * e) / det),
        ((f * g - d * i) / det, (a * i - c * g) / det, (c * d - a * f) / det),
        ((d * h - e * g) / det, (b * g - a * h) / det, (a * e - b * d) / det),
    )


def project(m: Matrix, point: complex) -> complex | None:
    """``point`` (x + iy) through the homography; None at or behind the horizon, seen from pixel scale."""
    x, y = point.real, point.imag
    w = m[2][0] * x + m[2][1] * y + m[2][2]
    if w * m[2][2] <= 1e-9:
        return None
    return complex((m[0][0] * x + m[0][1] * y + m[0][2]) / w, (m[1][0] * x + m[1][1] * y + m[1][2]) / w)


def fitted(camera_size: tuple[int, int], programme_size: tuple[int, int]) -> Transform:
    """The picture upright and whole in the programme: what a camera without homography gets."""
    scale = min(programme_size[0] / camera_size[0], programme_size[1] / camera_size[1])
    return Transform(0.0, 0.0, scale, 0.0)


def closest(
    homography: Matrix, camera_size: tuple[int, int], programme_size: tuple[int, int], field_px: complex
) -> Transform:
    """The similarity nearest to a homography, by weighted least squares over a grid of programme points.

    Points near the surgical field weigh more, because there is where a cut is judged. Points outside the camera's
    picture do not count; where hardly any is left inside (a camera that sees past the programme), all count.

    Parameters
    ----------
    homography
        Camera pixel -> programme pixel.
    camera_size, programme_size
        Width and height in pixels.
    field_px
        The surgical field's middle in programme pixels, x + iy.
    """
    width, height = programme_size
    inverse = invert(homography)
    inside: list[tuple[complex, complex, float]] = []
    everywhere: list[tuple[complex, complex, float]] = []
    for row in range(GRID):
        for column in range(GRID):
            target = complex(column * (width - 1) / (GRID - 1), row * (height - 1) / (GRID - 1))
            source = project(inverse, target)
            if source is None:
                continue
            weight = exp(-0.5 * (abs(target - field_px) / (SPREAD * width)) ** 2)
            everywhere.append((source, target, weight))
            if -0.5 <= source.real <= camera_size[0] - 0.5 and -0.5 <= source.imag <= camera_size[1] - 0.5:
                inside.append((source, target, weight))
    points = inside if len(inside) >= GRID else everywhere
    if len(points) < GRID:
        return fitted(camera_size, programme_size)
    total = sum(w for _, _, w in points)
    source_mean = sum(z * w for z, _, w in points) / total
    target_mean = sum(q * w for _, q, w in points) / total
    spread = sum(w * abs(z - source_mean) ** 2 for z, _, w in points)
    turn = sum(w * (z - source_mean).conjugate() * (q - target_mean) for z, q, w in points) / spread
    middle = complex((camera_size[0] - 1) / 2, (camera_size[1] - 1) / 2)
    shift = turn * (middle - source_mean) + target_mean - complex((width - 1) / 2, (height - 1) / 2)
    return Transform(shift.real, 0.0 - shift.imag, abs(turn), 0.0 - cmath.phase(turn))


def touching(homography: Matrix, point: complex) -> Matrix | None:
    """The similarity that touches a homography at a programme point: the same there, and as near as can be about it.

    Parameters
    ----------
    homography
        Camera pixel -> programme pixel.
    point
        In programme pixels, x + iy.

    Returns
    -------
    Matrix or None
        Camera pixel -> programme pixel, affine; None where the camera does not look that way.
    """
    source = project(invert(homography), point)
    if source is None or project(homography, source) is None:
        return None
    (a, b, _), (d, e, _), (g, h, i) = homography
    w = g * source.real + h * source.imag + i
    along_x = complex(a - point.real * g, d - point.imag * g) / w  # how the picture moves a pixel further there
    along_y = complex(b - point.real * h, e - point.imag * h) / w
    turn = (along_x - 1j * along_y) / 2
    if abs(turn) < 1e-9:  # mirrored
        return None
    shift = point - turn * source
    return (turn.real, -turn.imag, shift.real), (turn.imag, turn.real, shift.imag), (0.0, 0.0, 1.0)
