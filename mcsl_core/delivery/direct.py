"""The programme written to a video without Blender."""

from __future__ import annotations

from itertools import chain
from pathlib import Path

from attrs import frozen

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Edl
from mcsl_core.edl.removal import delivered
from mcsl_core.errors import InputError
from mcsl_core.imaging.planes import resize_planes
from mcsl_core.imaging.warp import Resampling
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Progress, Silent, Steps
from mcsl_core.recording.changed_media import media_files, tell_of_changed_media
from mcsl_core.recording.contents import read_contents
from mcsl_core.recording.damage import tell_of_damage
from mcsl_core.recording.decoding import tell_of_hardware
from mcsl_core.timing import FrameRange

from .audio import AUDIO_RATE, delivered_sound, is_audible
from .quality import STANDARD, Quality
from .reuse import chunks_there, pictures
from .source import ProgrammeSource


@frozen
class VideoFormat:
    """What kind of video is written.

    Parameters
    ----------
    encoding
        Of pictures and sound; the writer's own without.
    size
        (width, height), even; the programme's without.
    keyframe_interval
        Most frames from keyframe to keyframe; the encoder's own without.
    audio_channels
        How many there are; the sound is the same in each.
    resampling
        How the cameras' pictures are brought into the programme.
    """

    encoding: Encoding | None = None
    size: tuple[int, int] | None = None
    keyframe_interval: int | None = None
    audio_channels: int = 1
    resampling: Resampling = "linear"


def write_direct(
    source: ProgrammeSource,
    path: Path,
    *,
    video: VideoFormat = VideoFormat(),
    piece: FrameRange | None = None,
    conformed: Path | None = None,
    quality: Quality = STANDARD,
    progress: Progress | None = None,
) -> None:
    """Writes the programme (or ``piece`` of it) with sound to ``path`` without Blender, in flat memory.

    What is removed is left out; InputError where that is all of ``piece``.

    Pictures that lie conformed in the folder ``conformed``, in this ``quality``, are taken from there.
    """
    progress = progress or Silent()
    edl = source.edl
    pieces = _delivered(edl, piece)
    frames = sum(map(len, pieces))
    size, camera = video.size or edl.size, source.sound_camera
    steps = Steps(progress, ["files", "programme"])
    read_contents(media_files(edl, source.base), progress)
    tell_of_changed_media(edl, source.base, progress)
    tell_of_hardware(source.hwaccel, media_files(edl, source.base), progress)
    chunks = () if conformed is None else chunks_there(source, conformed, quality)
    taken = sum(len(both) for chunk in chunks for one in pieces if (both := chunk.range.intersection(one)) is not None)
    if taken:
        progress.note(f"{taken} of {frames} frames are taken from {conformed}, where they are conformed")
    footage = source.footage()
    sound = None
    if camera is not None and is_audible(footage, camera, progress):
        sound = delivered_sound(footage, camera, edl, pieces)
    steps.begin("programme")
    progress.stage("Writing the programme", frames, "frames")
    with (
        Compositor(edl, footage, filler=source.filler, resampling=video.resampling) as compositor,
        VideoWriter(
            path,
            size=size,
            rate=edl.rate,
            encoding=video.encoding,
            keyframe_interval=video.keyframe_interval,
            audio_rate=AUDIO_RATE if sound is not None else None,
            audio_channels=video.audio_channels,
        ) as writer,
    ):
        made = chain.from_iterable(pictures(compositor, one, chunks, conformed or source.base) for one in pieces)
        for done, planes in enumerate(made, start=1):
            writer.write(resize_planes(planes, size))
            while (
                sound is not None and writer.samples * edl.rate < done * AUDIO_RATE
            ):  # side by side, as players read them
                block = next(sound, None)
                if block is None:
                    break
                writer.write_audio(block[:, None].repeat(video.audio_channels, axis=1))
            progress.advance(done)
    compositor.stand_ins.tell(edl.rate, progress)
    tell_of_damage(footage, progress)


def _delivered(edl: Edl, piece: FrameRange | None) -> tuple[FrameRange, ...]:
    pieces = delivered(edl, piece)
    if not pieces:
        raise InputError(f"all of {piece} is removed", remedy="Choose other frames, or bring them back: mcsl remove")
    return pieces
