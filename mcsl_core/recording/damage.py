"""The cameras' gaps: programme ranges in which their files have no whole picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import ceil

import attrs

from mcsl_core.edl import Camera
from mcsl_core.media.damage import Damage, find_damage
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange, format_time

from .decoder import Part, exact_programme_time
from .footage import Footage

DamageOf = Mapping[str, tuple[tuple[Damage, ...], ...]]  # camera -> one entry for each of its files
_MIB = 1 << 20
_MOST_NOTES = 12  # for each camera


def damage_of(footage: Footage, progress: Progress) -> DamageOf:
    """What is damaged in the files of every camera; they are read once from end to end, nothing is decoded.

    Parameters
    ----------
    footage
        The cameras; their clocks do not matter.
    progress
        Told of what has been read.
    """
    parts = {camera.name: footage.parts(camera.name) for camera in footage.cameras}
    sizes = {part.facts.path: part.facts.path.stat().st_size for of in parts.values() for part in of}
    progress.stage("Looking for damage", sum(sizes.values()) // _MIB, "MiB")
    before, found = 0, {}
    for camera, of in parts.items():
        each = []
        for part in of:
            each.append(find_damage(part.facts, lambda done, before=before: progress.advance((before + done) // _MIB)))
            before += sizes[part.facts.path]
        found[camera] = tuple(each)
    progress.advance(before // _MIB)
    return found


def with_gaps(footage: Footage, damage: DamageOf, progress: Progress) -> tuple[Camera, ...]:
    """The cameras of ``footage``, whose clocks are set, with the gaps that ``damage`` makes; every one is told."""
    cameras = []
    for camera in footage.cameras:
        gaps: list[FrameRange] = []
        notes = []
        for part, found in zip(footage.parts(camera.name), damage[camera.name], strict=True):
            for one in found:
                gap = _gap(footage, camera, part, one)
                where = f"{part.facts.path.name}, {format_time(one.start_s)} to {format_time(one.stop_s)}"
                notes.append(f"{camera.name} has no picture in {where}: {one.why}")
                gaps += [] if gap is None else [gap]
        for note in notes[:_MOST_NOTES]:
            progress.note(note)
        if len(notes) > _MOST_NOTES:
            progress.note(f"{camera.name}: {len(notes) - _MOST_NOTES} more such stretches, see its gaps in the report")
        cameras.append(attrs.evolve(camera, gaps=tuple(_joined(gaps))))
    return tuple(cameras)


def _gap(footage: Footage, camera: Camera, part: Part, damage: Damage) -> FrameRange | None:
    """The programme frames that would show it."""

    def first_showing(file_s: Fraction) -> int:
        camera_s = part.begin_s + file_s - part.facts.tolerance_s
        return min(max(ceil(exact_programme_time(camera, camera_s) * footage.rate), 0), footage.frames)

    start, stop = first_showing(damage.start_s), first_showing(damage.stop_s)
    return FrameRange(start, stop) if start < stop else None


def _joined(gaps: Sequence[FrameRange]) -> list[FrameRange]:
    joined: list[FrameRange] = []
    for gap in sorted(gaps):
        if joined and gap.start <= joined[-1].stop:
            gap = FrameRange(joined[-1].start, max(joined.pop().stop, gap.stop))
        joined.append(gap)
    return joined


def tell_of_damage(footage: Footage, progress: Progress) -> None:
    """Notes what was met while decoding and lies in no known gap: another camera stood in there."""
    for camera, pieces in footage.damage_met().items():
        for piece in pieces[:_MOST_NOTES]:
            start, stop = (format_time(frame / footage.rate) for frame in (piece.start, piece.stop))
            progress.note(
                f"{camera} is damaged from {start} to {stop} (frames {piece}) inside its pictures, which no gap in the "
                "EDL says: another camera stands in there"
            )
