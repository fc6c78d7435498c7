# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the timeline still runs in the programme's time. No bpy.

The programme's time is the recording's: shots can be cut anywhere in it, but nothing can be taken out of it, put into
it or run at another speed. An edit that does so (a ripple delete, a strip slid or retimed, another frame rate) would
show other pictures than the exact ones, so it is refused by name and place before anything is written, conformed or
rendered. What is harmless, or may be meant so, is told.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import PurePosixPath

import attrs
from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.errors import InputError

from .strip_plan import camera_tracks, tracks_key

_KINDS = {"camera": "camera strip", "conformed": "conformed strip", "sound": "sound strip", "centering": "strip"}
_LEAVE_OUT = (
    "the programme's time is the recording's and cannot be cut or stretched. To leave a stretch out, cut the delivered "
    "video, or render a range of frames"
)


@frozen
class FoundFilm:
    """One of our strips that play a file, or the Centering strip, as found.

    Attributes
    ----------
    start, stop
        The programme frames [start, stop) that it covers.
    content, frames
        Where its file's first picture stands, and how many there are.
    laid
        Where that picture stood when the strip was built; None where the strip does not say.
    odd
        What was done to its time, in words for a person.
    """

    role: str
    name: str
    start: int
    stop: int
    content: int
    frames: int
    file: str = ""
    laid: int | None = None
    muted: bool = False
    odd: tuple[str, ...] = ()


@frozen
class SceneTime:
    """How a scene counts and shows time: its rate, every n-th frame, from first to last, and the pictures' size."""

    rate: Fraction
    step: int
    stretched: bool
    first: int
    last: int
    size: tuple[int, int]


@frozen
class FoundShot:
    """A Programme strip: its id, which says where it was built, and where it is."""

    id: str
    name: str
    start: int
    stop: int


def check_times(
    edl: Edl, scene: SceneTime | None, films: Sequence[FoundFilm], shots: Iterable[FoundShot], tracks: str = ""
) -> None:
    """Refuses a timeline in which time was changed.

    Parameters
    ----------
    edl
        The timeline's EDL.
    scene, films, shots
        The timeline as found.
    tracks
        What its camera strips were built from (`tracks_key`); '' where it is not known.

    Raises
    ------
    InputError
        Names the first strip in time, its frame, and what to do.
    """
    if scene is not None:
        _check_scene(edl, scene)
    films = _with_laid(edl, films, tracks)
    for film in sorted(films, key=lambda f: f.start):
        if film.odd and film.role != "sound":
            raise InputError(f"is {', '.join(film.odd)}", where=_where(film), remedy=f"Undo that: {_LEAVE_OUT}")
    slid = sorted((f for f in films if f.role != "sound" and not f.muted and _slip(f)), key=lambda f: f.start)
    if slid:
        first, more = slid[0], len(slid) - 1
        others = f", and {more} more strip{'s' * (more > 1)} at or after it" if more else ""
        raise InputError(
            f"stands {_shifted(_slip(first))} than it was recorded{others}",
            where=_where(first),
            remedy=f"Undo that, or move {'them' if more else 'it'} back: {_LEAVE_OUT}",
        )
    for film in films:
        if film.role == "conformed" and not (film.content <= film.start and film.stop <= film.content + film.frames):
            raise InputError(
                "is drawn out beyond its pictures, which stand still there",
                where=_where(film),
                remedy="Drag its ends back, or delete it and conform again",
            )
    _check_shots(edl, shots)


def _check_scene(edl: Edl, scene: SceneTime) -> None:
    if abs(scene.rate - edl.rate) > edl.rate / 10_000:
        raise InputError(
            f"the scene runs at {float(scene.rate):.5g} frames/s, the programme at {float(edl.rate):.5g}",
            where="Output Properties, Frame Rate",
            remedy=f"Set it back to {-(-edl.rate.numerator // edl.rate.denominator)} with the base "
            f"{float(-(-edl.rate.numerator // edl.rate.denominator) / edl.rate):.6g}, or undo. Another rate is made "
            "from the delivered video",
        )
    if scene.step != 1 or scene.stretched:
        what = f"every {scene.step}. frame" if scene.step != 1 else "stretched time"
        raise InputError(
            f"the scene renders {what}, which would run at another speed",
            where="Output Properties, Frame Range, Step" if scene.step != 1 else "Output Properties, Time Stretching",
            remedy="Set the step to 1" if scene.step != 1 else "Set old and new to the same number",
        )


def _with_laid(edl: Edl, films: Sequence[FoundFilm], tracks: str) -> list[FoundFilm]:
    """Where camera strips of an older timeline were laid follows from the EDL, if they were built from this one."""
    if all(f.laid is not None for f in films if f.role == "camera"):
        return list(films)
    planned = camera_tracks(edl)
    if tracks != tracks_key(planned):
        return list(films)
    laid = {PurePosixPath(file.path).name: file.start for track in planned for file in track.files}
    return [f if f.role != "camera" or f.laid is not None else attrs.evolve(f, laid=laid.get(f.file)) for f in films]


def _check_shots(edl: Edl, shots: Iterable[FoundShot]) -> None:
    """Refuses a Programme channel whose end was rippled: shots all moved by the same way, the last one's end too."""
    shots, first = sorted(shots, key=lambda s: s.start), {}
    for shot in shots:
        built = shot.id.removeprefix("shot-")
        if built.isdigit():
            first.setdefault(int(built), shot)
    if not first:
        return
    by = max(shot.stop for shot in shots) - edl.frames
    moved: list[FoundShot] = []
    for built, shot in sorted(first.items(), reverse=True):
        if by == 0 or shot.start - built != by:
            break
        moved.append(shot)
    if len(moved) > 1:
        raise InputError(
            f"and the {len(moved) - 1} after it stand {_shifted(by)} than they were built, and the cameras do not",
            where=f"strip {moved[-1].name!r}, frame {moved[-1].start + 1}",
            remedy=f"Undo the edit that moved them all (a ripple?): {_LEAVE_OUT}",
        )


def remarks(edl: Edl, scene: SceneTime | None, films: Iterable[FoundFilm]) -> tuple[str, ...]:
    """What a person should know about the timeline's time before it is conformed or rendered."""
    notes = []
    if scene is not None and (scene.first != 1 or scene.last != edl.frames):
        notes.append(f"the scene renders frames {scene.first} to {scene.last}, the programme has 1 to {edl.frames}")
    if scene is not None and any(a != b and not 0 < b - a < 4 for a, b in zip(scene.size, edl.size, strict=True)):
        sizes = [f"{width} x {height}" for width, height in (scene.size, edl.size)]
        notes.append(
            f"the scene's pictures are {sizes[0]}, the programme's {sizes[1]}: cut or framed in black, not scaled"
        )
    for film in films:
        if film.role == "sound" and (slip := _slip(film)):
            notes.append(f"{_where(film)} stands {_shifted(slip)} than it was recorded, and is kept so")
        if film.role == "sound" and film.odd:
            notes.append(
                f"{_where(film)} is {', '.join(film.odd)}: it cannot follow new sound, and would be muted then"
            )
        if film.role == "conformed" and film.muted:
            notes.append(
                f"exact pictures are muted by hand, so the preview shows in frames {film.start + 1} to {film.stop}"
            )
    return tuple(notes)


def _slip(film: FoundFilm) -> int:
    return 0 if film.laid is None else film.content - film.laid


def _shifted(by: int) -> str:
    return f"{abs(by)} frame{'s' * (abs(by) != 1)} {'later' if by > 0 else 'earlier'}"


def _where(film: FoundFilm) -> str:
    return f"{_KINDS.get(film.role, 'strip')} {film.name!r}, frame {film.start + 1}"
