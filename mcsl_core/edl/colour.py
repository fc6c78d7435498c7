"""A camera's colours in a pose: its match to the reference camera, and gains that follow its drift."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from attrs import field, frozen

from mcsl_core.documents import Bounds, doc
from mcsl_core.timing import FrameRange

from .checks import NUMBERS, require

Matrix34 = tuple[
    tuple[float, float, float, float], tuple[float, float, float, float], tuple[float, float, float, float]
]
ColourKey = tuple[int, float, float, float]
GAINS = Bounds(0.1, 10)


@frozen
class Colour:
    """Matches a camera's colours to the reference camera's."""

    matrix: Matrix34 = field(
        validator=NUMBERS,
        metadata=doc("[Y', Cb, Cr, 1] of the camera, BT.709 limited range, 8-bit codes -> of the reference camera"),
    )


def check_keys(keys: Sequence[ColourKey], piece: FrameRange, at: str) -> None:
    """`Fault` where keys do not rise, lie outside of ``piece`` or hold no gains."""
    last = piece.start - 1
    for index, (frame, *gains) in enumerate(keys):
        where = f"{at}[{index}]"
        require(frame in piece, f"frame {frame} is outside its pose's [{piece.start}, {piece.stop})", f"{where}[0]")
        require(frame > last, f"keys must rise, got frame {frame} after {last}", f"{where}[0]")
        for number, gain in enumerate(gains, 1):
            GAINS.check(gain, f"{where}[{number}]")
        last = frame


def gains_at(keys: Sequence[ColourKey], frame: float) -> tuple[float, float, float]:
    """The gains of R', G' and B' at a frame: linear between keys, held outside.

    Examples
    --------
    >>> gains_at(((0, 1.0, 1.0, 1.0), (10, 1.2, 1.0, 0.9)), 5)
    (1.1, 1.0, 0.95)
    """
    after = bisect_right(keys, frame, key=lambda key: key[0])
    if after in (0, len(keys)):
        return keys[0 if after == 0 else -1][1:]
    (f0, *before), (f1, *behind) = keys[after - 1], keys[after]
    part = (frame - f0) / (f1 - f0)
    red, green, blue = (a + part * (b - a) for a, b in zip(before, behind, strict=True))
    return red, green, blue


def keys_over(keys: Sequence[ColourKey], part: FrameRange) -> list[ColourKey]:
    """The gains over ``part``: at its ends and the keys between, which is all that linear change depends on."""
    inside = [key for key in keys if part.start < key[0] < part.stop - 1]
    return [(part.start, *gains_at(keys, part.start)), *inside, (part.stop - 1, *gains_at(keys, part.stop - 1))]
