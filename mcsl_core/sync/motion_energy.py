"""Motion energy: of every picture, the share of pixels that changed since the picture before."""

from __future__ import annotations

import threading
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from fractions import Fraction

import cv2
import numpy as np
import scipy
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.media.frames import to_planes
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

Array = NDArray[np.float64]

SIZE = (64, 36)
CHANGED = (4, 10)  # grey levels: past the noise of a downscaled picture; past the shimmer of wet tissue
BASELINE_S = 8.0


@frozen(eq=False)
class MotionTrack:
    """Motion energy of one camera over time.

    Attributes
    ----------
    values
        (2, n): log share of changed pixels by either threshold of `CHANGED`, less its moving average.
    start_s
        The camera's own time of the first.
    rate
        Values per second.
    """

    values: Array
    start_s: float
    rate: float


def motion_tracks(
    footage: Footage, pieces: Mapping[str, tuple[float, float]], rate: float, progress: Progress
) -> dict[str, MotionTrack]:
    """Motion energy of several cameras, two at once.

    Parameters
    ----------
    footage
        What to decode.
    pieces
        Camera -> (start, stop), seconds of its own time.
    rate
        Values per second.
    progress
        Told of each camera.
    """
    progress.stage("Watching what moves", len(pieces), "cameras")
    tracks: dict[str, MotionTrack] = {}
    stop = threading.Event()
    with ThreadPoolExecutor(max_workers=2) as workers:
        names = list(pieces)
        jobs = [workers.submit(motion_track, footage, name, *pieces[name], rate, stop) for name in names]
        try:
            for done, (name, job) in enumerate(zip(names, jobs, strict=True)):
                tracks[name] = job.result()
                progress.advance(done + 1)
        finally:
            stop.set()
    return tracks


def motion_track(
    footage: Footage, camera: str, start_s: float, stop_s: float, rate: float, stop: threading.Event | None = None
) -> MotionTrack:
    """Motion energy of one camera.

    Parameters
    ----------
    footage, camera
        What to decode.
    start_s, stop_s
        The camera's own times.
    rate
        Values per second.
    stop
        Once it is set, the track ends early.
    """
    start_s = max(0.0, start_s)
    times, changes = [], []
    before = None
    with closing(_greys(footage, camera, Fraction(start_s), Fraction(stop_s))) as greys:
        for time, grey in greys:
            if stop is not None and stop.is_set():
                break
            if before is not None:
                change = cv2.absdiff(grey, before)
                changes.append([float((change >= least).mean()) for least in CHANGED])
                times.append(float(time))
            before = grey
    return MotionTrack(_evenly(times, changes, start_s, rate), start_s, rate)


def _greys(
    footage: Footage, camera: str, start_s: Fraction, stop_s: Fraction
) -> Generator[tuple[Fraction, NDArray[np.uint8]]]:
    """(own time, downscaled luma) of every picture of a camera between two of its own times."""
    for part in footage.parts(camera):
        if part.end_s <= start_s or part.begin_s >= stop_s:
            continue
        with closing(VideoReader(part.facts, threads=1)) as reader:
            for time, frame in reader.read(max(part.facts.start_s, start_s - part.begin_s)):
                own = part.begin_s + time
                if own >= stop_s:
                    break
                if frame is None:  # what is damaged does not move
                    continue
                grey = to_planes(frame, part.facts).y
                yield own, cv2.resize(grey, SIZE, interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]


def _evenly(times: Sequence[float], changes: Sequence[Sequence[float]], start_s: float, rate: float) -> Array:
    """(2, n) at an even rate: the change between two pictures is spread evenly over their interval, then resampled."""
    if len(times) < 2:
        return np.zeros((len(CHANGED), 0))
    edges = np.arange(start_s, times[-1] + 1e-6, 1 / rate)
    sums = np.cumsum(np.array(changes), axis=0)
    tracks = np.array([np.diff(np.interp(edges, times, column)) for column in sums.T])
    # Logarithms: a head close to one lens changes twenty times as much as the hands that all of them see.
    level = np.log(tracks + 0.02 * tracks.mean(axis=1, keepdims=True) + 1e-4)
    baseline = scipy.ndimage.uniform_filter1d(level, round(BASELINE_S * rate) | 1, axis=1, mode="nearest")
    return np.clip(level - baseline, -3, 3)
