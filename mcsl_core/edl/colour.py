"""A camera's colours in a pose: its match to the reference camera."""

from __future__ import annotations

from attrs import field, frozen

from mcsl_core.documents import doc

from .checks import NUMBERS

Matrix34 = tuple[
    tuple[float, float, float, float], tuple[float, float, float, float], tuple[float, float, float, float]
]


@frozen
class Colour:
    """Matches a camera's colours to the reference camera's."""

    matrix: Matrix34 = field(
        validator=NUMBERS,
        metadata=doc("[Y', Cb, Cr, 1] of the camera, BT.709 limited range, 8-bit codes -> of the reference camera"),
    )
