"""How an area is divided among cameras: the pictures come out as large as the area lets them."""

from __future__ import annotations

import pytest

from blender_addon.core.angles import rows_of


@pytest.mark.parametrize(
    ("size", "count", "rows"),
    [
        ((1600, 450), 2, (2,)),
        ((400, 900), 2, (1, 1)),
        ((768, 432), 4, (2, 2)),
        ((400, 900), 5, (1, 1, 1, 1, 1)),
        ((768, 700), 5, (2, 2, 1)),
        ((1600, 450), 9, (5, 4)),
        ((300, 300), 1, (1,)),
    ],
)
def test_the_grid_follows_the_area(size, count, rows):
    assert rows_of(*size, count) == rows
