"""The cameras of a recording: found, probed, the reference among them, and the programme's length."""

from __future__ import annotations

import os
from collections.abc import Sequence
from fractions import Fraction
from math import floor
from pathlib import Path

from mcsl_core.edl import Camera, Media
from mcsl_core.edl.checks import LONGEST_S, MOST_FRAMES
from mcsl_core.errors import Fault, InputError, UsageError
from mcsl_core.media.facts import MediaFacts
from mcsl_core.media.probing import probe
from mcsl_core.outputs.deliveries import own_videos
from mcsl_core.progress import Progress
from mcsl_core.timing import format_time

from .contents import read_contents
from .discovery import SUFFIXES, discover, look_like_parts
from .footage import Footage
from .joining import describe_joins, joined

_EARLY_S = 10  # operators stop recorders one after another; who ends earlier by more is told
_LOST_S = 1  # so much of another camera may lie outside the reference camera's recording


def open_cameras(recording: Sequence[Path], base: Path, progress: Progress) -> tuple[Camera, ...]:
    """The cameras of a recording, probed; their clocks are not yet set.

    Parameters
    ----------
    recording
        A folder, or the camera files in order; see `discover`.
    base
        The folder that media paths are made relative to, the EDL's.
    progress
        Told of each camera.

    Raises
    ------
    InputError
        With fewer than two cameras, or where a camera's files differ in size.
    """
    found = _without_own_work(recording, base, progress)
    if len(found) < 2:
        raise InputError(
            f"only one camera was found ({found[0][0]})",
            where=", ".join(str(p) for p in recording),
            remedy="Hand in the files of at least two cameras",
        )
    progress.stage("Opening the cameras", len(found), "cameras")
    facts: list[list[MediaFacts]] = []
    for name, files in found:
        facts.append([probe(path) for path in files])
        if len({f.size for f in facts[-1]}) > 1:
            raise InputError(
                "its files have different sizes: " + ", ".join(f"{w}x{h}" for w, h in (f.size for f in facts[-1])),
                where=f"camera {name}",
                remedy="Hand them in as different cameras, or convert them to one size",
            )
        progress.advance(len(facts))
    keys = iter(read_contents([(path, "") for _, files in found for path in files], progress))
    cameras = []
    for (name, files), known in zip(found, facts, strict=True):
        media = tuple(
            Media(relative_path(path, base), fact.frames, next(keys)) for path, fact in zip(files, known, strict=True)
        )
        for note in (*_describe_files(name, known), *_describe_crops(name, known)):
            progress.note(note)
        try:
            cameras.append(Camera(name, media, known[0].size, known[0].rate))
        except Fault as fault:
            remedy = "Leave it out, or convert it"
            raise InputError(f"cannot be taken: {fault}", where=f"camera {name}", remedy=remedy) from fault
    for name, other in _same_films(cameras):
        progress.note(f"{name} and {other} are one film, byte for byte; if one is a copy, take it out of the recording")
    for name, other in look_like_parts([camera.name for camera in cameras]):
        progress.note(
            f"{name} and {other} are taken for two cameras; if they are parts of one, put both into a folder {name}"
        )
    return tuple(cameras)


def _same_films(cameras: Sequence[Camera]) -> list[tuple[str, str]]:
    """(camera, further camera) that have the same files: a copy left behind, a link."""
    first: dict[tuple[str, ...], str] = {}
    found = []
    for camera in cameras:
        name = first.setdefault(tuple(media.fingerprint for media in camera.media), camera.name)
        found += [(name, camera.name)] if name != camera.name else []
    return found


def _without_own_work(recording: Sequence[Path], base: Path, progress: Progress) -> list[tuple[str, tuple[Path, ...]]]:
    """The cameras, without what mcsl made of them earlier and people keep beside them: that is told."""
    folders = [path for path in recording if path.is_dir()]
    own = {file for file in own_videos({*folders, base}) if file.suffix.lower() in SUFFIXES}
    found = discover(recording, own)
    real = {Path(os.path.realpath(folder)) for folder in folders}
    left_out = [file.name for file in own if file.parent in real]
    left_out += {f"{file.parent.name}/" for file in own if file.parent.parent in real}
    if left_out:
        names = ", ".join(sorted(left_out))
        progress.note(f"left out, as mcsl made it: {names}. To take it for a camera, name the camera files singly")
    return found


def _describe_files(name: str, files: Sequence[MediaFacts]) -> list[str]:
    """What a person should know of a camera's files: which they are, in what order, and how they join."""
    if len(files) == 1:
        return []
    notes = [f"{name}: {len(files)} files one after another, {', '.join(f.path.name for f in files)}"]
    made = [f.created for f in files]
    wrong = next((i for i in range(1, len(files)) if made[i - 1] and made[i] and made[i] < made[i - 1]), None)
    if wrong is not None:
        first, then = files[wrong - 1], files[wrong]
        notes.append(
            f"{name}: by its name {then.path.name} follows {first.path.name}, but it was made earlier ({then.created}, "
            f"{first.created}); the names were followed"
        )
    order = sorted(files, key=lambda f: f.zero_s + f.start_s)
    if order != list(files) and _go_on(order) and not _go_on(files):
        names = ", ".join(f.path.name for f in order)
        notes.append(f"{name}: by their clock the files follow each other as {names}; their names were followed")
    return notes + describe_joins(name, joined(files))


def _describe_crops(name: str, files: Sequence[MediaFacts]) -> list[str]:
    """What players cut off that is shown here."""
    return [
        f"{name}: {facts.path.name} asks players to show {'x'.join(map(str, facts.asked_size))} of its "
        f"{'x'.join(map(str, facts.coded_size))} pixels; here all of them are shown"
        for facts in files
        if facts.asked_size is not None
    ]


def _go_on(files: Sequence[MediaFacts]) -> bool:
    """Whether each file's clock begins where that of the one before ends."""
    pairs = zip(files, files[1:], strict=False)
    return all(abs(b.zero_s + b.start_s - a.zero_s - a.end_s) <= 2 / a.rate for a, b in pairs)


def relative_path(path: Path, base: Path) -> str:
    """``path`` relative to the folder ``base`` with forward slashes; absolute where there is no way (other drive)."""
    try:
        return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()
    except ValueError:
        return path.resolve().as_posix()


def programme_length(footage: Footage, reference: str, progress: Progress) -> int:
    """Frames of the programme: until the last camera ends, at least 1.

    It ends with the reference camera where that loses at most a second of another: operators stop recorders one after
    another.

    Parameters
    ----------
    footage
        The cameras with their clocks; its own length is not read.
    reference
        The camera whose clock the programme keeps, and with whose first picture it begins.
    progress
        Told of what the reference camera does not show.
    """
    spans = {camera.name: footage.span_s(camera.name) for camera in footage.cameras}
    ends = {name: ends_s for name, (_, ends_s) in spans.items()}
    own_s, last = footage.parts(reference)[-1].end_s, max(ends, key=lambda name: ends[name])
    for name, (begins_s, _) in spans.items():
        if begins_s < -_LOST_S:
            progress.note(
                f"{name} begins {-begins_s:.1f} s before {reference}, the reference camera, with which the "
                f"programme begins (--reference {name} would begin it earlier)"
            )
    seconds = own_s
    if ends[last] > own_s + _LOST_S:
        seconds = Fraction(ends[last])
        progress.note(
            f"{reference}, the reference camera, ends at {format_time(own_s)}; the programme goes on with others until "
            f"{format_time(seconds)}, where {last} ends. Its sound is {reference}'s unless another's is chosen"
        )
    for name, end_s in ends.items():
        if name != reference and end_s < float(seconds) - _EARLY_S:
            progress.note(
                f"{name} ends at {format_time(end_s)}, {float(seconds) - end_s:.0f} s before the programme; if its "
                "recorder ran on, its last file may be cut short, or another is missing"
            )
    if seconds > LONGEST_S or seconds * footage.rate > MOST_FRAMES:  # told now, not when the EDL is made at the end
        raise InputError(
            f"lasts until {float(seconds):.6g} s, at most {LONGEST_S // 3600} hours ({MOST_FRAMES} frames) are taken",
            where=f"camera {last if seconds != own_s else reference}",
            remedy="Leave that camera out, or cut the recording",
        )
    return max(1, floor(seconds * footage.rate + Fraction(1, 2)))


def choose_reference(cameras: Sequence[Camera], name: str | None) -> Camera:
    """The camera called ``name``; the first without a name.

    Raises
    ------
    UsageError
        Where there is no such camera.
    """
    for camera in cameras:
        if name in (None, camera.name):
            return camera
    raise UsageError(
        f"there is no camera {name!r} to be the reference",
        remedy=f"Choose one of {', '.join(c.name for c in cameras)}",
    )
