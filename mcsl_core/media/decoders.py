"""The decoder of a stream's pictures that notices most of the damage inside them, at the price of any other.

What hits the inside of a packet leaves no trace in the container, and arithmetic coding makes a picture of anything.
Decoders know more than they tell: of 16 damaged AV1 packets libdav1d refuses 12, and all 16 where it may check what
stands behind the last symbol; of 21 of VP9 FFmpeg's own decoder refuses none, libvpx 17, at the same speed; of 37 of
HEVC none, and 9 where what is skipped is an error, or all where the encoder wrote checksums (SEI); of 16 of Motion JPEG
none, and 13 where it is an error. Those of H.264, MPEG-1, 2 and 4, ProRes and DNxHD tell most as they are, of VP8 none.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from itertools import dropwhile, islice
from pathlib import Path
from typing import Any

import av
from av.error import FFmpegError

from .opening import main_video, open_file, timestamp_of
from .packets import packets_of

_STRICT = {
    "hevc": {"err_detect": "crccheck+explode"},
    "libdav1d": {"strict": "1"},
    "mjpeg": {"err_detect": "explode"},
    "vp9": {},
}
_OTHER = {"vp9": "libvpx-vp9"}
_TRIED = 6  # packets at each place: of what encoders do against the rules, some comes with every picture


def strict_decoder(stream: Any) -> Any:
    """A stream's decoder, not yet opened, that refuses a packet rather than show what it holds no picture of."""
    context = stream.codec_context
    codec = context.name
    if _OTHER.get(codec) in av.codecs_available:
        context = _like(context, _OTHER[codec])
    if codec in _STRICT:
        context.options = _STRICT[codec]
    return context


def _like(context: Any, codec: str) -> Any:
    other: Any = av.CodecContext.create(codec, "r")
    if context.extradata:
        other.extradata = context.extradata
    # What the container alone says of the colours.
    other.color_range, other.colorspace = context.color_range, context.colorspace
    other.color_primaries, other.color_trc = context.color_primaries, context.color_trc
    return other


def takes_strictly(path: Path) -> bool:
    """Whether `strict_decoder` takes a file's pictures, as far as a few from its start and its quarters tell. Kept for
    the run.

    Encoders break small rules that do a picture no harm (SVT-AV1 does at its finest and fastest); all pictures of such
    a file would be called damaged. One place that is refused among others is damage.
    """
    state = path.stat()
    return _takes_strictly(path, state.st_size, state.st_mtime_ns)


@lru_cache(maxsize=1024)
def _takes_strictly(path: Path, _size: int, _changed_ns: int) -> bool:
    with open_file(path) as container:
        stream = main_video(container, path)
        if stream.codec_context.name not in _STRICT:
            return True
        context = strict_decoder(stream)
        taken = dict(_taken(container, stream, context, Fraction(place, 4)) for place in range(4))
    return list(taken.values()).count(False) < min(2, len(taken))


def _taken(container: Any, stream: Any, context: Any, place: Fraction) -> tuple[int | None, bool]:
    """The keyframe before ``place``, a part of the file, and whether the decoder takes the packets from it on."""
    try:
        if place:
            container.seek((stream.start_time or 0) + int((stream.duration or 0) * place), stream=stream)
            context.flush_buffers()
    except FFmpegError:
        return None, True
    sized = (packet for packet in packets_of(container, stream) if packet.size)
    packets = list(islice(dropwhile(lambda packet: not packet.is_keyframe, sized), _TRIED))
    at = timestamp_of(packets[0]) if packets else None
    try:
        for packet in packets:
            context.decode(packet)
    except FFmpegError:
        return at, False
    return at, True
