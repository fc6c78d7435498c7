"""Sampling all cameras at regular steps, at little more than the cost of decoding their keyframes."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from fractions import Fraction
from typing import Any

from attrs import frozen

from mcsl_core.imaging.planes import U8
from mcsl_core.timing import FrameRange

from .decoder import Decoder
from .footage import Footage

_AHEAD = 3  # samples each camera may be ahead of the consumer: 3 x 1.6 MB at 540 rows


@frozen(eq=False)
class KeyframeSample:
    """What the cameras show at about one programme frame.

    Attributes
    ----------
    frame
        The programme frame.
    pictures
        Camera -> (H, W, 3) BGR, None without picture.
    shown_frames
        Camera -> the programme frame its picture really belongs to: the nearest keyframe is seldom the very frame.
    """

    frame: int
    pictures: Mapping[str, U8 | None]
    shown_frames: Mapping[str, int]


@frozen(eq=False)
class _SampledPicture:
    """One camera's share of a `KeyframeSample`."""

    picture: U8 | None
    shown_frame: int


def sample_cameras(
    footage: Footage,
    cameras: Sequence[str] | None = None,
    *,
    step_s: float = 1.0,
    height: int = 540,
    piece: FrameRange | None = None,
) -> Iterator[KeyframeSample]:
    """About one picture of every camera each step, at the least cost, in order.

    Parameters
    ----------
    footage
        The cameras on the programme clock.
    cameras
        Their names; all without.
    step_s
        Seconds from one sample to the next.
    height
        Rows of the pictures.
    piece
        The programme frames to sample; all without.

    Notes
    -----
    Where a camera's keyframes are at most 1.5 steps apart only they are decoded, and the nearest in time stands for the
    sample; else all pictures that others need. Each camera is decoded by its own thread a few samples ahead, so memory
    is flat; a fault in one of them is raised here. When the consumer stops, so do the threads.
    """
    cameras = tuple(c.name for c in footage.cameras) if cameras is None else cameras
    piece = piece or FrameRange(0, footage.frames)
    step = max(1, round(Fraction(step_s) * footage.rate))
    frames = range(piece.start, piece.stop, step)
    for camera in cameras:
        footage.parts(camera)  # probed here: a file that cannot be opened is told before a thread starts
    stop = threading.Event()
    queues: dict[str, queue.Queue] = {camera: queue.Queue(_AHEAD) for camera in cameras}
    threads = []
    for camera in cameras:
        arguments = footage, camera, frames, step, height, queues[camera], stop
        threads.append(threading.Thread(target=_decode_into, args=arguments, name=f"samples of {camera}", daemon=True))
        threads[-1].start()
    try:
        for frame in frames:
            sampled: dict[str, _SampledPicture] = {}
            for camera in cameras:
                item = queues[camera].get()
                if isinstance(item, BaseException):
                    raise item
                sampled[camera] = item
            pictures = {camera: one.picture for camera, one in sampled.items()}
            yield KeyframeSample(frame, pictures, {camera: one.shown_frame for camera, one in sampled.items()})
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def _decode_into(
    footage: Footage,
    camera: str,
    frames: range,
    step: int,
    height: int,
    out: queue.Queue,
    stop: threading.Event,
) -> None:
    """One camera's thread: puts a `_SampledPicture` for each of ``frames``, or the exception that ended it."""
    try:
        for sampled in _sampled_pictures(footage, camera, frames, step, height):
            if not _put(out, sampled, stop):
                return
    except BaseException as fault:  # raised again in the consumer
        _put(out, fault, stop)


def _put(out: queue.Queue, item: Any, stop: threading.Event) -> bool:
    while not stop.is_set():
        try:
            out.put(item, timeout=0.1)
            return True
        except queue.Full:
            continue
    return False


def _sampled_pictures(
    footage: Footage, camera: str, frames: range, step: int, height: int
) -> Iterator[_SampledPicture]:
    parts = footage.parts(camera)
    reach = Fraction(step) / footage.rate * Fraction(3, 2)
    by_keyframes = all(part.facts.keyframe_interval_s <= reach for part in parts)
    # Nothing here needs the pictures that no other picture needs; they are half of the decoding where B-frames are.
    shown: Fraction | None = None
    picture: U8 | None = None
    with closing(Decoder(parts, threads=1, skip="" if by_keyframes else "NONREF")) as decoder:
        for frame in frames:
            if by_keyframes:
                found = footage.shown_near(camera, decoder, frame, reach)
            else:
                found = footage.shown(camera, decoder, frame)
            if found is None:
                yield _SampledPicture(None, frame)
                continue
            if shown != found.camera_s:
                shown, picture = found.camera_s, footage.picture(camera, found, height)
            yield _SampledPicture(picture, footage.programme_frame(camera, found.camera_s))
