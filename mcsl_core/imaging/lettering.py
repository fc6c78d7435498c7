"""Text in pictures that stands out from whatever is below it."""

from __future__ import annotations

from itertools import product

import cv2

from .planes import U8


def write_text(
    picture: U8, text: str, at: tuple[int, int], size: float, colour: tuple[int, int, int] = (255, 255, 255)
) -> None:
    """Write ``text`` into a picture, with a dark edge.

    Parameters
    ----------
    picture
        (H, W, 3), BGR; changed.
    text
        ASCII: OpenCV's fonts have no more.
    at
        Its lower left corner.
    size
        1 is some 22 pixels high.
    colour
        BGR.

    Notes
    -----
    The edge is the text itself, moved: OpenCV 5 takes thickness for the letters' weight, and bold letters stand farther
    apart.
    """
    around = [(at[0] + dx, at[1] + dy) for dx, dy in product((-1, 0, 1), repeat=2) if (dx, dy) != (0, 0)]
    for place, ink in [*((place, (0, 0, 0)) for place in around), (at, colour)]:
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, ink, 1, cv2.LINE_AA)
