"""Footage: the cameras' pictures and audio on the programme clock.

Programme frame n stands at n / rate seconds; a camera's own time is its clock's `camera_time` of that. A camera's
files follow each other as `joining` says: by their clock, or where the one before ends. Inside a file
presentation timestamps are the authority: the picture shown is the latest whose timestamp has come, so that a file of
variable rate, a remuxed one and one with dropped frames are all in time. Before a file's first timestamp
(a late start), beyond the end, where a file was cut short and in the camera's gaps there is no picture: None. A start
that is late by two frames at most is muxers' rounding, and the first picture stands from the beginning.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from fractions import Fraction
from functools import partial
from math import ceil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Camera, Edl
from mcsl_core.imaging.planes import U8, Planes, median_planes, planes_to_bgr, resize_planes
from mcsl_core.lru_cache import LruCache
from mcsl_core.media.frames import to_planes
from mcsl_core.media.hardware import NONE
from mcsl_core.media.probing import probe
from mcsl_core.timing import FrameRange, ranges_of

from .audio import camera_audio
from .decoder import DecodedFrame, Decoder, Part, exact_camera_time, exact_programme_time
from .joining import joined
from .sound_track import SoundTrack, sound_track

_LEFT_OUT = 4  # pictures in a row that no other needs, and one more: coders seldom put more than three B-frames
_MEDIANS, _KEYFRAMES = 16, 40  # pictures' worth of medians, and of what they are made from; 3 MB each at 1080p


class Player:
    """One camera's full-size pictures by programme frame: cheap going forward, exact anywhere. For one thread."""

    def __init__(self, footage: Footage, camera: str, decoder: Decoder) -> None:
        self._footage, self._camera, self._decoder = footage, camera, decoder
        self._frame: object = None
        self._planes: Planes | None = None
        self._last: tuple[int, Planes | None] = (-1, None)

    def at(self, frame: int) -> Planes | None:
        """The picture at programme frame ``frame``; the same object as long as the same picture is shown."""
        if frame != self._last[0]:
            self._last = (frame, self._read(frame))
        return self._last[1]

    def _read(self, frame: int) -> Planes | None:
        shown = self._footage.shown(self._camera, self._decoder, frame)
        if shown is None:
            return None
        if shown.frame is not self._frame:
            self._frame, self._planes = shown.frame, self._footage.full_picture(self._camera, shown)
        return self._planes

    def close(self) -> None:
        """Closes the camera's file."""
        self._decoder.close()
        self._frame, self._planes, self._last = None, None, (-1, None)


class Footage:
    """Pictures and audio of all cameras by programme time. Each call opens its own decoders: safe from many threads.

    Parameters
    ----------
    cameras
        Each with its files and its clock.
    rate
        Programme frames per second.
    frames
        The programme's length.
    base
        The folder that relative media paths are relative to, the EDL's.
    threads
        Decoder threads of each stream read at full size, 0 for one a core.
    hwaccel
        Which hardware decodes streams read at full size, as `media.hardware` names it.

    Examples
    --------
    >>> footage = footage_of(load("edl.json"), Path("."))  # doctest: +SKIP
    >>> for frame, picture in footage.pictures("cam1", [0, 250, 500], height=360):  # doctest: +SKIP
    ...     print(frame, picture.shape)
    """

    def __init__(
        self,
        cameras: Sequence[Camera],
        *,
        rate: Fraction,
        frames: int,
        base: Path,
        threads: int = 0,
        hwaccel: str = NONE,
    ) -> None:
        self.cameras, self.rate, self.frames, self.base = tuple(cameras), Fraction(rate), frames, Path(base)
        self._decoding = {"threads": threads, "hwaccel": hwaccel}
        self._by_name = {camera.name: camera for camera in self.cameras}
        self._parts: dict[str, tuple[Part, ...]] = {}
        self._damaged: dict[str, set[int]] = {camera.name: set() for camera in self.cameras}
        picture_bytes = max((c.size[0] * c.size[1] * 3 // 2 for c in self.cameras), default=1)
        self._medians: LruCache[Planes | None] = LruCache(_MEDIANS * picture_bytes)
        self._keyframes: LruCache[Planes | None] = LruCache(_KEYFRAMES * picture_bytes)

    def camera(self, name: str) -> Camera:
        """The camera of that name.

        Raises
        ------
        KeyError
            Where there is none.
        """
        return self._by_name[name]

    def parts(self, camera: str) -> tuple[Part, ...]:
        """The camera's files and where they begin in its own time. Probed at the first call, then kept."""
        if camera not in self._parts:
            media = self.camera(camera).media
            self._parts[camera] = joined([probe(self.base / one.path) for one in media])
        return self._parts[camera]

    def span_s(self, camera: str) -> tuple[float, float]:
        """Programme seconds at which a camera has its first picture, and at which its last one is over."""
        clock, parts = self.camera(camera).clock, self.parts(camera)
        return clock.programme_time(parts[0].first_s), clock.programme_time(parts[-1].end_s)

    def camera_time(self, camera: str, frame: int) -> Fraction:
        """The camera's own time in seconds at programme frame ``frame``, exactly."""
        return exact_camera_time(self.camera(camera), Fraction(frame) / self.rate)

    def programme_frame(self, camera: str, camera_s: Fraction) -> int:
        """The programme frame nearest to the camera's own time ``camera_s``."""
        return round(Fraction(self.camera(camera).clock.programme_time(camera_s)) * self.rate)

    def first_showing(self, camera: str, camera_s: Fraction) -> int:
        """The first programme frame that shows the picture of the camera's own time ``camera_s``; 0 to the length."""
        frame = ceil(exact_programme_time(self.camera(camera), camera_s) * self.rate)
        return min(max(frame, 0), self.frames)

    def has_gap(self, camera: str, frame: int) -> bool:
        """Whether programme frame ``frame`` lies in one of the camera's gaps, where it has no picture."""
        return any(frame in gap for gap in self.camera(camera).gaps)

    def shown(self, camera: str, decoder: Decoder, frame: int) -> DecodedFrame | None:
        """What ``decoder``, one of the camera's, shows at programme frame ``frame``; None without a whole picture."""
        if self.has_gap(camera, frame):
            return None
        shown = decoder.at(self.camera_time(camera, frame))
        if decoder.damaged:
            self._damaged[camera].add(frame)
        return shown

    def shown_near(self, camera: str, decoder: Decoder, frame: int, within_s: Fraction) -> DecodedFrame | None:
        """As `shown`, but the nearest keyframe where there is one within ``within_s`` seconds and no gap."""
        if self.has_gap(camera, frame):
            return None
        shown = decoder.keyframe(self.camera_time(camera, frame), within_s)
        if decoder.broken_key_s is not None:
            broken = self.first_showing(camera, decoder.broken_key_s)
            if broken < self.frames and not self.has_gap(camera, broken):
                self._damaged[camera].add(broken)
        if shown is None or self.has_gap(camera, self.programme_frame(camera, shown.camera_s)):
            return self.shown(camera, decoder, frame)
        return shown

    def damage_met(self) -> dict[str, tuple[FrameRange, ...]]:
        """Camera -> programme frames that were asked for, lie in no known gap and could not be decoded whole."""
        return {camera: tuple(ranges_of(frames)) for camera, frames in self._damaged.items() if frames}

    def player(self, camera: str) -> Player:
        """Full-size pictures of ``camera`` one at a time; close it when done."""
        return Player(self, camera, Decoder(self.parts(camera), **self._decoding))

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        """The median of full-size pictures of ``camera`` near ``frames``: what lies still. None without any picture.

        Near: the nearest keyframe of ``within``, a range in which nothing but people moves, where one is less than half
        the way to the next of ``frames``; a tenth of the cost of the frame itself. By a decoder opened for it alone.
        The latest medians are kept, for whoever asks next.
        """
        key = camera, tuple(frames)
        return self._medians.get(key, lambda: self._median(camera, frames, within))

    def _median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        half_way = min((b - a for a, b in zip(frames, frames[1:], strict=False)), default=0) / 2
        with closing(Decoder(self.parts(camera), **self._decoding)) as head:

            def near(frame: int) -> Planes | None:
                reach = min(half_way, frame - within.start, within.stop - 1 - frame)
                shown = self.shown_near(camera, head, frame, Fraction(reach) / self.rate)
                return None if shown is None else self.full_picture(camera, shown)

            keys = [(camera, frame, half_way, within) for frame in frames]
            found = [self._keyframes.get(key, partial(near, key[1])) for key in keys]
        pictures = [picture for picture in found if picture is not None]
        return median_planes(pictures) if pictures else None

    def planes(self, camera: str, piece: FrameRange) -> Iterator[Planes | None]:
        """Full-size pictures of consecutive programme frames.

        Parameters
        ----------
        camera
            Its name.
        piece
            The programme frames.

        Yields
        ------
        Planes or None
            One for each programme frame, of the camera's size; None without picture. Consecutive frames that show one
            picture are one object. Treat as read-only: they are the decoder's memory.
        """
        with closing(self.player(camera)) as player:
            for frame in piece:
                yield player.at(frame)

    def pictures(
        self, camera: str, frames: Sequence[int], *, height: int | None = None
    ) -> Iterator[tuple[int, U8 | None]]:
        """BGR pictures at given programme frames.

        Parameters
        ----------
        camera
            Its name.
        frames
            Programme frames, rising. Near ones are reached by decoding on, far ones by a seek.
        height
            Rows to downscale to, by area average with the aspect kept; never enlarged. Full size without.

        Yields
        ------
        frame, picture
            The programme frame, and (H, W, 3) or None without picture.

        Raises
        ------
        ValueError
            Where ``frames`` do not rise.
        """
        last = None
        with closing(Decoder(self.parts(camera), **self._decoding)) as decoder:
            for frame in frames:
                if last is not None and frame <= last:
                    raise ValueError(f"frames must rise, got {last} then {frame}")
                last = frame
                shown = self.shown(camera, decoder, frame)
                yield frame, None if shown is None else self.picture(camera, shown, height)

    def glances(
        self, camera: str, frames: Sequence[int], *, height: int, early_s: float
    ) -> Iterator[tuple[U8 | None, float]]:
        """As `pictures`, for what is measured and never shown, in less time.

        Parameters
        ----------
        camera, frames, height
            As `pictures` takes them.
        early_s
            By how many seconds a picture may be an earlier one than the one asked for.

        Yields
        ------
        picture, taken
            (H, W, 3) or None without picture, and when it was taken, in programme frames. What is scaled to half or
            less is not smoothed as its coder meant it (`VideoReader`). Pictures that no other needs are not decoded
            where that makes it no earlier than ``early_s``.

        Notes
        -----
        Of a simulated recording, 1080p at 30 frames a second with B-frames, decoding takes 0.60 of the time, 0.84 by
        the loop filter alone; scaled to 540 rows one pixel of 100,000 is more than 8 of 255 off, at most.
        """
        seen, parts = self.camera(camera), self.parts(camera)
        skip = "NONREF" if _LEFT_OUT / seen.rate <= early_s else ""
        how = {"skip": skip, "loop_filter": seen.size[1] < 2 * height, **self._decoding}
        with closing(Decoder(parts, **how)) as decoder:
            for frame in frames:
                shown = self.shown(camera, decoder, frame)
                if shown is None:
                    yield None, float(frame)
                else:
                    taken = exact_programme_time(seen, shown.camera_s) * self.rate
                    yield self.picture(camera, shown, height), float(taken)

    def full_picture(self, camera: str, shown: DecodedFrame) -> Planes:
        """The picture of a decoded frame of ``camera``, of the size that the EDL says."""
        return resize_planes(to_planes(shown.frame, shown.facts), self.camera(camera).size)

    def picture(self, camera: str, shown: DecodedFrame, height: int | None) -> U8:
        """The BGR picture of a decoded frame of ``camera``, downscaled to ``height`` rows."""
        return planes_to_bgr(self.full_picture(camera, shown), height=height)

    def has_sound(self, camera: str) -> bool:
        """Whether any file of the camera has a sound track that can be decoded."""
        return any(part.facts.has_audio for part in self.parts(camera))

    def sound_track(self, camera: str) -> SoundTrack:
        """Which of the camera's sound tracks is heard, and how its channels become one."""
        return sound_track([part.facts for part in self.parts(camera)])

    def audio_blocks(
        self,
        camera: str,
        start_s: float | Fraction,
        stop_s: float | Fraction,
        rate: int = 48000,
        *,
        block_s: float = 10.0,
    ) -> Iterator[NDArray[np.float32]]:
        """Mono audio in consecutive blocks; memory stays flat.

        Parameters
        ----------
        camera
            Its name; offset and drift of its clock are applied by resampling.
        start_s, stop_s
            Programme time.
        rate
            Samples per second.
        block_s
            Length of a block; the last may be shorter.

        Yields
        ------
        NDArray
            (n,) float32 in -1..1; 0 where the camera has no audio.
        """
        return camera_audio(self.camera(camera), self.parts(camera), start_s, stop_s, rate, block_s)

    def audio(
        self, camera: str, start_s: float | Fraction, stop_s: float | Fraction, rate: int = 48000
    ) -> NDArray[np.float32]:
        """As `audio_blocks`, in one (n,) float32 array."""
        blocks = list(self.audio_blocks(camera, start_s, stop_s, rate))
        return np.concatenate(blocks) if blocks else np.zeros(0, np.float32)


def footage_of(edl: Edl, base: Path, threads: int = 0, hwaccel: str = NONE) -> Footage:
    """The footage of an EDL; ``base`` is the EDL's folder, ``threads`` and ``hwaccel`` as `Footage` takes them."""
    return Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base, threads=threads, hwaccel=hwaccel)
