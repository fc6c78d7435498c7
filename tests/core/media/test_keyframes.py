"""A keyframe alone, as sampling reads it, is the nearest there is."""

from __future__ import annotations

from fractions import Fraction

import av
import pytest
from coded_video import read_number, write_coded

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader

FRAMES, GOP = 120, 20


@pytest.mark.parametrize("bframes", [0, 2, 4])
@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.mkv", "a.ts"])
def test_the_nearest_keyframe_is_given(tmp_path, name, bframes):
    """A transport stream, which has no index, gave the one after the next: half a group late."""
    path = write_coded(tmp_path / name, range(FRAMES), gop=GOP, bframes=bframes)
    with av.open(str(path)) as container:
        keys = len([p for p in container.demux(video=0) if p.is_keyframe and p.size])
    assert keys == FRAMES // GOP
    facts = probe(path)
    reader = VideoReader(facts, threads=1)
    for near in range(0, FRAMES - GOP // 2, 3):
        found = reader.keyframe(Fraction(near) / facts.rate + facts.start_s)
        assert found is not None
        time, frame = found
        number = round((time - facts.start_s) * facts.rate)
        assert number == read_number(planes_to_bgr(to_planes(frame, facts)))
        assert number % GOP == 0
        assert abs(number - near) <= GOP // 2 + 3  # reordered pictures move the middle between two
    reader.close()
