"""What was measured, in its file beside the EDL."""

import numpy as np

from mcsl_core.analysis.measurements import Measurements, load_measurements
from mcsl_core.movement.protocol import Curve
from mcsl_core.occlusion.score_table import ScoreTable

SHOWN = np.array([[3, 1], [9, 12]])


def test_scores_come_back_as_they_were_saved(tmp_path) -> None:
    table = ScoreTable(
        np.array([3, 9]), ("a", "ä"), np.array([[0.25, np.nan], [1, 0]]), np.eye(2, dtype=bool), shown=SHOWN
    )
    curve = Curve("displacement", "px", np.array([3, 9]), np.array([0.5, np.nan]), np.array([1.0, 1.0]))
    Measurements(table, curve).save(tmp_path / "s.npz")
    read = load_measurements(tmp_path / "s.npz")
    again = read.scores
    assert again.cameras == table.cameras
    np.testing.assert_array_equal(again.visible, table.visible)
    np.testing.assert_array_equal(again.usable, table.usable)
    np.testing.assert_array_equal(again.shown, SHOWN)
    assert (read.movement.label, read.movement.unit) == ("displacement", "px")
    np.testing.assert_array_equal(read.movement.values, curve.values)
    first = (tmp_path / "s.npz").read_bytes()
    Measurements(table, curve).save(tmp_path / "s.npz")
    assert (tmp_path / "s.npz").read_bytes() == first
