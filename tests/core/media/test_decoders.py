"""Damage inside a packet, of which the container knows nothing: what decoders can notice of it is not shown."""

from __future__ import annotations

import random
from fractions import Fraction

import av
import numpy as np
import pytest
from coded_video import SIZE, coded_picture
from damaged_films import GOP, write_film

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader

FRAMES = 60
CHECKSUMS = {"preset": "ultrafast", "crf": "1", "x265-params": "log-level=none:bframes=2:keyint=30:hash=1"}
FILMS = {
    "av1": ("a.mp4", "libsvtav1", None),
    "vp9": ("v.webm", "libvpx-vp9", None),
    "hevc with checksums": ("h.mp4", "libx265", CHECKSUMS),
    "hevc with checksums in a stream": ("h.ts", "libx265", CHECKSUMS),
    "hevc": ("p.mp4", "libx265", None),
    "mjpeg": ("j.avi", "mjpeg", {"q:v": "2"}),
    "mjpeg in mov": ("j.mov", "mjpeg", {"q:v": "2"}),
}


def film(folder, kind):
    name, codec, options = FILMS[kind]
    settings = {"options": options} if options else {}
    return write_film(folder, name, codec, FRAMES, **settings, pix_fmt="yuvj420p" if codec == "mjpeg" else "yuv420p")


def pictures(path, threads=1):
    """Picture number -> how far it is from the right one in grey levels; None where none is shown."""
    facts = probe(path)
    reader = VideoReader(facts, threads=threads)
    shown = {}
    for time, frame in reader.read(Fraction(0)):
        number = round((time - facts.start_s) * 30)
        if frame is not None:
            picture = planes_to_bgr(to_planes(frame, facts)).astype(int)
            shown[number] = np.abs(picture - coded_picture(number, SIZE)).mean()
    reader.close()
    return shown


def hit(path, seed):
    """Sixteen bytes inside one packet that is no first one, changed; the picture's number."""
    with av.open(str(path)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
    rng = random.Random(seed)
    packet = rng.choice([p for p in packets[2:45] if p.size > 400])
    at = packet.pos + (200 if path.suffix == ".ts" else rng.randrange(60, packet.size - 20))
    data = bytearray(path.read_bytes())
    data[at : at + 16] = rng.randbytes(16)
    path.write_bytes(data)
    return round((packet.pts - min(p.pts for p in packets)) * packet.time_base * 30)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("kind", FILMS)
def test_a_whole_film_is_shown_whole(tmp_path, kind, threads):
    path = film(tmp_path, kind)
    assert probe(path).strict
    shown = pictures(path, threads)
    assert sorted(shown) == list(range(FRAMES))
    assert max(shown.values()) < 8


@pytest.mark.parametrize("kind", [kind for kind in FILMS if kind != "hevc"])
def test_what_is_damaged_inside_is_not_shown(tmp_path, kind):
    """The decoders of VP9 and Motion JPEG miss some, the others none."""
    path = film(tmp_path, kind)
    whole = path.read_bytes()
    wrong, met = 0, 0
    for seed in range(8):
        path.write_bytes(whole)
        number = hit(path, seed)
        shown = pictures(path, threads=1 + seed % 2)
        wrong += max(shown.values()) > 8
        met += len(shown) < FRAMES
        begin, end = number // GOP * GOP, (number // GOP + 1) * GOP
        # The few that the decoder holds back to put them into order are lost with it.
        assert set(range(FRAMES)) - set(shown) <= set(range(begin - 4, end)), "the rest of the film is shown"
    misses = kind.startswith(("vp9", "mjpeg"))
    assert wrong <= (2 if misses else 0)
    assert met >= (5 if misses else 6)


def test_encoders_that_break_small_rules_are_read(tmp_path):
    """Here each picture's checksum is of another: nothing is wrong with the pictures."""
    path = film(tmp_path, "hevc with checksums")
    data = path.read_bytes()
    message = b"\x84\x31\x00"  # a decoded picture's hash, 49 bytes, MD5
    assert data.count(message) == FRAMES
    pieces = data.split(message)
    path.write_bytes(message.join([pieces[0], *(bytes([p[0] ^ 1]) + p[1:] for p in pieces[1:])]))
    assert not probe(path).strict
    shown = pictures(path)
    assert sorted(shown) == list(range(FRAMES))
    assert max(shown.values()) < 8
