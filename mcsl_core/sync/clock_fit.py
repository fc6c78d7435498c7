"""What the methods of synchronising share: a refusal in words for a person, and the robust line through lags."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Clock
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

MAX_DRIFT = 500e-6  # share of the rate; ten times a poor crystal


class Refusal(Exception):
    """Why a camera's clock cannot be found in this way, in words for a person that follow "timecode: "."""


ClockResults = Mapping[str, Clock | Refusal]
# (cameras with default clocks, the reference camera, the cameras to be found, progress) -> one result for each
ClockFinder = Callable[[Footage, str, Sequence[str], Progress], ClockResults]


def length_s(footage: Footage, camera: str) -> float:
    """Seconds from the camera's own time 0 to its last picture's end."""
    return float(footage.parts(camera)[-1].end_s)


def robust_line(found: Sequence[tuple[float, float]], heard: int, within_s: float) -> tuple[float, float, float]:
    """The line through measured lags that most of them agree with: all pairs as hypotheses, then least squares.

    Parameters
    ----------
    found
        (time, lag) of each window with a clear lag, seconds.
    heard
        How many windows there were to be found in.
    within_s
        How far from the line a lag still agrees.

    Returns
    -------
    level, slope, share
        Lag at time 0 in seconds, seconds per second, and the share of ``heard`` that agree.

    Raises
    ------
    Refusal
        When fewer than three, or fewer than half of the windows, agree.
    """
    if len(found) < 3:
        raise Refusal(f"only {len(found)} of {heard} windows have something in common")
    points = np.array(found)
    best: NDArray[np.bool_] | None = None
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            slope = (points[j, 1] - points[i, 1]) / (points[j, 0] - points[i, 0])
            if abs(slope) > MAX_DRIFT:
                continue
            near = np.abs(points[:, 1] - points[i, 1] - slope * (points[:, 0] - points[i, 0])) < within_s
            if best is None or near.sum() > best.sum():
                best = near
    if best is None or best.sum() < 3 or best.sum() < heard / 2:
        agree = 0 if best is None else int(best.sum())
        raise Refusal(f"only {agree} of {heard} windows agree on one clock")
    slope, level = np.polyfit(points[best, 0], points[best, 1], 1)
    return float(level), float(slope), float(best.sum() / heard)
