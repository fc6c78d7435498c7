"""The switches between shots moved to the very frame.

Samples lie about a second apart; around a switch the two cameras are decoded more densely. The cost grows with the
number of switches, not with the length of the recording.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

import attrs
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Movement, Shot
from mcsl_core.occlusion.scoring import ScoringSegment
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT
from mcsl_core.timing import FrameRange

from .protocol import least_frames

_GAP = 100.0  # a frame without a picture weighs more than any that are not clear
# Number of the switch and the frames it may go to -> the one of them to switch at.
ChooseFrame = Callable[[int, FrameRange], int]


@frozen
class RefinementSettings:
    """How far a switch is moved and how densely the pictures around it are scored.

    Attributes
    ----------
    reach_s : float
        Seconds by which a switch moves at most.
    moving_reach_s : float
        The same for a switch while the lamp moves.
    step_s : float
        Seconds between the frames that are scored around a switch.
    """

    reach_s: float = field(default=1.0)
    moving_reach_s: float = field(default=3.0)
    step_s: float = field(default=0.16)


def refine_switches(
    shots: Sequence[Shot],
    footage: Footage,
    segments: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    progress: Progress,
    *,
    min_shot_s: float,
    settings: RefinementSettings = RefinementSettings(),
) -> tuple[int, ...]:
    """Moves every switch to where its two cameras together show most of the field.

    Parameters
    ----------
    shots : sequence of Shot
        What the selector chose, tiling the programme.
    footage : Footage
        Where the pictures around the switches are read from.
    segments : sequence of ScoringSegment
        What scores them.
    movements : sequence of Movement
        While the lamp moves no score holds, unless it is followed.
    progress : Progress
        Told of every switch.
    min_shot_s : float
        The minimum shot length that the selector promised, in seconds. No shot becomes shorter, or than it was.
    settings : RefinementSettings, optional
        How far and how densely.

    Returns
    -------
    tuple of int
        The programme frames to switch at, one fewer than ``shots``; see `with_switches_at`.
    """
    step = max(1, round(settings.step_s * float(footage.rate)))

    def choose_frame(number: int, span: FrameRange) -> int:
        before, after = shots[number], shots[number + 1]
        switch = after.range.start
        segment = next((s for s in segments if switch in s.range), None)
        scored = None if segment is None else span.intersection(segment.range)
        if segment is None or scored is None:
            return switch
        frames = range(scored.start, scored.stop, step)
        seen, seen_after = (
            _visible(shot.camera, frames, footage, segment, settings.step_s) for shot in (before, after)
        )
        lacks = _gaps(footage, after.camera, scored) - _gaps(footage, before.camera, scored)
        return clearest(switch, scored, np.array(frames), seen - seen_after, lacks)

    progress.stage("Refining the switches", len(shots) - 1, "switches")
    switches: list[int] = []
    held = [movement for movement in movements if not movement.views]
    for switch in moved_switches(shots, held, footage.rate, min_shot_s, choose_frame, settings):
        switches.append(switch)
        progress.advance(len(switches))
    return tuple(switches)


def moved_switches(
    shots: Sequence[Shot],
    movements: Sequence[Movement],
    rate: Fraction,
    min_shot_s: float,
    choose_frame: ChooseFrame,
    settings: RefinementSettings = RefinementSettings(),
) -> Iterator[int]:
    """Where every switch goes: how far it may, and whom it is left to within that.

    No score holds while the lamp moves. A switch that falls into a movement goes to its middle, where the pose changes
    and the picture jumps in any case: so the viewer sees one camera up to there, one from there on, and one jump.

    Parameters
    ----------
    shots : sequence of Shot
        Tiling the programme.
    movements : sequence of Movement
        In order.
    rate : Fraction
        Programme frames per second.
    min_shot_s : float
        Seconds below which no shot is made shorter.
    choose_frame : callable
        Asked for the frame of every switch that may move and lies by no movement: (number of the switch from 0, range
        it may go to) -> a frame of that range.
    settings : RefinementSettings, optional
        How far a switch moves.

    Yields
    ------
    int
        The programme frame of each switch, in order. Whatever ``choose_frame`` answers, every shot is at least
        min(``min_shot_s``, what it lasted in ``shots``) long.
    """
    least = least_frames(min_shot_s, rate)
    start = 0  # of the shot before the switch, which has been moved already; the shot after still ends where it did
    for number, shot in enumerate(shots[1:]):
        switch, stop = shot.range.start, shot.range.stop
        moving = next((m.range for m in movements if switch in m.range), None)
        reach = round((settings.reach_s if moving is None else settings.moving_reach_s) * float(rate))
        earliest = max(start + min(least, switch - start), switch - reach)
        latest = min(stop - min(least, stop - switch), switch + reach)
        if moving is not None:
            middle = (moving.start + moving.stop) // 2
            if earliest <= middle <= latest:
                switch = middle
        elif latest > earliest and not _meets_movement(earliest, latest, movements):
            switch = choose_frame(number, FrameRange(earliest, latest + 1))
        yield switch
        start = switch


def with_switches_at(shots: Sequence[Shot], switches: Sequence[int]) -> tuple[Shot, ...]:
    """The shots with their switches moved.

    Parameters
    ----------
    shots : sequence of Shot
        Tiling the programme.
    switches : sequence of int
        Rising programme frames, one fewer than ``shots``.

    Returns
    -------
    tuple of Shot
        The same shots, each from its switch to the next.
    """
    ends = [0, *switches, shots[-1].range.stop]
    return tuple(
        attrs.evolve(shot, range=FrameRange(start, stop))
        for shot, (start, stop) in zip(shots, pairwise(ends), strict=True)
    )


def _meets_movement(first: int, last: int, movements: Sequence[Movement]) -> bool:
    """Whether the lamp moves at ``first``, ``last`` or between."""
    return any(m.range.start <= last and first < m.range.stop for m in movements)


def _gaps(footage: Footage, camera: str, span: FrameRange) -> NDArray[np.float64]:
    """For each frame of ``span`` 1 in a gap of ``camera``, else 0."""
    return np.array([footage.has_gap(camera, frame) for frame in span], np.float64)


def clearest(
    switch: int,
    span: FrameRange,
    frames: NDArray[np.int64],
    gain: NDArray[np.float64],
    lacks: NDArray[np.float64],
) -> int:
    """The frame to switch at: most visible field in the camera before up to it, in the one after from it.

    Parameters
    ----------
    switch : int
        Where the samples put it.
    span : FrameRange
        Where it may go.
    frames : (N,) int array
        Frames of ``span`` that are scored, rising.
    gain : (N,) float array
        How much more of the field the camera before shows at each of them, NaN without picture.
    lacks : (len(span),) float array
        For each frame of ``span`` 1 in a gap of the camera after, -1 in one of the camera before, else 0.

    Returns
    -------
    int
        A frame of ``span``; of equals the one nearest to ``switch``.
    """
    known = ~np.isnan(gain)
    if known.sum() < 2 and not lacks.any():
        return switch
    every = np.arange(span.start, span.stop)
    staying = np.interp(every, frames[known], gain[known]) if known.any() else np.zeros(len(every))
    staying[lacks != 0] = lacks[lacks != 0] * _GAP
    worth = np.concatenate([[0.0], np.cumsum(staying)[:-1]])  # of staying with the camera before up to each frame
    best = every[worth >= worth.max() - 1e-9]
    return int(best[np.argmin(np.abs(best - switch))])  # of equals the one nearest to where the samples put it


def _visible(
    camera: str, frames: Sequence[int], footage: Footage, segment: ScoringSegment, early_s: float
) -> NDArray[np.float64]:
    """(N,) visible field of ``camera`` at ``frames``, 0..1, NaN without picture; see `Footage.glances`."""
    visible, shown = np.full(len(frames), np.nan), np.array(frames, np.float64)
    glances = footage.glances(camera, frames, height=SAMPLE_HEIGHT, early_s=early_s)
    for position, (picture, taken) in enumerate(glances):
        views = segment.views({camera: picture}, {camera: taken})
        if views:
            visible[position], shown[position] = segment.score(views)[camera], taken
    known = ~np.isnan(visible)
    if known.any():
        visible[known] = np.interp(np.array(frames)[known], shown[known], visible[known])
    return visible
