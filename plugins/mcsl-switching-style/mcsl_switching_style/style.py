"""What an editor would say about cutting, and what that comes to in seconds of a fully visible field.

Everything is weighed in one currency: a second in which the whole field shows is worth 1. A sample stands for the
frames around it; cuts fall on the borders between samples (`mcsl` moves them to the frame afterwards).
"""

from __future__ import annotations

from math import inf

import numpy as np
from attrs import field, frozen, validators
from numpy.typing import NDArray

from mcsl_core.hooks import ScoreTable, UsageError, worth

FIRST = "first"  # as the preferred camera: the recording's first, which is its reference by default

AT_LEAST_0 = validators.ge(0.0)
SHARE = validators.and_(validators.ge(0.0), validators.le(1.0))


@frozen
class Style:
    """min_shot_s: no shot is shorter (but a programme that is shorter itself is one shot). max_shot_s: a longer one
    costs `long_cost` a second beyond.

    cut_cost_s: what every cut must gain. preferred: a camera's name, "first", or "" for none; preference: what it
    counts more than the others, as a share of the field. return_s, return_cost_s: going back to the camera before after
    less than so long costs so much. hold, hold_cost_s: so does leaving a camera that still shows this share of the
    field.
    """

    min_shot_s: float = field(default=4.0, validator=AT_LEAST_0)
    max_shot_s: float = field(default=inf, validator=AT_LEAST_0)
    long_cost: float = field(default=0.1, validator=AT_LEAST_0)
    cut_cost_s: float = field(default=1.0, validator=AT_LEAST_0)
    preferred: str = field(default="")
    preference: float = field(default=0.1, validator=AT_LEAST_0)
    return_s: float = field(default=0.0, validator=AT_LEAST_0)
    return_cost_s: float = field(default=0.0, validator=AT_LEAST_0)
    hold: float = field(default=1.0, validator=SHARE)
    hold_cost_s: float = field(default=0.0, validator=AT_LEAST_0)


CALM = Style(min_shot_s=6, cut_cost_s=2, return_s=20, return_cost_s=3, hold=0.6, hold_cost_s=3)
CLOSE = Style(
    min_shot_s=1.5,
    max_shot_s=20,
    long_cost=0.05,
    cut_cost_s=0.3,
    return_s=4,
    return_cost_s=0.5,
    hold=0.97,
    hold_cost_s=0.5,
)
TEACHING = Style(
    min_shot_s=4,
    cut_cost_s=1,
    preferred=FIRST,
    preference=0.25,
    return_s=6,
    return_cost_s=0.5,
    hold=0.75,
    hold_cost_s=1,
)


@frozen(eq=False)
class Costs:
    """A style on a recording, in frames of a fully visible field; S samples, C cameras.

    value: (S, C) what each camera's sample is worth. borders: (S + 1,) frames. leaving: (S + 1, C) what a cut at that
    border costs beside `cut` for leaving that camera. The others as in `Style`, times the rate.
    """

    value: NDArray[np.float64]
    borders: NDArray[np.int64]
    leaving: NDArray[np.float64]
    cut: float
    least: float
    most: float
    long: float
    soon: float
    back: float


def costs_of(style: Style, table: ScoreTable, borders: NDArray[np.int64], rate: float) -> Costs:
    """UsageError where the preferred camera is none of the table's."""
    value = worth(table, borders)
    if style.preferred:
        name = table.cameras[0] if style.preferred == FIRST and FIRST not in table.cameras else style.preferred
        if name not in table.cameras:
            raise UsageError(
                f"prefers camera {name!r}, which is not there", remedy=f"Name one of {', '.join(table.cameras)}"
            )
        value[:, table.cameras.index(name)] += style.preference * np.diff(borders)
    # Whether a camera still shows the field is asked of the sample after the cut: that is what the viewer misses.
    holding = np.where(table.usable, table.seen, 0.0) >= style.hold  # NaN, no data, holds nobody
    leaving = np.zeros((len(borders), len(table.cameras)))
    leaving[:-1] = np.where(holding, style.hold_cost_s * rate, 0.0)
    return Costs(
        value=value,
        borders=borders,
        leaving=leaving,
        cut=style.cut_cost_s * rate,
        least=style.min_shot_s * rate,
        most=style.max_shot_s * rate,
        long=style.long_cost,
        soon=style.return_s * rate,
        back=style.return_cost_s * rate,
    )
