"""Closer looks where the programme is in doubt: a head that comes and goes between two samples is seen in time.

Samples lie about a second apart. A programme is chosen by them. Where anybody has come or gone from one to the next, or
just before and just after, it is looked between them, five times a second: at all cameras where the programme shows
much less than it could, else at those that it shows, and at all where these turn out to be covered. Then it is chosen
anew, until nothing new is found. Right before a movement of the lamp, after it and at the end it is looked in any case
where no sample lies near. The cost grows with how often heads come and go, not with the recording.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import TypeVar

import attrs
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Movement, Shot
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.occlusion.scoring import ScoringSegment
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT
from mcsl_core.timing import FrameRange, joined

T = TypeVar("T")
Choose = Callable[[ScoreTable], Sequence[Shot]]
# Frame -> (visible, usable, shown) of some cameras, as a `ScoreTable` has them.
Rows = Mapping[int, tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.int64]]]
Look = Callable[[Sequence[str], Sequence[FrameRange]], Rows]


@frozen
class CloseLookSettings:
    """Where to look closer, and how closely.

    Attributes
    ----------
    change : float
        A share of the field, for all that is told apart: somebody has come or gone where that of any camera differs by
        more from one sample to the next; a camera shows much less where it is so much less than of the best one, or
        than its own samples before and after say.
    step_s : float
        Seconds between the frames that are scored there.

    Notes
    -----
    Of 25 simulated recordings of 24 s a quarter of all cameras' frames was decoded so: 2 to 12 % of most with usual
    heads, half with quick ones. Looking at the cameras on air all along decoded 38 %, and where scores are good showed
    no more of the field.
    """

    change: float = field(default=0.2)
    step_s: float = field(default=0.2)


@frozen
class Doubt:
    """A stretch between two samples in which somebody has come or gone, or just before it and just after.

    Attributes
    ----------
    stretch : FrameRange
        From the sample before up to and with the sample after.
    shown : tuple of str
        The cameras on air in it.
    poor : bool
        Whether one of them shows much less than the best camera at either sample.
    """

    stretch: FrameRange
    shown: tuple[str, ...]
    poor: bool


def look_around_movements(
    table: ScoreTable,
    footage: Footage,
    segments: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    progress: Progress,
    settings: CloseLookSettings = CloseLookSettings(),
) -> ScoreTable:
    """Adds samples to a table right before the lamp's movements and after them, and at the end, whatever is chosen.

    Parameters
    ----------
    table : ScoreTable
        Of the samples.
    footage : Footage
        Where the pictures between them are read from.
    segments : sequence of ScoringSegment
        What scores them.
    movements : sequence of Movement
        Those that are followed are looked at closely all along: arms grip the lamp, and every view goes over the field.
        In others there is no data.
    progress : Progress
        Told of every frame that is scored.
    settings : CloseLookSettings, optional
        How closely.

    Returns
    -------
    ScoreTable
        ``table`` with rows for the frames between.
    """
    looks = _Looks.of(footage, segments, movements, progress, settings)
    edges = [FrameRange(n, n + 1) for n in unseen_edges(table, looks.held, footage.frames, looks.step)]
    followed = [movement.range for movement in movements if movement.views]
    for stretches in edges, joined(followed):
        table = _with_rows(table, looks.at(table.cameras, stretches))
    return table


def look_closer(
    table: ScoreTable,
    footage: Footage,
    segments: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    choose: Choose,
    progress: Progress,
    settings: CloseLookSettings = CloseLookSettings(),
) -> ScoreTable:
    """Adds samples to a table where the programme is in doubt.

    Parameters
    ----------
    table : ScoreTable
        Of `look_around_movements`.
    footage, segments, progress
        As of `look_around_movements`.
    movements : sequence of Movement
        In those that are not followed there is no data, and no closer look.
    choose : callable
        The shots of a programme, by a table.
    settings : CloseLookSettings, optional
        Where, and how closely.

    Returns
    -------
    ScoreTable
        ``table`` with rows for the frames between; those of its samples at which it was looked anew are of the very
        frame and no longer of the keyframe nearest to it.
    """
    looks = _Looks.of(footage, segments, movements, progress, settings)
    return without_doubts(table, choose, looks.at, looks.step, settings.change)


def without_doubts(table: ScoreTable, choose: Choose, look: Look, step: int, change: float) -> ScoreTable:
    """Chooses a programme, looks where it is in doubt, and chooses anew, until nothing new is to be looked at.

    Parameters
    ----------
    table : ScoreTable
        Of S samples.
    choose : callable
        The shots of a programme, by a table.
    look : callable
        Scores some cameras in stretches, at frames that lie ``step`` apart from each one's first.
    step : int
        Samples no further apart than so many frames are close enough.
    change : float
        See `CloseLookSettings`.

    Returns
    -------
    ScoreTable
        ``table`` with rows of all cameras where it was worth to look at all.
    """
    if not _minds_scores(table, choose):
        return table
    alone: dict[str, dict[int, float]] = {camera: {} for camera in table.cameras}  # what single cameras show
    alone_at: set[tuple[str, FrameRange]] = set()
    done: set[FrameRange] = set()
    while True:
        found = [doubt for doubt in doubts(table, choose(table), step, change) if doubt.stretch not in done]
        for camera, seen in alone.items():
            asked = {(camera, doubt.stretch) for doubt in found if camera in doubt.shown and not doubt.poor} - alone_at
            rows = look((camera,), joined(stretch for _, stretch in asked))
            seen |= {frame: float(visible[0]) for frame, (visible, *_) in rows.items()}
            alone_at |= asked
        certain = [d.stretch for d in found if d.poor or _covered(d, table, alone, change)]
        if not certain:
            return table
        table = _with_rows(table, look(table.cameras, joined(certain)))
        done |= set(certain)


def doubts(table: ScoreTable, shots: Sequence[Shot], step: int, change: float) -> list[Doubt]:
    """Where a programme may not show what its samples say.

    Parameters
    ----------
    table : ScoreTable
        Of S samples.
    shots : sequence of Shot
        The programme.
    step : int
        Samples no further apart than so many frames are close enough.
    change : float
        See `CloseLookSettings`.

    Returns
    -------
    list of Doubt
        In order.
    """
    seen = table.seen_at(table.frames)
    there = table.usable & ~np.isnan(table.visible)
    best = np.where(there, seen, 0.0).max(axis=1, initial=0.0)
    apart = np.where(there[1:] & there[:-1], np.abs(np.diff(seen, axis=0)), 0.0).max(axis=1, initial=0.0)
    busy = apart > change
    busy[1:-1] |= busy[:-2] & busy[2:]  # who comes and goes within a stretch does so among others
    starts, stops = [shot.range.start for shot in shots], [shot.range.stop for shot in shots]
    found = []
    for i in np.flatnonzero(busy & (np.diff(table.frames) > step)):
        first, last = int(table.frames[i]), int(table.frames[i + 1])
        on_air = shots[bisect_right(stops, first) : bisect_left(starts, last + 1)]
        shown = tuple(sorted({shot.camera for shot in on_air}))
        columns = [table.cameras.index(camera) for camera in shown]
        lacks = best[i : i + 2, None] - seen[i : i + 2, columns]
        found.append(Doubt(FrameRange(first, last + 1), shown, bool(lacks.max(initial=0.0) > change)))
    return found


def unseen_edges(table: ScoreTable, movements: Sequence[Movement], frames: int, step: int) -> list[int]:
    """Where no sample tells what is seen: before and after the lamp's movements, and at the end.

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
    edges = {n for m in movements for n in (m.range.start - step, m.range.stop - 1 + step)} | {frames - 1}
    possible = (n for n in edges if 0 <= n < frames and not any(n in m.range for m in movements))
    return sorted(n for n in possible if not len(known) or np.abs(known - n).min() > step)


def _minds_scores(table: ScoreTable, choose: Choose) -> bool:
    """Whether another camera is chosen where another one alone sees the field: of one that is fixed, no look tells."""

    def cameras(alone: int) -> list[tuple[FrameRange, str]]:
        visible = np.where(np.isnan(table.visible), np.nan, np.arange(len(table.cameras)) == alone)
        return [(shot.range, shot.camera) for shot in choose(attrs.evolve(table, visible=visible))]

    first, *others = (cameras(alone) for alone in range(len(table.cameras)))
    return any(other != first for other in others)


@frozen
class _Looks:
    """Decodes and scores frames between samples; no frame of the ``held`` movements."""

    footage: Footage
    segments: Sequence[ScoringSegment]
    held: Sequence[Movement]
    step: int
    progress: Progress

    @classmethod
    def of(
        cls,
        footage: Footage,
        segments: Sequence[ScoringSegment],
        movements: Sequence[Movement],
        progress: Progress,
        settings: CloseLookSettings,
    ) -> _Looks:
        """With the movements that are not followed for held."""
        step = max(1, round(settings.step_s * float(footage.rate)))
        return cls(footage, segments, [movement for movement in movements if not movement.views], step, progress)

    def at(self, cameras: Sequence[str], stretches: Sequence[FrameRange]) -> Rows:
        """Of these cameras, at the frames of the stretches that lie ``step`` apart."""
        segment_of = {n: segment for stretch in stretches for segment, inside in self._within(stretch) for n in inside}
        if not segment_of:
            return {}
        self.progress.stage("Looking closer", len(segment_of), "frames")
        frames, rows = sorted(segment_of), {}
        with ThreadPoolExecutor(len(cameras)) as pool:
            # One decoder a camera for all stretches: to open one for each took a fifth of the time.
            early_s = self.step / float(self.footage.rate)
            glances = [
                _read_ahead(pool, self.footage.glances(name, frames, height=SAMPLE_HEIGHT, early_s=early_s))
                for name in cameras
            ]
            for frame, *together in zip(frames, *glances, strict=True):
                pictures, taken = (dict(zip(cameras, each, strict=True)) for each in zip(*together, strict=True))
                segment = segment_of[frame]
                views = segment.views(pictures, taken)
                scores, there = segment.score(views), {view.camera for view in views}
                visible = np.array([scores.get(camera, np.nan) for camera in cameras])
                usable = np.array([camera in there for camera in cameras])
                at = np.rint(list(taken.values())).astype(np.int64)
                visible[[any(int(n) in movement.range for movement in self.held) for n in at]] = np.nan
                rows[frame] = visible, usable, at
                self.progress.advance(len(rows))
        return rows

    def _within(self, stretch: FrameRange) -> list[tuple[ScoringSegment, list[int]]]:
        """Which frames of a stretch to score, and by what."""
        every = range(stretch.start, stretch.stop, self.step)
        frames = [n for n in every if not any(n in movement.range for movement in self.held)]
        found = [(segment, [n for n in frames if n in segment.range]) for segment in self.segments]
        return [(segment, inside) for segment, inside in found if inside]


def _read_ahead(pool: Executor, items: Iterator[T]) -> Iterator[T]:
    """The same, each made by a thread while the one before it is used."""
    coming = pool.submit(next, items, None)
    while (item := coming.result()) is not None:
        coming = pool.submit(next, items, None)
        yield item


def _covered(doubt: Doubt, table: ScoreTable, seen: dict[str, dict[int, float]], change: float) -> bool:
    """Whether a camera on air shows much less between two samples than they say; ``seen``: by camera and frame."""
    for camera in doubt.shown:
        frames = [n for n in range(doubt.stretch.start, doubt.stretch.stop) if n in seen[camera]]
        said = table.seen_at(np.array(frames, np.int64))[:, table.cameras.index(camera)]
        if any(before - seen[camera][n] > change for n, before in zip(frames, said, strict=True)):
            return True
    return False


def _with_rows(table: ScoreTable, rows: Rows) -> ScoreTable:
    """The table with these rows in place of its own or between them."""
    if not rows:
        return table
    own = {int(n): (table.visible[i], table.usable[i], table.shown[i]) for i, n in enumerate(table.frames)}
    merged = dict(sorted({**own, **rows}.items()))
    visible, usable, shown = (np.array(part) for part in zip(*merged.values(), strict=True))
    return ScoreTable(np.array(list(merged)), table.cameras, visible, usable, shown=shown)
