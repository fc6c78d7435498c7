"""FCPXML of any version as it comes back from Final Cut Pro or Resolve."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

from mcsl_core.errors import DocumentError, Fault
from mcsl_core.fades import FADE_FRAMES
from mcsl_core.timing import FrameRange

from .found import FoundClip, FoundCut, bounded
from .origin import ORIGIN
from .xml_text import path_of, read_xml

WHAT = "an FCPXML document"
_BUNDLE = "Info.fcpxml"
_TIME = re.compile(r"([+-]?\d{1,20})(?:/(\d{1,20}))?s")
_KNOWN = ("mc-clip", "asset-clip", "clip", "video", "audio")
_UNREAD = ("title", "ref-clip", "sync-clip", "audition", "live-drawing")
_STORY = (*_KNOWN, *_UNREAD, "spine", "gap", "caption")
_SOUND_SOURCES = ("audio-channel-source", "audio-role-source")
_UNTOUCHED = {  # what editors write of clips that nobody touched
    "adjust-transform": {"position": "0 0", "scale": "1 1", "rotation": "0", "anchor": "0 0"},
    "adjust-volume": {"amount": "0dB"},
    "adjust-blend": {"amount": "1"},
    "adjust-conform": {"type": "fit"},
}


def read_fcpxml(path: Path) -> FoundCut:
    """The first sequence of a document.

    Raises
    ------
    InputError
        Where it cannot be read, is no FCPXML, or has no sequence.
    """
    path = path / _BUNDLE if path.is_dir() else path
    root = read_xml(path, "fcpxml", WHAT)
    sequences = root.findall(".//project/sequence")
    if not sequences:
        raise DocumentError("has no project with a sequence", where=str(path), remedy="Export the project itself")
    try:
        found = _Reader(root, sequences[0], path).read()
    except Fault as fault:
        raise DocumentError(str(fault), where=str(path), remedy="Export it again from the editor") from fault
    if len(sequences) > 1:
        names = ", ".join(repr(one.get("name", "")) for one in root.findall(".//project")[1:])
        found.notes.append(f"of {len(sequences)} projects the first is read, not {names}")
    return found.cut()


class _Reader:
    """Collects the clips of one sequence."""

    def __init__(self, root: ET.Element, sequence: ET.Element, path: Path) -> None:
        self._sequence, self._path = sequence, path
        self._resources = {element.get("id", ""): element for element in root.iter() if element.get("id")}
        form = self._resources.get(sequence.get("format", ""))
        duration = self._time(form, "frameDuration") if form is not None else Fraction(0)
        if duration <= 0:
            raise self._fault("the sequence has no format with a frameDuration")
        self._rate = 1 / duration
        self._clips: list[FoundClip] = []
        self._sounds: list[FoundClip] = []
        self._markers: list[tuple[int, str]] = []
        self.notes: list[str] = []

    def read(self) -> _Reader:
        spine = self._sequence.find("spine")
        if spine is None:
            raise self._fault("the sequence has no spine")
        self._spine(spine, self._time(self._sequence, "tcStart"), 0)
        return self

    def cut(self) -> FoundCut:
        said = " ".join(note.text or "" for note in self._sequence.findall("note"))
        origin = ORIGIN.search(said)
        return FoundCut(
            rate=self._rate,
            clips=tuple(self._clips),
            sounds=tuple(self._sounds),
            markers=tuple(self._markers),
            origin=origin[1] if origin else "",
            notes=tuple(self.notes),
        )

    def _spine(self, spine: ET.Element, begin_s: Fraction, layer: int) -> None:
        """The items of a storyline; their offsets count in the time that begins at ``begin_s`` at the sequence's 0."""
        at_s = begin_s
        for item in spine:
            if item.tag == "transition":
                self.notes.append(f"a transition at frame {self._frame(self._time(item, 'offset', at_s) - begin_s)}")
            elif item.tag in _STORY:
                offset_s = self._offset(item, at_s)
                self._item(item, offset_s - begin_s, layer)
                at_s = offset_s + self._lasts(item)

    def _item(self, item: ET.Element, at_s: Fraction, layer: int) -> None:
        """One item that begins ``at_s`` after the sequence's start, and what is connected to it."""
        start_s = self._start(item)
        lasts_s = self._lasts(item)
        if self._is_unread(item):
            self._unread(item, at_s, lasts_s, layer)
        elif item.tag == "caption":
            self.notes.append(f"a caption at frame {self._frame(at_s)}")
        elif item.tag in _KNOWN:
            self._pictures(item, at_s, lasts_s, layer)
            self._sound(item, at_s, lasts_s, layer)
        for child in item:
            if child.tag == "marker" or child.tag == "chapter-marker":
                at = self._frame(at_s + self._time(child, "start") - start_s)
                self._markers.append((at, child.get("value", "")))
            elif child.tag in _STORY and child.get("lane") is not None:
                lane = layer + self._lane(child)
                below_s = at_s + self._offset(child, Fraction(0)) - start_s
                if child.tag == "spine":
                    self._spine_at(child, below_s, lane)
                else:
                    self._item(child, below_s, lane)
            for effect in (child, *(child if child.tag == "mc-source" else ())):
                if self._is_effect(effect):
                    self.notes.append(f"{effect.tag} of {item.get('name', '')!r} at frame {self._frame(at_s)}")

    def _spine_at(self, spine: ET.Element, at_s: Fraction, layer: int) -> None:
        first = next((item for item in spine if item.tag in _STORY), None)
        begin_s = Fraction(0) if first is None else self._offset(first, Fraction(0))
        self._spine(spine, begin_s - at_s, layer)

    def _is_unread(self, item: ET.Element) -> bool:
        """Whether an item shows what is not read: nested, a title or generator."""
        if item.tag == "clip":  # of one medium, or of a storyline of its own
            return not any(child.tag in ("video", "asset-clip", "audio") for child in item)
        resource = self._resources.get(item.get("ref", ""))
        return item.tag in _UNREAD or (resource is not None and resource.tag == "effect")

    def _unread(self, item: ET.Element, at_s: Fraction, lasts_s: Fraction, layer: int) -> None:
        start, stop = self._frame(at_s), self._frame(at_s + lasts_s)
        self.notes.append(f"a {item.tag} {item.get('name', '')!r} at frame {start}")
        if 0 <= start < stop and item.get("srcEnable") != "audio":
            shown = item.get("enabled", "1") != "0"
            piece = FrameRange(start, stop)
            self._clips.append(
                FoundClip(name=item.get("name", ""), range=piece, layer=layer, enabled=shown, unread=True)
            )

    def _pictures(self, item: ET.Element, at_s: Fraction, lasts_s: Fraction, layer: int) -> None:
        sources = [child for child in item if child.tag in ("video", "asset-clip")] if item.tag == "clip" else [item]
        source = next((one for one in sources if self._has(one, "hasVideo")), None)
        if source is None or item.tag == "audio" or item.get("srcEnable") == "audio":
            return
        start, stop = self._frame(at_s), self._frame(at_s + lasts_s)
        if not 0 <= start < stop:
            self.notes.append(f"the clip {item.get('name', '')!r} before the sequence's start, or of no length")
            return
        angle = None
        if item.tag == "mc-clip":
            angle = next(self._angles(item, "video"), "" if item.find("mc-source") is None else None)
            if angle is None:  # sound alone is left of it
                self._unread(item, at_s, lasts_s, layer)
                return
        self._clips.append(self._found(item, source, FrameRange(start, stop), self._start(item), layer, angle))

    def _sound(self, item: ET.Element, at_s: Fraction, lasts_s: Fraction, layer: int) -> None:
        """What is heard of an item: its sound may begin and end elsewhere than its picture."""
        inside = [*item, *(deeper for child in item if child.tag == "video" for deeper in child)]
        sources = [one for one in inside if one.tag in ("audio", "asset-clip")] if item.tag == "clip" else [item]
        source = next((one for one in sources if self._has(one, "hasAudio")), None)
        if source is None or item.tag == "video" or item.get("srcEnable") == "video":
            return
        first_s = self._time(item, "audioStart", self._start(item))
        at_s += first_s - self._start(item)
        start, stop = self._frame(at_s), self._frame(at_s + self._time(item, "audioDuration", lasts_s))
        if not 0 <= start < stop:
            self.notes.append(f"the sound of {item.get('name', '')!r} before the sequence's start, or of no length")
            return
        for angle in self._angles(item, "audio") if item.tag == "mc-clip" else [None]:
            self._sounds.append(self._found(item, source, FrameRange(start, stop), first_s, layer, angle))

    def _found(
        self, item: ET.Element, source: ET.Element, piece: FrameRange, start_s: Fraction, layer: int, angle: str | None
    ) -> FoundClip:
        """An item that shows or sounds what ``source`` refers to, from ``start_s`` in the item's time on."""
        resource = self._resources.get(source.get("ref", ""))
        path, zero_s = "", None
        if angle is not None:
            zero_s = self._multicam_start(resource)
        elif resource is not None:
            rep = resource.find("media-rep")
            path = path_of(resource.get("src", "") if rep is None else rep.get("src", ""))
            zero_s = self._time(resource, "start")
        if source is not item:  # a clip's own time is that of what lies in it
            start_s += self._start(source) - self._time(source, "offset")
        return FoundClip(
            name=item.get("name", ""),
            range=piece,
            layer=layer,
            enabled=item.get("enabled", "1") != "0",
            angle=angle,
            path=path,
            source_s=start_s,
            zero_s=zero_s,
            retimed=item.find("timeMap") is not None,
        )

    def _has(self, source: ET.Element, what: str) -> bool:
        """Whether what an item refers to has pictures or sound."""
        resource = self._resources.get(source.get("ref", ""))
        return resource is None or resource.tag != "asset" or resource.get(what) == "1"

    def _angles(self, item: ET.Element, what: str) -> Iterator[str]:
        """The names of the angles that an mc-clip shows, or lets hear; of one that says nothing, the first."""
        media = self._resources.get(item.get("ref", ""))
        angles = [] if media is None else media.findall("./multicam/mc-angle")
        names = {angle.get("angleID"): angle.get("name", "") for angle in angles}
        sources = item.findall("mc-source")
        for source in sources:
            if source.get("srcEnable", "all") in ("all", what):
                yield names.get(source.get("angleID"), "")
        if not sources:
            yield from list(names.values())[:1]

    def _is_effect(self, element: ET.Element) -> bool:
        """Whether an element changes how a clip looks or sounds; what editors write of every clip does not."""
        if element.tag in _SOUND_SOURCES:
            off = "0" in (element.get("enabled"), element.get("active"))
            return off or any(child.tag == "mute" or self._is_effect(child) for child in element)
        if element.tag == "adjust-colorConform" or not element.tag.startswith(("adjust-", "filter-", "timeMap")):
            return False
        plain = _UNTOUCHED.get(element.tag)
        if plain is None or any(value != plain.get(name) for name, value in element.attrib.items()):
            return True
        return not all(element.tag == "adjust-volume" and self._fades_at_seams(child) for child in element)

    def _fades_at_seams(self, level: ET.Element) -> bool:
        """Whether a level does no more than fade as the export lets it beside what is removed."""
        most_s = FADE_FRAMES / self._rate
        return dict(level.attrib) == {"name": "amount"} and all(
            child.tag in ("fadeIn", "fadeOut")
            and child.get("type") == "linear"
            and self._time(child, "duration") <= most_s
            for child in level
        )

    def _multicam_start(self, media: ET.Element | None) -> Fraction:
        multicam = None if media is None else media.find("multicam")
        return Fraction(0) if multicam is None else self._time(multicam, "tcStart")

    def _start(self, item: ET.Element) -> Fraction:
        """An item's own time where it begins: what it refers to begins there, where it does not say."""
        if item.get("start") is not None:
            return self._time(item, "start")
        resource = self._resources.get(item.get("ref", ""))
        if resource is None:
            return Fraction(0)
        return self._multicam_start(resource) if resource.tag == "media" else self._time(resource, "start")

    def _lasts(self, item: ET.Element) -> Fraction:
        """An item's length: that of what it refers to, or of the first of an audition, where it does not say."""
        if item.get("duration") is not None:
            return self._time(item, "duration")
        resource = self._resources.get(item.get("ref", ""))
        if resource is not None:
            angles = [sum(map(self._lasts, angle), Fraction(0)) for angle in resource.findall("./multicam/mc-angle")]
            sequence = resource.find("sequence")
            return max(angles) if angles else self._time(resource if sequence is None else sequence, "duration")
        picked = _picked(item)
        return Fraction(0) if picked is None else self._lasts(picked)

    def _offset(self, item: ET.Element, otherwise: Fraction) -> Fraction:
        picked = _picked(item)
        if item.get("offset") is None and picked is not None:
            return self._time(picked, "offset", otherwise)
        return self._time(item, "offset", otherwise)

    def _lane(self, item: ET.Element) -> int:
        try:
            return int(item.get("lane", "0"))
        except ValueError:
            raise self._fault(f"lane={item.get('lane')!r} is no whole number") from None

    def _frame(self, seconds: Fraction) -> int:
        return bounded(round(seconds * self._rate))

    def _time(self, element: ET.Element, name: str, otherwise: Fraction = Fraction(0)) -> Fraction:
        said = element.get(name)
        if said is None:
            return otherwise
        match = _TIME.fullmatch(said)
        if match is None or (match[2] is not None and int(match[2]) == 0):
            raise self._fault(f"{name}={said[:40]!r} of <{element.tag}> is no time")
        return bounded(Fraction(int(match[1]), int(match[2] or 1)))

    def _fault(self, what: str) -> DocumentError:
        return DocumentError(what, where=str(self._path), remedy="Export it again from the editor")


def _picked(item: ET.Element) -> ET.Element | None:
    """What an audition shows; None of other items."""
    return next((child for child in item if child.tag in _STORY), None) if item.tag == "audition" else None
