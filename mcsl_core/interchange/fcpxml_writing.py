"""The cut as FCPXML 1.10, for Final Cut Pro and Resolve: a multicam clip whose angles are the cameras.

Shots are `mc-clip`s; of a conformed programme they are `asset-clip`s of that, with the multicam clip connected below,
so that an angle shows where one is disabled. Times are fractions of a second; positions are in percent of the height.

References
----------
Apple, Final Cut Pro XML Reference; its document type definition of version 1.10.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from fractions import Fraction

from mcsl_core.timing import FrameRange

from .model import Clip, Marker, Medium, Sequence, Shot, Transform
from .xml_text import add, document, file_url, number

VERSION = "1.10"
_AUDIO_RATES = {32000: "32k", 44100: "44.1k", 48000: "48k", 88200: "88.2k", 96000: "96k", 176400: "176.4k"}


def write_fcpxml(cut: Sequence) -> bytes:
    """The document."""
    root = ET.Element("fcpxml", version=VERSION)
    writer = _Writer(cut, add(root, "resources"))
    event = add(add(root, "library"), "event", name=cut.name)
    sequence = add(
        add(event, "project", name=cut.name),
        "sequence",
        format=writer.format(cut.rate, cut.size),
        duration=time(cut.seconds(cut.length)),
        tcStart=time(cut.start_s),
        tcFormat="DF" if cut.drop else "NDF",
        audioLayout="stereo",
        audioRate="48k",
    )
    add(sequence, "note", f"mcsl cut {cut.origin}")
    writer.spine(add(sequence, "spine"))
    return document(root, "fcpxml")


def time(seconds: Fraction) -> str:
    """An exact time: ``1001/30000s``, ``5s``."""
    return f"{seconds.numerator}s" if seconds.denominator == 1 else f"{seconds.numerator}/{seconds.denominator}s"


class _Writer:
    """Resources as they are needed, and the clips that refer to them."""

    def __init__(self, cut: Sequence, resources: ET.Element) -> None:
        self._cut, self._resources = cut, resources
        self._formats: dict[tuple[Fraction, tuple[int, int]], str] = {}
        self.format(cut.rate, cut.size)
        self._assets = {medium: self._asset(medium) for medium in cut.media()}
        self._angles = {angle.camera: f"angle{n}" for n, angle in enumerate(reversed(cut.angles), start=1)}
        self._multicam = self._make_multicam()

    def format(self, rate: Fraction, size: tuple[int, int]) -> str:
        """The id of the format of that rate and size."""
        if (rate, size) not in self._formats:
            name = f"f{len(self._formats) + 1}"
            width, height = size
            duration = Fraction(rate.denominator, rate.numerator)
            add(self._resources, "format", id=name, frameDuration=time(duration), width=width, height=height)
            self._formats[rate, size] = name
        return self._formats[rate, size]

    def _asset(self, medium: Medium) -> str:
        name = f"a{sum(child.tag == 'asset' for child in self._resources) + 1}"
        form = None if medium.size is None else self.format(medium.rate, medium.size)
        asset = add(
            self._resources,
            "asset",
            id=name,
            name=medium.path.name,
            start=time(medium.start_s),
            duration=time(medium.duration_s),
            hasVideo=None if medium.size is None else 1,
            format=form,
            videoSources=None if medium.size is None else 1,
            hasAudio=1 if medium.channels else None,
            audioSources=1 if medium.channels else None,
            audioChannels=medium.channels or None,
            audioRate=medium.audio_rate or None,
        )
        add(asset, "media-rep", kind="original-media", src=file_url(medium.path))
        return name

    def _make_multicam(self) -> str:
        cut, name = self._cut, "m1"
        multicam = add(
            add(self._resources, "media", id=name, name=f"{cut.name} cameras"),
            "multicam",
            format=self.format(cut.rate, cut.size),
            tcStart=time(cut.start_s),
            tcFormat="DF" if cut.drop else "NDF",
        )
        for angle in reversed(cut.angles):
            track = add(multicam, "mc-angle", name=angle.camera, angleID=self._angles[angle.camera])
            at = 0
            for clip in angle.clips:
                self._gap(track, at, clip.range.start)
                self._asset_clip(track, clip, self._place(clip.range.start))
                at = clip.range.stop
            self._gap(track, at, cut.frames)
        return name

    def _place(self, frame: int) -> Fraction:
        return self._cut.start_s + self._cut.seconds(frame)

    def _gap(self, track: ET.Element, start: int, stop: int) -> None:
        if start < stop:
            lasts = time(self._cut.seconds(stop - start))
            add(track, "gap", name="Gap", offset=time(self._place(start)), start="0s", duration=lasts)

    def _asset_clip(self, parent: ET.Element, clip: Clip, offset: Fraction, **more: object) -> ET.Element:
        form = None if clip.medium.size is None else self.format(clip.medium.rate, clip.medium.size)
        made = add(
            parent,
            "asset-clip",
            ref=self._assets[clip.medium],
            offset=time(offset),
            name=clip.camera,
            start=time(_source_s(clip)),
            duration=time(self._cut.seconds(len(clip.range))),
            format=form,
            tcFormat="DF" if clip.medium.drop else "NDF",
            **more,
        )
        if clip.transform is not None and clip.medium.size is not None:
            add(made, "adjust-transform", **self._transform(clip.transform, clip.medium.size))
        return made

    def _transform(self, transform: Transform, size: tuple[int, int]) -> Mapping[str, str]:
        width, height = self._cut.size
        fitted = min(width / size[0], height / size[1])  # the size that a clip has before it is scaled
        scale = number(transform.scale / fitted)
        return {
            "position": f"{number(100 * transform.x / height)} {number(-100 * transform.y / height)}",
            "scale": f"{scale} {scale}",
            "rotation": number(-transform.rotation),
        }

    def spine(self, spine: ET.Element) -> None:
        """The shots; what is conformed is heard from its own file, cameras are heard as an angle."""
        cut, markers = self._cut, list(self._cut.held_markers())[::-1]
        begins = {piece.start: piece for piece in cut.kept}
        for shot in cut.held_shots():
            at = cut.position(shot.range.start)
            place = self._place(at)
            if cut.programme is None:
                clip, start = self._mc_clip(spine, shot, place), self._place(shot.range.start)
            else:
                shown = next(cut.shown_in(shot))
                clip, start = self._asset_clip(spine, shown, place, srcEnable="video"), _source_s(shown)
                if (piece := begins.get(shot.range.start)) is not None:
                    for sound in filter(None, (sound.part(piece) for sound in cut.sound)):
                        offset = start + cut.seconds(sound.range.start - piece.start)
                        self._fades(self._asset_clip(clip, sound, offset, lane=-2, audioRole="dialogue"), sound.range)
                self._mc_clip(clip, shot, start, lane=-1)
            while markers and markers[-1].range.start < at + len(shot.range):
                marker = markers.pop()
                self._marker(clip, marker, start + cut.seconds(marker.range.start - at))

    def _mc_clip(self, parent: ET.Element, shot: Shot, offset: Fraction, **more: object) -> ET.Element:
        clip = add(
            parent,
            "mc-clip",
            ref=self._multicam,
            offset=time(offset),
            name=shot.camera,
            start=time(self._place(shot.range.start)),
            duration=time(self._cut.seconds(len(shot.range))),
            **more,
        )
        heard = {sound.camera for sound in self._cut.sound} if self._cut.programme is None else set()
        if heard:
            self._fades(clip, shot.range)
        both = shot.camera in heard
        add(clip, "mc-source", angleID=self._angles[shot.camera], srcEnable="all" if both else "video")
        for camera in heard - {shot.camera}:
            add(clip, "mc-source", angleID=self._angles[camera], srcEnable="audio")
        return clip

    def _fades(self, clip: ET.Element, piece: FrameRange) -> None:
        """Beside what is removed the sound fades, as it does in the delivery."""
        rises, falls = self._cut.fades(piece)
        if not rises and not falls:
            return
        level = add(add(clip, "adjust-volume", amount="0dB"), "param", name="amount")
        for name, frames in (("fadeIn", rises), ("fadeOut", falls)):
            if frames:
                add(level, name, type="linear", duration=time(self._cut.seconds(frames)))

    def _marker(self, clip: ET.Element, marker: Marker, at: Fraction) -> None:
        lasts = time(1 / self._cut.rate)
        add(clip, "marker", start=time(at), duration=lasts, value=marker.name, note=marker.note or None)


def _source_s(clip: Clip) -> Fraction:
    """Where a clip begins in its medium's own timecode."""
    return clip.medium.start_s + clip.source / clip.medium.rate
