"""EDL -> Sequence: the cut as the EDL has it now, its angles, what is heard, and what an editor should see of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.errors import UsageError
from mcsl_core.recording.decoder import Part
from mcsl_core.timing import FrameRange

from .angles import laid_files, posed_angle
from .model import OVERRIDE, Clip, Marker, Medium
from .model import Sequence as Cut
from .origin import CONFORMED, origin_of, shots_of, with_sound
from .timecode import count_of, is_broadcast, may_drop

DEFAULT_START = "01:00:00:00"


@frozen(kw_only=True)
class Wanted:
    """How a cut is to be made.

    Attributes
    ----------
    name
        Of the sequence.
    start
        What frame 0 is called; with a semicolon the timecode is drop-frame.
    sound_camera
        Whose sound is heard; None for none.
    programme, sound
        The conformed pictures, which the shots then show, and the conformed sound.
    """

    name: str
    start: str = DEFAULT_START
    sound_camera: str | None = None
    programme: Medium | None = None
    sound: Medium | None = None


def sequence_of(edl: Edl, parts: Mapping[str, Sequence[Part]], wanted: Wanted) -> Cut:
    """The cut of an EDL.

    Parameters
    ----------
    edl
        The decisions, overrides included.
    parts
        Every camera's files, and where each begins in the camera's own time.
    wanted
        What is wanted of it.

    Raises
    ------
    UsageError
        Where the programme's rate has no timecode, or ``start`` is none at that rate.
    """
    check_rate(edl.rate)
    start, drop = count_of(wanted.start, edl.rate)
    if drop and not may_drop(edl.rate):  # parse_timecode knows rates that are near
        raise UsageError(f"there is no drop-frame timecode at {edl.rate} frames/s", remedy="Write it with a colon")
    laid = {camera.name: laid_files(edl, camera, parts[camera.name]) for camera in edl.cameras}
    order = sorted(edl.cameras, key=lambda camera: camera.name == edl.reference)  # stable: the reference last
    heard = laid[wanted.sound_camera] if wanted.sound_camera is not None and wanted.programme is None else ()
    sound = tuple(clip for clip in heard if clip.medium.channels)
    if wanted.sound is not None:
        sound = (
            Clip(wanted.sound_camera or edl.reference, FrameRange(0, edl.frames), wanted.sound, Fraction(0), edl.rate),
        )
    return Cut(
        name=wanted.name,
        rate=edl.rate,
        frames=edl.frames,
        size=edl.size,
        start=start,
        drop=drop,
        origin=with_sound(origin_of(edl), _heard(sound, wanted), [camera.name for camera in order]),
        shots=shots_of(edl),
        angles=tuple(posed_angle(edl, camera, laid[camera.name]) for camera in order),
        markers=tuple(sorted(_markers(edl))),
        programme=wanted.programme,
        sound=sound,
        removed=edl.removed,
    )


def _heard(sound: Sequence[Clip], wanted: Wanted) -> str | None:
    return (CONFORMED if wanted.sound is not None else sound[0].camera) if sound else None


def check_rate(rate: Fraction) -> None:
    """UsageError where no editor has timecode at ``rate``."""
    if not is_broadcast(rate):
        raise UsageError(
            f"editors know whole rates and NTSC's (30000/1001), the programme has {rate} frames/s",
            remedy="Analyse again with --rate, such as 25 or 30000/1001",
        )


def _markers(edl: Edl) -> Iterator[Marker]:
    for movement in edl.movements:
        yield Marker(movement.range, "movement", "lamp moves")
    last = None
    for number, pose in enumerate(edl.poses, start=1):
        known = "" if pose.perspective == last else f", perspective {pose.perspective}"
        yield Marker(_at(pose.range.start), "pose", f"pose {number}{known}")
        last = pose.perspective
        for weak in pose.weak:
            yield Marker(_at(pose.range.start), "weak", f"{weak.camera} could not be aligned", weak.reason)
    for shot in edl.shots:
        if shot.why:
            yield Marker(_at(shot.range.start), "shot", f"{shot.camera}: {shot.why}", f"score {shot.score:.2f}")
    for override in edl.overrides:
        said = [override.camera] if override.camera else []
        said += [
            f"{name} {'on' if value else 'off'}"
            for name in ("centering", "fill", "colour", "surface", "see_through")
            if (value := getattr(override, name)) is not None
        ]
        said += ["centred by hand"] if override.offset is not None else []
        yield Marker(override.range, "override", f"{OVERRIDE}{', '.join(said) or 'nothing'}", override.note)


def _at(frame: int) -> FrameRange:
    return FrameRange(frame, frame + 1)
