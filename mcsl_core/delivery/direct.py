"""The programme written to a video without Blender."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Edl
from mcsl_core.filling.protocol import Filler
from mcsl_core.imaging.planes import resize_planes
from mcsl_core.imaging.warp import Resampling
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Progress, Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange

from .audio import AUDIO_RATE, sound_of


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
    resampling: Resampling = "linear",
    progress: Progress | None = None,
) -> None:
    """Writes the programme (or ``piece`` of it) with sound to ``path`` without Blender, in flat memory.

    size: (width, height) of the video, even; the programme's without. The sound is the camera ``audio_from``'s, the
    reference's without; the same in every channel.
    """
    progress = progress or Silent()
    piece = piece or FrameRange(0, edl.frames)
    camera = sound_of(edl, audio_from)
    footage = footage_of(edl, base, threads=0)
    audible = any(part.facts.has_audio for part in footage.parts(camera))
    start_s, stop_s = (Fraction(frame) / edl.rate for frame in (piece.start, piece.stop))
    progress.stage("Writing the programme", len(piece), "frames")
    sound = footage.audio_blocks(camera, start_s, stop_s, AUDIO_RATE, block_s=1.0)
    with (
        Compositor(edl, footage, filler=filler, resampling=resampling) as compositor,
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
