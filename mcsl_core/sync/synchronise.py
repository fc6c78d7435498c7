"""Bringing the cameras' clocks onto the reference camera's.

A camera's own time is (t - offset_s) * (1 + drift_ppm * 1e-6) at programme time t, which is the reference camera's
own time. Three methods, the surest first: `timecode` (but a preset one after the sound), `audio`, `motion`. What is
weak or ambiguous is refused with its reason, not guessed: then the camera is taken to start with the reference, and its
clock says method none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path

import attrs

from mcsl_core.edl import Camera, Clock
from mcsl_core.errors import UsageError
from mcsl_core.progress import Progress, Silent
from mcsl_core.recording.footage import Footage

from .audio import clocks_from_audio
from .clock_fit import ClockFinder, Refusal, length_s
from .motion import clocks_from_motion
from .timecode import clocks_from_timecode

__all__ = ["METHODS", "synchronise"]

_FINDERS: Mapping[str, ClockFinder] = {
    "timecode": clocks_from_timecode,
    "audio": clocks_from_audio,
    "motion": clocks_from_motion,
}
METHODS: Mapping[str, tuple[str, ...]] = {
    "auto": tuple(_FINDERS),
    **{name: (name,) for name in _FINDERS},
    "none": (),
}


def synchronise(
    method: str,
    cameras: Sequence[Camera],
    base: Path,
    progress: Progress | None = None,
    *,
    reference: str | None = None,
) -> tuple[Clock, ...]:
    """A clock for each camera against the reference camera's.

    Parameters
    ----------
    method
        "timecode", "audio", "motion", "none" (all start together), or "auto": for each camera the first of these that
        is sure.
    cameras
        Their clocks are not read.
    base
        The folder that media paths are relative to.
    progress
        Told of the stages, of each camera that no method settles, and where a camera's audio contradicts its timecode.
    reference
        The camera whose clock is the programme's; the first by default.

    Returns
    -------
    tuple of Clock
        In the cameras' order. A camera that no method settles has method "none" and confidence 0. The reference's clock
        names the surest method by which any camera was tied to it.

    Raises
    ------
    UsageError
        For another method.

    Examples
    --------
    >>> clocks = synchronise("audio", cameras, Path("recording"))  # doctest: +SKIP
    >>> clocks[1].offset_s, clocks[1].confidence  # doctest: +SKIP
    (0.213, 0.93)
    """
    progress = progress or Silent()
    if method not in METHODS:
        raise UsageError(f"there is no sync method {method!r}", remedy=f"Choose one of {', '.join(METHODS)}")
    if not cameras:
        return ()
    reference = reference or cameras[0].name
    plain = [attrs.evolve(camera, clock=Clock()) for camera in cameras]
    footage = Footage(plain, rate=Fraction(1), frames=1, base=Path(base))
    if "audio" in METHODS[method]:
        for camera in cameras:
            for note in footage.sound_track(camera.name).notes:
                progress.note(f"{camera.name}: {note}")
    clocks = _found(METHODS[method], footage, reference, progress)
    by_timecode = {n: c for n, c in clocks.items() if c.method == "timecode"}
    clocks |= _checked(by_timecode, footage, reference, progress, alone="audio" not in METHODS[method])
    used = [name for name in _FINDERS if any(c.method == name for c in clocks.values())]
    clocks[reference] = Clock(method=used[0], confidence=1.0) if used else Clock()
    return tuple(clocks.get(camera.name, Clock()) for camera in cameras)


def _found(methods: Sequence[str], footage: Footage, reference: str, progress: Progress) -> dict[str, Clock]:
    """The clock of each camera by the first of the methods that is sure; those that none settles are told of."""
    clocks: dict[str, Clock] = {}
    reasons: dict[str, list[str]] = {c.name: [] for c in footage.cameras if c.name != reference}
    for used_method in methods:
        wanted = [name for name in reasons if name not in clocks]
        if not wanted:
            break
        for name, result in _FINDERS[used_method](footage, reference, wanted, progress).items():
            if isinstance(result, Refusal):
                reasons[name].append(f"{used_method}: {result}")
            else:
                clocks[name] = result
    for name, why in reasons.items():
        if name not in clocks and why:
            progress.note(f"{name} is taken to start with {reference} ({'; '.join(why)})")
    return clocks


def _checked(
    by_timecode: Mapping[str, Clock], footage: Footage, reference: str, progress: Progress, *, alone: bool
) -> dict[str, Clock]:
    """The clocks found by timecode, checked against the audio: what it contradicts keeps half of its confidence.

    Where the labels are equal as well, they are what recorders were preset to, and the audio's clock is taken, unless
    the timecode alone was asked for.
    """
    if not by_timecode:
        return {}
    checked = dict(by_timecode)
    for name, heard in clocks_from_audio(footage, reference, list(by_timecode), progress).items():
        if isinstance(heard, Refusal):
            continue
        clock = by_timecode[name]
        end = min(length_s(footage, reference), length_s(footage, name))
        apart = max(abs(clock.programme_time(t) - heard.programme_time(t)) for t in (0.0, end))
        # One picture is what a label leaves open; two for recorders that label late.
        picture_s = 1 / footage.camera(reference).rate
        if apart <= 2 * picture_s:
            checked[name] = attrs.evolve(clock, confidence=1.0)
        elif abs(clock.offset_s) <= 2 * picture_s and not alone:
            progress.note(
                f"{name}: its timecode begins as {reference}'s does, but its sound says {1000 * apart:.0f} ms other "
                "and was taken; --sync timecode goes by the timecode"
            )
            checked[name] = heard
        else:
            progress.note(
                f"{name}: its sound says {1000 * apart:.0f} ms other than its timecode, which was taken; "
                "--sync audio goes by the sound"
            )
            checked[name] = attrs.evolve(clock, confidence=round(clock.confidence / 2, 3))
    return checked
