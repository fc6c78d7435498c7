"""Clocks from start timecodes, in files that FFmpeg's muxers labelled; the oracle counts labels one by one."""

from fractions import Fraction
from itertools import pairwise

import av
import numpy as np
import pytest
from coded_video import DATA
from hypothesis import given
from hypothesis import strategies as st
from notes import Notes
from sync_sound import heard, room

from mcsl_core.edl import Camera, Media
from mcsl_core.media.probing import probe
from mcsl_core.sync.clock_fit import Refusal
from mcsl_core.sync.synchronise import synchronise
from mcsl_core.sync.timecode import parse_timecode

PAL, NTSC = Fraction(25), Fraction(30000, 1001)


def film(path, label, *, rate=PAL, pictures=50, late=0, codec=None, sound=None):
    """A small film whose first picture bears ``label`` (None for none) and stands ``late`` pictures after time 0."""
    codec = codec or ("mpeg2video" if path.suffix == ".mxf" else "libx264")
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=rate)
        stream.width, stream.height, stream.pix_fmt = 64, 36, "yuv420p"
        stream.codec_context.max_b_frames = 0
        track = container.add_stream("aac", rate=48000, layout="mono") if sound is not None else None
        if label is not None:
            container.metadata["timecode"] = label
        for index in range(pictures):
            grey = np.full((36, 64, 3), 40 + index % 100, np.uint8)
            frame = av.VideoFrame.from_ndarray(grey, format="bgr24").reformat(format="yuv420p")
            frame.pts, frame.time_base = index + late, 1 / rate
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
        if track is not None:
            for start in range(0, len(sound), 4800):
                piece = np.ascontiguousarray(sound[start : start + 4800], np.float32)[None]
                frame = av.AudioFrame.from_ndarray(piece, format="fltp", layout="mono")
                frame.sample_rate, frame.pts, frame.time_base = 48000, start, Fraction(1, 48000)
                container.mux(track.encode(frame))
            container.mux(track.encode(None))
    return path


def recorded(tmp_path, labels, *, rate=PAL, suffix=".mov", pictures=50):
    """Cameras a, b, ...; each of ``labels`` is one camera's label, or several for several files."""
    cameras = []
    for name, label in zip("abcdefg", labels, strict=False):
        files = [label] if label is None or isinstance(label, str) else label
        media = []
        for part, one in enumerate(files):
            path = film(tmp_path / f"{name}{part}{suffix}", one, rate=rate, pictures=pictures)
            media.append(Media(path.name, pictures))
        cameras.append(Camera(name, tuple(media), (64, 36), rate))
    return cameras


def ticks(rate: int, drop: bool, minutes: int = 24):
    """The labels of the day's first minutes in order, written down as the standard tells it: the oracle."""
    for minute in range(minutes):
        for second in range(60):
            first = rate // 15 if drop and second == 0 and minute % 10 else 0
            for picture in range(first, rate):
                yield f"{minute // 60:02}:{minute % 60:02}:{second:02}{';' if drop else ':'}{picture:02}"


@pytest.mark.parametrize(("rate", "drop"), [(PAL, False), (NTSC, True), (NTSC, False), (Fraction(60000, 1001), True)])
def test_labels_count_pictures_since_midnight(rate, drop):
    nominal = -(-rate.numerator // rate.denominator)
    labels = list(ticks(nominal, drop))
    for at in {*range(0, len(labels), 97), *range(1795, 1805), *range(17975, 17990), len(labels) - 1}:
        assert parse_timecode(labels[at], rate).count == at
    whole = sum(60 * nominal - (nominal // 15 if drop and minute % 10 else 0) for minute in range(24 * 60))
    last = parse_timecode(f"23:59:59{';' if drop else ':'}{nominal - 1}", rate)
    assert (last.day, last.count) == (whole, whole - 1)


def test_a_day_of_dropped_labels_is_a_day():
    """29.97 pictures a second, labels dropped: 24 hours of labels last 86 ms less than a day."""
    code = parse_timecode("00:00:00;00", NTSC)
    assert float(code.day / NTSC) == pytest.approx(86400, abs=0.1)
    assert float(parse_timecode("00:00:00:00", NTSC).day / NTSC) == pytest.approx(86486.4)


@given(st.text("0123456789:;. ", max_size=14), st.sampled_from([PAL, NTSC, Fraction(30)]))
def test_what_is_no_label_is_refused(text, rate):
    try:
        code = parse_timecode(text, rate)
    except Refusal:
        return
    assert 0 <= code.count < code.day


@pytest.mark.parametrize("label", ["24:00:00:00", "10:60:00:00", "10:00:00:25", "10:00:00;00", "", "now"])
def test_labels_that_cannot_be_are_refused(label):
    with pytest.raises(Refusal):
        parse_timecode(label, PAL)


@pytest.mark.parametrize(
    ("suffix", "rate", "labels", "pictures_later"),
    [
        (".mov", PAL, ("10:11:12:13", "10:11:13:00", "10:11:11:20"), (12, -18)),
        (".mp4", NTSC, ("10:59:59;20", "11:00:00;10", "10:59:59;00"), (20, -20)),
        (".mp4", NTSC, ("10:58:59;20", "10:59:00;10", "10:58:59;00"), (18, -20)),  # ;00 and ;01 are left out
        (".mxf", PAL, ("23:59:59:20", "00:00:00:05", "23:59:59:00"), (10, -20)),  # round midnight
        (".mov", Fraction(50), ("09:00:00:40", "09:00:01:10", "09:00:00:10"), (20, -30)),
    ],
)
def test_clocks_differ_by_whole_pictures(tmp_path, suffix, rate, labels, pictures_later):
    clocks = synchronise("timecode", recorded(tmp_path, labels, rate=rate, suffix=suffix), tmp_path)
    assert [c.method for c in clocks] == ["timecode"] * 3
    assert clocks[0].offset_s == 0
    for clock, pictures in zip(clocks[1:], pictures_later, strict=True):
        assert clock.offset_s == pytest.approx(float(pictures / rate), abs=1e-9)
        assert clock.drift_ppm == 0
        assert clock.confidence > 0.9


def test_a_picture_that_starts_late_bears_the_label(tmp_path):
    """The label is the first picture's, not that of the file's time 0."""
    names = [film(tmp_path / "a.mov", "10:00:00:00"), film(tmp_path / "b.mov", "10:00:01:00", late=10)]
    assert probe(names[1]).start_s == Fraction(10, 25)
    cameras = [Camera(p.stem, (Media(p.name, 50),), (64, 36), PAL) for p in names]
    assert synchronise("timecode", cameras, tmp_path)[1].offset_s == pytest.approx(1 - 0.4)


@pytest.mark.parametrize(
    ("labels", "why"),
    [
        (("10:00:00:00", None), "b has no timecode"),
        ((None, "10:00:00:00"), "a has no timecode"),
        (("00:00:00:00", "00:00:00:00"), "nobody has set"),
        (("01:00:00:00", "01:00:00:00"), "nobody has set"),
        (("10:00:00:00", "10:00:00:00"), "nobody has set"),
        (("10:00:00:00", "14:00:00:00"), "never together"),
        (("10:00:00:00", ["10:00:00:00", "10:05:00:00"]), "do not follow each other"),
    ],
)
def test_what_says_nothing_is_refused_with_the_reason(tmp_path, labels, why):
    progress = Notes()
    clocks = synchronise("timecode", recorded(tmp_path, labels), tmp_path, progress)
    assert (clocks[1].method, clocks[1].confidence, clocks[1].offset_s) == ("none", 0, 0)
    assert why in progress.notes[0]


def test_cameras_that_count_otherwise_are_refused(tmp_path):
    for rates, labels in (
        ((PAL, NTSC), ("10:00:00:00", "10:00:00:00")),
        ((NTSC, NTSC), ("10:00:00;02", "10:00:00:02")),
    ):
        cameras = []
        for name, rate, label in zip("ab", rates, labels, strict=True):
            path = film(tmp_path / f"{name}.mov", label, rate=rate)
            cameras.append(Camera(name, (Media(path.name, 50),), (64, 36), rate))
        progress = Notes()
        assert synchronise("timecode", cameras, tmp_path, progress)[1].method == "none"
        assert "a counts" in progress.notes[0]


def test_above_30_a_second_every_picture_must_be_known_to_have_its_label(tmp_path):
    """ST 12-1 lets 50 and 60 pictures a second share 25 or 30 labels: :10 may be the 10th picture or the 20th."""
    progress = Notes()
    cameras = recorded(tmp_path, ("10:00:00:10", "10:00:00:20"), rate=Fraction(50))
    assert synchronise("timecode", cameras, tmp_path, progress)[1].method == "none"
    assert "every other one" in progress.notes[0]


def test_further_files_tell_the_drift(tmp_path):
    """Four files of 4 minutes, pictures every 10 s: by the fourth label a camera 400 ppm fast is 7 pictures behind."""
    rate, pictures, ppm = PAL, 24, 400.0
    own = [Fraction(k * 240) for k in range(6)]

    def label(seconds):
        count = round(seconds * rate)
        return f"10:{count // 25 // 60:02}:{count // 25 % 60:02}:{count % 25:02}"

    def parts(name, drift):
        media = []
        for k, at in enumerate(own):
            path = tmp_path / f"{name}{k}.mov"
            with av.open(str(path), "w") as container:
                stream = container.add_stream("libx264", rate=rate)
                stream.width, stream.height, stream.pix_fmt = 64, 36, "yuv420p"
                stream.codec_context.max_b_frames = 0
                container.metadata["timecode"] = label(at / Fraction(1 + drift * 1e-6))
                for index in (*range(pictures), *range(240 * 25 - 24, 240 * 25)):
                    frame = av.VideoFrame.from_ndarray(np.full((36, 64, 3), index % 200, np.uint8), format="bgr24")
                    frame = frame.reformat(format="yuv420p")
                    frame.pts, frame.time_base = index, 1 / rate
                    container.mux(stream.encode(frame))
                container.mux(stream.encode(None))
            media.append(Media(path.name, 48))
        return Camera(name, tuple(media), (64, 36), rate)

    clock = synchronise("timecode", [parts("a", 0.0), parts("b", ppm)], tmp_path)[1]
    assert clock.method == "timecode"
    # A label is a picture of 40 ms: over 20 minutes 33 ppm.
    assert clock.drift_ppm == pytest.approx(ppm, abs=35)


@pytest.mark.slow
def test_auto_takes_the_timecode_and_says_where_the_sound_contradicts_it(tmp_path):
    source = room(45)
    cameras = []
    for name, offset, label in (("a", 0.0, "10:00:00:00"), ("b", 2.0, "10:00:02:00"), ("c", 3.0, "10:00:01:00")):
        sound = heard(source, (offset, 0.0), 32, ord(name))
        path = film(tmp_path / f"{name}.mov", label, pictures=32 * 25, sound=sound)
        cameras.append(Camera(name, (Media(path.name, 32 * 25),), (64, 36), PAL))
    progress = Notes()
    clocks = synchronise("auto", cameras, tmp_path, progress)
    assert [c.method for c in clocks] == ["timecode"] * 3
    assert [c.offset_s for c in clocks] == [0, 2, 1]
    assert (clocks[1].confidence, clocks[2].confidence) == (1.0, pytest.approx(0.475))
    assert len(progress.notes) == 1
    assert progress.notes[0].startswith("c: its sound says 2000 ms other than its timecode")


@pytest.mark.slow
def test_auto_goes_on_camera_by_camera(tmp_path):
    """One has a timecode, one only sound, one neither: each is tied by the first way that is sure."""
    source = room(45)
    given = (("a", 0.0, "10:00:00:00"), ("b", 2.0, "10:00:02:00"), ("c", 3.0, None), ("d", None, None))
    cameras = []
    for name, offset, label in given:
        sound = None if offset is None else heard(source, (offset, 0.0), 32, ord(name))
        path = film(tmp_path / f"{name}.mov", label, pictures=32 * 25, sound=sound)
        cameras.append(Camera(name, (Media(path.name, 32 * 25),), (64, 36), PAL))
    progress = Notes()
    clocks = synchronise("auto", cameras, tmp_path, progress)
    assert [c.method for c in clocks] == ["timecode", "timecode", "audio", "none"]
    assert clocks[2].offset_s == pytest.approx(3.0, abs=0.005)
    assert all(f"{way}: " in progress.notes[-1] for way in ("timecode", "audio", "motion"))


def test_labels_that_are_equal_by_chance_of_the_clock_are_good(tmp_path):
    """Recorders of one switcher start together and bear the time of day."""
    clocks = synchronise("timecode", recorded(tmp_path, ("10:17:00:00", "10:17:00:00")), tmp_path)
    assert (clocks[1].method, clocks[1].offset_s) == ("timecode", 0)


@pytest.mark.slow
@pytest.mark.parametrize("label", ["01:00:00:00", "00:00:00:00", "23:00:00:00", "08:12:34:05"])
def test_the_sound_wins_over_a_timecode_that_all_recorders_were_preset_to(tmp_path, label):
    source = room(45)
    cameras = []
    for name, offset in (("a", 0.0), ("b", 5.147)):
        path = film(tmp_path / f"{name}.mov", label, pictures=800, sound=heard(source, (offset, 0.0), 32, ord(name)))
        cameras.append(Camera(name, (Media(path.name, 800),), (64, 36), PAL))
    progress = Notes()
    clock = synchronise("auto", cameras, tmp_path, progress)[1]
    assert (clock.method, clock.offset_s) == ("audio", pytest.approx(5.147, abs=0.003))
    if label == "08:12:34:05":
        assert "its sound says 5147 ms other and was taken" in progress.notes[0]
    assert synchronise("timecode", cameras, tmp_path, progress)[1].offset_s == 0


def test_recorders_preset_alike_in_the_world():
    folder = DATA / "faults" / "timecode-preset"
    if not folder.is_dir():
        pytest.skip("the folder ../shared/data/faults/timecode-preset is not here")
    cameras = [Camera(n, (Media(f"{n}.mov", 1000),), (96, 54), PAL) for n in ("cam1", "cam2")]
    clock = synchronise("auto", cameras, folder)[1]
    assert (clock.method, clock.offset_s) == ("audio", pytest.approx(5.147, abs=0.003))


def test_the_oracle_itself_leaves_labels_out():
    labels = list(ticks(30, True))
    assert labels[1799:1801] == ["00:00:59;29", "00:01:00;02"]
    assert all(a < b for a, b in pairwise(labels))
