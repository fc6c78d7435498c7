"""The cut as Final Cut Pro 7 XML (xmeml 5), for Premiere Pro and Resolve.

The cameras lie on tracks of their own, the shots on the track above: what lies highest shows, so that an angle is
chosen by taking what covers it away. xmeml's own multiclip is not used: it is nowhere said that today's readers take
it for more than its active angle. A clip's `in` and `out` count from its file's first picture, whatever timecode that
bears.

References
----------
Apple, Final Cut Pro XML Interchange Format (retired).
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from fractions import Fraction
from math import ceil, floor

from .model import Clip, Marker, Medium, Sequence, Transform
from .timecode import is_broadcast, is_ntsc, label, nominal
from .xml_text import add, document, file_url, number

_COLOURS = {"movement": "4294741314", "override": "4281740498"}  # of Premiere's marker: the kinds most looked for


def write_xmeml(cut: Sequence) -> bytes:
    """The document."""
    root = ET.Element("xmeml", version="5")
    sequence = add(root, "sequence", id="sequence-1")
    add(sequence, "name", cut.name)
    add(sequence, "duration", cut.length)
    _rate(sequence, cut.rate)
    _timecode(sequence, cut.rate, cut.start, cut.drop)
    writer = _Writer(cut)
    media = add(sequence, "media")
    video = add(media, "video")
    _format(video, cut)
    for angle in cut.angles:
        writer.track(video, map(cut.moved, cut.held(angle.clips)))
    writer.track(video, map(cut.moved, cut.shown()))
    audio = add(media, "audio")
    add(audio, "numOutputChannels", 2)
    characteristics = add(add(audio, "format"), "samplecharacteristics")
    add(characteristics, "depth", 16)
    add(characteristics, "samplerate", 48000)
    for channel in range(1, max((clip.medium.channels for clip in cut.sound), default=0) + 1):
        heard = (clip for clip in cut.sound if channel <= clip.medium.channels)
        writer.track(audio, map(cut.moved, cut.held(heard)), channel)
    for marker in cut.held_markers():
        _marker(sequence, marker)
    comments = add(sequence, "comments")
    add(comments, "mastercomment1", f"mcsl cut {cut.origin}")
    return document(root, "xmeml")


def file_rate(medium: Medium, programme: Fraction) -> Fraction:
    """The rate that a file's pictures are counted in: its own where there is timecode at it."""
    return medium.rate if is_broadcast(medium.rate) else programme


class _Writer:
    """Clips, and the files that are described where they first appear."""

    def __init__(self, cut: Sequence) -> None:
        self._cut = cut
        self._files: dict[Medium, str] = {}
        self._clips = 0

    def track(self, parent: ET.Element, clips: Iterable[Clip], channel: int | None = None) -> None:
        """A track of pictures, or of one channel of sound."""
        track = add(parent, "track")
        for clip in clips:
            self._clip(track, clip, channel)
        add(track, "enabled", "TRUE")
        add(track, "locked", "FALSE")

    def _clip(self, track: ET.Element, clip: Clip, channel: int | None) -> None:
        self._clips += 1
        rate = file_rate(clip.medium, self._cut.rate)
        first, stop = (at * rate / clip.medium.rate for at in (clip.source, clip.source_stop))
        item = add(track, "clipitem", id=f"clipitem-{self._clips}")
        add(item, "name", clip.camera)
        add(item, "enabled", "TRUE")
        add(item, "duration", _lasts(clip.medium, rate))
        _rate(item, rate)
        add(item, "start", clip.range.start)
        add(item, "end", clip.range.stop)
        add(item, "in", floor(first))
        add(item, "out", min(ceil(stop), _lasts(clip.medium, rate)))
        self._file(item, clip.medium, rate)
        if channel is not None:
            source = add(item, "sourcetrack")
            add(source, "mediatype", "audio")
            add(source, "trackindex", channel)
        elif clip.transform is not None and clip.medium.size is not None:
            _motion(item, clip.transform, self._cut.size)

    def _file(self, item: ET.Element, medium: Medium, rate: Fraction) -> None:
        if medium in self._files:
            add(item, "file", id=self._files[medium])
            return
        self._files[medium] = f"file-{len(self._files) + 1}"
        file = add(item, "file", id=self._files[medium])
        add(file, "name", medium.path.name)
        add(file, "pathurl", file_url(medium.path))
        _rate(file, rate)
        add(file, "duration", _lasts(medium, rate))
        _timecode(file, rate, floor(medium.start_s * rate), medium.drop)
        media = add(file, "media")
        if medium.size is not None:
            characteristics = add(add(media, "video"), "samplecharacteristics")
            _rate(characteristics, rate)
            _picture(characteristics, medium.size)
        if medium.channels:
            audio = add(media, "audio")
            characteristics = add(audio, "samplecharacteristics")
            add(characteristics, "depth", 16)
            add(characteristics, "samplerate", medium.audio_rate)
            add(audio, "channelcount", medium.channels)


def _lasts(medium: Medium, rate: Fraction) -> int:
    return floor(medium.duration_s * rate)


def _rate(parent: ET.Element, rate: Fraction) -> None:
    element = add(parent, "rate")
    add(element, "timebase", nominal(rate))
    add(element, "ntsc", "TRUE" if is_ntsc(rate) else "FALSE")


def _timecode(parent: ET.Element, rate: Fraction, count: int, drop: bool) -> None:
    element = add(parent, "timecode")
    _rate(element, rate)
    add(element, "string", label(count, rate, drop=drop))
    add(element, "frame", count)
    add(element, "displayformat", "DF" if drop else "NDF")


def _format(video: ET.Element, cut: Sequence) -> None:
    characteristics = add(add(video, "format"), "samplecharacteristics")
    _rate(characteristics, cut.rate)
    _picture(characteristics, cut.size)


def _picture(characteristics: ET.Element, size: tuple[int, int]) -> None:
    add(characteristics, "width", size[0])
    add(characteristics, "height", size[1])
    add(characteristics, "anamorphic", "FALSE")
    add(characteristics, "pixelaspectratio", "square")
    add(characteristics, "fielddominance", "none")


def _motion(item: ET.Element, transform: Transform, size: tuple[int, int]) -> None:
    effect = add(add(item, "filter"), "effect")
    for tag, text in (
        ("name", "Basic Motion"),
        ("effectid", "basic"),
        ("effectcategory", "motion"),
        ("effecttype", "motion"),
        ("mediatype", "video"),
    ):
        add(effect, tag, text)
    for name, value in (("scale", 100 * transform.scale), ("rotation", transform.rotation)):
        parameter = add(effect, "parameter")
        add(parameter, "parameterid", name)
        add(parameter, "name", name.capitalize())
        add(parameter, "value", number(value))
    parameter = add(effect, "parameter")
    add(parameter, "parameterid", "center")
    add(parameter, "name", "Center")
    middle = add(parameter, "value")
    add(middle, "horiz", number(transform.x / size[0]))
    add(middle, "vert", number(transform.y / size[1]))


def _marker(sequence: ET.Element, marker: Marker) -> None:
    element = add(sequence, "marker")
    add(element, "comment", marker.note)
    add(element, "name", marker.name)
    add(element, "in", marker.range.start)
    add(element, "out", marker.range.stop if len(marker.range) > 1 else -1)
    if marker.kind in _COLOURS:
        add(element, "pproColor", _COLOURS[marker.kind])
