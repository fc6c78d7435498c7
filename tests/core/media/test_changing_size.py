"""A stream whose pictures change their size: scaled where the shape stays, left out and told where it does not."""

from __future__ import annotations

import struct
from fractions import Fraction

import pytest
from changing_films import CODECS, EACH, film, footage_of
from coded_video import read_number
from notes import Notes
from remuxed import remux

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.probing import probe
from mcsl_core.progress import Silent
from mcsl_core.recording.damage import damage_met, with_gaps
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange


def numbers(footage):
    shown = enumerate(footage.planes("cam", FrameRange(0, footage.frames)))
    return {frame: read_number(planes_to_bgr(planes)) for frame, planes in shown if planes is not None}


@pytest.mark.parametrize("suffix", CODECS)
def test_pictures_of_the_same_shape_are_scaled(tmp_path, suffix):
    footage = footage_of(film(tmp_path / f"a{suffix}", [(256, 144), (512, 288), (256, 144)]), 3)
    seen = numbers(footage)
    assert {frame: number for frame, number in seen.items() if frame != number} == {}
    assert len(seen) >= 3 * EACH - 2


@pytest.mark.parametrize("suffix", CODECS)
def test_pictures_of_another_shape_are_a_gap_and_told(tmp_path, suffix):
    path = film(tmp_path / f"a{suffix}", [(256, 144), (320, 240), (256, 144)])
    footage = footage_of(path, 3)
    seen = numbers(footage)
    assert {frame: number for frame, number in seen.items() if frame != number} == {}
    assert not [frame for frame in seen if EACH <= frame < 2 * EACH]
    assert len(seen) >= 2 * EACH - 3
    samples = SampleStore.record(footage, tmp_path / "samples", Silent(), step_s=0.5)
    notes = Notes()
    (camera,) = with_gaps(footage, damage_met(footage, samples, Silent()), notes)
    samples.close()
    (gap,) = camera.gaps
    assert EACH - 3 <= gap.start <= EACH
    assert gap.stop == 2 * EACH
    assert [note for note in notes.notes if "another shape (320x240, not 256x144)" in note and path.name in note]


@pytest.mark.parametrize("suffix", [".ts", ".mpg"])
def test_pixels_of_another_aspect_are_a_gap_and_told(tmp_path, suffix):
    """As broadcasts and DVD recorders switch between 4:3 and 16:9 at one size."""
    aspects = [Fraction(1), Fraction(4, 3), Fraction(1)]
    if suffix == ".mpg":  # MPEG-2 knows the picture's aspect alone
        aspects = [Fraction(16, 9) * Fraction(144, 256), Fraction(4, 3) * Fraction(144, 256), Fraction(1)]
    path = film(tmp_path / f"a{suffix}", [(256, 144)] * 3, aspects)
    assert probe(path).size == (256, 144)
    footage = footage_of(path, 3)
    seen = numbers(footage)
    assert {frame: number for frame, number in seen.items() if frame != number} == {}
    last = 1  # MPEG-2's decoder holds a picture back, and tells the aspect of the next with it
    assert not [frame for frame in seen if EACH <= frame < 2 * EACH - last]
    assert len(seen) >= 2 * EACH - 6
    samples = SampleStore.record(footage, tmp_path / "samples", Silent(), step_s=0.5)
    (camera,) = with_gaps(footage, damage_met(footage, samples, Silent()), Silent())
    samples.close()
    (gap,) = camera.gaps
    assert EACH - 4 <= gap.start <= EACH
    assert 2 * EACH - last <= gap.stop <= 2 * EACH + 3


@pytest.mark.parametrize("suffix", CODECS)
@pytest.mark.parametrize("aspect", [Fraction(1), Fraction(4, 3), Fraction(64, 45)])
def test_one_aspect_all_along_leaves_no_gap(tmp_path, suffix, aspect):
    footage = footage_of(film(tmp_path / f"a{suffix}", [(256, 144)] * 2, [aspect] * 2), 2)
    assert len(numbers(footage)) >= 2 * EACH - 1


def test_a_container_that_says_another_aspect_than_the_stream_leaves_no_gap(tmp_path):
    path = film(tmp_path / "a.ts", [(256, 144)] * 2, [Fraction(4, 3)] * 2)
    remux(path, tmp_path / "a.mp4")
    data = (tmp_path / "a.mp4").read_bytes()
    at = data.index(b"pasp") + 4
    (tmp_path / "a.mp4").write_bytes(data[:at] + struct.pack(">2I", 64, 45) + data[at + 8 :])
    facts = probe(tmp_path / "a.mp4")
    assert (facts.sample_aspect, facts.stream_aspect) == (Fraction(64, 45), Fraction(4, 3))
    assert len(numbers(footage_of(tmp_path / "a.mp4", 2))) >= 2 * EACH - 1
