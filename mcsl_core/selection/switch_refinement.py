"""The switches of the shots moved to the very frame.

Samples lie about a second apart; around a switch the two cameras are decoded more densely. The cost grows with the
number of switches, not with the length of the recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import attrs
import numpy as np
from attrs import field, frozen

from mcsl_core.edl import Movement, Shot
from mcsl_core.occlusion.scoring import ScoringSegment
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT
from mcsl_core.timing import FrameRange


@frozen
class RefinementSettings:
    """reach_s: a switch moves by so much at most. step_s: how densely it is looked at. least_s: no shot is made shorter
    than this, or than it was. moving_reach_s: as reach_s, of a switch while the lamp moves."""

    reach_s: float = field(default=1.0)
    moving_reach_s: float = field(default=3.0)
    step_s: float = field(default=0.16)
    least_s: float = field(default=2.0)


def refine_switches(
    shots: Sequence[Shot],
    footage: Footage,
    pieces: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    progress: Progress,
    settings: RefinementSettings = RefinementSettings(),
) -> tuple[int, ...]:
    """The frames to switch at: for every switch where its two cameras together show most of the field.

    No score holds while the lamp moves. A switch that falls into a movement goes to its middle, where the pose changes
    and the picture jumps in any case: so the viewer sees one camera up to there, one from there on, and one jump.
    """
    rate = float(footage.rate)
    least = round(settings.least_s * rate)
    cuts = [s.range.start for s in shots[1:]]
    ends = [0, *cuts, footage.frames]
    progress.stage("Refining the switches", len(cuts), "switches")
    for n, (before, after) in enumerate(zip(shots, shots[1:], strict=False)):
        # The switch before has been moved already, the one after has not: both bound this one.
        moving = next((m.range for m in movements if ends[n + 1] in m.range), None)
        reach = round((settings.reach_s if moving is None else settings.moving_reach_s) * rate)
        earliest = max(ends[n] + min(least, ends[n + 1] - ends[n]), ends[n + 1] - reach)
        latest = min(ends[n + 2] - min(least, ends[n + 2] - ends[n + 1]), ends[n + 1] + reach)
        piece = next((p for p in pieces if ends[n + 1] in p.range), None)
        if moving is not None:
            middle = (moving.start + moving.stop) // 2
            if earliest <= middle <= latest:
                ends[n + 1] = middle
        elif piece is not None and latest > earliest and not _moving(earliest, latest, movements):
            span = FrameRange(max(earliest, piece.range.start), min(latest + 1, piece.range.stop))
            ends[n + 1] = _best_cut(ends[n + 1], span, before.camera, after.camera, footage, piece, settings)
        progress.advance(n + 1)
    return tuple(ends[1:-1])


def with_switches_at(shots: Sequence[Shot], cuts: Sequence[int]) -> tuple[Shot, ...]:
    """``shots`` with their switches at the frames ``cuts``, one fewer than shots."""
    ends = [0, *cuts, shots[-1].range.stop]
    return tuple(
        attrs.evolve(shot, range=FrameRange(start, stop))
        for shot, (start, stop) in zip(shots, pairwise(ends), strict=True)
    )


def _moving(start: int, stop: int, movements: Sequence[Movement]) -> bool:
    return any(m.range.start <= stop and start < m.range.stop for m in movements)


def _best_cut(
    cut: int,
    span: FrameRange,
    before: str,
    after: str,
    footage: Footage,
    piece: ScoringSegment,
    settings: RefinementSettings,
) -> int:
    """The frame of ``span`` to switch at: most visible field in ``before`` up to it and in ``after`` from it on."""
    frames = list(range(span.start, span.stop, max(1, round(settings.step_s * float(footage.rate)))))
    seen = [_seen(camera, frames, footage, piece) for camera in (before, after)]
    known = ~np.isnan(seen[0]) & ~np.isnan(seen[1])
    if known.sum() < 2:
        return cut
    every = np.arange(span.start, span.stop)
    gain = np.interp(every, np.array(frames)[known], (seen[0] - seen[1])[known])
    worth = np.concatenate([[0.0], np.cumsum(gain)[:-1]])  # of staying with `before` up to each frame
    # Of equals the one nearest to where the samples put it.
    best = np.flatnonzero(worth >= worth.max() - 1e-9)
    return int(every[best[np.argmin(np.abs(every[best] - cut))]])


def _seen(camera: str, frames: Sequence[int], footage: Footage, piece: ScoringSegment) -> np.ndarray:
    """(N,) visible field of ``camera`` at ``frames``, NaN without picture."""
    seen = np.full(len(frames), np.nan)
    for n, (_, picture) in enumerate(footage.pictures(camera, frames, height=SAMPLE_HEIGHT)):
        views = piece.moments.scene.views({camera: picture})
        if views:
            seen[n] = piece.score(views)[camera]
    return seen
