"""Every format read back by parsers that are not mcsl's: frame by frame the pictures that the footage shows."""

from fractions import Fraction
from itertools import product

import attrs
import pytest
from apple_structure import faults_of
from hypothesis import given, settings
from interchange_cuts import NTSC, RATES, R, facts_of, film, films
from interchange_readers import (
    by_cmx_adapter,
    by_fcp_adapter,
    by_lxml,
    by_otio,
    by_pycmx,
    expanded,
    frames_of,
    of_items,
    of_multicam,
    of_track,
    otio,
    seconds,
)

from mcsl_core.edl import Clock, Movement, Override
from mcsl_core.errors import UsageError
from mcsl_core.interchange.cmx_writing import reels_of, write_cmx
from mcsl_core.interchange.fcpxml_writing import write_fcpxml
from mcsl_core.interchange.formats import FORMATS
from mcsl_core.interchange.otio_writing import write_otio
from mcsl_core.interchange.timecode import label
from mcsl_core.interchange.xmeml_writing import write_xmeml

STARTS = ["00:00:00:00", "01:00:00:00", "10:09:59;28", "00:59:59;29", "22:58:00:00"]
DROP = (Fraction(30000, 1001), Fraction(60000, 1001))
MATRIX = [(rate, start) for rate, start in product(RATES, STARTS) if ";" not in start or rate in DROP]


def wanted(made):
    """Programme frame -> (file, picture) of the shown camera, where it has one."""
    found = {n: made.picture_at(made.camera_at(n), n) for n in range(made.edl.frames)}
    return {n: at for n, at in found.items() if at is not None}


def of_programme(cut):
    return {n: (str(cut.programme.path), n) for n in range(cut.frames)}


def top(timeline):
    return expanded(of_track(timeline.video_tracks()[-1]))


@given(films())
@settings(max_examples=40)
def test_otio(made):
    timeline = by_otio(write_otio(made.cut()))
    assert top(timeline) == wanted(made)
    names = [track.name for track in timeline.video_tracks()]
    assert names[-2:] == [made.edl.reference.replace("\0", ""), "Programme"]
    for track in timeline.video_tracks()[:-1]:
        shown = {n: made.picture_at(track.name, n) for n in range(made.edl.frames)}
        assert expanded(of_track(track)) == {n: at for n, at in shown.items() if at is not None}
    exact = made.cut(exact=True)
    assert top(by_otio(write_otio(exact))) == of_programme(exact)


@given(films())
@settings(max_examples=40)
def test_xmeml(made):
    cut = made.cut()
    timeline = by_fcp_adapter(write_xmeml(cut))
    assert top(timeline) == wanted(made)
    assert len(timeline.video_tracks()) == len(made.edl.cameras) + 1
    exact = made.cut(exact=True)
    assert top(by_fcp_adapter(write_xmeml(exact))) == of_programme(exact)


@given(films())
@settings(max_examples=40)
def test_fcpxml_angles(made):
    document = write_fcpxml(made.cut())
    assert expanded(of_multicam(document)) == wanted(made)
    assert faults_of(by_lxml(document)) == []


@given(films())
@settings(max_examples=40)
def test_fcpxml_exact(made):
    cut = made.cut(exact=True)
    document = write_fcpxml(cut)
    root = by_lxml(document)
    assert faults_of(root) == []
    spine = root.find(".//project/sequence/spine")
    assert expanded(of_items(root, spine, cut.rate, cut.start_s)) == of_programme(cut)
    assert [clip.get("name") for clip in spine] == [shot.camera for shot in cut.shots]
    for clip in spine:  # the angle below lies where the shot lies
        below = [c for c in clip if c.get("lane") == "-1"]
        assert [c.tag for c in below] == ["mc-clip"]
        assert seconds(below[0].get("offset")) == seconds(clip.get("start"))
        assert seconds(below[0].get("start")) == seconds(clip.get("offset"))
        assert below[0].get("duration") == clip.get("duration")
    collection = otio.adapters.read_from_string(document.decode(), "fcpx_xml")
    timeline = next(one for one in collection if isinstance(one, otio.schema.Timeline))
    main = next(track for track in timeline.tracks if track.name == "0")
    assert [clip.name for clip in main.find_clips()] == [shot.camera for shot in cut.shots]


@given(made=films())
@settings(max_examples=40)
def test_cmx(made, tmp_path_factory):
    cut, exact = made.cut(), made.cut(exact=True)
    starts = {str(medium.path): medium.start for medium in (*cut.media(), *exact.media())}
    path = tmp_path_factory.getbasetemp() / "cut.edl"
    for one, whole in ((cut, wanted(made)), (exact, of_programme(exact))):
        if not whole:
            continue
        path.write_bytes(write_cmx(one))
        shown, names = by_pycmx(path, one.rate, starts)
        first = min(whole)  # a list begins with its first event
        assert {n + first: at for n, at in expanded(shown).items()} == whole
        assert [" ".join(clip.camera.split()) for clip in one.shown()] == names


@pytest.mark.parametrize(("rate", "start"), MATRIX)
def test_every_rate_and_start_timecode(rate, start, tmp_path):
    """No track is a frame off after an hour and a half, and timecode says of itself whether it is drop-frame."""
    frames = 5400 * -(-rate.numerator // rate.denominator)
    code = "10:00:00;02" if ";" in start else "10:00:00:02"
    files = {"cam2": [facts_of("2 ü.mp4", rate, frames, timecode=code)]}
    made = film(rate, frames, names=("cam1", "cam2"), files=files)
    drop = ";" in start
    cut = made.cut(start=start)
    middle = frames // 2
    spans = [(0, middle, "/films/0/cam1.mp4", 0), (middle, frames - middle, "/films/2 ü.mp4", middle)]

    timeline = by_otio(write_otio(cut))
    assert timeline.global_start_time.value == frames_of(start, rate)
    assert timeline.global_start_time.rate == float(rate)
    assert of_track(timeline.video_tracks()[-1]) == spans
    assert of_track(by_fcp_adapter(write_xmeml(cut)).video_tracks()[-1]) == spans
    assert of_multicam(write_fcpxml(cut)) == spans

    root = by_lxml(write_fcpxml(cut))
    sequence = root.find(".//project/sequence")
    assert seconds(sequence.get("tcStart")) == frames_of(start, rate) / rate
    assert sequence.get("tcFormat") == ("DF" if drop else "NDF")
    asset = next(a for a in root.iter("asset") if a.get("name") == "2 ü.mp4")
    assert seconds(asset.get("start")) == frames_of(code, rate) / rate
    assert seconds(asset.get("duration")) == frames / rate

    xmeml = by_lxml(write_xmeml(cut))
    timecode = xmeml.find("./sequence/timecode")
    assert timecode.findtext("string") == start
    assert int(timecode.findtext("frame")) == frames_of(start, rate)
    assert timecode.findtext("displayformat") == ("DF" if drop else "NDF")
    assert (timecode.findtext("rate/ntsc") == "TRUE") == (rate in NTSC)
    file = next(f for f in xmeml.iter("file") if f.findtext("name") == "2 ü.mp4")
    assert file.findtext("timecode/string") == code

    path = tmp_path / "cut.edl"
    path.write_bytes(write_cmx(cut))
    text = path.read_text("utf-8")
    assert f"FCM: {'DROP FRAME' if drop else 'NON-DROP FRAME'}\n" in text
    assert f" {start} {label(frames_of(start, rate) + middle, rate, drop=drop)}\n" in text
    shown, _ = by_pycmx(path, rate, {"/films/0/cam1.mp4": 0, "/films/2 ü.mp4": frames_of(code, rate)})
    assert shown == spans
    if rate not in NTSC and not start.startswith(
        "22"
    ):  # nothing past midnight, and the adapter's own arithmetic is in floats
        timeline = by_cmx_adapter(write_cmx(cut), rate)  # held: its tracks live no longer than it does
        assert [c.duration().value for c in timeline.video_tracks()[0]] == [middle, frames - middle]


def marked():
    return film(
        movements=(Movement(R(20, 30)),),
        overrides=(Override(R(40, 50), camera="cam1", fill=False, note="a hand"),),
    )


def test_markers_stand_where_they_belong_in_every_format():
    cut = marked().cut()
    said = [(m.range.start, len(m.range), m.name, m.note) for m in cut.markers]
    assert (20, 10, "lamp moves", "") in said
    assert (40, 10, "override: cam1, fill off", "a hand") in said
    stack = by_otio(write_otio(cut)).tracks
    assert [
        (m.marked_range.start_time.value, m.marked_range.duration.value, m.name, m.comment) for m in stack.markers
    ] == said
    markers = by_lxml(write_xmeml(cut)).findall("./sequence/marker")
    assert [(int(m.findtext("in")), m.findtext("name"), m.findtext("comment")) for m in markers] == [
        (start, name, note) for start, _, name, note in said
    ]
    root = by_lxml(write_fcpxml(cut))
    found = []
    for clip in root.find(".//spine"):
        for marker in clip.findall("marker"):
            inside = seconds(marker.get("start")) - seconds(clip.get("start"))
            assert 0 <= inside < seconds(clip.get("duration"))
            at = (seconds(clip.get("offset")) - cut.start_s + inside) * cut.rate
            found.append((at, marker.get("value"), marker.get("note", "")))
    assert found == [(start, name, note) for start, _, name, note in said]
    timeline = by_cmx_adapter(write_cmx(cut), cut.rate)
    names = [m.name for clip in timeline.video_tracks()[0].find_clips() for m in clip.markers]
    assert names == [f"{name} ({note})" if note else name for _, _, name, note in said]


@pytest.mark.parametrize("channels", [1, 2, 6])
def test_sound_is_the_chosen_cameras_with_all_its_channels(channels):
    rate = Fraction(25)
    files = {"cam2": [facts_of("2.mp4", rate, 100, channels=channels)]}
    made = film(files=files, cameras={"cam2": {"clock": Clock(offset_s=0.4)}})
    cut = made.cut(sound="cam2")
    heard = {n: made.picture_at("cam2", n) for n in range(10, 100)}
    assert [expanded(of_track(track)) for track in by_fcp_adapter(write_xmeml(cut)).audio_tracks()] == [
        heard
    ] * channels
    assert expanded(of_track(by_otio(write_otio(cut)).audio_tracks()[0])) == heard
    root = by_lxml(write_fcpxml(cut))
    asset = next(a for a in root.iter("asset") if a.get("name") == "2.mp4")
    assert (asset.get("audioChannels"), asset.get("audioSources")) == (str(channels), "1")
    assert root.find(".//project/sequence").get("audioLayout") == "stereo"
    angle = next(a.get("angleID") for a in root.iter("mc-angle") if a.get("name") == "cam2")
    for clip in root.find(".//spine"):
        chosen = [s.get("angleID") for s in clip.findall("mc-source") if s.get("srcEnable") in ("all", "audio")]
        assert chosen == [angle]


def test_no_sound_at_all():
    cut = film().cut(sound=None)
    assert by_otio(write_otio(cut)).audio_tracks() == []
    assert len(by_fcp_adapter(write_xmeml(cut)).audio_tracks()) == 0
    assert {s.get("srcEnable") for s in by_lxml(write_fcpxml(cut)).iter("mc-source")} == {"video"}
    assert " A " not in write_cmx(cut).decode()


def test_xmeml_has_the_format_that_resolve_asks_for():
    root = by_lxml(write_xmeml(film(Fraction(30000, 1001)).cut()))
    characteristics = root.find("./sequence/media/video/format/samplecharacteristics")
    assert [characteristics.findtext(tag) for tag in ("width", "height", "rate/timebase", "rate/ntsc")] == [
        "1920",
        "1080",
        "30",
        "TRUE",
    ]


def test_the_transform_is_about_the_middle_in_each_formats_units():
    """A camera of half the size, laid 96 px right of and 54 px below the middle, turned by 90 degrees clockwise."""
    turned = ((0.0, -1.0, 1055.5 + 269.5), (1.0, 0.0, 593.5 - 479.5), (0.0, 0.0, 1.0))
    made = film(names=("cam1", "cam2"))
    cameras = tuple(c if c.name == "cam1" else _resized(c) for c in made.edl.cameras)
    edl = attrs.evolve(made.edl, cameras=cameras, poses=(_posed(made.edl.poses[0], turned),))
    cut = type(made)(edl, made.parts).cut()
    transform = cut.angle("cam2").clips[0].transform
    assert (transform.x, transform.y) == pytest.approx((96, 54), abs=1e-6)
    assert (transform.scale, transform.rotation) == pytest.approx((1, 90))
    effect = by_lxml(write_xmeml(cut)).find(".//track/clipitem[name='cam2']/filter/effect")
    values = {p.findtext("parameterid"): p for p in effect.findall("parameter")}
    assert values["scale"].findtext("value") == "100"
    assert values["rotation"].findtext("value") == "90"
    assert [values["center"].findtext(f"value/{tag}") for tag in ("horiz", "vert")] == ["0.05", "0.05"]
    adjust = by_lxml(write_fcpxml(cut)).find(".//mc-angle[@name='cam2']/asset-clip/adjust-transform")
    assert adjust.get("position") == "8.888889 -5"
    assert adjust.get("rotation") == "-90"


def _resized(camera):
    return attrs.evolve(camera, size=(960, 540))


def _posed(pose, matrix):
    return attrs.evolve(pose, homographies={**pose.homographies, "cam2": matrix})


def test_reels_are_short_and_none_is_anothers():
    names = ["camera one", "camera two", "手術", "術", "ax", "CAMERAON"]
    reels = reels_of(names)
    assert len(set(reels.values())) == len(names)
    assert all(len(reel) <= 8 and reel.isascii() and reel not in ("AX", "BL") for reel in reels.values())


def test_a_list_of_more_frames_a_second_than_it_can_count_is_refused():
    with pytest.raises(UsageError, match="99 frames"):
        write_cmx(film(Fraction(120)).cut())


def test_the_same_cut_gives_the_same_bytes():
    for form in FORMATS.values():
        assert form.write(marked().cut()) == form.write(marked().cut())
