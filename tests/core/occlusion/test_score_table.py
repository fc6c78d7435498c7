"""The table of visible field: what it takes and what it refuses."""

import numpy as np
import pytest

from mcsl_core.occlusion.score_table import ScoreTable


def test_scores_out_of_range_or_shape_are_refused() -> None:
    usable = np.ones((2, 1), bool)
    with pytest.raises(ValueError, match=r"0\.\.1"):
        ScoreTable(np.arange(2), ("a",), np.array([[0.5], [1.2]]), usable)
    with pytest.raises(ValueError, match="rise"):
        ScoreTable(np.array([3, 3]), ("a",), np.zeros((2, 1)), usable)
    with pytest.raises(ValueError, match="must be"):
        ScoreTable(np.arange(2), ("a", "b"), np.zeros((2, 1)), usable)
