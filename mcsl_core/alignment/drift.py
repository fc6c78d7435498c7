"""How a camera's exposure and white balance drift inside a pose: gains by time, as few keys with lines between them.

Asked is what stands still in the camera's own picture (`steady`), and what stays from one picture to the next: a hand
or a head that comes in changes nothing, but for what the camera's own automatics make of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from heapq import merge
from itertools import pairwise

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import ColourKey
from mcsl_core.imaging.exposure import Exposure, Float, gain_between, levels, small
from mcsl_core.imaging.masks import resize_mask
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT, SampleStore
from mcsl_core.timing import FrameRange

from .aligned_views import Picture
from .observations import spread
from .steady import steady_view

Shown = tuple[int, Picture]  # a programme frame and a camera's picture of it


@frozen
class DriftSettings:
    """What counts as drift, and how closely it is followed.

    Attributes
    ----------
    least : float
        A camera whose gains stay so near to 1 does not drift: 2.5 codes at mid grey.
    exact : float
        Keys and the lines between them follow the gains to so much: 1.3 codes at mid grey. Gains are found to half of
        it, so that what stands still stays still.
    fast : float
        It is looked closer between two samples whose gains differ by so much.
    step_s : float
        Seconds between the pictures looked at there; a change of less than two of them counts as an error.
    share : float
        Of what counts, so much must have one gain between two pictures. Even where heads hide two thirds of a view;
        wrong ones contradict the others.
    moments : int
        How many samples a camera's usual picture is made of.
    """

    least: float = field(default=0.02)
    exact: float = field(default=0.01)
    fast: float = field(default=0.02)
    step_s: float = field(default=0.1)
    share: float = field(default=0.25)
    moments: int = field(default=24)


@frozen(eq=False)
class GainTrack:
    """A camera's gains over time.

    Attributes
    ----------
    frames : (T,) int array
        Programme frames, rising.
    gains : (T, 3) float array
        What its blue, green and red are to be multiplied with to be as usual.
    """

    frames: NDArray[np.int64]
    gains: NDArray[np.float64]

    def drifts(self, least: float) -> bool:
        """Whether any is further than ``least`` from 1."""
        return bool((np.abs(np.log(self.gains)) > least).any())

    def fast(self, change: float, step: int) -> list[FrameRange]:
        """Where gains change by more than ``change`` within a step: from one frame to another, neighbours joined."""
        found: list[FrameRange] = []
        steps = np.abs(np.diff(np.log(self.gains), axis=0)).max(axis=1) if len(self.frames) else ()
        for (start, last), much in zip(pairwise(self.frames.tolist()), steps, strict=False):
            if much <= change or last - start <= step:
                continue
            if found and found[-1].stop > start:
                found[-1] = FrameRange(found[-1].start, last + 1)
            else:
                found.append(FrameRange(start, last + 1))
        return found

    def keys(self, exact: float) -> tuple[ColourKey, ...]:
        """As few of its frames as can be so that lines between them are no further than ``exact`` off any gain."""
        kept, open_ends = {0, len(self.frames) - 1}, [(0, len(self.frames) - 1)]
        while open_ends:
            first, last = open_ends.pop()
            if last - first < 2:
                continue
            part = (self.frames[first : last + 1] - self.frames[first]) / (self.frames[last] - self.frames[first])
            line = self.gains[first] + part[:, None] * (self.gains[last] - self.gains[first])
            off = np.abs(line / self.gains[first : last + 1] - 1).max(axis=1)
            furthest = first + int(off.argmax())
            if off.max() > exact:
                kept.add(furthest)
                open_ends += [(first, furthest), (furthest, last)]
        rows = ((int(self.frames[i]), np.round(self.gains[i], 4).tolist()) for i in sorted(kept))
        return tuple((frame, red, green, blue) for frame, (blue, green, red) in rows)


def usual_exposure(pictures: Sequence[Picture]) -> Exposure | None:
    """What a camera shows steadily, as small as gains need it; None where that is nothing."""
    view = steady_view(pictures)
    if view is None or not view.steady.any():
        return None
    usual = small(view.picture)
    return Exposure(usual, resize_mask(view.steady, usual.shape[1::-1]))


def gain_track(usual: Exposure, shown: Iterable[Shown], share: float) -> GainTrack:
    """Finds a camera's gains.

    Parameters
    ----------
    usual : Exposure
        Of `usual_exposure`.
    shown : iterable of (int, (h, w, 3) uint8 array)
        Its pictures in order of time, with their programme frames.
    share : float
        See `DriftSettings`.

    Notes
    -----
    Each picture is compared with the usual one and with the one before, where a head that stays is no hindrance; where
    the usual one says nothing, with some further back. Without the one before, three of ten simulated cameras, whose
    views heads fill, were known for a third of the time; with it all for 98 %, to 0.8 % (rms), as the others.
    """
    everywhere = np.ones_like(usual.inside)
    frames: list[int] = []
    before: list[Float] = []
    pairs, ratios, weights = [(0, 0)], [np.zeros(3)], [1.0]  # of picture n + 1 against another; 0 is the usual one
    for frame, picture in shown:
        now, own = small(picture), len(frames) + 1
        direct = gain_between(now, usual.usual, usual.inside, share)
        compared = [(0, direct, _USUAL)] + [
            (own - back, gain_between(now, before[-back], everywhere, share), weight)
            for back, weight in (_BEFORE if direct is None else _BEFORE[:1])
            if back <= len(before)
        ]
        for other, log, weight in compared:
            if log is not None:
                pairs.append((own, other))
                ratios.append(log)
                weights.append(weight)
        frames.append(frame)
        before = [*before[-_BEFORE[-1][0] + 1 :], now]
    logs, group = levels(len(frames) + 1, np.array(pairs), np.array(ratios), np.array(weights))
    known = np.flatnonzero(group[1:] == group[0])
    return GainTrack(np.array(frames)[known], np.exp(_without_spikes((logs[1:] - logs[0])[known])))


# How many pictures back it is compared, and what that counts: after the errors there were, 0.002 from one picture to
# the next, 0.01 against the usual one, slowly changing. So steps are kept, and what the usual picture says is smoothed.
_BEFORE = ((1, 1.0), (3, 0.2), (8, 0.2), (21, 0.2))
_USUAL = 0.04


def drift_keys(
    camera: str,
    still: FrameRange,
    standing: Sequence[int],
    samples: SampleStore,
    footage: Footage,
    settings: DriftSettings = DriftSettings(),
) -> tuple[ColourKey, ...]:
    """The keys of one camera in one pose.

    Parameters
    ----------
    camera : str
        Its name.
    still : FrameRange
        In which the lamp stands still.
    standing : sequence of int
        Positions of the samples in it.
    samples : SampleStore
        The recording's samples.
    footage : Footage
        Where pictures between them are read from, where gains change fast.
    settings : DriftSettings, optional
        What counts as drift.

    Returns
    -------
    tuple of ColourKey
        In order of time; none where it does not drift.
    """
    own = [i for i in standing if samples.shows(i, camera) and samples.shown_frame(i, camera) in still]
    moments = [samples.picture(i, camera) for i in spread(own, settings.moments)] if own else []
    usual = usual_exposure([picture for picture in moments if picture is not None])
    if usual is None:
        return ()
    track = gain_track(usual, _of_samples(samples, camera, own, ()), settings.share)
    if not len(track.frames):
        return ()
    middle = np.median(track.gains, axis=0)  # of what is evenly spread over time; the usual picture is a little off it
    step = max(1, round(settings.step_s * float(footage.rate)))
    stretches = _to_the_ends(track.fast(settings.fast, step), track, still)
    if stretches:
        closer = _between(footage, camera, [n for s in stretches for n in range(s.start, s.stop, step)])
        shown = merge(_of_samples(samples, camera, own, stretches), closer, key=lambda one: one[0])
        track = gain_track(usual, shown, settings.share)
    track = GainTrack(track.frames, track.gains / middle)
    return track.keys(settings.exact) if track.drifts(settings.least) else ()


def _of_samples(
    samples: SampleStore, camera: str, positions: Sequence[int], but: Sequence[FrameRange]
) -> Iterator[Shown]:
    """The pictures of these samples, each once, but for those that belong to a frame in any of ``but``."""
    last = -1
    for position in positions:
        frame = samples.shown_frame(position, camera)
        if frame <= last or any(frame in piece for piece in but):
            continue
        picture = samples.picture(position, camera)
        if picture is not None:
            last = frame
            yield frame, picture


def _between(footage: Footage, camera: str, frames: Sequence[int]) -> Iterator[Shown]:
    pictures = footage.pictures(camera, frames, height=SAMPLE_HEIGHT) if frames else ()
    return ((frame, picture) for frame, picture in pictures if picture is not None)


def _to_the_ends(stretches: list[FrameRange], track: GainTrack, still: FrameRange) -> list[FrameRange]:
    """The stretches, those at the first or the last sample up to the end of ``still``."""
    if stretches and stretches[0].start == track.frames[0]:
        stretches[0] = FrameRange(still.start, stretches[0].stop)
    if stretches and stretches[-1].stop == track.frames[-1] + 1:
        stretches[-1] = FrameRange(stretches[-1].start, still.stop)
    return stretches


def _without_spikes(logs: NDArray[np.float64]) -> NDArray[np.float64]:
    """The median of each and its two neighbours: what is fast was looked at closely, and one alone is an error."""
    if len(logs) < 3:
        return logs
    return np.concatenate([logs[:1], np.median([logs[:-2], logs[1:-1], logs[2:]], axis=0), logs[-1:]])
