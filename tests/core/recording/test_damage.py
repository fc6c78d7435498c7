"""What is damaged in a file becomes a gap, and what is shown beside the gap is the right picture, never a smear."""

from fractions import Fraction

import numpy as np
import pytest
from coded_video import SIZE, coded_picture, read_number, write_coded
from damaged_films import FRAMES, GOP, damaged, lost, noise, place_of, write_film, zeros
from notes import Notes

from mcsl_core.edl import Camera, Clock, Media
from mcsl_core.errors import MediaError
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.damage import find_damage
from mcsl_core.media.probing import probe
from mcsl_core.progress import Silent
from mcsl_core.recording.damage import damage_met, damage_of, tell_of_damage, with_gaps
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

RATE = Fraction(30)
AVI = {"b": "8M", "qmin": "1"}
QUARTER = 140_000  # bytes of the films of H.264: two and a half seconds, and more than FFmpeg looks through at a time


def footage_of_file(path, *, gaps=(), frames=FRAMES, clock=None, notes=None):
    """A camera of one file; with gaps as they are found where none are given."""
    facts = probe(path)
    camera = Camera("cam", (Media(path.name, facts.frames),), facts.size, facts.rate, clock or Clock(), gaps or ())
    footage = Footage([camera], rate=RATE, frames=frames, base=path.parent, threads=1)
    if gaps is None:
        cameras = with_gaps(footage, damage_of(footage, Silent()), notes or Silent())
        footage = Footage(cameras, rate=RATE, frames=frames, base=path.parent, threads=1)
    return footage


def shown(footage):
    """Programme frame -> number in the picture, for all that have one; smears beside the number fail."""
    seen = {}
    for frame, planes in enumerate(footage.planes("cam", FrameRange(0, footage.frames))):
        if planes is not None:
            picture = planes_to_bgr(planes)
            seen[frame] = read_number(picture)
            below = np.s_[SIZE[1] // 3 :]
            error = np.abs(picture[below].astype(int) - coded_picture(seen[frame], SIZE)[below]).mean()
            assert error < 12, f"frame {frame} is smeared"
    return seen


CASES = [
    (name, codec, damage)
    for name, codec in [
        ("a.mp4", "libx264"),
        ("a.mov", "libx265"),
        ("a.mkv", "libx264"),
        ("a.ts", "libx264"),
        ("h.ts", "libx265"),
        ("m.ts", "mpeg2video"),
        ("m.avi", "mpeg4"),
        ("a.avi", "libx264"),
    ]
    for damage in ("zeros", "noise", "hole")
    if (name, damage) != ("m.avi", "hole")  # that is inside one packet
] + [("v.webm", "libvpx-vp9", "zeros"), ("a.ts", "libx264", "lost"), ("a.mkv", "libx264", "lost")]
# What is done, to which part of the file, from which picture on.
WAYS = {
    "zeros": (zeros, 1 / 4, 100),
    "noise": (noise, 1 / 4, 100),
    "hole": (zeros, 1 / 500, 90),
    "lost": (lost, 1 / 12, 100),
}


@pytest.mark.parametrize(("name", "codec", "damage"), CASES, ids=lambda value: value)
def test_a_damaged_stretch_is_a_gap_and_what_is_shown_is_right(tmp_path, name, codec, damage):
    path = write_film(tmp_path, name, codec)
    way, share, hit = WAYS[damage]
    damaged(path, place_of(path, hit) + 200, way(int(path.stat().st_size * share)))
    notes = Notes()
    footage = footage_of_file(path, gaps=None, notes=notes)
    (gap,) = footage.camera("cam").gaps
    assert hit - 8 <= gap.start <= hit
    assert gap.stop % GOP == 0, "it ends at a keyframe"
    seen = shown(footage)
    assert {frame: number for frame, number in seen.items() if frame != number} == {}
    held = 2 if name == "a.avi" else 0  # pictures before it whose place is only known by those that are missing
    missing = set(range(FRAMES)) - set(seen)
    assert set(gap) <= missing <= set(range(gap.start - held, gap.stop))
    assert [note for note in notes.notes if "cam has no picture in" in note and path.name in note and "damaged" in note]


@pytest.mark.parametrize("name", ["a.mp4", "a.ts", "a.mkv"])
def test_a_whole_film_has_no_gap_and_shows_everything(tmp_path, name):
    footage = footage_of_file(write_film(tmp_path, name), gaps=None)
    assert footage.camera("cam").gaps == ()
    assert shown(footage) == {frame: frame for frame in range(FRAMES)}


@pytest.mark.parametrize("threads", [1, 2])
def test_damage_inside_one_packet_is_met_by_the_decoder_and_told(tmp_path, threads):
    """It leaves no trace but in what is decoded: nothing from there to the next keyframe is shown."""
    path = write_film(tmp_path, "a.mp4")
    damaged(path, place_of(path, 90) + 1200, noise(300))
    footage = footage_of_file(path)
    footage._threads = threads
    seen = shown(footage)
    assert {frame: number for frame, number in seen.items() if frame != number} == {}
    missing = set(range(FRAMES)) - set(seen)
    assert 90 in missing
    assert missing <= set(range(90, 120))
    assert footage.damage_met() == {"cam": (FrameRange(min(missing), 120),)}
    notes = Notes()
    tell_of_damage(footage, notes)
    assert len(notes.notes) == 1
    assert "cam is damaged from 0:00:03." in notes.notes[0]


@pytest.mark.parametrize("offset_s", [0.0, 0.2, -0.2])
@pytest.mark.parametrize(("name", "codec"), [("a.mp4", "libx264"), ("a.ts", "libx264"), ("m.mp4", "mpeg2video")])
def test_a_keyframe_that_sampling_meets_damaged_is_a_gap(tmp_path, name, codec, offset_s):
    """Whether the sample that met it lies before it or behind it; kept with the samples."""
    path = write_film(tmp_path, name, codec)
    damaged(path, place_of(path, 90) + 1200, noise(60))  # within one packet of a transport stream
    footage = footage_of_file(path, clock=Clock(offset_s=offset_s), gaps=None)
    assert footage.camera("cam").gaps == (), "no packet tells"
    SampleStore.record(footage, tmp_path / "samples", Silent()).close()
    samples = SampleStore.load(tmp_path / "samples")
    assert samples is not None
    notes = Notes()
    (camera,) = with_gaps(footage, damage_met(footage, samples, Silent()), notes)
    samples.close()
    shift = round(offset_s * RATE)
    (gap,) = camera.gaps
    assert 90 - 2 <= gap.start - shift <= 90
    assert gap.stop - shift == 120
    assert [note for note in notes.notes if "cam has no picture in" in note and "damaged" in note]
    again = Footage([camera], rate=RATE, frames=FRAMES, base=tmp_path, threads=1)
    seen = shown(again)
    assert all(number == frame - shift for frame, number in seen.items() if 0 <= frame - shift < FRAMES)
    assert again.damage_met() == {}, "all of it is in the gap"


def test_a_whole_film_has_no_damage_that_sampling_meets(tmp_path):
    footage = footage_of_file(write_film(tmp_path, "a.mp4"))
    samples = SampleStore.record(footage, tmp_path / "samples", Silent())
    assert damage_met(footage, samples, Silent()) == {"cam": ((),)}
    samples.close()


def test_an_edl_without_the_gap_shows_no_frozen_picture_either(tmp_path):
    path = write_film(tmp_path, "a.ts")
    damaged(path, place_of(path, 100), zeros(QUARTER))
    seen = shown(footage_of_file(path))
    frozen = {frame: number for frame, number in seen.items() if frame != number}
    assert len(frozen) <= 2  # pictures shown before the packet in which it begins, and missing behind it
    assert FRAMES - 1 in seen, "the film after it is whole"


def test_a_keyframe_in_a_gap_stands_for_no_sample_nor_median(tmp_path):
    path = write_film(tmp_path, "a.mp4")
    damaged(path, place_of(path, 100), zeros(QUARTER))
    footage = footage_of_file(path, gaps=(FrameRange(85, 125),))
    from mcsl_core.recording.keyframe_sampling import sample_cameras

    for sample in sample_cameras(footage, step_s=0.5, height=SIZE[1]):
        picture = sample.pictures["cam"]
        if sample.frame in FrameRange(85, 125):
            assert picture is None
        elif picture is not None:
            assert read_number(picture) == sample.shown_frames["cam"]
            assert not 85 <= read_number(picture) < 125


def test_gaps_lie_on_the_programmes_clock(tmp_path):
    path = write_film(tmp_path, "a.mp4")
    damaged(path, place_of(path, 100), zeros(QUARTER))
    plain = footage_of_file(path, gaps=None).camera("cam").gaps[0]
    late = footage_of_file(path, gaps=None, clock=Clock(offset_s=1.5)).camera("cam").gaps[0]
    assert (late.start, late.stop) == (plain.start + 45, plain.stop + 45)
    early = footage_of_file(path, gaps=None, clock=Clock(offset_s=-3.5))
    assert early.camera("cam").gaps == (FrameRange(0, plain.stop - 105),)


# ------------------------------------------------------------------------------------------- stops, ends, stills


@pytest.mark.parametrize("name", ["a.mkv", "a.mp4", "a.ts"])
def test_a_recorder_that_stopped_and_went_on_within_a_file_leaves_a_gap(tmp_path, name):
    stamps = [*range(100), *range(220, 420)]
    path = write_coded(tmp_path / name, range(300), stamps=stamps, gop=10)
    footage = footage_of_file(path, gaps=None, frames=420)
    (gap,) = footage.camera("cam").gaps
    assert (gap.start, gap.stop) == (100, 220)
    assert all(number == stamps.index(frame) for frame, number in shown(footage).items())


def test_dropped_pictures_and_a_source_that_stands_still_are_no_damage(tmp_path):
    dropped = [n for n in range(300) if n % 37 not in (3, 4, 5)]
    path = write_coded(tmp_path / "dropped.mkv", dropped, stamps=dropped)
    assert find_damage(probe(path)) == ()
    path = write_coded(tmp_path / "still.mp4", [*range(60), *[60] * 200, *range(61, 90)])
    assert find_damage(probe(path)) == ()


def test_a_file_cut_short_is_a_gap_to_its_promised_end_and_told(tmp_path):
    path = write_film(tmp_path, "a.mp4", container_options={"movflags": "faststart"})
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    notes = Notes()
    footage = footage_of_file(path, gaps=None, notes=notes)
    (gap,) = footage.camera("cam").gaps
    assert gap.stop == FRAMES
    assert 150 < gap.start < 210
    assert any("cut short" in note for note in notes.notes)
    assert all(frame == number for frame, number in shown(footage).items())


def test_a_matroska_file_cut_short_has_no_cues_and_is_told(tmp_path):
    path = write_film(tmp_path, "a.mkv")
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    notes = Notes()
    footage = footage_of_file(path, gaps=None, notes=notes)
    assert footage.camera("cam").gaps[-1].stop == FRAMES
    assert any("cut short" in note for note in notes.notes)
    seen = shown(footage)
    assert len(seen) > 120
    assert all(frame == number for frame, number in seen.items())


@pytest.mark.parametrize("name", ["a.ts", "a.m2ts"])
def test_a_transport_stream_cut_short_inside_a_packet_is_told(tmp_path, name):
    """It promises no end; copying stops at a sector of the disk, not at a packet of the stream."""
    path = write_film(tmp_path, name)
    assert find_damage(probe(path)) == ()
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10 // 4096 * 4096 + 512])
    notes = Notes()
    footage = footage_of_file(path, gaps=None, notes=notes)
    assert any("cut short" in note and name in note for note in notes.notes)
    seen = shown(footage)
    assert len(seen) > 100
    assert all(frame == number for frame, number in seen.items())


def test_an_avi_with_sound_and_dropped_pictures_keeps_its_times_behind_damage(tmp_path):
    """Its pictures bear no times, and what is lost was not counted: the index says where they belong."""
    tone = 0.3 * np.sin(2 * np.pi * 440 * np.arange(10 * 48000) / 48000)
    stamps = [n for n in range(FRAMES) if n % 50 not in (7, 8, 9)]  # stored as chunks without a picture
    path = write_coded(tmp_path / "a.avi", stamps, stamps=stamps, codec="mpeg4", gop=GOP, options=AVI, sound=tone)
    whole = footage_of_file(path, gaps=None)
    assert whole.camera("cam").gaps == ()
    right = shown(whole)
    assert {frame: number for frame, number in right.items() if frame in stamps and frame != number} == {}
    damaged(path, place_of(path, 100) + 200, zeros(QUARTER // 4))
    footage = footage_of_file(path, gaps=None)
    (gap,) = footage.camera("cam").gaps
    seen = shown(footage)
    assert {frame: right[frame] for frame in seen} == seen
    assert set(range(FRAMES)) - set(seen) == set(gap)


def test_an_avi_cut_short_is_told(tmp_path):
    path = write_film(tmp_path, "m.avi", "mpeg4")
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 95 // 100])
    notes = Notes()
    footage_of_file(path, gaps=None, notes=notes)
    assert any("cut short" in note for note in notes.notes)


@pytest.mark.parametrize("codec", ["mpeg4", "libx264"])
def test_an_avi_that_lacks_bytes_inside_is_refused_by_name(tmp_path, codec):
    """Its index stands at its end and fits no more: all after the loss would be shown early."""
    path = write_film(tmp_path, "m.avi", codec)
    damaged(path, place_of(path, 100) + 200, lost(path.stat().st_size // 12))
    with pytest.raises(MediaError, match="index does not fit"):
        probe(path)


def test_sound_goes_on_after_damage(tmp_path):
    tone = 0.3 * np.sin(2 * np.pi * 440 * np.arange(10 * 48000) / 48000)
    path = write_film(tmp_path, "mp4.ts", sound=tone)
    size = path.stat().st_size
    damaged(path, size * 4 // 10, zeros(QUARTER))
    sound = footage_of_file(path).audio("cam", 8, 9)
    assert np.abs(sound).max() > 0.2
