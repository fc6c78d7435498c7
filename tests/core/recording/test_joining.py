"""How a camera's files join: numbers drawn into the pictures say whether one is missing, twice, or late."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from coded_video import DATA, SIZE, read_number, write_coded
from remuxed import remux, split

from mcsl_core.edl import Camera, Clock, Media
from mcsl_core.media.probing import probe
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.joining import describe_joins, joined
from mcsl_core.timing import FrameRange

RATE = Fraction(30)
FAULTS = DATA / "faults"


def footage(paths, *, rate=RATE, frames=200, size=SIZE):
    camera = Camera("a", tuple(Media(str(p), 1) for p in paths), size, rate, clock=Clock())
    return Footage([camera], rate=rate, frames=frames, base=Path("/"))


def numbers(paths, frames):
    shown = footage(paths, frames=frames).planes("a", FrameRange(0, frames))
    return [None if p is None else read_number(p.y) for p in shown]


@pytest.mark.parametrize("suffix", [".mkv", ".mp4", ".mov", ".ts"])
@pytest.mark.parametrize("later_s", [0, 95441.6, 95441.1])  # MPEG's clock wraps at 95443.7: in part 1, part 2
def test_parts_of_a_clock_that_goes_on_lose_no_picture(tmp_path, suffix, later_s):
    film = write_coded(tmp_path / "a.mp4", range(130), gop=20)
    parts = split(film, suffix=suffix, at_s=[1, 2.5], later_s=[later_s] * 3)
    assert numbers(parts, 132) == [*range(130), None, None]
    assert describe_joins("a", footage(parts).parts("a")) == []
    assert numbers(parts[1:], 100)[:10] == list(range(40, 50))  # a camera whose first part is not there


@pytest.mark.parametrize("suffix", [".mkv", ".mp4", ".ts"])
def test_a_recorder_that_paused_leaves_a_gap_of_that_length_and_it_is_told(tmp_path, suffix):
    film = write_coded(tmp_path / "a.mp4", range(100), gop=20)
    parts = split(film, suffix=suffix, at_s=[1], later_s=[0, 2])
    assert numbers(parts, 162) == [*range(40), *[None] * 60, *range(40, 100), None, None]
    (note,) = describe_joins("a", footage(parts).parts("a"))
    assert note.startswith("a: no picture for 2.0 s from 0:00:01.3 on, between a_000")


def test_parts_that_overlap_show_the_later_one(tmp_path):
    film = write_coded(tmp_path / "a.mp4", range(100), gop=20)
    one = remux(film, tmp_path / "a_000.mkv", later_s=5, stop_s=Fraction(2))
    two = remux(film, tmp_path / "a_001.mkv", later_s=5, start_s=Fraction(1))
    got = numbers([one, two], 100)
    assert got == list(range(100))
    (note,) = describe_joins("a", footage([one, two]).parts("a"))
    assert "overlap by 0." in note


@pytest.mark.parametrize("suffix", [".ts", ".mp4"])
@pytest.mark.parametrize("anew", [False, True])
def test_sound_that_leads_in_every_part_adds_nothing_up(tmp_path, suffix, anew):
    """Whether the clock goes on from part to part or begins anew in each."""
    film = write_coded(tmp_path / "a.mp4", range(160), gop=20, sound=np.zeros(5 * 48000, np.float32))
    parts = split(film, suffix=suffix, at_s=range(1, 5), anew=anew, sound_later_s=-0.12)
    shown = footage(parts).parts("a")
    first = shown[0].begin_s + shown[0].facts.start_s
    begins = [float((part.begin_s + part.facts.start_s - first) * RATE) for part in shown]
    assert begins == pytest.approx([0, 40, 60, 100, 120], abs=0.05)
    assert sorted({n for n in numbers(parts, 200) if n is not None}) == list(range(160))


def test_a_clock_that_jumps_ahead_inside_a_file_leaves_a_gap(tmp_path):
    film = write_coded(tmp_path / "a.mp4", range(90), bframes=0)
    pieces = [remux(film, tmp_path / f"{later}.ts", later_s=later) for later in (2, 25)]
    spliced = tmp_path / "spliced.ts"
    spliced.write_bytes(b"".join(piece.read_bytes() for piece in pieces))
    got = numbers([spliced], 785)
    assert got[:85] == list(range(85))  # the last of a stream wait in the decoder when it is cut off
    assert set(got[100:690]) == {None}
    assert got[691:780] == list(range(1, 90))


def test_clocks_that_begin_anew_still_follow_each_other(tmp_path):
    for rate in (RATE, Fraction(25)):
        paths = [write_coded(tmp_path / f"a_{k}.ts", range(k * 30, k * 30 + 30), rate=rate) for k in range(3)]
        parts = joined([probe(p) for p in paths])
        assert [round(float(p.begin_s * rate), 6) for p in parts] == [0, 30, 60]


def test_the_first_timestamp_may_be_an_hour(tmp_path):
    film = write_coded(tmp_path / "a.mp4", range(60), sound=np.zeros(2 * 48000, np.float32))
    for suffix in (".mkv", ".mp4", ".ts"):
        path = remux(film, tmp_path / f"hour{suffix}", later_s=3600)
        assert probe(path).duration_s == pytest.approx(2, abs=0.06)
        got = numbers([path], 60)
        assert got[0] == 0
        assert got[10:50] in (list(range(10, 50)), list(range(9, 49)))  # sound may lead by its priming
        assert footage([path]).audio("a", 0, 1, 8000).shape == (8000,)


@pytest.mark.parametrize(
    ("folder", "begins"),
    [("segments-continuing-clock", [0, 5.12, 9.6]), ("ts-parts-audio-leads", None)],
)
def test_faulty_parts_from_the_world(folder, begins):
    paths = sorted((FAULTS / folder).glob("cam2_*"))
    if not paths:
        pytest.skip(f"the folder ../shared/data/faults/{folder} is not here")
    facts = [probe(p) for p in paths]
    parts = joined(facts)
    if begins is not None:
        assert [float(p.begin_s + p.facts.start_s) for p in parts] == begins
    lead = parts[0].begin_s + facts[0].start_s
    assert float(parts[-1].end_s - lead) == pytest.approx(12, abs=1e-3)
    shown = list(footage(paths, rate=Fraction(25), frames=300, size=facts[0].size).planes("a", FrameRange(0, 300)))
    assert None not in shown
    assert len({id(p) for p in shown}) in (299, 300)  # 12 s of 25: every one, or one less where sound leads by half
