"""Conform: the exact full-resolution programme pictures as media that Blender cuts, and the programme's sound.

The programme is cut into chunks on a fixed grid of ten seconds from frame 0. A chunk's name holds a hash of everything
its pixels depend on: the effective decisions in it, poses, colours, centering, the sources' content, clocks, filler,
encoder and the versions of the algorithms. So a changed override makes again the chunks it touches and no others, an
interrupted run loses the chunks it was at, and runs need no record of what they did. The grid does not follow the
shots: an editor moves cuts, and boundaries that moved along would orphan whole chunks beside the change; and Blender
takes 0.15 s and more for each movie strip, so that 2,000 shots must not become 2,000 files.
"""

from __future__ import annotations

import hashlib
import threading
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from fractions import Fraction
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import attrs
import cv2
from attrs import frozen

from . import compositor as compositing
from .compositor import Compositor
from .decisions import Decision, offset_at, placed, resolve, shift_at
from .documents import canonical_json
from .edl import Camera, Edl
from .errors import Cancelled, UsageError
from .filling import Filler, FootprintFiller
from .footage import Footage
from .images import Planes, resize_planes
from .media import fingerprint
from .programme_sound import AUDIO_RATE, sound_key, sound_of, write_wav
from .progress import Progress, Silent
from .timing import FrameRange, merge_equal
from .video import Encoding, VideoWriter

VERSION = 1  # rises when chunks come out differently for a reason that no key holds
CHUNK_S = compositing.BLOCK_S
KEYFRAMES = 15  # scrubbing in Blender decodes from the keyframe before: 15 frames are 0.1 s
# No B-frames: a tenth larger, but decoding order is showing order, which every player seeks right.
INTERMEDIATE = Encoding(options={"preset": "superfast", "crf": "14", "bf": "0"})
_SUFFIX = ".mp4"
_STALE_S = 3600


@frozen
class Chunk:
    """One file of conformed pictures: which programme frames, the hash they depend on, and the file's name."""

    range: FrameRange
    key: str

    @property
    def name(self) -> str:
        return f"{self.range.start:07d}-{self.range.stop:07d}-{self.key}{_SUFFIX}"


@frozen
class Conformed:
    """What lies in ``folder`` after conforming: chunks that tile the programme, the sound, and how much was new."""

    folder: Path
    chunks: tuple[Chunk, ...]
    audio: Path | None
    made: int

    def path(self, chunk: Chunk) -> Path:
        return self.folder / chunk.name


def default_folder(edl_path: Path) -> Path:
    """Where the conformed media of an EDL lie: edl.json -> edl.conformed."""
    return edl_path.with_name(f"{edl_path.stem}.conformed")


# -------------------------------------------------------------------------------------------------------- planning


@lru_cache(maxsize=256)
def _content(path: Path, _size: int, _changed_ns: int) -> str:
    return fingerprint(path)


def content_of(camera: Camera, base: Path) -> list[str]:
    """Content keys of a camera's files as they are now; InputError where one is gone."""
    keys = []
    for media in camera.media:
        path = base / media.path
        if path.is_file():
            state = path.stat()
            keys.append(_content(path, state.st_size, state.st_mtime_ns))
        else:
            keys.append(fingerprint(path))  # says what is wrong
    return keys


def plan(edl: Edl, base: Path, *, filler: Filler | None = None, encoding: Encoding = INTERMEDIATE) -> tuple[Chunk, ...]:
    """The chunks that tile the programme, and their keys. Reads three blocks of each source, decodes nothing.

    Chunks that no decision, pose or source distinguishes from the last plan's have the same key and name.
    """
    filler = filler or FootprintFiller()
    step = max(1, round(CHUNK_S * edl.rate))
    content: dict[str, Any] = {}
    decisions = resolve(edl)

    def source(name: str) -> Any:
        if name not in content:
            camera = edl.camera(name)
            clock = [camera.clock.offset_s, camera.clock.drift_ppm]
            gaps = [[g.start, g.stop] for g in camera.gaps]
            content[name] = [name, content_of(camera, base), list(camera.size), clock, gaps]
        return content[name]

    def around(number: int, decision: Decision, part: FrameRange) -> Any:
        """Where the fill may look beside the frame itself; at other poses only where this one leaves something open."""
        pose = edl.poses[number]
        still = compositing.still_range(edl, pose)
        offsets = tuple(shift_at(edl, decision, row[0]) for row in _offsets(edl, part))
        key = number, offsets
        if key not in open_:
            open_[key] = not compositing.covered(edl, pose, offsets)
        return [[still.start, still.stop], *(beside(n) for n in compositing.elsewhere(edl, number) if open_[key])]

    @lru_cache
    def beside(number: int) -> Any:
        pose = edl.poses[number]
        still = compositing.still_range(edl, pose)
        names = [c.name for c in edl.cameras if placed(edl, pose, c.name) is not None]
        colours = {n: pose.colour[n].matrix for n in names if n in pose.colour}
        places = {n: placed(edl, pose, n) for n in names}
        return [[still.start, still.stop], places, colours, [source(n) for n in names]]

    chunks = []
    open_: dict[Any, bool] = {}
    for start in range(0, edl.frames, step):
        piece = FrameRange(start, min(start + step, edl.frames))
        block = start - start % compositing.block_frames(edl) if filler.remembers else start
        before = compositing.remembered(block) if filler.remembers else ()
        spans = (*(FrameRange(frame, frame + 1) for frame in before), FrameRange(block, piece.stop))
        parts: list[tuple[FrameRange, Any]] = []
        for span, (stretch, decision) in product(spans, decisions):
            for number, pose in enumerate(edl.poses):
                part = stretch.intersection(span)
                part = part and part.intersection(pose.range)
                if part is None:
                    continue
                cameras = {decision.camera, edl.reference}
                if decision.fill:
                    cameras |= {c.name for c in edl.cameras if placed(edl, pose, c.name) is not None}
                facts = {
                    "decision": [
                        decision.camera,
                        decision.offset if decision.centering and decision.offset else decision.centering,
                        decision.fill,
                        decision.colour,
                    ],
                    "sources": [source(camera.name) for camera in edl.cameras if camera.name in cameras],
                    "placed": {n: placed(edl, pose, n) for n in sorted(cameras)},
                }
                if decision.colour:
                    facts["colour"] = {n: pose.colour[n].matrix for n in sorted(cameras) if n in pose.colour}
                if decision.fill:
                    facts["still"] = around(number, decision, part)
                parts.append((part, facts))
        key = _digest(
            {
                "versions": [VERSION, compositing.VERSION, filler.name, filler.version],
                "programme": [str(edl.rate), list(edl.size), edl.reference],
                "encoding": attrs.asdict(encoding),
                "range": [piece.start, piece.stop],
                # merged, since it does not matter whether an editor or the analysis chose what is shown
                "parts": [
                    [part.start, part.stop, facts, _offsets(edl, part) if facts["decision"][1] is True else None]
                    for part, facts in merge_equal(parts)
                ],
            }
        )
        chunks.append(Chunk(piece, key))
    return tuple(chunks)


def _offsets(edl: Edl, part: FrameRange) -> list[Any]:
    """The centering over ``part``: its ends and the keys between, which is all that linear motion depends on."""
    inside = [key[0] for key in edl.centering if part.start < key[0] < part.stop - 1]
    return [[frame, *offset_at(edl.centering, frame)] for frame in (part.start, *inside, part.stop - 1)]


def _digest(value: Any) -> str:
    """A hash that an EDL keeps when it is saved and loaded: numbers as the document writes them."""
    return hashlib.sha256(canonical_json(_plain(value)).encode()).hexdigest()[:20]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(value[k]) for k in sorted(value)}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return float(value) if isinstance(value, int) else value


# ---------------------------------------------------------------------------------------------------------- making


def conform(
    edl: Edl,
    base: Path,
    out: Path,
    *,
    filler: Filler | None = None,
    jobs: int = 2,
    prune: bool = False,
    audio_from: str | None = None,
    encoding: Encoding = INTERMEDIATE,
    progress: Progress | None = None,
) -> Conformed:
    """Makes the chunks that ``out`` lacks, ``jobs`` at a time, and the programme's sound; returns what is there.

    base: the folder that media paths are relative to. audio_from: the camera whose sound it is, the reference without.
    prune: afterwards delete the chunks and sound that this EDL does not use. A run that is stopped leaves whole chunks
    only, and the next carries on. Raises what reading or writing raises, and Cancelled.
    """
    progress = progress or Silent()
    filler = filler or FootprintFiller()
    if jobs < 1:
        raise UsageError(f"at least one chunk is made at a time, got {jobs}", remedy="Choose 1 or more jobs")
    chunks = plan(edl, base, filler=filler, encoding=encoding)
    out.mkdir(parents=True, exist_ok=True)
    _sweep(out)
    _tell_of_changed_media(edl, base, progress)
    audio = _make_sound(edl, base, out, audio_from, progress)
    missing = [chunk for chunk in chunks if not (out / chunk.name).is_file()]
    if missing:
        _make_chunks(edl, base, out, missing, filler, jobs, encoding, progress)
    if prune:
        keep = {chunk.name for chunk in chunks} | ({audio.name} if audio else set())
        for path in out.iterdir():
            if path.name not in keep and (_is_chunk(path.name) or _is_sound(path.name)):
                path.unlink()
    return Conformed(out, chunks, audio, len(missing))


def _is_chunk(name: str) -> bool:
    parts = name.removesuffix(_SUFFIX).split("-")
    return name.endswith(_SUFFIX) and len(parts) == 3 and parts[0].isdigit() and parts[1].isdigit()


def _is_sound(name: str) -> bool:
    return name.startswith("sound-") and name.endswith(".wav")


def _sweep(out: Path) -> None:
    """Deletes what a killed run left half-written; younger parts may be another run's."""
    for path in out.glob(".*.part"):
        if time.time() - path.stat().st_mtime > _STALE_S:
            path.unlink(missing_ok=True)


def _tell_of_changed_media(edl: Edl, base: Path, progress: Progress) -> None:
    for camera in edl.cameras:
        for media, now in zip(camera.media, content_of(camera, base), strict=True):
            if media.fingerprint and media.fingerprint != now:
                progress.note(f"{media.path} of {camera.name} has changed since the analysis")


def _make_sound(edl: Edl, base: Path, out: Path, audio_from: str | None, progress: Progress) -> Path | None:
    camera = sound_of(edl, audio_from)
    footage = _footage(edl, base, 1)
    if not any(part.facts.has_audio for part in footage.parts(camera)):
        progress.note(f"{camera} has no sound, so the programme has none")
        return None
    path = out / f"sound-{sound_key(edl, camera, content_of(edl.camera(camera), base))}.wav"
    if not path.is_file():
        write_wav(footage, camera, edl, path, progress)
    return path


def _footage(edl: Edl, base: Path, threads: int) -> Footage:
    return Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base, threads=threads)


def _make_chunks(
    edl: Edl,
    base: Path,
    out: Path,
    missing: list[Chunk],
    filler: Filler,
    jobs: int,
    encoding: Encoding,
    progress: Progress,
) -> None:
    """Threads, not processes: decoding, warping and encoding run outside Python's lock, and plugins need no pickling.

    Each job decodes and encodes in one thread of its own; two jobs then keep two cores as busy as frame threads do,
    without waiting for each other.
    """
    progress.stage("Conforming", sum(len(chunk.range) for chunk in missing), "frames")
    footage = _footage(edl, base, threads=0 if jobs == 1 else 1)
    if jobs > 1 and encoding.codec == "libx264":
        encoding = attrs.evolve(encoding, options={**encoding.options, "threads": "1"})
    stop, count, lock = threading.Event(), [0], threading.Lock()

    def make(chunk: Chunk) -> None:
        with (
            Compositor(edl, footage, filler=filler) as compositor,
            VideoWriter(
                out / chunk.name, size=edl.size, rate=edl.rate, encoding=encoding, keyframe_interval=KEYFRAMES
            ) as writer,
        ):
            for planes in compositor.frames(chunk.range):
                if stop.is_set():
                    raise Cancelled
                writer.write(planes)
                with lock:
                    count[0] += 1

    threads_before = cv2.getNumThreads()
    if jobs > 1:
        cv2.setNumThreads(1)
    waiting, running = list(reversed(missing)), set[Future]()
    try:
        with ThreadPoolExecutor(jobs, thread_name_prefix="conform") as pool:
            try:
                while waiting or running:
                    while waiting and len(running) < jobs:
                        running.add(pool.submit(make, waiting.pop()))
                    done, running = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
                    for future in done:
                        future.result()
                    progress.advance(count[0])
            except BaseException:
                stop.set()
                raise
    finally:
        cv2.setNumThreads(threads_before)


# ---------------------------------------------------------------------------------------------------------- direct


def programme_frames(
    edl: Edl, base: Path, piece: FrameRange | None = None, *, filler: Filler | None = None
) -> Iterator[Planes]:
    """The programme's pictures over ``piece`` (all of it without), one after another, in flat memory."""
    with Compositor(edl, _footage(edl, base, threads=0), filler=filler) as compositor:
        yield from compositor.frames(piece or FrameRange(0, edl.frames))


def write_direct(
    edl: Edl,
    base: Path,
    path: Path,
    *,
    encoding: Encoding | None = None,
    size: tuple[int, int] | None = None,
    piece: FrameRange | None = None,
    filler: Filler | None = None,
    audio_from: str | None = None,
    audio_channels: int = 1,
    keyframe_interval: int | None = None,
    progress: Progress | None = None,
) -> None:
    """Writes the programme (or ``piece`` of it) with sound to ``path`` without Blender, in flat memory.

    size: (width, height) of the video, even; the programme's without. The sound is the camera ``audio_from``'s, the
    reference's without; the same in every channel.
    """
    progress = progress or Silent()
    piece = piece or FrameRange(0, edl.frames)
    camera = sound_of(edl, audio_from)
    footage = _footage(edl, base, threads=0)
    audible = any(part.facts.has_audio for part in footage.parts(camera))
    start_s, stop_s = (Fraction(frame) / edl.rate for frame in (piece.start, piece.stop))
    progress.stage("Writing the programme", len(piece), "frames")
    sound = footage.audio_blocks(camera, start_s, stop_s, AUDIO_RATE, block_s=1.0)
    with (
        Compositor(edl, footage, filler=filler) as compositor,
        VideoWriter(
            path,
            size=size or edl.size,
            rate=edl.rate,
            encoding=encoding,
            keyframe_interval=keyframe_interval,
            audio_rate=AUDIO_RATE if audible else None,
            audio_channels=audio_channels,
        ) as writer,
    ):
        for done, planes in enumerate(compositor.frames(piece), start=1):
            writer.write(resize_planes(planes, size or edl.size))
            while audible and writer.samples * edl.rate < done * AUDIO_RATE:  # side by side, as players read them
                block = next(sound, None)
                if block is None:
                    break
                writer.write_audio(block[:, None].repeat(audio_channels, axis=1))
            progress.advance(done)
