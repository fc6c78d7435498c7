"""Text in pictures."""

from __future__ import annotations

import cv2
import numpy as np

from mcsl_core.imaging.lettering import write_text


def test_every_letter_has_its_edge_about_it() -> None:
    """The last of a long line as well: drawn bolder, an edge wandered off to the right of its letters."""
    picture = np.full((60, 700, 3), 128, np.uint8)
    write_text(picture, "0:00:12.4  cam3, and so on to the end", (8, 40), 1.0)
    white, dark = picture[..., 1] > 230, (picture[..., 1] < 40).astype(np.uint8)
    assert white.sum() > 500
    near = cv2.dilate(white.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    assert near[dark > 0].all()
    assert cv2.dilate(dark, np.ones((5, 5), np.uint8))[white].mean() > 0.95
