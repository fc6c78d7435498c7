"""The selectors that come with mcsl: shots that tile the programme, from the table of visible field.

A sample stands for the frames around it: the border between two samples lies halfway between their frames.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Shot
from mcsl_core.errors import InputError, UsageError
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.timing import FrameRange

from .protocol import MIN_SHOT_S, least_frames
from .worth import ViewingWorth

# Worse than any sum of visible field over a day at 60 frames a second, better than infinity: where every camera
# is unusable the programme still shows one.
FORBIDDEN = -1e7


@frozen
class ShortestPath:
    """The programme that is worth most to watch, with a cost per switch and a hard minimum shot length.

    Attributes
    ----------
    min_shot_s : float
        No shot is shorter, in seconds (but a programme that is shorter itself is one shot).
    switch_cost_s : float
        A switch must gain so many seconds of fully visible field.
    worth : ViewingWorth
        How much a covered field counts against one that is partly covered, and what else counts: sharpness, how finely
        a camera shows the field, how near it looks from where the reference camera does.
    score_error : float
        By so much of the field scores differ by chance. What a camera seems to show less than the best one counts as a
        part of that, the less the nearer to it: d^2 / (d + ``score_error``). 0 believes every hundredth.
    seen_through : float
        So much of what is hidden from a camera and the best one shows counts as seen, 0..1: what the look
        ``see_through`` makes good.

    Notes
    -----
    Exact, by dynamic programming over (sample, camera).
    """

    min_shot_s: float = field(default=MIN_SHOT_S)
    switch_cost_s: float = field(default=0.5)
    worth: ViewingWorth = field(factory=ViewingWorth)
    score_error: float = field(default=0.03)
    seen_through: float = field(default=0.0)
    name = "shortest-path"

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> tuple[Shot, ...]:
        """Chooses the shots that are worth most; see `Selector.select`.

        Raises
        ------
        InputError
            Where the table has no sample.
        """
        borders = sample_borders(table, frames)
        deductions = tuple(self.worth.deductions(table))
        visible = with_heads_seen_through(table.seen_at(table.frames), table.usable, self.seen_through)
        seen = believed(visible, table.usable, self.score_error)
        each = self.worth.of(seen) - sum(off for _, off in deductions)
        value = np.where(table.usable, each, FORBIDDEN) * np.diff(borders)[:, None]
        total = np.vstack([np.zeros(value.shape[1]), np.cumsum(value, axis=0)])
        choice = _best_path(
            total, borders, least=least_frames(self.min_shot_s, rate), cost=self.switch_cost_s * float(rate)
        )
        return shots_from(choice, table, borders, "{visible}{next}", deductions)


@frozen
class ThroughHeads(ShortestPath):
    """`ShortestPath` for a programme that sees through heads: with fewer switches, for a covered camera shows more.

    Attributes
    ----------
    seen_through : float
        See there. What is measured is 0.6 to 0.8. By ``benchmarks/selection.py``, where heads are quick and 0.75 is
        seen through, to count on 0.5 shows 98.8 % of the field, on 0.75 96.3 % for a third of the switches.
    """

    seen_through: float = field(default=0.5)
    name = "through-heads"


@frozen
class LeastOccluded:
    """The camera that sees most at every sample, whatever the number of switches: the paper's greedy choice.

    It promises no minimum shot length: a shot is as short as a sample, and shorter at the programme's end.

    References
    ----------
    The paper's section "Method", the step "Selection".
    """

    name = "least-occluded"

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> tuple[Shot, ...]:
        """Chooses the best camera of every sample; see `Selector.select`.

        Raises
        ------
        InputError
            Where the table has no sample.

        Notes
        -----
        Of two that see equally much the one on air stays.
        """
        borders = sample_borders(table, frames)
        value = worth(table, borders)
        choice = np.zeros(len(value), np.int64)
        current = int(np.argmax(value[0]))
        for sample, row in enumerate(value):
            if row[current] < row.max():
                current = int(np.argmax(row))
            choice[sample] = current
        return shots_from(choice, table, borders, "sees most: {visible}{next}")


@frozen
class Fixed:
    """One camera throughout: the first of the recording, or the one it is made with.

    Attributes
    ----------
    camera : str, optional
        Its name.
    """

    camera: str | None = field(default=None)
    name = "fixed"

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> tuple[Shot, ...]:
        """One shot over the whole programme; see `Selector.select`.

        Raises
        ------
        UsageError
            Where there is no such camera.
        InputError
            Where the table has no sample.
        """
        camera = self.camera or table.cameras[0]
        if camera not in table.cameras:
            raise UsageError(f"there is no camera {camera!r}", remedy=f"Choose one of {', '.join(table.cameras)}")
        choice = np.full(len(table.frames), table.cameras.index(camera), np.int64)
        return shots_from(choice, table, sample_borders(table, frames), "the camera asked for")


def with_heads_seen_through(
    visible: NDArray[np.float64], usable: NDArray[np.bool_], share: float
) -> NDArray[np.float64]:
    """What cameras show of the field where other cameras' pictures are shown under heads.

    Parameters
    ----------
    visible : (S, C) float array
        Visible share of the field.
    usable : (S, C) bool array
        The best camera is one of these.
    share : float
        Of what the best camera shows more, 0..1. All cameras together may show more than the best: this counts less.

    Returns
    -------
    (S, C) float array
        No less than ``visible``.
    """
    if not visible.size:
        return visible
    best = np.where(usable, visible, 0.0).max(axis=1, keepdims=True)
    return visible + share * np.maximum(best - visible, 0)


def believed(visible: NDArray[np.float64], usable: NDArray[np.bool_], error: float) -> NDArray[np.float64]:
    """What cameras may be taken to see, where small differences between them may be chance.

    Parameters
    ----------
    visible : (S, C) float array
        Visible share of the field.
    usable : (S, C) bool array
        The best camera is one of these.
    error : float
        By so much scores differ by chance; 0 changes nothing.

    Returns
    -------
    (S, C) float array
        Nearer to the best camera of the sample, in the same order. What differs by much more than ``error`` comes
        nearer by that; what differs by less differs by next to nothing.
    """
    if not visible.size:
        return visible
    best = np.where(usable, visible, 0.0).max(axis=1, keepdims=True)
    less = np.maximum(best - visible, 0)
    return np.where(less > 0, best - less**2 / (less + error + 1e-12), visible)


def sample_borders(table: ScoreTable, frames: int) -> NDArray[np.int64]:
    """Which frames each sample stands for.

    Parameters
    ----------
    table : ScoreTable
        Of S samples.
    frames : int
        Length of the programme.

    Returns
    -------
    (S + 1,) int array
        Sample i stands for the frames [borders[i], borders[i + 1]); they tile [0, ``frames``).

    Raises
    ------
    InputError
        Where there is no sample.
    """
    if not len(table.frames):
        raise InputError("no picture could be scored", remedy="Check that the recording is longer than one sample")
    middle = (table.frames[:-1] + table.frames[1:] + 1) // 2
    return np.concatenate([[0], middle, [frames]]).astype(np.int64)


def worth(table: ScoreTable, borders: NDArray[np.int64]) -> NDArray[np.float64]:
    """What each sample of each camera is worth: visible field times the frames it stands for.

    Parameters
    ----------
    table : ScoreTable
        Of S samples and C cameras.
    borders : (S + 1,) int array
        See `sample_borders`.

    Returns
    -------
    (S, C) float array
        In frames of fully visible field; `FORBIDDEN` times the frames where a camera is not usable.

    Notes
    -----
    Where there is no data, as while the lamp moves, the line between what was seen before and after stands for it; see
    `ScoreTable.seen_at`.
    """
    return np.where(table.usable, table.seen_at(table.frames), FORBIDDEN) * np.diff(borders)[:, None]


def shots_from(
    choice: NDArray[np.int64],
    table: ScoreTable,
    borders: NDArray[np.int64],
    why: str,
    deductions: Iterable[tuple[str, NDArray[np.float64]]] = (),
) -> tuple[Shot, ...]:
    """Shots from the camera chosen for every sample.

    Parameters
    ----------
    choice : (S,) int array
        Index of the camera in ``table.cameras`` for every sample.
    table : ScoreTable
        Of S samples.
    borders : (S + 1,) int array
        See `sample_borders`.
    why : str
        The reason to write to each shot; ``{visible}`` in it becomes what the camera sees over the shot and ``{next}``
        which other camera sees most.
    deductions : iterable of (str, (S, C) float array), optional
        What else was weighed: its name, and what it takes off each camera at each sample, as a share of the field.
        Written behind what a camera sees where it is a hundredth or more.

    Returns
    -------
    tuple of Shot
        Tiling [0, borders[S]); neighbours differ in their camera. A shot's score is the mean visible field, 0..1.
    """
    starts = np.flatnonzero(np.concatenate([[True], np.diff(choice) != 0]))
    lengths, deductions, measured = np.diff(borders), tuple(deductions), table.seen
    shots = []
    for start, stop in zip(starts, [*starts[1:], len(choice)], strict=True):
        camera, rows = int(choice[start]), slice(int(start), int(stop))
        seen = [mean_known(column, lengths[rows]) for column in measured[rows].T]
        usable = np.any(table.usable[rows], axis=0)
        others = [(s, -c) for c, s in enumerate(seen) if s is not None and c != camera and usable[c]]

        def told(c: int, rows: slice = rows) -> str:
            means = [(name, float(np.average(off[rows, c], weights=lengths[rows]))) for name, off in deductions]
            marks = ", ".join(f"{name} -{off:.0%}" for name, off in means if off >= 0.01)
            return f" ({marks})" if marks else ""

        score = seen[camera]
        best = max(others, default=None)
        text = why.format(
            visible=f"sees {score:.0%} of the field{told(camera)}" if score is not None else "no score in this stretch",
            next=f", next best {table.cameras[-best[1]]} {best[0]:.0%}{told(-best[1])}" if best else "",
        )
        span = FrameRange(int(borders[start]), int(borders[stop]))
        shots.append(Shot(span, table.cameras[camera], round(min(score or 0.0, 1.0), 4), text))
    return tuple(shots)


def mean_known(values: NDArray[np.float64], lengths: NDArray[np.int64]) -> float | None:
    """The mean of what is known: samples are closer where much changes, and must not count more there.

    Parameters
    ----------
    values : (N,) float array
        Of samples, NaN where there is no data.
    lengths : (N,) int array
        How many frames each sample stands for.

    Returns
    -------
    float or None
        None where nothing is known.
    """
    known = ~np.isnan(values)
    return float(np.average(values[known], weights=lengths[known])) if known.any() else None


def _best_path(total: NDArray[np.float64], borders: NDArray[np.int64], *, least: int, cost: float) -> NDArray[np.int64]:
    """(S,) camera of every sample. ``total``: (S + 1, C) running sums of worth; ``borders``: (S + 1,) frames.

    best[i, c]: most worth of [0, borders[i]) when a shot of camera c is on air up to there and already long
    enough to end. It either goes on from best[i - 1, c], or began at a border j that leaves it long enough only
    now, after a shot of another camera that was itself free to end at j.
    """
    samples, cameras = total.shape[0] - 1, total.shape[1]
    best = np.full((samples + 1, cameras), -np.inf)
    began = np.zeros((samples + 1, cameras), np.int64)  # border at which the shot began
    previous = np.full((samples + 1, cameras), -1, np.int64)  # camera before it, -1 at the programme's start
    latest = np.searchsorted(borders, borders - least, side="right") - 1
    for i in range(1, samples + 1):
        best[i], began[i], previous[i] = best[i - 1], began[i - 1], previous[i - 1]
        best[i] += total[i] - total[i - 1]
        for j in range(max(0, int(latest[i - 1]) + 1), int(latest[i]) + 1):  # shots long enough just now
            if j == 0:
                fresh, before = total[i] - total[0], np.full(cameras, -1)
            elif cameras == 1:
                break
            else:
                second, first = np.argsort(best[j], kind="stable")[-2:]
                before = np.where(np.arange(cameras) == first, second, first)
                fresh = best[j, before] - cost + total[i] - total[j]
            better = fresh > best[i]
            best[i] = np.where(better, fresh, best[i])
            began[i] = np.where(better, j, began[i])
            previous[i] = np.where(better, before, previous[i])
    choice = np.zeros(samples, np.int64)
    if not np.isfinite(best[samples]).any():  # shorter than one shot: a single one
        choice[:] = int(np.argmax(total[samples]))
        return choice
    at, camera = samples, int(np.argmax(best[samples]))
    while at > 0:
        start, before = int(began[at, camera]), int(previous[at, camera])
        choice[start:at] = camera
        at, camera = start, before
    return choice
