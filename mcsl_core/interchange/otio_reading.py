"""OpenTimelineIO's JSON as it comes back from an editor."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

from mcsl_core.documents import read_json
from mcsl_core.errors import DocumentError
from mcsl_core.timing import FrameRange

from .found import FoundClip, FoundCut, Reference, bounded
from .otio_writing import KEY
from .xml_text import path_of

WHAT = "an OpenTimelineIO document"
_TIME_EFFECTS = ("TimeEffect", "LinearTimeWarp", "FreezeFrame")
_MOST_RATE = 1_000_000  # sound's are below
_CLOSE = Fraction(1, 10_000)  # rates are floats: within so much of NTSC's they are those


def read_otio(path: Path) -> FoundCut:
    """The timeline of a document.

    Raises
    ------
    InputError
        Where it cannot be read, or is no timeline.
    """
    document = read_json(path, wanted=WHAT, remedy="Hand in the .otio file as the editor exported it")
    try:
        return _Reader(document).read()
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, ZeroDivisionError) as error:
        what = f"is not {WHAT}, or misses what one has ({type(error).__name__}: {error})"
        raise DocumentError(what, where=str(path), remedy="Export it again from the editor") from error


class _Reader:
    def __init__(self, document: dict[str, Any]) -> None:
        if _kind(document) != "Timeline":
            raise ValueError(f"it is a {_kind(document)}, not a Timeline")
        self._timeline = document
        tracks = document["tracks"]["children"]
        laid = [t if _kind(t) == "Track" else {"kind": "Video", "children": [t]} for t in tracks]
        self._tracks = [t for t in laid if t["kind"] == "Video"]
        self._sounds = [t for t in laid if t["kind"] == "Audio"]
        said = document.get("metadata", {}).get(KEY, {})
        self._origin = str(said.get("cut", ""))
        start = document.get("global_start_time")
        first = next((c for t in self._tracks for c in t["children"] if c.get("source_range")), None)
        if start is None and first is None:
            raise ValueError("it has no video")
        self._rate = rate_of(start["rate"] if start else first["source_range"]["duration"]["rate"])  # pyright: ignore[reportOptionalSubscript]
        self.notes: list[str] = []

    def read(self) -> FoundCut:
        clips = tuple(clip for layer, track in enumerate(self._tracks) for clip in self._track(track, layer))
        sounds = tuple(clip for layer, track in enumerate(self._sounds) for clip in self._track(track, layer))
        for whole in (self._timeline["tracks"], *self._tracks, *self._sounds):
            self._note_whole(whole)
        marked = [
            *self._timeline["tracks"].get("markers", ()),
            *(m for t in self._tracks for m in t.get("markers", ())),
        ]
        markers = [(self._frames(m["marked_range"]["start_time"]), str(m.get("name", ""))) for m in marked]
        return FoundCut(
            rate=self._rate,
            clips=clips,
            sounds=sounds,
            markers=tuple(markers),
            origin=self._origin,
            notes=tuple(self.notes),
        )

    def _note_whole(self, whole: dict[str, Any]) -> None:
        """What is said of a track, or of all of them, and is not read."""
        name = str(whole.get("name", ""))
        self.notes += [f"{_named(effect)!r} of all of {name!r}" for effect in whole.get("effects", ())]
        if whole.get("source_range"):
            self.notes.append(f"what {name!r} is trimmed to as a whole")

    def _track(self, track: dict[str, Any], layer: int) -> Iterator[FoundClip]:
        at_s = Fraction(0)
        shown = track.get("enabled", True)
        of = "of the sound " if track["kind"] == "Audio" else ""
        for child in track["children"]:
            kind = _kind(child)
            at = bounded(round(at_s * self._rate))
            if kind == "Transition":
                self.notes.append(f"a transition {of}at frame {at}")
                continue
            lasts_s = _lasts(child)
            stop = bounded(round((at_s + lasts_s) * self._rate))
            name = str(child.get("name", ""))
            for effect in child.get("effects", ()):
                self.notes.append(f"{_named(effect)!r} {of or 'of '}{name!r} at frame {at}")
            for marker in child.get("markers", ()):
                self.notes.append(f"the marker {marker.get('name', '')!r} of {name!r} at frame {at}")
            if kind == "Clip" and at < stop:
                yield from self._clip(child, FrameRange(at, stop), layer, shown)
            elif kind not in ("Clip", "Gap"):
                self.notes.append(f"a {kind} {name!r} at frame {at}")
                if at < stop:
                    yield self._unread(child, FrameRange(at, stop), layer, shown)
            at_s += lasts_s

    def _clip(self, clip: dict[str, Any], piece: FrameRange, layer: int, shown: bool) -> Iterator[FoundClip]:
        key, active = _active(clip)
        name = str(clip.get("name", ""))
        # The source range counts in the medium that the clip is named after, whichever angle was chosen since.
        medium = clip.get("media_references", {}).get(name) or active
        span = clip.get("source_range") or _available(clip)
        if {_kind(medium), _kind(active)} != {"ExternalReference"}:
            self.notes.append(f"the clip {clip.get('name', '')!r} at frame {piece.start}, which has no file")
            yield self._unread(clip, piece, layer, shown)
            return
        at = _reference(medium)
        yield FoundClip(
            name=name,
            range=piece,
            layer=layer,
            enabled=bool(shown and clip.get("enabled", True)),
            angle=key,
            path=at.path,
            source_s=seconds(span["start_time"]),
            zero_s=at.zero_s,
            active=_reference(active) if key is not None else None,
            retimed=any(_retimes(effect) for effect in clip.get("effects", ())),
        )

    def _unread(self, child: dict[str, Any], piece: FrameRange, layer: int, shown: bool) -> FoundClip:
        enabled = bool(shown and child.get("enabled", True))
        return FoundClip(name=str(child.get("name", "")), range=piece, layer=layer, enabled=enabled, unread=True)

    def _frames(self, time: dict[str, Any]) -> int:
        return bounded(round(seconds(time) * self._rate))


def rate_of(value: Any) -> Fraction:
    """The rate that a float stands for: NTSC's fractions where it is near one."""
    exact = _number(value)
    if not 0 < exact <= _MOST_RATE:
        raise ValueError(f"{value!r:.40} is no rate")
    whole = Fraction(-(-exact.numerator // exact.denominator))
    near = next((r for r in (Fraction(round(value)), whole * 1000 / 1001) if abs(r - exact) < _CLOSE), None)
    return near or exact.limit_denominator(1001)


def seconds(time: dict[str, Any]) -> Fraction:
    """A RationalTime in seconds, its rate made exact."""
    return bounded(_number(time["value"]) / rate_of(time["rate"]))


def _number(value: Any) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r:.40} is no number")
    return Fraction(value)


def _reference(medium: dict[str, Any]) -> Reference:
    available = medium.get("available_range")
    zero_s = seconds(available["start_time"]) if available else None
    return Reference(path_of(str(medium.get("target_url", ""))), zero_s)


def _named(effect: dict[str, Any]) -> str:
    return str(effect.get("effect_name") or effect.get("name") or _kind(effect))


def _retimes(effect: dict[str, Any]) -> bool:
    scalar = effect.get("time_scalar")
    return _kind(effect) in _TIME_EFFECTS and (scalar is None or scalar != 1)


def _kind(value: Any) -> str:
    return str(value["OTIO_SCHEMA"]).partition(".")[0]


def _active(clip: dict[str, Any]) -> tuple[str | None, dict[str, Any]]:
    """(key, medium) that the clip shows; the key of one that has several."""
    if "media_references" not in clip:
        return None, clip["media_reference"]
    key = clip.get("active_media_reference_key", "DEFAULT_MEDIA")
    return str(key), clip["media_references"][key]


def _available(clip: dict[str, Any]) -> dict[str, Any]:
    return _active(clip)[1]["available_range"]


def _lasts(child: dict[str, Any]) -> Fraction:
    """How long something in a track lasts; what is nested lasts as long as what lies in it."""
    if span := child.get("source_range"):
        return seconds(span["duration"])
    if _kind(child) == "Clip":
        return seconds(_available(child)["duration"])
    if _kind(child) not in ("Stack", "Track"):
        raise ValueError(f"a {_kind(child)} has no source_range")
    inside = [_lasts(one) for one in child["children"] if _kind(one) != "Transition"]
    return bounded(max(inside, default=Fraction(0)) if _kind(child) == "Stack" else sum(inside, Fraction(0)))
