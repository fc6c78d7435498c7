"""Bringing the cameras' clocks onto the reference camera's.

A camera's own time is (t - offset_s) * (1 + drift_ppm * 1e-6) at programme time t, which is the reference camera's
own time. Three ways, the surest first: `timecode`, `audio`, `motion`. What is weak or ambiguous is refused with its
reason, not guessed: then the camera is taken to start with the reference, and its clock says method none.
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
from mcsl_core.sync import audio, motion, timecode

from .clock_fit import Finder, Refusal, length_s

__all__ = ["METHODS", "synchronise"]

_FINDERS: Mapping[str, Finder] = {"timecode": timecode.find, "audio": audio.find, "motion": motion.find}
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
    """A clock for each camera, in their order; the ``reference`` camera's (the first by default) is the programme's.

    method: "timecode", "audio", "motion", "none" (all start together), or "auto": for each camera the first of these
    that is sure. A camera that none settles gets method "none" with confidence 0, and ``progress`` is told why; so it
    is where a camera's sound contradicts its timecode. The reference's clock names the surest method by which any
    camera was tied to it. base: the folder that media paths are relative to. UsageError for another method.
    """
    progress = progress or Silent()
    if method not in METHODS:
        raise UsageError(f"there is no sync method {method!r}", remedy=f"Choose one of {', '.join(METHODS)}")
    if not cameras:
        return ()
    reference = reference or cameras[0].name
    plain = [attrs.evolve(camera, clock=Clock()) for camera in cameras]
    footage = Footage(plain, rate=Fraction(1), frames=1, base=Path(base))
    clocks: dict[str, Clock] = {}
    reasons: dict[str, list[str]] = {c.name: [] for c in plain if c.name != reference}
    for way in METHODS[method]:
        wanted = [name for name in reasons if name not in clocks]
        if not wanted:
            break
        for name, answer in _FINDERS[way](footage, reference, wanted, progress).items():
            if isinstance(answer, Refusal):
                reasons[name].append(f"{way}: {answer}")
            else:
                clocks[name] = answer
    for name, why in reasons.items():
        if name not in clocks and why:
            progress.note(f"{name} is taken to start with {reference} ({'; '.join(why)})")
    clocks |= _checked({n: c for n, c in clocks.items() if c.method == "timecode"}, footage, reference, progress)
    used = [way for way in _FINDERS if any(c.method == way for c in clocks.values())]
    clocks[reference] = Clock(method=used[0], confidence=1.0) if used else Clock()
    return tuple(clocks.get(camera.name, Clock()) for camera in cameras)


def _checked(
    by_timecode: Mapping[str, Clock], footage: Footage, reference: str, progress: Progress
) -> dict[str, Clock]:
    """The clocks found by timecode, weighed against the sound: what it contradicts keeps half of its confidence."""
    if not by_timecode:
        return {}
    checked = dict(by_timecode)
    for name, heard in audio.find(footage, reference, list(by_timecode), progress).items():
        if isinstance(heard, Refusal):
            continue
        clock = by_timecode[name]
        end = min(length_s(footage, reference), length_s(footage, name))
        apart = max(abs(clock.programme_time(t) - heard.programme_time(t)) for t in (0.0, end))
        # One picture is what a label leaves open; two for recorders that label late.
        if apart > 2 / footage.camera(reference).rate:
            progress.note(
                f"{name}: its sound says {1000 * apart:.0f} ms other than its timecode, which was taken; "
                "--sync audio goes by the sound"
            )
            checked[name] = attrs.evolve(clock, confidence=round(clock.confidence / 2, 3))
        else:
            checked[name] = attrs.evolve(clock, confidence=1.0)
    return checked
