"""The grid of frames from which a camera's medians are made: fixed, so that a frame is the same in whatever range made.

A median of several pictures shows what stays in view without whoever moves: a temporal median background.
"""

from __future__ import annotations

from mcsl_core.timing import FrameRange

GRID_S = 10.0  # from one grid frame to the next: each is a keyframe, where decoding on would take two seconds of CPU
MEDIAN_FRAMES = 7  # of which the median is taken, so that a hand or a head in up to three of them is not kept


def grid_step(still: FrameRange, rate: float) -> int:
    """Distance of the grid's frames in a pose.

    Parameters
    ----------
    still : FrameRange
        The pose's range in which the lamp stands still.
    rate : float
        Programme frames per second.

    Returns
    -------
    int
        Frames from one grid frame to the next: `GRID_S`, or less where ``still`` is too short for `MEDIAN_FRAMES`.
    """
    return max(1, min(round(GRID_S * rate), len(still) // MEDIAN_FRAMES))


def grid_frames(still: FrameRange, step: int, last: int) -> tuple[int, ...]:
    """The latest `MEDIAN_FRAMES` frames of the grid up to a given one.

    Parameters
    ----------
    still : FrameRange
        The range they lie in.
    step : int
        See `grid_step`.
    last : int
        Index in the grid of the latest frame wanted; frame ``last * step``.

    Returns
    -------
    tuple of int
        Programme frames, rising; near the start of ``still`` its first ones.
    """
    first = -(-still.start // step)
    last = min(max(last, first + MEDIAN_FRAMES - 1), (still.stop - 1) // step)
    return tuple(n * step for n in range(max(first, last - MEDIAN_FRAMES + 1), last + 1))


def first_grid_frames(still: FrameRange, step: int) -> tuple[int, ...]:
    """The first `MEDIAN_FRAMES` frames of the grid within ``still``; see `grid_frames`."""
    return grid_frames(still, step, -(-still.start // step))
