"""After a damaged picture nothing is whole up to the next keyframe, whatever times a container gives its packets."""

from fractions import Fraction

import av
import pytest
from coded_video import write_coded
from damaged_films import GOP, damaged, noise

from mcsl_core.media import reading
from mcsl_core.media.opening import main_video, open_file
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.media.whole_frames import WholeFrames

FRAMES, HIT = 3 * GOP, GOP + 10
FINE = {"preset": "veryfast", "crf": "1", "sc_threshold": "0"}
FILMS = {
    "plain.avi": ("libx264", {**FINE, "bf": "0"}),
    "reordered.avi": ("libx264", {**FINE, "bf": "2"}),
    "plain.mp4": ("libx264", {**FINE, "bf": "0"}),
}


def hit_inside(path, number):
    """Overwrites the inside of the packet that is ``number``-th in decoding order, no keyframe."""
    with av.open(str(path)) as container:
        packet = [p for p in container.demux(video=0) if p.size][number]
        assert not packet.is_keyframe
    return damaged(path, packet.pos + packet.size // 3, noise(40))


def without_presentation_times(packets):
    """As some versions of FFmpeg give those of H.264 in AVI."""
    for packet, whole in packets:
        packet.pts = None
        yield packet, whole


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("stamped", [True, False], ids=["as read", "decoding times alone"])
@pytest.mark.parametrize("name", FILMS)
def test_what_follows_a_damaged_picture_is_not_whole(tmp_path, monkeypatch, name, stamped, threads):
    codec, options = FILMS[name]
    path = hit_inside(write_coded(tmp_path / name, range(FRAMES), codec=codec, gop=GOP, options=options), HIT)
    facts = probe(path)
    if not stamped:
        judged = reading.judged_packets
        monkeypatch.setattr(reading, "judged_packets", lambda *given: without_presentation_times(judged(*given)))
    reader = VideoReader(facts, threads=threads)
    # Decoding times lie one picture before the others where the demuxer makes those up.
    whole = {int(time_s * 30 + Fraction(1, 2)) for time_s, frame in reader.read(Fraction(0)) if frame is not None}
    reader.close()
    missing = set(range(FRAMES)) - whole
    assert set(range(HIT + 3, 2 * GOP - 1)) <= missing, "smeared up to the next keyframe"
    assert missing <= set(range(HIT - 3, 2 * GOP)) | {FRAMES - 1}


def test_keyframes_that_have_come_are_forgotten(tmp_path):
    path = write_coded(tmp_path / "a.avi", range(60), codec="mjpeg", pix_fmt="yuvj420p", options={"q": "3"}, gop=1)
    judge, most, seen = WholeFrames(Fraction(1, 30)), 0, 0
    with open_file(path) as container:
        stream = main_video(container, path)
        for packet in container.demux(stream):
            judge.sent(packet)
            for frame in packet.decode():
                seen += len(list(judge.judged(frame.pts * stream.time_base, frame)))
            most = max(most, len(judge.keys))
    assert seen == 60
    assert most < 20, "those that the decoder's threads hold"
