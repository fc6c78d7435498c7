"""What the report says first."""

from __future__ import annotations

import numpy as np
from builders import small_edl

from mcsl_core.analysis.measurements import Measurements
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.report.facts import gather
from mcsl_core.report.headline import visible_field


def test_closer_samples_do_not_count_more() -> None:
    """Three fifths of the programme all is seen; then, looked at closely, nothing."""
    edl = small_edl(300)
    frames = np.array([120, *range(240, 300, 2)])
    shape = (len(frames), len(edl.cameras))
    visible = np.zeros(shape)
    visible[0] = 1
    table = ScoreTable(frames, tuple(c.name for c in edl.cameras), visible, np.ones(shape, bool))
    assert visible_field(edl, table) == (0.6, 0.6)
    assert [lane.visible for lane in gather(edl, Measurements(table)).lanes] == ["60%"] * len(edl.cameras)
