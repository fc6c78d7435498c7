"""The cut as OpenTimelineIO's JSON, for Resolve, Premiere Pro and others.

The cameras lie on tracks of their own, the shots above them. A shot's clip has the picture that is shown as its active
medium and the other angles beside it, as far as one file of theirs covers the clip. There are no transforms in OTIO.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import floor
from typing import Any

from .model import Clip, Marker, Medium, Sequence
from .xml_text import file_url, plain

_COLOURS = {"movement": "ORANGE", "pose": "BLUE", "weak": "RED", "shot": "GREEN", "override": "PURPLE"}
KEY = "mcsl"


def write_otio(cut: Sequence) -> bytes:
    """The document."""
    tracks = [_track(cut, a.camera, "Video", [_clip(cut.moved(c)) for c in cut.held(a.clips)]) for a in cut.angles]
    tracks.append(_track(cut, "Programme", "Video", [_clip(cut.moved(c), _others(cut, c)) for c in cut.shown()]))
    if cut.sound:
        tracks.append(_track(cut, "Sound", "Audio", [_clip(cut.moved(c)) for c in cut.held(cut.sound)]))
    stack = _object("Stack.1", "tracks", children=tracks, markers=[_marker(m, cut.rate) for m in cut.held_markers()])
    timeline = {
        "OTIO_SCHEMA": "Timeline.1",
        "metadata": {KEY: {"cut": cut.origin, "rate": str(cut.rate)}},
        "name": plain(cut.name),
        "global_start_time": _time(Fraction(cut.start), cut.rate),
        "tracks": stack,
    }
    return (json.dumps(timeline, indent=1, ensure_ascii=False) + "\n").encode()  # rates with all their digits


def _object(schema: str, name: str, **fields: Any) -> dict[str, Any]:
    shared = {"metadata": {}, "name": plain(name), "source_range": None, "effects": [], "markers": [], "enabled": True}
    return {"OTIO_SCHEMA": schema, **shared, **fields}


def _track(cut: Sequence, name: str, kind: str, clips: Iterable[tuple[Clip, dict[str, Any]]]) -> dict[str, Any]:
    children, at = [], 0
    for clip, made in clips:
        children += [_gap(clip.range.start - at, cut.rate)] * (at < clip.range.start)
        children.append(made)
        at = clip.range.stop
    return _object("Track.1", name, kind=kind, children=children)


def _gap(frames: int, rate: Fraction) -> dict[str, Any]:
    return _object("Gap.1", "", source_range=_range(Fraction(0), frames, rate, rate))


def _clip(clip: Clip, others: Mapping[str, Clip] | None = None) -> tuple[Clip, dict[str, Any]]:
    media = {plain(clip.camera): _medium(clip.medium)}
    media |= {plain(name): _medium(other.medium) for name, other in (others or {}).items()}
    made = _object(
        "Clip.2",
        clip.camera,
        source_range=_range(clip.medium.start + clip.source, len(clip.range), clip.medium.rate, clip.rate),
        media_references=media,
        active_media_reference_key=plain(clip.camera),
    )
    return clip, made


def _others(cut: Sequence, shown: Clip) -> dict[str, Clip]:
    """Camera -> its clip over all of ``shown``, of the cameras that have one."""
    found = {}
    for angle in cut.angles:
        clip = next((c for c in angle.within(shown.range) if c.range == shown.range), None)
        if clip is not None and angle.camera != shown.camera:
            found[angle.camera] = clip
    return found


def _medium(medium: Medium) -> dict[str, Any]:
    return {
        "OTIO_SCHEMA": "ExternalReference.1",
        "metadata": {},
        "name": plain(medium.path.name),
        "available_range": _range(Fraction(medium.start), medium.frames, medium.rate, medium.rate),
        "available_image_bounds": None,
        "target_url": file_url(medium.path),
    }


def _marker(marker: Marker, rate: Fraction) -> dict[str, Any]:
    return {
        "OTIO_SCHEMA": "Marker.2",
        "metadata": {KEY: {"kind": marker.kind}},
        "name": plain(marker.name),
        "color": _COLOURS[marker.kind],
        "comment": plain(marker.note),
        "marked_range": _range(Fraction(marker.range.start), len(marker.range), rate, rate),
    }


def _range(start: Fraction, frames: int, rate: Fraction, length_rate: Fraction) -> dict[str, Any]:
    return {
        "OTIO_SCHEMA": "TimeRange.1",
        "start_time": _time(start, rate),
        "duration": _time(Fraction(frames), length_rate),
    }


def _time(value: Fraction, rate: Fraction) -> dict[str, Any]:
    return {"OTIO_SCHEMA": "RationalTime.1", "rate": float(rate), "value": float(floor(value))}
