"""Films whose pictures change their size or shape within one stream; written without mcsl."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import av
from coded_video import coded_picture

from mcsl_core.edl import Camera, Media
from mcsl_core.media.probing import probe
from mcsl_core.recording.footage import Footage

EACH = 60
RATE = Fraction(30)
CODECS = {
    ".ts": ("libx264", {"preset": "veryfast", "crf": "10", "bf": "0"}),
    ".mkv": ("libx265", {"preset": "ultrafast", "crf": "10", "x265-params": "log-level=none:repeat-headers=1"}),
    ".webm": ("libvpx-vp9", {"deadline": "realtime", "cpu-used": "8", "crf": "20", "b": "0"}),
}


def film(path, sizes, aspects=()):
    """Two seconds of each size, or aspect of the pixels, in one stream, as a recorder writes whose input changes."""
    codec, options = CODECS.get(path.suffix, ("mpeg2video", {"b": "4M"}))
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, rate=30)
        stream.width, stream.height, stream.pix_fmt = *sizes[0], "yuv420p"
        number = 0
        for index, size in enumerate(sizes):
            encoder: Any = av.CodecContext.create(codec, "w")
            encoder.width, encoder.height, encoder.pix_fmt = *size, "yuv420p"
            encoder.time_base, encoder.framerate, encoder.gop_size = 1 / RATE, RATE, 30
            encoder.options = options
            if aspects:
                encoder.sample_aspect_ratio = aspects[index]
            packets = []
            for _ in range(EACH):
                frame = av.VideoFrame.from_ndarray(coded_picture(number, size), format="bgr24")
                frame = frame.reformat(format="yuv420p", dst_colorspace="ITU709")
                frame.pts, frame.time_base = number, 1 / RATE
                packets += encoder.encode(frame)
                number += 1
            for packet in [*packets, *encoder.encode(None)]:
                packet.stream = stream
                container.mux(packet)
    return path


def footage_of(path, count, gaps=()):
    facts = probe(path)
    camera = Camera("cam", (Media(path.name, facts.frames),), facts.size, facts.rate, gaps=gaps)
    return Footage([camera], rate=RATE, frames=count * EACH, base=path.parent, threads=1)
