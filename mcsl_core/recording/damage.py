"""The cameras' gaps: programme ranges in which their files have no whole picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from fractions import Fraction
from itertools import chain
from typing import Any

import attrs

from mcsl_core.edl import Camera
from mcsl_core.media.damage import Damage, find_damage
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange, format_time, joined

from .decoder import Part, part_at
from .footage import Footage
from .sample_store import SampleStore

DamageOf = Mapping[str, tuple[tuple[Damage, ...], ...]]  # camera -> one entry for each of its files
_Picture = tuple[Fraction, Any | None]
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
        cameras.append(attrs.evolve(camera, gaps=tuple(joined(gaps))))
    return tuple(cameras)


def _gap(footage: Footage, camera: Camera, part: Part, damage: Damage) -> FrameRange | None:
    """The programme frames that would show it."""
    begin_s = part.begin_s - part.facts.tolerance_s
    start, stop = (footage.first_showing(camera.name, begin_s + s) for s in (damage.start_s, damage.stop_s))
    return FrameRange(start, stop) if start < stop else None


def damage_met(footage: Footage, samples: SampleStore, progress: Progress) -> DamageOf:
    """What is damaged inside the pictures that sampling met, which no packet tells: around each of them, exactly.

    A keyframe that is hit takes all to the next one with it. What hits other pictures only, sampling by keyframes does
    not see. Every damaged stretch is read once, however many of the samples lie in it.
    """
    total = footage.frames * len(footage.cameras)
    if any(samples.damaged.values()):
        progress.stage("Looking around damaged pictures", total, "frames")
    found = {}
    for before, camera in enumerate(footage.cameras):
        done = _Done(footage, camera.name, before * footage.frames, progress)
        parts = footage.parts(camera.name)
        each: list[list[Damage]] = [[] for _ in parts]
        for frame in samples.damaged.get(camera.name, ()):  # rising
            done.reached(frame)
            camera_s = footage.camera_time(camera.name, frame)
            part = part_at(parts, camera_s)
            file_s = None if part is None else part.file_time(camera_s)
            if part is None or file_s is None:
                continue
            of = each[parts.index(part)]
            if of and of[-1].start_s <= file_s + part.facts.tolerance_s < of[-1].stop_s:
                continue
            around = _damage_around(part, file_s, done)
            of += [] if around is None else [around]
        found[camera.name] = tuple(tuple(of) for of in each)
    if any(samples.damaged.values()):
        progress.advance(total)
    return found


@attrs.define
class _Done:
    """Tells how far into a camera's programme the damage is known, and so lets whoever waits stop it."""

    footage: Footage
    camera: str
    before: int  # frames of the cameras before
    progress: Progress
    _latest: int = 0

    def reached(self, frame: int) -> None:
        """All up to programme ``frame`` is known; an earlier one is looked at again."""
        self._latest = max(self._latest, min(frame, self.footage.frames))
        self.progress.advance(self.before + self._latest)

    def read(self, camera_s: Fraction) -> None:
        """The picture at ``camera_s`` was read."""
        self.reached(self.footage.programme_frame(self.camera, camera_s))


def _damage_around(part: Part, at_s: Fraction, done: _Done) -> Damage | None:
    """From the first picture around ``at_s`` of a file that is not whole to the next that is; None where it is whole.

    Goes back until a whole picture stands before it, and reads forward from there.
    """
    facts, back = part.facts, Fraction(part.facts.keyframe_interval_s)
    with closing(VideoReader(facts, threads=1)) as reader:
        while True:
            from_s = max(at_s - back, facts.start_s)
            pictures = _told(reader.read(from_s), part, done)
            start_s, following = _broken_since(pictures, at_s + facts.tolerance_s)
            if start_s is None:
                return None
            if start_s > from_s + facts.tolerance_s or from_s <= facts.start_s:
                break
            back *= 2
        stop_s = next((time_s for time_s, frame in chain(following, pictures) if frame is not None), facts.usable_s)
        why = "damaged"
        if reader.other_shape:
            usual = "x".join(map(str, facts.coded_size))
            why = f"pictures of another shape ({reader.other_shape}, not {usual}); "
            why += "to use them, cut the file into two cameras"
    return Damage(start_s, stop_s, why)


def _told(pictures: Iterable[_Picture], part: Part, done: _Done) -> Iterator[_Picture]:
    for picture in pictures:
        done.read(part.begin_s + picture[0])
        yield picture


def _broken_since(pictures: Iterator[_Picture], goal_s: Fraction) -> tuple[Fraction | None, list[_Picture]]:
    """Since when what is shown at ``goal_s`` is not whole, None where it is; and the picture after it, if one is."""
    start_s = None
    for time_s, frame in pictures:
        if time_s > goal_s:
            return start_s, [(time_s, frame)]
        if frame is not None:
            start_s = None
        elif start_s is None:
            start_s = time_s
    return start_s, []


def tell_of_damage(footage: Footage, progress: Progress) -> None:
    """Notes what was met while decoding and lies in no known gap: another camera stood in there."""
    for camera, pieces in footage.damage_met().items():
        for piece in pieces[:_MOST_NOTES]:
            start, stop = (format_time(frame / footage.rate) for frame in (piece.start, piece.stop))
            progress.note(
                f"{camera} is damaged from {start} to {stop} (frames {piece}) inside its pictures, which no gap in the "
                "EDL says: another camera stands in there"
            )
