"""The report's pictures."""

import numpy as np

from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.relief import Placement
from mcsl_core.imaging.warp import WarpField
from mcsl_core.report.pictures import superimposed


def grey(level: int) -> Planes:
    chroma = np.full((6, 10), 128, np.uint8)
    return Planes(np.full((12, 20), level, np.uint8), chroma, chroma)


def test_views_laid_over_each_other_are_their_mean_where_they_reach() -> None:
    """Codes 50 and 222 of limited range are 40 and 240 of 255."""
    aside = np.array([[1, 0, 10.0], [0, 1, 0], [0, 0, 1]])
    made = superimposed({"a": grey(50), "b": grey(222)}, {"a": Placement(np.eye(3)), "b": Placement(aside)}, (20, 12))
    assert (made[:, :10] == 40).all()
    assert (made[:, 10:] == 140).all()


def test_a_view_that_a_relief_moves_lies_where_it_moves_it() -> None:
    """Ten pixels to the right again, by what a relief adds to the plane."""
    aside = WarpField(np.full((2, 2, 2), [-10, 0], np.float32), (0, 0), 20)
    made = superimposed({"b": grey(222)}, {"b": Placement(np.eye(3), aside)}, (20, 12))
    assert (made[:, :10] == 0).all()
    assert (made[:, 10:] == 240).all()
