"""At which frames other cameras are looked at now and then: a fixed grid, so that a frame is the same wherever made."""

from __future__ import annotations

from mcsl_core.timing import FrameRange

GRID_S = 10.0  # a new look every so many seconds: a keyframe, where decoding on would take two seconds of CPU
MEDIAN_FRAMES = 7  # of which the median is taken, so that a hand or a head in up to three of them is not kept


def grid_step(still: FrameRange, rate: float) -> int:
    """Frames from one look to the next: fewer in a stretch that is too short for `LOOKS` of them."""
    return max(1, min(round(GRID_S * rate), len(still) // MEDIAN_FRAMES))


def grid_frames(still: FrameRange, step: int, last: int) -> tuple[int, ...]:
    """The latest `LOOKS` frames of the grid up to number ``last``, within ``still``; near its start the first ones."""
    first = -(-still.start // step)
    last = min(max(last, first + MEDIAN_FRAMES - 1), (still.stop - 1) // step)
    return tuple(n * step for n in range(max(first, last - MEDIAN_FRAMES + 1), last + 1))


def first_grid_frames(still: FrameRange, step: int) -> tuple[int, ...]:
    """The first `LOOKS` frames of the grid within ``still``."""
    return grid_frames(still, step, -(-still.start // step))
