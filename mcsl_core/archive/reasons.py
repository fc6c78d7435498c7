"""Why an operation needs a person, how much, and the command to begin with."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping

from attrs import frozen

from .figures import Figures

KINDS: Mapping[str, str] = {
    "stopped": "not made",
    "weak": "weak cameras",
    "field": "field hardly seen",
    "clocks": "unsure clocks",
    "gaps": "gaps and damage",
    "movements": "long movements",
    "overrides": "overrides that do not fit",
}
LEAST_VISIBLE = 0.5  # of the field, in the mean: below it a viewer misses half of the operation
LONG_MOVEMENT_S = 20.0
LEAST_GAPS = 0.002  # seven seconds an hour and camera


@frozen
class Reason:
    """One of the things that need a person.

    Attributes
    ----------
    kind : str
        A key of `KINDS`.
    weight : float
        0 (hardly) to 1, above it where there is nothing to see at all.
    words : str
        What it is.
    command : str
        What to begin with, in the folder of results.
    """

    kind: str
    weight: float
    words: str
    command: str


def reasons_of(row: Figures) -> tuple[Reason, ...]:
    """What of an operation needs a person, the heaviest first."""
    return tuple(sorted(_found(row), key=lambda reason: -reason.weight))


def _found(row: Figures) -> Iterator[Reason]:
    folder = shlex.quote(row.results)
    edl = f"{folder}/edl.json"
    analyse = f"mcsl analyse {folder}/recording -o {edl}"
    timeline = f"mcsl timeline {edl} -o {folder}/edit.blend"
    if row.state in ("refused", "failed"):
        yield Reason("stopped", 3.0 if row.state == "refused" else 2.0, f"{row.step}: {row.why}", _again(row, folder))
    if row.weak_cameras:
        share = row.weak_share or 0.0
        words = f"{row.weak_cameras} of {row.cameras} cameras not tied in, {share:.0%} of all their time"
        yield Reason("weak", min(1.0, 0.2 + share), words, timeline)
    draw = f"mcsl field {edl} --show {folder}/field.png"
    if row.field_unknown_share:
        words = f"nothing shows where the field lies for {row.field_unknown_share:.0%} of the time"
        yield Reason("field", 0.3 + 0.5 * row.field_unknown_share, words, draw)
    elif row.visible is not None and row.visible < LEAST_VISIBLE:
        words = f"{row.visible:.0%} of the field visible, {row.visible_best or 0:.0%} in the best camera"
        yield Reason("field", 1 - row.visible / LEAST_VISIBLE, words, timeline)
    if row.unsure_clocks:
        sure = row.clock_confidence or 0.0
        words = f"{row.unsure_clocks} of {row.cameras} clocks unsure, the least {sure:.0%}"
        yield Reason("clocks", 0.6 * (1 - sure), words, f"{analyse} --sync motion")
    if row.gap_share and row.gap_share > LEAST_GAPS:
        words = f"no picture for {row.gap_share:.1%} of all cameras' time"
        yield Reason("gaps", min(1.0, 0.1 + 2 * row.gap_share), words, f"{analyse}")
    if row.longest_movement_s and row.longest_movement_s > LONG_MOVEMENT_S:
        words = f"the lamp moves for {row.longest_movement_s:.0f} s at a stretch, {row.movement_s:.0f} s in all"
        share = (row.movement_s or 0.0) / max(row.seconds, 1e-9)
        yield Reason("movements", min(1.0, 0.1 + share), words, f"{analyse} --movement-view hold")
    if row.overrides_without_picture:
        words = (
            f"{row.overrides_without_picture} of {row.overrides} overrides take a camera that has no picture or is weak"
        )
        yield Reason("overrides", 0.5, words, timeline)


def _again(row: Figures, folder: str) -> str:
    """The job that failed, as a person runs it."""
    edl, job = f"{folder}/edl.json", row.step.partition("-")[0]
    if job in ("open", "analyse"):
        return f"mcsl analyse {folder}/recording -o {edl}"
    out = {"render": f" --engine direct -o {folder}/programme.mp4", "report": f" -o {folder}/report.html"}
    return f"mcsl {job} {edl}{out.get(job, '')}"
