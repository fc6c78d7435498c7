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
    with pytest.raises(ValueError, match="must be"):
        ScoreTable(np.arange(2), ("a",), np.zeros((2, 1)), usable, shown=np.zeros((2, 2), int))


def test_what_a_camera_sees_at_a_frame_lies_between_what_its_pictures_are_of() -> None:
    frames = np.array([0, 10, 20, 30])
    visible = np.array([[0.0, 1.0], [0.0, 0.5], [0.2, np.nan], [0.2, 0.1]])
    shown = np.array([[4, 0], [4, 10], [24, 20], [24, 30]])  # two samples each take one keyframe of the first camera
    table = ScoreTable(frames, ("a", "b"), visible, np.ones((4, 2), bool), shown=shown)
    np.testing.assert_allclose(table.seen_at(np.array([4, 14, 24]))[:, 0], [0.0, 0.1, 0.2])
    np.testing.assert_allclose(table.seen_at(frames)[:, 1], [1.0, 0.5, 0.3, 0.1])
    np.testing.assert_allclose(table.seen[:, 1], [1.0, 0.5, np.nan, 0.1])
    empty = ScoreTable(frames, ("a",), np.full((4, 1), np.nan), np.ones((4, 1), bool))
    assert not empty.seen_at(frames).any()


def test_a_table_without_frames_of_pictures_is_of_its_samples_frames() -> None:
    table = ScoreTable(np.array([0, 30]), ("a", "b"), np.full((2, 2), 0.5), np.ones((2, 2), bool))
    old = {name: array for name, array in table.arrays().items() if name != "shown"}
    assert ScoreTable.from_arrays(old).shown.tolist() == [[0, 0], [30, 30]]
