"""What a picture is worth to who watches: how much of the field it shows, and how well.

All in one unit, seconds of a fully visible field, so that what a switch costs can be set against it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.occlusion.score_table import ScoreTable


@frozen
class ViewingWorth:
    """The worth of a camera's picture over a second.

    Of a camera that shows the share v of the field it is ``v - covered * (1 - v)**2``, less what each merit lacks,
    times its weight.

    Attributes
    ----------
    covered : float
        How many seconds more than one a second of a wholly covered field costs. 0 counts a second of it as ten seconds
        with a tenth covered; the 2 that is the default as twenty-five.
    sharpness, resolution, viewpoint : float
        What a camera that lacks this merit altogether counts less, as a share of the field: see
        `mcsl_core.selection.merits`.

    Notes
    -----
    By ``benchmarks/selection.py``, with quick heads and a switch at half a second, the field is covered for 0.7 seconds
    a minute in place of 2.4, for 13.6 switches in place of 9.1. A cheaper switch alone would do as much for the mean.
    """

    covered: float = field(default=2.0)
    sharpness: float = field(default=0.3)
    resolution: float = field(default=0.05)
    viewpoint: float = field(default=0.02)

    def of(self, visible: NDArray[np.float64]) -> NDArray[np.float64]:
        """The worth of so much visible field, any shape, -``covered`` to 1; it rises, the faster the less is seen."""
        return visible - self.covered * (1 - visible) ** 2

    def deductions(self, table: ScoreTable) -> Iterator[tuple[str, NDArray[np.float64]]]:
        """What is taken off for each merit that is known: its name, and (S, C) shares of the field, 0 or more."""
        for name, merit in table.merits.items():
            weight = getattr(self, name, 0.0)
            if weight:
                yield name, weight * (1 - merit)
