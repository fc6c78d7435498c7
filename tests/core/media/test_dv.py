"""DV, as camcorders and their capture cards write it: every picture in its place, in square pixels."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from coded_video import read_number, write_coded

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.damage import find_damage
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader

PAL: dict[str, Any] = {"size": (720, 576), "rate": Fraction(25), "pix_fmt": "yuv420p"}
NTSC: dict[str, Any] = {"size": (720, 480), "rate": Fraction(30000, 1001), "pix_fmt": "yuv411p"}


@pytest.mark.parametrize(("system", "shown"), [(PAL, (768, 576)), (NTSC, (640, 480))], ids=["PAL", "NTSC"])
@pytest.mark.parametrize("name", ["a.dv", "a.avi", "a.mov", "a.mxf"])
def test_dv_is_read_from_anywhere(tmp_path, name, system, shown):
    path = write_coded(tmp_path / name, range(50), codec="dvvideo", options={}, **system)
    facts = probe(path)
    assert (facts.size, facts.rate, facts.frames) == (shown, system["rate"], 50)
    assert find_damage(facts) == ()
    reader = VideoReader(facts, threads=1)
    for first in (0, 20, 7):
        read = [
            (round((time - facts.start_s) * facts.rate), read_number(planes_to_bgr(to_planes(frame, facts))))
            for time, frame in reader.read(facts.start_s + first / facts.rate)
        ]
        assert read == [(number, number) for number in range(first, 50)]
    reader.close()
