"""What numbers, matrices and counts of the document may be, and how a wrong one is refused."""

from __future__ import annotations

from typing import Any

import attrs
from attrs import frozen

from mcsl_core.documents import Bounds, NotEmpty
from mcsl_core.errors import Fault
from mcsl_core.input_files import name_fault

# What is taken, so that nobody's document fills the memory or never ends: each is beyond any operation.
MOST_FRAMES = 50_000_000  # two days at 240 frames/s have 41 million
LONGEST_S = 48 * 3600
LARGEST_SIDE = 16_384
MOST_CAMERAS, MOST_FILES, MOST_POSES, MOST_DRAWN, MOST_DECISIONS = 256, 10_000, 10_000, 1_000, 100_000
Matrix = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
NO_SOUND = "none"  # in place of the camera whose sound is taken
UNIT = Bounds(0, 1)
FRAMES = Bounds(1, MOST_FRAMES)
SIDES = Bounds(1, LARGEST_SIDE)
NOT_NEGATIVE = Bounds(0)
NUMBERS = Bounds(-10_000_000, 10_000_000)  # of matrices and shifts in pixels; their products stay finite
SECONDS = Bounds(-(10**11), 10**11)  # epoch times in milliseconds as well


def require(condition: bool, what: str, at: str) -> None:
    """`Fault` at the path ``at`` where the condition does not hold."""
    if not condition:
        raise Fault(what, at)


def check_matrix(matrix: Any, at: str) -> None:
    """`Fault` where a matrix is no 3x3 homography, scaled so that its last element is 1."""
    shape_is_right = isinstance(matrix, tuple) and [len(row) for row in matrix] == [3, 3, 3]
    require(shape_is_right, f"must be a tuple of three rows of three numbers, got {matrix!r}", at)
    NUMBERS.check(matrix, at)
    (a, b, c), (d, e, f), (g, h, i) = matrix
    require(abs(i - 1) < 1e-9, f"must be scaled so that its last element is 1, got {i}", f"{at}[2][2]")
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    require(abs(determinant) > 1e-12, "is singular: it maps the picture to a line or a point", at)


@frozen
class FileName(NotEmpty):
    """Validator: a text that can be the path of a file."""

    def __call__(self, _instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        super().__call__(_instance, attribute, value)
        fault = name_fault(value)
        require(not fault, fault, f".{attribute.name}")
