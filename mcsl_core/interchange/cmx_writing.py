"""The cut as a CMX3600 edit decision list: one track of pictures, and what is heard, for whatever reads nothing else.

Sources are in their own timecode, counted at the programme's rate. A reel is a camera's name, as far as eight letters
go; the file stands in a comment after each event, as do markers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import floor

from mcsl_core.errors import UsageError

from .model import Clip, Marker, Sequence
from .timecode import label, may_drop, nominal

PROGRAMME_REEL = "MCSL"  # of what is conformed
_REEL = 8
_WORDS = 4  # a line
_COLOURS = {"movement": "YELLOW", "pose": "BLUE", "weak": "RED", "shot": "GREEN", "override": "MAGENTA"}


def write_cmx(cut: Sequence) -> bytes:
    """The document.

    Raises
    ------
    UsageError
        Where a second has more frames than its two digits name.
    """
    if nominal(cut.rate) > 99:
        what = f"an EDL counts to 99 frames a second, the programme has {cut.rate}"
        raise UsageError(what, remedy="Export .fcpxml, .xml or .otio")
    lines = [f"TITLE: {_line(cut.name)[:70]}", f"FCM: {'DROP FRAME' if cut.drop else 'NON-DROP FRAME'}"]
    reels = reels_of([angle.camera for angle in cut.angles])
    events = [(clip.range.start, "V", clip) for clip in map(cut.moved, cut.shown())]
    heard = map(cut.moved, cut.held(cut.sound))
    events += [(clip.range.start, "A" if clip.medium.channels == 1 else "AA", clip) for clip in heard]
    width = max(3, len(str(len(events))))
    markers = list(cut.held_markers())[::-1]
    for number, (_, track, clip) in enumerate(sorted(events, key=lambda e: (e[0], e[1] != "V")), start=1):
        reel = PROGRAMME_REEL if cut.programme is not None else reels[clip.camera]
        lines += ["", f"{number:0{width}d}  {reel:<8} {track:<5} C        {_codes(cut, clip)}"]
        lines += [f"* FROM CLIP NAME: {_line(clip.camera)}", f"* SOURCE FILE: {_line(str(clip.medium.path))}"]
        if number == 1:
            basis, *shown = cut.origin.split()
            lines.append(f"* MCSL CUT: {basis} {label(cut.start, cut.rate, drop=cut.drop)}")
            lines += [f"* MCSL CUT SHOWN: {' '.join(shown[n : n + _WORDS])}" for n in range(0, len(shown), _WORDS)]
        while track == "V" and markers and markers[-1].range.start < clip.range.stop:
            lines.append(_locator(cut, markers.pop()))
    return ("\n".join(lines) + "\n").encode("utf-8", "replace")


def reels_of(cameras: list[str]) -> dict[str, str]:
    """A reel of at most eight letters and digits for every camera, each another."""
    reels: dict[str, str] = {}
    for camera in cameras:
        plain = re.sub("[^A-Z0-9_]", "", camera.upper())[:_REEL] or "CAM"
        number, reel = 1, plain
        while reel in ("AX", "BL", PROGRAMME_REEL, *reels.values()):
            number += 1
            reel = f"{plain[: _REEL - len(str(number))]}{number}"
        reels[camera] = reel
    return reels


def _codes(cut: Sequence, clip: Clip) -> str:
    return " ".join([*_source(cut, clip), *(label(cut.start + n, cut.rate, drop=cut.drop) for n in _ends(clip))])


def _source(cut: Sequence, clip: Clip) -> Iterator[str]:
    medium = clip.medium
    first = floor((medium.start + clip.source) / medium.rate * cut.rate)
    drop = may_drop(cut.rate) and (medium.drop if medium.start else cut.drop)
    for count in (first, first + len(clip.range)):
        yield label(count, cut.rate, drop=drop)


def _ends(clip: Clip) -> tuple[int, int]:
    return clip.range.start, clip.range.stop


def _locator(cut: Sequence, marker: Marker) -> str:
    at = label(cut.start + marker.range.start, cut.rate, drop=cut.drop)
    note = f" ({marker.note})" if marker.note else ""
    return f"* LOC: {at} {_COLOURS[marker.kind]:<7} {_line(marker.name + note)}"


def _line(text: str) -> str:
    return " ".join(text.split())
