# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of shots as the panel shows it: what the viewer gets, why, and where the editor decided. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.edl.resolve import Decisions, resolve
from mcsl_core.timing import FrameRange

SHORT_FRAMES = 10  # a shot of fewer is told of


@frozen
class ShotRow:
    """A stretch of the programme from one camera.

    Attributes
    ----------
    automatic
        The camera that the analysis chose at its beginning.
    score, why
        The analysis' word on its own choice there; the score lies in 0..1.
    overridden
        Whether an editor's decision holds somewhere in it.
    """

    range: FrameRange
    camera: str
    automatic: str
    score: float
    why: str
    overridden: bool


def rows_of(edl: Edl, decisions: Decisions | None = None) -> tuple[ShotRow, ...]:
    """The shots of ``edl`` (the timeline's decisions already in it), one row for each effective decision.

    decisions: what `resolve` says of it, where that is known.
    """
    shots = iter(edl.shots)
    shot = next(shots)
    rows = []
    for stretch, decision in resolve(edl) if decisions is None else decisions:
        while stretch.start not in shot.range:
            shot = next(shots)
        rows.append(ShotRow(stretch, decision.camera, shot.camera, shot.score, shot.why, decision.overridden))
    return tuple(rows)


def unchanged(before: Sequence[ShotRow], now: Sequence[ShotRow]) -> tuple[int, int]:
    """How many rows are the same from the beginning, and how many of the others from the end."""
    shorter = min(len(before), len(now))
    first = next((i for i in range(shorter) if before[i] != now[i]), shorter)
    left = shorter - first
    return first, next((i for i in range(left) if before[-1 - i] != now[-1 - i]), left)


def row_at(rows: Sequence[ShotRow], frame: int) -> int:
    """The index of the row that holds a programme frame; -1 outside."""
    low, high = 0, len(rows)
    while low < high:
        middle = (low + high) // 2
        if rows[middle].range.stop <= frame:
            low = middle + 1
        else:
            high = middle
    return low if low < len(rows) and frame in rows[low].range else -1


def next_override(rows: Sequence[ShotRow], frame: int, *, back: bool = False) -> int:
    """The index of the nearest overridden row that begins after (before) a programme frame; -1 where there is none."""
    found = [i for i, row in enumerate(rows) if row.overridden]
    if back:
        return max((i for i in found if rows[i].range.start < frame), default=-1)
    return min((i for i in found if rows[i].range.start > frame), default=-1)


def next_cut(rows: Sequence[ShotRow], frame: int, *, back: bool = False) -> int:
    """The index of the row that begins next after (last before) a programme frame; -1 where none does."""
    if back:
        return max((i for i, row in enumerate(rows) if row.range.start < frame), default=-1)
    return min((i for i, row in enumerate(rows) if row.range.start > frame), default=-1)


def short(rows: Sequence[ShotRow]) -> tuple[int, ...]:
    """The indices of the rows that are over before they are seen: such shots are mostly slips of the hand."""
    return tuple(i for i, row in enumerate(rows) if len(row.range) < SHORT_FRAMES)


def time_text(frame: int, rate: Fraction) -> str:
    """Hours, minutes, seconds and frame as editors read them: 0:01:23:07."""
    whole = round(rate)
    seconds = frame // whole
    return f"{seconds // 3600}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{frame % whole:02d}"


def seconds_text(seconds: float) -> str:
    """A length for people: 4.2 s, 1:23, 1:02:03."""
    if seconds < 59.95:
        return f"{seconds:.1f}\u00a0s"  # a line is not broken between them
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d}"
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
