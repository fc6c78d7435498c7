"""Seeking and decoding: the frames of a file in presentation order from any time on, or single keyframes."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
from av.error import FFmpegError

from .decoders import strict_decoder
from .deinterlacing import deinterlaced, is_woven
from .facts import MediaFacts
from .hardware import NONE
from .opening import main_video, open_file, timestamp_of
from .packets import judged_packets, packets_of
from .reordering import ShownOrder
from .whole_frames import WholeFrames

log = logging.getLogger(__name__)

_REORDERED = 32  # packets to read until the frame that is shown after a keyframe has come
_SHAPE = Fraction(1, 50)  # that much wider or narrower is a coder's rounding (1088 rows for 1080)


class VideoReader:
    """Decodes the frames of one file in presentation order, from any time on. Not for use by two threads at once.

    Parameters
    ----------
    facts
        The file, as `probe` describes it.
    threads
        Decoder threads, 0 for as many as the machine has cores.
    skip
        What the decoder may leave out: "NONREF", pictures that no other needs; "NONKEY", all but keyframes.
    loop_filter
        Whether blocks' edges are smoothed as the coder meant it; where not, H.264 is decoded in less time, and its
        blocks show a little, more from picture to picture up to the next keyframe, where they jump back: nothing to
        see movements in. What refuses a picture by its checksum (HEVC) smooths in any case.
    hwaccel
        Which hardware decodes, as `open_file` takes it. Its frames come back in the processor's memory.

    Notes
    -----
    Frames are `av.VideoFrame`, interlaced ones made whole (`deinterlacing`); `to_planes` makes pictures of them.

    Examples
    --------
    >>> reader = VideoReader(probe("cam1.mp4"))  # doctest: +SKIP
    >>> time_s, frame = next(reader.read(Fraction(10)))  # doctest: +SKIP
    >>> picture = to_planes(frame, reader.facts)  # doctest: +SKIP
    """

    def __init__(
        self, facts: MediaFacts, *, threads: int = 0, skip: str = "", loop_filter: bool = True, hwaccel: str = NONE
    ) -> None:
        self.facts, self._threads, self._loop_filter, self._hwaccel = facts, threads, loop_filter, hwaccel
        self._skip = "" if facts.decoding_order else skip  # what is left out could not be counted
        self._keys: list[int] = []
        self._woven = False  # whether a keyframe was
        self.broken_key_s: Fraction | None = None  # the time of the keyframe asked for last, where it is not whole
        self.other_shape = ""  # of pictures that were left out for it: their coded size, their pixels' aspect
        self._reopen()

    def _reopen(self) -> None:
        self._container = open_file(self.facts.path, hwaccel=self._hwaccel)
        self._stream = main_video(self._container, self.facts.path)
        self._context = strict_decoder(self._stream) if self.facts.strict else self._stream.codec_context
        context = self._context
        context.thread_count = self._threads
        context.thread_type = "AUTO" if self._threads != 1 else "SLICE"
        if self._skip:
            context.skip_frame = self._skip
        if not self._loop_filter and context.name == "h264":
            context.options = {"skip_loop_filter": "all"}
        self._fresh = True

    def close(self) -> None:
        """Closes the file."""
        self._container.close()

    def read(self, from_s: Fraction) -> Iterator[tuple[Fraction, Any | None]]:
        """Frames in presentation order, from the one shown at ``from_s`` on.

        Parameters
        ----------
        from_s
            Seconds of the file's own time.

        Yields
        ------
        time_s, frame
            The frame's presentation time on the file's own time; rising. None for the frame from the first that is not
            whole to the next keyframe that is: what decoders show there is made up; and for frames of another shape.

        Notes
        -----
        Seeks to a keyframe before ``from_s`` and decodes forward. Containers seek by decoding time, which with B-frames
        can land on a keyframe that is shown later than asked: then it goes back further. So it does where an interlaced
        keyframe is asked for, since the frame before it is needed.
        """
        goal, back = from_s + self.facts.tolerance_s, Fraction(0)
        while True:
            target = goal - back
            at_start = target <= self.facts.start_s or not self._seek(target)
            if at_start and not self._fresh:
                self.close()
                self._reopen()
            frames = deinterlaced(self._decoded(), self.facts.scan, from_start=at_start)
            shown = next(frames, None)
            if at_start or (shown is not None and shown[0] <= goal):
                break
            back = max(back * 2, Fraction(1))
        if shown is None:
            return
        for following in frames:
            if shown[0] > goal or following[0] > goal:
                yield shown
            shown = following
        yield shown

    def _seek(self, target_s: Fraction) -> bool:
        try:
            self._container.seek(int((target_s + self.facts.zero_s) / self._stream.time_base), stream=self._stream)
        except FFmpegError:  # no index and no way back: read from the start instead
            return False
        self._fresh = False
        return True

    def _decoded(self) -> Iterator[tuple[Fraction, Any | None]]:
        """Frames as they come from the decoder, None where they are not whole.

        Nothing is decoded from damage to the next keyframe, and the decoder begins anew there: HEVC's lost all of the
        pictures after that keyframe otherwise.
        """
        order = ShownOrder(from_start=self._fresh) if self.facts.decoding_order else None
        self._fresh = False
        context, judge, lost = self._context, WholeFrames(1 / self.facts.rate), False
        for packet, whole in judged_packets(self._container, self._stream, self.facts.rate):
            lost = not whole or (lost and not packet.is_keyframe)
            frames = []
            if order is not None:
                order.feed(packet)
            try:
                if not lost:
                    judge.sent(packet)
                    frames = context.decode(packet)
                elif not judge.broken and order is None:  # what is held back has a place among those that are missing
                    frames = context.decode(None)
            except FFmpegError as error:
                log.info("%s: a damaged part is left out (%s)", self.facts.path.name, error.strerror)
                lost = True
            for frame in frames:
                stamp = timestamp_of(frame) if order is None else order.stamp(frame)
                if stamp is not None:
                    time_s = stamp * self._stream.time_base - self.facts.zero_s
                    for shown_s, whole in judge.judged(time_s, frame):
                        yield shown_s, whole if self._fits(whole) else None
            if lost:
                if not judge.broken:
                    context.flush_buffers()
                judge.cut()
        yield from judge.end()

    def _fits(self, frame: Any | None) -> bool:
        """Whether a frame may be scaled to the file's size; one of another shape would be distorted."""
        if frame is None:
            return True
        width, height = self.facts.coded_size
        first, now = self.facts.stream_aspect, self._context.sample_aspect_ratio
        wider = Fraction(frame.width * height, width * frame.height) * (now / first if now and first else 1)
        fits = abs(wider - 1) <= _SHAPE
        if not fits:
            self.other_shape = f"{frame.width}x{frame.height}" + (f", pixels {now}" if now and now != first else "")
        return fits

    def _keyframe_stamps(self) -> list[int]:
        """Presentation timestamps of all keyframes where the file has a full index; else nothing.

        An index holds decoding times; how far the keyframes' presentation lies behind is read off the first.
        """
        index = self._stream.index_entries
        if not self._keys and 0 < self._stream.frames <= len(index):
            first = next((p for p in packets_of(self._container, self._stream) if p.is_keyframe and p.size), None)
            delay = first.pts - first.dts if first is not None and None not in (first.pts, first.dts) else 0
            self._keys = [e.timestamp + delay for e in index if e.is_keyframe]
        return self._keys

    def keyframe(self, near_s: Fraction) -> tuple[Fraction, Any] | None:
        """The keyframe nearest to ``near_s`` as far as the file's index knows; only it is decoded.

        Parameters
        ----------
        near_s
            Seconds of the file's own time.

        Returns
        -------
        tuple or None
            The keyframe's time on the file's own time, and the frame; None where none can be decoded, and where its
            time is known only after those around it.
        """
        self.broken_key_s = None
        if self.facts.decoding_order:
            return None
        tick = self._stream.time_base
        target = int((near_s + self.facts.zero_s) / tick)
        keys = self._keyframe_stamps()
        if keys:
            at = int(np.searchsorted(keys, target))
            target = min(keys[max(0, at - 1) : at + 1], key=lambda stamp: abs(stamp - target))
        else:
            half = int(Fraction(self.facts.keyframe_interval_s) / 2 / tick)
            # Transport streams are sought to any picture, and the keyframe is the first after it.
            target += -half if "mpeg" in self._container.format.name else half
        try:
            frames = self._keyframe_and_next(target)
        except FFmpegError as error:
            log.info("%s: no keyframe at %.1f s (%s)", self.facts.path.name, float(near_s), error.strerror)
            return None
        self._fresh = False
        times = ((timestamp_of(frame) * tick - self.facts.zero_s, frame) for frame in frames)
        return next(deinterlaced(times, self.facts.scan, from_start=True), None)

    def _keyframe_and_next(self, target: int) -> list[Any]:
        """The keyframe before ``target`` ticks; where it is interlaced, also the frame shown next."""
        context = self._context
        self._container.seek(target, stream=self._stream)
        packets = packets_of(self._container, self._stream)
        first = next((p for p in packets if p.is_keyframe and p.size), None)
        if first is None:
            return []
        begin = timestamp_of(first)
        self.broken_key_s = None if begin is None else begin * self._stream.time_base - self.facts.zero_s
        frames = context.decode(first)
        if self._woven:
            for packet in itertools.islice((p for p in packets if p.size), _REORDERED):
                frames += context.decode(packet)
                if len(_from(frames, first)) > 1:
                    break
        frames += context.decode(None)
        context.flush_buffers()
        shown = _from(frames, first)[:2]
        if shown and (shown[0].is_corrupt or not self._fits(shown[0])):
            return []
        if shown:
            self.broken_key_s = None
        if shown and not self._woven and is_woven(shown[0], self.facts.scan):
            self._woven = True
            return self._keyframe_and_next(target)
        return shown


def _from(frames: list[Any], keyframe: Any) -> list[Any]:
    """Those shown from the keyframe, a packet, on; all that have a time where it has none."""
    begin = timestamp_of(keyframe)
    stamped = [(stamp, frame) for frame in frames if (stamp := timestamp_of(frame)) is not None]
    return [f for stamp, f in stamped if begin is None or stamp >= begin] or [f for _, f in stamped]
