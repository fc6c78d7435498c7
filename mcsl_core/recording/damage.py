"""The cameras' gaps: programme ranges in which their files have no whole picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from fractions import Fraction

import attrs

from mcsl_core.edl import Camera
from mcsl_core.media.damage import Damage, find_damage
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange, format_time

from .decoder import Part, part_at
from .footage import Footage
from .sample_store import SampleStore

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
    """The cameras of ``footage``, whose clocks are set, with the gaps that ``damage`` makes beside theirs; all told."""
    cameras = []
    for camera in footage.cameras:
        gaps = list(camera.gaps)
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
    begin_s = part.begin_s - part.facts.tolerance_s
    start, stop = (footage.first_showing(camera.name, begin_s + s) for s in (damage.start_s, damage.stop_s))
    return FrameRange(start, stop) if start < stop else None


def _joined(gaps: Sequence[FrameRange]) -> list[FrameRange]:
    joined: list[FrameRange] = []
    for gap in sorted(gaps):
        if joined and gap.start <= joined[-1].stop:
            gap = FrameRange(joined[-1].start, max(joined.pop().stop, gap.stop))
        joined.append(gap)
    return joined


def damage_met(footage: Footage, samples: SampleStore) -> DamageOf:
    """What is damaged inside the pictures that sampling met, which no packet tells: around each of them, exactly.

    A keyframe that is hit takes all to the next one with it. What hits other pictures only, sampling by keyframes does
    not see.
    """
    found = {}
    for camera in footage.cameras:
        each: list[list[Damage]] = [[] for _ in footage.parts(camera.name)]
        for frame in samples.damaged.get(camera.name, ()):
            around = _damage_around(footage, camera.name, frame)
            if around is not None and around[1] not in each[around[0]]:
                each[around[0]].append(around[1])
        found[camera.name] = tuple(tuple(of) for of in each)
    return found


def _damage_around(footage: Footage, camera: str, frame: int) -> tuple[int, Damage] | None:
    """In which of the camera's files, and from its first picture that is not whole to the next that is; or None."""
    camera_s = footage.camera_time(camera, frame)
    parts = footage.parts(camera)
    part = part_at(parts, camera_s)
    file_s = None if part is None else part.file_time(camera_s)
    if part is None or file_s is None:
        return None
    facts, back = part.facts, Fraction(part.facts.keyframe_interval_s)
    with closing(VideoReader(facts, threads=1)) as reader:
        from_s = max(file_s - back, facts.start_s)
        start_s, stop_s = _not_whole(reader, from_s, file_s)
        while start_s is not None and start_s <= from_s and from_s > facts.start_s:
            back *= 2
            from_s = max(file_s - back, facts.start_s)
            start_s, stop_s = _not_whole(reader, from_s, file_s)
    if start_s is None:
        return None
    why = "damaged"
    if reader.other_shape:
        usual = "x".join(map(str, facts.coded_size))
        why = (
            f"pictures of another shape ({reader.other_shape}, not {usual}); to use them, cut the file into two cameras"
        )
    return parts.index(part), Damage(start_s, stop_s or facts.usable_s, why)


def _not_whole(reader: VideoReader, from_s: Fraction, at_s: Fraction) -> tuple[Fraction | None, Fraction | None]:
    """From where to where what is shown at ``at_s`` is not whole, as read from ``from_s`` on; None where it is whole.

    Without a stop it is not whole to the end.
    """
    start_s = None
    for time_s, frame in reader.read(from_s):
        if time_s > at_s + reader.facts.tolerance_s:
            if start_s is None or frame is not None:
                return start_s, time_s
        elif frame is not None:
            start_s = None
        elif start_s is None:
            start_s = time_s
    return start_s, None


def tell_of_damage(footage: Footage, progress: Progress) -> None:
    """Notes what was met while decoding and lies in no known gap: another camera stood in there."""
    for camera, pieces in footage.damage_met().items():
        for piece in pieces[:_MOST_NOTES]:
            start, stop = (format_time(frame / footage.rate) for frame in (piece.start, piece.stop))
            progress.note(
                f"{camera} is damaged from {start} to {stop} (frames {piece}) inside its pictures, which no gap in the "
                "EDL says: another camera stands in there"
            )
