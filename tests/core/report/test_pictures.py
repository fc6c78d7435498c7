"""The report's pictures."""

import numpy as np

from mcsl_core.report.pictures import superimposed


def test_views_laid_over_each_other_are_their_mean_where_they_reach() -> None:
    dark, light = np.full((10, 20, 3), 40, np.uint8), np.full((10, 20, 3), 240, np.uint8)
    aside = np.array([[1, 0, 10.0], [0, 1, 0], [0, 0, 1]])
    made = superimposed({"a": dark, "b": light}, {"a": np.eye(3), "b": aside}, (20, 10))
    assert (made[:, :10] == 40).all()
    assert (made[:, 10:] == 140).all()
