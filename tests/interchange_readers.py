"""Exported documents read by parsers that are not mcsl's: opentimelineio with its adapters, pycmx, lxml.

Each gives what a document shows: which pictures of which file, where.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from fractions import Fraction
from pathlib import Path
from urllib.parse import unquote_to_bytes, urlsplit

import pycmx
import pytest
from lxml import etree

otio = pytest.importorskip("opentimelineio", reason="opentimelineio has no wheel for this Python")

Shown = list[tuple[int, int, str, Fraction]]  # (frame, how many, file, picture of the file from its first)


def expanded(shown: Shown) -> dict[int, tuple[str, Fraction]]:
    """Frame -> (file, picture)."""
    found = {start + n: (path, first + n) for start, length, path, first in shown for n in range(length)}
    assert len(found) == sum(length for _, length, _, _ in shown)  # nothing overlaps
    return found


def path_of(url: str) -> str:
    assert url.startswith("file:///")
    return os.fsdecode(unquote_to_bytes(urlsplit(url).path))


def exact(time: otio.opentime.RationalTime) -> Fraction:
    """A RationalTime's frames; they are whole."""
    assert time.value == int(time.value)
    return Fraction(int(time.value))


def of_track(track: otio.schema.Track) -> Shown:
    """What a track shows, in its own frames; every clip lies within its medium."""
    shown: Shown = []
    for clip in track.find_clips():
        medium, span = clip.media_reference, clip.source_range
        available = medium.available_range
        assert available.start_time <= span.start_time
        end = span.end_time_exclusive().to_seconds()
        assert end <= available.end_time_exclusive().to_seconds() + 1e-6
        first = exact(span.start_time) - exact(available.start_time)
        start, length = exact(clip.range_in_parent().start_time), exact(clip.duration())
        shown.append((int(start), int(length), path_of(medium.target_url), first))
    return shown


def by_otio(document: bytes) -> otio.schema.Timeline:
    return otio.adapters.read_from_string(document.decode(), "otio_json")


def by_fcp_adapter(document: bytes) -> otio.schema.Timeline:
    return otio.adapters.read_from_string(document.decode(), "fcp_xml")


def by_cmx_adapter(document: bytes, rate: Fraction) -> otio.schema.Timeline:
    return otio.adapters.read_from_string(document.decode(), "cmx_3600", rate=float(rate))


def frames_of(label: str, rate: Fraction) -> int:
    """What a label counts, by opentimelineio."""
    return int(otio.opentime.from_timecode(label, float(rate)).value)


def day_of(label: str, rate: Fraction) -> int:
    """Frames from midnight to midnight, counted as ``label`` is."""
    return frames_of(f"23:59:59{label[8]}00", rate) + round(rate)


def by_pycmx(path: Path, rate: Fraction, starts: Mapping[str, int]) -> tuple[Shown, list[str]]:
    """(what the pictures' events show from the first event on, their clip names). starts: file -> its timecode."""
    with path.open(encoding="utf-8") as stream:
        parsed = pycmx.parse_cmx3600(stream)
    edits = [edit for event in parsed.events for edit in event.edits if edit.channels.video]
    zero = frames_of(edits[0].record_in, rate)
    shown: Shown = []
    for edit in edits:
        begin, end = (frames_of(code, rate) - zero for code in (edit.record_in, edit.record_out))
        source, source_end = (frames_of(code, rate) for code in (edit.source_in, edit.source_out))
        length = (end - begin) % day_of(edit.record_in, rate)
        begin %= day_of(edit.record_in, rate)
        assert (source_end - source) % day_of(edit.source_in, rate) == length
        file = str(edit.source_file)
        shown.append((begin, length, file, Fraction((source - starts[file]) % day_of(edit.source_in, rate))))
    return shown, [str(edit.clip_name) for edit in edits]


# ------------------------------------------------------------------------------------------------------- FCPXML


def seconds(text: str) -> Fraction:
    assert text.endswith("s")
    return Fraction(text[:-1])


def by_lxml(document: bytes) -> etree._Element:
    return etree.fromstring(document, etree.XMLParser(resolve_entities=False))


def of_items(root: etree._Element, items: Iterable[etree._Element], rate: Fraction, zero_s: Fraction) -> Shown:
    """What asset-clips of a storyline or angle show; each lies within its asset, and begins on a frame."""
    shown: Shown = []
    for clip in items:
        assets = root.xpath("./resources/asset[@id=$id]", id=clip.get("ref"))
        assert len(assets) == 1
        asset = assets[0]
        form = root.xpath("./resources/format[@id=$id]", id=asset.get("format"))[0]
        own = 1 / seconds(form.get("frameDuration"))
        begins, lasts = seconds(asset.get("start")), seconds(asset.get("duration"))
        start, length = seconds(clip.get("start")), seconds(clip.get("duration"))
        assert begins <= start <= start + length <= begins + lasts
        first = (seconds(clip.get("offset")) - zero_s) * rate
        count = length * rate
        assert first.denominator == count.denominator == 1
        assert own == rate
        shown.append((int(first), int(count), path_of(asset.find("media-rep").get("src")), (start - begins) * own))
    return shown


def of_multicam(document: bytes) -> Shown:
    """What the mc-clips of the spine show of the angles they choose; angles are filled without a hole."""
    root = by_lxml(document)
    sequence = root.find(".//project/sequence")
    rate = 1 / seconds(root.xpath("./resources/format[@id=$id]", id=sequence.get("format"))[0].get("frameDuration"))
    zero_s = seconds(sequence.get("tcStart"))
    multicam = root.find("./resources/media/multicam")
    begin_s = seconds(multicam.get("tcStart"))
    angles, ends = {}, set()
    for angle in multicam.findall("mc-angle"):
        at_s = begin_s
        for item in angle:
            assert seconds(item.get("offset")) == at_s
            at_s += seconds(item.get("duration"))
        ends.add(at_s)
        angles[angle.get("angleID")] = of_items(root, angle.findall("asset-clip"), rate, begin_s)
    assert len(ends) == 1
    shown: Shown = []
    at_s = zero_s
    for clip in sequence.find("spine"):
        assert seconds(clip.get("offset")) == at_s
        at_s += seconds(clip.get("duration"))
        chosen = [s.get("angleID") for s in clip.findall("mc-source") if s.get("srcEnable") in ("all", "video")]
        assert len(chosen) == 1
        first = (seconds(clip.get("offset")) - zero_s) * rate
        inside = (seconds(clip.get("start")) - begin_s) * rate
        for start, length, path, picture in angles[chosen[0]]:
            begin, end = max(start, inside), min(start + length, inside + seconds(clip.get("duration")) * rate)
            if begin < end:
                shown.append((int(first + begin - inside), int(end - begin), path, picture + begin - start))
    assert at_s == zero_s + seconds(sequence.get("duration"))
    return shown
