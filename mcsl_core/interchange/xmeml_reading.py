"""Final Cut Pro 7 XML as it comes back from Premiere Pro or Resolve."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import attrs

from mcsl_core.errors import DocumentError, Fault
from mcsl_core.timing import FrameRange

from .found import FoundClip, FoundCut, bounded
from .model import Transform
from .origin import ORIGIN
from .xml_text import path_of, read_xml

WHAT = "a Final Cut Pro 7 XML document (xmeml)"
_UNTOUCHED = {"opacity": 100, "crop": 0, "audiolevels": 1, "audiopan": 0}  # effect -> what its parameters are
_TAKEN_UP = -1  # of a start or end that lies in a transition


def read_xmeml(path: Path) -> FoundCut:
    """The first sequence of a document.

    Raises
    ------
    InputError
        Where it cannot be read, is no xmeml, or has no sequence.
    """
    root = read_xml(path, "xmeml", WHAT)
    sequence = root.find(".//sequence")
    if sequence is None:
        raise DocumentError("has no sequence", where=str(path), remedy="Export the sequence itself")
    reader = _Reader(root, sequence, path)
    inside = set(sequence.iter("sequence"))  # nested in it
    others = [repr(one.findtext("name", "")) for one in root.iter("sequence") if one not in inside]
    if others:
        name = sequence.findtext("name", "")
        reader.notes.append(f"of {len(others) + 1} sequences the first is read, {name!r}, not {', '.join(others)}")
    try:
        return reader.read()
    except Fault as fault:
        raise DocumentError(str(fault), where=str(path), remedy="Export it again from the editor") from fault


class _Reader:
    def __init__(self, root: ET.Element, sequence: ET.Element, path: Path) -> None:
        self._sequence, self._path = sequence, path
        self._files = {f.get("id"): f for f in root.iter("file") if f.find("pathurl") is not None}
        self._rate = self._rate_of(sequence)
        if self._rate is None:
            raise self._fault("the sequence has no rate")
        self.notes: list[str] = []

    def read(self) -> FoundCut:
        clips: list[FoundClip] = []
        for layer, track in enumerate(self._sequence.findall("./media/video/track")):
            shown = _is_enabled(track)
            items = list(track)
            for index, item in enumerate(items):
                if item.tag == "clipitem":
                    clips += self._clip(items, index, layer, shown)
                elif item.tag == "transitionitem":
                    self.notes.append(f"a transition at frame {self._number(item, 'start')}")
                elif item.tag == "generatoritem":
                    start, stop, _ = self._ends(items, index)
                    self.notes.append(f"a title or generator {item.findtext('name', '')!r} at frame {start}")
                    clips += self._unread(item, start, stop, layer, shown)
        sounds = list(self._sounds())
        markers = [(self._number(m, "in"), m.findtext("name", "")) for m in self._sequence.findall("marker")]
        origin = ORIGIN.search(" ".join(self._sequence.itertext()))
        assert self._rate is not None
        return FoundCut(
            rate=self._rate,
            clips=tuple(clips),
            sounds=tuple(sounds),
            markers=tuple(markers),
            origin=origin[1] if origin else "",
            notes=tuple(self.notes),
        )

    def _sounds(self) -> Iterator[FoundClip]:
        """The clips of sound, a channel of their file each."""
        for layer, track in enumerate(self._sequence.findall("./media/audio/track")):
            items = list(track)
            for index, item in enumerate(items):
                if item.tag == "transitionitem":
                    self.notes.append(f"a transition of the sound at frame {self._number(item, 'start')}")
                elif item.tag == "clipitem":
                    for clip in self._clip(items, index, layer, _is_enabled(track), "sound"):
                        channel = item.find("sourcetrack")
                        number = 1 if channel is None else self._number(channel, "trackindex")
                        yield attrs.evolve(clip, channel=number, transform=None)

    def _clip(
        self, items: list[ET.Element], index: int, layer: int, shown: bool, what: str = "clip"
    ) -> list[FoundClip]:
        item = items[index]
        name = item.findtext("name", "")
        start, stop, late = self._ends(items, index)
        if not 0 <= start < stop:
            self.notes.append(f"the {what} {name!r} before the sequence's start, or of no length")
            return []
        markers = [marker.findtext("name", "") for marker in item.findall("marker")]
        self.notes += [f"the marker {marker!r} of {name!r} at frame {start}" for marker in markers]
        self._note_effects(item, repr(name) if what == "clip" else f"the {what} {name!r}", start)
        file = item.find("file")
        if file is None:
            self.notes.append(f"the {what} {name!r} at frame {start}, which is nested or a multiclip")
            return self._unread(item, start, stop, layer, shown)
        assert self._rate is not None
        rate = self._rate_of(item) or self._rate
        described = self._files.get(file.get("id"), file)
        return [
            FoundClip(
                name=name,
                range=FrameRange(start, stop),
                layer=layer,
                enabled=shown and _is_enabled(item),
                path=path_of(described.findtext("pathurl", "").strip()),
                source_s=self._number(item, "in") / rate + late / self._rate,
                zero_s=Fraction(0),
                retimed=any(map(_retimes, item.findall("./filter/effect"))),
                transform=self._motion(item),
            )
        ]

    def _unread(self, item: ET.Element, start: int, stop: int, layer: int, shown: bool) -> list[FoundClip]:
        """What is seen of an item that is not read: that there is something."""
        if not 0 <= start < stop:
            return []
        enabled = shown and _is_enabled(item)
        piece = FrameRange(start, stop)
        return [FoundClip(name=item.findtext("name", ""), range=piece, layer=layer, enabled=enabled, unread=True)]

    def _motion(self, item: ET.Element) -> Transform | None:
        """Where Basic Motion puts the picture, in pixels of the sequence; None without it, or where it moves."""
        effect = next((e for e in item.findall("./filter/effect") if e.findtext("effectid") == "basic"), None)
        size = self._sequence.find("./media/video/format/samplecharacteristics")
        if effect is None or size is None:
            return None
        said = {p.findtext("parameterid", ""): p.find("value") for p in effect.findall("parameter")}
        middle = said.get("center")
        try:
            return Transform(
                x=_decimal(middle, "horiz", 0) * self._number(size, "width"),
                y=_decimal(middle, "vert", 0) * self._number(size, "height"),
                scale=_decimal(said.get("scale"), ".", 100) / 100,
                rotation=_decimal(said.get("rotation"), ".", 0),
            )
        except ValueError:
            return None

    def _ends(self, items: list[ET.Element], index: int) -> tuple[int, int, int]:
        """(where an item begins, where it ends, how long after its ``in`` it begins).

        A transition beside it says so in its place: the item is taken to reach up to the cut under the transition, its
        ``in`` and ``out`` lie at the transition's ends.
        """
        start, stop, late = self._number(items[index], "start"), self._number(items[index], "end"), 0
        if start == _TAKEN_UP and index and items[index - 1].tag == "transitionitem":
            start = self._cut_under(items[index - 1])
            late = start - self._number(items[index - 1], "start")
        if stop == _TAKEN_UP and index + 1 < len(items) and items[index + 1].tag == "transitionitem":
            stop = self._cut_under(items[index + 1])
        return start, stop, late

    def _cut_under(self, transition: ET.Element) -> int:
        start, stop = self._number(transition, "start"), self._number(transition, "end")
        kind = transition.findtext("alignment", "center").strip().partition("-")[0]  # "start-black": from black
        return {"start": start, "end": stop}.get(kind, (start + stop) // 2)

    def _note_effects(self, item: ET.Element, of: str, start: int) -> None:
        effects = item.findall("./filter/effect")
        found = [effect.findtext("name", "an effect") for effect in effects if not _is_untouched(effect)]
        mode = item.findtext("compositemode", "normal").strip()
        for what in [*found, *([mode] if mode.lower() not in ("", "normal") else [])]:
            self.notes.append(f"{what!r} of {of} at frame {start}")

    def _rate_of(self, element: ET.Element) -> Fraction | None:
        rate = element.find("rate")
        if rate is None:
            return None
        base = self._number(rate, "timebase")
        if not 0 < base <= 1000:
            raise self._fault(f"{base} is no timebase")
        ntsc = rate.findtext("ntsc", "FALSE").strip().upper() == "TRUE"
        return Fraction(base * 1000, 1001) if ntsc else Fraction(base)

    def _number(self, element: ET.Element, tag: str) -> int:
        text = (element.findtext(tag) or "").strip()
        if not re.fullmatch(r"-?\d{1,18}", text):
            raise self._fault(f"<{tag}>{text[:40]}</{tag}> of <{element.tag}> is no whole number")
        return bounded(int(text))

    def _fault(self, what: str) -> DocumentError:
        return DocumentError(what, where=str(self._path), remedy="Export it again from the editor")


def _is_enabled(element: ET.Element) -> bool:
    return element.findtext("enabled", "TRUE").strip().upper() != "FALSE"


def _is_untouched(effect: ET.Element) -> bool:
    """Whether an effect is one that editors write of every clip, as it is there."""
    kind = effect.findtext("effectid", "").strip()
    if kind == "basic":  # is compared with how the export laid the picture
        return True
    parameters = effect.findall("parameter")
    if kind not in _UNTOUCHED or any(parameter.find("keyframe") is not None for parameter in parameters):
        return False
    try:
        return all(float(p.findtext("value") or _UNTOUCHED[kind]) == _UNTOUCHED[kind] for p in parameters)
    except ValueError:
        return False


def _retimes(effect: ET.Element) -> bool:
    """Whether an effect changes the speed; the one of its name at a speed of 100 percent does not."""
    if effect.findtext("effectid", "").strip() != "timeremap":
        return False
    said = {p.findtext("parameterid", ""): p.findtext("value", "").strip().upper() for p in effect.findall("parameter")}
    try:
        plain = float(said.get("speed", "nan")) == 100
    except ValueError:
        plain = False
    return not plain or said.get("reverse") == "TRUE" or said.get("variablespeed", "0") not in ("0", "FALSE")


def _decimal(element: ET.Element | None, tag: str, otherwise: float) -> float:
    return otherwise if element is None else float(element.findtext(tag) or otherwise)
