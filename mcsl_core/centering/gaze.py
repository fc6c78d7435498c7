"""Gaze: where viewers looked, as eye trackers record it, and the fixations in it: points that the eyes rest on."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.timing import FrameRange

# Frame, camera -> (3, 3), camera pixel to programme pixel; None where it is not known.
ToProgramme = Callable[[int, str], NDArray[np.float64] | None]

WINDOW_S = 2.0  # over which one observer's eyes are taken together: they come to rest a few times in it
REST_S = 6.0  # eyes that are back sooner have not moved on
APART = 0.06  # share of the picture's width from which on it is another point


@frozen
class Gaze:
    """One sample of an eye tracker.

    Attributes
    ----------
    frame : float
        Programme frame, not rounded.
    observer : str
        Whose eyes.
    x, y : float
        Pixel of the programme without centering, or of ``camera``.
    camera : str, optional
        The camera whose picture the observer was shown.
    """

    frame: float
    observer: str
    x: float
    y: float
    camera: str | None = None


def fixations(
    gaze: Sequence[Gaze], to_programme: ToProgramme, *, frames: int, size: tuple[int, int], rate: float
) -> list[tuple[FrameRange, tuple[float, float]]]:
    """The points that the eyes rest on.

    Parameters
    ----------
    gaze : sequence of Gaze
        In any order; outside of the programme it does not count.
    to_programme : callable
        How a camera's picture lies in the programme at a frame; see `ToProgramme`.
    frames : int
        Length of the programme.
    size : (int, int)
        Its width and height.
    rate : float
        Its frames per second.

    Returns
    -------
    list of (FrameRange, (float, float))
        Ranges that tile [0, ``frames``) and the programme pixel (x, y) looked at in each; empty without any gaze.

    Notes
    -----
    Of each two seconds, each observer's median, and of those the mean over the observers; where nobody's eyes were
    recorded, what was last looked at. A new fixation begins where the eyes stay away from the one before by ``APART``
    of the width for ``REST_S``: eyes that wander to an instrument and back do not move the picture.

    References
    ----------
    The paper's section "Centering Surgical Field": the average of five observers' gaze in every frame.
    """
    step = WINDOW_S * rate
    means = _window_means(gaze, to_programme, frames, step)
    found: list[_Fixation] = []
    astray: list[tuple[int, NDArray[np.float64]]] = []
    for number in sorted(means):
        if not found:
            found.append(_Fixation(0, [means[number]]))
            continue
        if np.linalg.norm(means[number] - found[-1].point) <= APART * size[0]:
            found[-1].means.append(means[number])
            astray = []
            continue
        astray.append((number, means[number]))
        first, _ = astray[0]
        if (number + 1 - first) * WINDOW_S >= REST_S:
            found.append(_Fixation(first, [mean for _, mean in astray]))
            astray = []
    starts = [round(fixation.window * step) for fixation in found] + [frames]
    rested = []
    for fixation, (start, stop) in zip(found, pairwise(starts), strict=True):
        x, y = fixation.point
        rested.append((FrameRange(start, stop), (float(x), float(y))))
    return rested


@frozen(eq=False)
class _Fixation:
    """window: number of the window it begins with. means: (2,) each, of its windows."""

    window: int
    means: list[NDArray[np.float64]]

    @property
    def point(self) -> NDArray[np.float64]:
        return np.median(self.means, axis=0)


def _window_means(
    gaze: Sequence[Gaze], to_programme: ToProgramme, frames: int, step: float
) -> Mapping[int, NDArray[np.float64]]:
    """Number of the window of ``step`` frames -> (2,) the mean of the observers' medians."""
    windows: dict[int, dict[str, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
    for sample in gaze:
        point = _in_programme(sample, to_programme) if 0 <= sample.frame < frames else None
        if point is not None:
            windows[int(sample.frame // step)][sample.observer].append(point)
    return {
        number: np.mean([np.median(points, axis=0) for points in observers.values()], axis=0)
        for number, observers in windows.items()
    }


def _in_programme(sample: Gaze, to_programme: ToProgramme) -> tuple[float, float] | None:
    """The programme pixel looked at; None where it is not known how the camera lies then."""
    if sample.camera is None:
        return sample.x, sample.y
    matrix = to_programme(int(sample.frame), sample.camera)
    if matrix is None:
        return None
    x, y, w = matrix @ (sample.x, sample.y, 1.0)
    return (float(x / w), float(y / w)) if w > 1e-9 else None  # else behind the camera
