"""Closer looks where occlusion changes fast: a head that comes and goes between two samples is seen in time.

Samples lie about a second apart. Where between two of them another camera has become the better one by far, all cameras
are decoded and scored five times a second. Right before a movement of the lamp and after it is looked in any case where
no sample lies near: the next one may be a movement away. The cost grows with how often that happens, not with the
recording.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Movement
from mcsl_core.edl.following import shown_at
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.occlusion.scoring import ScoringSegment
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT
from mcsl_core.timing import FrameRange, joined


@frozen
class CloseLookSettings:
    """Where to look closer, and how closely.

    Attributes
    ----------
    change : float
        A share of the field: it is looked closer between two samples where the camera that was best at one shows so
        much less at the other than the one that is best there.
    step_s : float
        Seconds between the frames that are scored there.

    Notes
    -----
    On simulated heads that come and go within a second or two half of the recording were looked at closely,
    with heads that stay for some seconds a tenth; every frame of it scored so gained 0.4 % of the field at most.
    """

    change: float = field(default=0.2)
    step_s: float = field(default=0.2)


def look_closer(
    table: ScoreTable,
    footage: Footage,
    segments: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    progress: Progress,
    settings: CloseLookSettings = CloseLookSettings(),
) -> ScoreTable:
    """Adds samples to a table where occlusion changes fast.

    Parameters
    ----------
    table : ScoreTable
        Of the samples.
    footage : Footage
        Where the pictures between them are read from.
    segments : sequence of ScoringSegment
        What scores them.
    movements : sequence of Movement
        In them there is no data, and no closer look; right before and after them a look. Those that are followed are
        looked at closely all along: arms grip the lamp, and every view goes over the field.
    progress : Progress
        Told of every frame that is scored.
    settings : CloseLookSettings, optional
        Where, and how closely.

    Returns
    -------
    ScoreTable
        ``table`` with rows for the frames between; those of its samples at which it was looked anew are of the very
        frame and no longer of the keyframe nearest to it.
    """
    step = max(1, round(settings.step_s * float(footage.rate)))
    held = [movement for movement in movements if not movement.views]
    alone = [FrameRange(n, n + 1) for n in unseen_edges(table, held, footage.frames, step)]
    looks = [look for one in alone for look in _within(one, step, segments, held)]
    progress.stage("Looking before and after movements", len(looks), "frames")
    table = _with_rows(table, _looked(table.cameras, footage, looks, progress))
    followed = [movement.range for movement in movements if movement.views]
    stretches = joined([*fast_changes(table, step, settings.change), *followed])
    looks = [look for stretch in stretches for look in _within(stretch, step, segments, held)]
    progress.stage("Looking closer where much changes", sum(len(frames) for _, frames in looks), "frames")
    return _with_rows(table, _looked(table.cameras, footage, looks, progress))


def unseen_edges(table: ScoreTable, movements: Sequence[Movement], frames: int, step: int) -> list[int]:
    """Where the lamp stands before and after its movements and no sample tells what is seen.

    Parameters
    ----------
    table : ScoreTable
        Of the samples.
    movements : sequence of Movement
        In order.
    frames : int
        Length of the programme.
    step : int
        So many frames off a movement the lamp surely stands; a sample within as many of there is near enough.

    Returns
    -------
    list of int
        Programme frames, rising. What the last one before a movement shows stands for the movement's first half: a head
        that came after the sample before it hides the field for as long.
    """
    known = table.frames[~np.isnan(table.visible).all(axis=1)]
    edges = {n for m in movements for n in (m.range.start - step, m.range.stop - 1 + step)}
    possible = (n for n in edges if 0 <= n < frames and not any(n in m.range for m in movements))
    return sorted(n for n in possible if not len(known) or np.abs(known - n).min() > step)


def _looked(
    cameras: Sequence[str],
    footage: Footage,
    looks: Sequence[tuple[ScoringSegment, list[int]]],
    progress: Progress,
) -> dict[int, tuple[NDArray, NDArray]]:
    """Frame -> (visible, usable) of all cameras at the frames that are looked at."""
    rows: dict[int, tuple[NDArray, NDArray]] = {}
    for segment, frames in looks:
        pictures = [footage.pictures(camera, frames, height=SAMPLE_HEIGHT) for camera in cameras]
        for together in zip(*pictures, strict=True):
            shown = {camera: picture for camera, (_, picture) in zip(cameras, together, strict=True)}
            frame = together[0][0]
            taken = {name: shown_at(footage.camera(name), frame, footage.rate) for name in cameras}
            views = segment.views(shown, taken)
            scores = segment.score(views)
            there = {view.camera for view in views}
            usable = np.array([camera in there for camera in cameras])
            rows[frame] = np.array([scores.get(camera, np.nan) for camera in cameras]), usable
            progress.advance(len(rows))
    return rows


def fast_changes(table: ScoreTable, step: int, change: float) -> list[FrameRange]:
    """Where occlusion changes fast.

    Parameters
    ----------
    table : ScoreTable
        Of S samples.
    step : int
        Samples no further apart than so many frames are close enough.
    change : float
        See `CloseLookSettings`.

    Returns
    -------
    list of FrameRange
        Each from a sample up to and with a later one, in order, without overlap; neighbours are one.
    """
    seen = np.where(table.usable & ~np.isnan(table.visible), table.seen_at(table.frames), -1.0)
    stretches: list[FrameRange] = []
    for i in range(len(seen) - 1):
        a, b = seen[i], seen[i + 1]
        start, stop = int(table.frames[i]), int(table.frames[i + 1]) + 1
        stale = max(b.max() - b[a.argmax()], a.max() - a[b.argmax()])
        if min(a.max(), b.max()) < 0 or stale <= change or stop - 1 - start <= step:
            continue
        if stretches and stretches[-1].stop > start:
            stretches[-1] = FrameRange(stretches[-1].start, stop)
        else:
            stretches.append(FrameRange(start, stop))
    return stretches


def _within(
    stretch: FrameRange, step: int, segments: Sequence[ScoringSegment], movements: Sequence[Movement]
) -> list[tuple[ScoringSegment, list[int]]]:
    """Which frames of a stretch to score, and by what."""
    frames = [n for n in range(stretch.start, stretch.stop, step) if not any(n in m.range for m in movements)]
    found = [(segment, [n for n in frames if n in segment.range]) for segment in segments]
    return [(segment, inside) for segment, inside in found if inside]


def _with_rows(table: ScoreTable, rows: dict[int, tuple[NDArray, NDArray]]) -> ScoreTable:
    """The table with these rows, frame -> (visible, usable), in place of its own or between them."""
    if not rows:
        return table
    own = {int(n): (table.visible[i], table.usable[i], table.shown[i]) for i, n in enumerate(table.frames)}
    close = {n: (*row, np.full(len(table.cameras), n)) for n, row in rows.items()}
    merged = dict(sorted({**own, **close}.items()))
    visible, usable, shown = (np.array(part) for part in zip(*merged.values(), strict=True))
    return ScoreTable(np.array(list(merged)), table.cameras, visible, usable, shown=shown)
