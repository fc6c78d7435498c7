"""What comes back from an editor: changed with opentimelineio and lxml, which know nothing of mcsl."""

from __future__ import annotations

import contextlib
import copy
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from interchange_cuts import R, facts_of, film, films
from interchange_readers import by_lxml, by_otio, otio, seconds
from lxml import etree

from mcsl_core.edl import Clock, Shot
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import DocumentError, InputError, McslError
from mcsl_core.interchange.changes import find_changes, with_cameras
from mcsl_core.interchange.formats import FORMATS

FLAVOURS = [(suffix, exact) for suffix in FORMATS for exact in (False, True)]


def read(made, suffix, document, folder):
    """What is found changed in a document."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return find_changes(made.cut(), form.read(path, made.edl.rate), form.layout)


def shown(edl):
    """Whom the programme shows, frame by frame."""
    return [decision.camera for piece, decision in resolve(edl) for _ in piece]


def said(changes):
    """Frame -> its camera now, of those that changed."""
    return {n: camera for piece, camera in changes.cameras for n in piece}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("zurück 100%")


@pytest.mark.parametrize(("suffix", "exact"), FLAVOURS)
@given(made=films(mixed_rates=True))
@settings(max_examples=25)
def test_what_nobody_touched_says_nothing(made, suffix, exact, folder):
    cut = made.cut(exact=exact)
    assume(cut.shown())
    changes = read(made, suffix, FORMATS[suffix].write(cut), folder)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())


# ------------------------------------------------------------------------------------- another angle, a moved cut


@pytest.mark.parametrize("exact", [False, True])
@given(made=films(), data=st.data())
@settings(max_examples=40)
def test_angles_switched_with_opentimelineio(made, exact, folder, data):
    timeline = by_otio(FORMATS[".otio"].write(made.cut(exact=exact)))
    expected = {}
    for clip in timeline.video_tracks()[-1].find_clips():
        key = data.draw(st.sampled_from(sorted(clip.media_references())))
        if key != clip.active_media_reference_key:
            clip.active_media_reference_key = key
            span = clip.range_in_parent()
            start = int(span.start_time.value)
            expected |= dict.fromkeys(range(start, start + int(span.duration.value)), key)
    text = otio.adapters.write_to_string(timeline, "otio_json").encode()
    changes = read(made, ".otio", text, folder)
    assert said(changes) == expected
    assert changes.removed == ()
    before, after = shown(made.edl), shown(with_cameras(made.edl, changes.cameras))
    assert after == [expected.get(n, camera) for n, camera in enumerate(before)]


@pytest.mark.parametrize("exact", [False, True])
@given(made=films(), data=st.data())
@settings(max_examples=40)
def test_angles_switched_in_fcpxml(made, exact, folder, data):
    """Of the exact flavour the clip above is disabled, so that the angle below shows."""
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut(exact=exact)))
    names = {angle.get("angleID"): angle.get("name") for angle in root.iter("mc-angle")}
    expected = {}
    for clip, shot in zip(root.find(".//spine"), made.cut().shots, strict=True):
        angle = data.draw(st.sampled_from([None, *sorted(names)]))
        if angle is None:
            continue
        multicam = clip if clip.tag == "mc-clip" else clip.find("mc-clip")
        if exact:
            clip.set("enabled", "0")
        for source in multicam.findall("mc-source"):
            multicam.remove(source)
        multicam.insert(0, etree.Element("mc-source", angleID=angle, srcEnable="all"))
        if names[angle] != shot.camera:
            expected |= dict.fromkeys(shot.range, names[angle])
    changes = read(made, ".fcpxml", etree.tostring(root), folder)
    assert (said(changes), changes.removed) == (expected, ())


def rolled(text):
    """A time of FCPXML."""
    return f"{text.numerator}/{text.denominator}s"


@given(made=films(), data=st.data(), exact=st.booleans())
@settings(max_examples=60)
def test_a_cut_moved_in_fcpxml(made, exact, folder, data):
    cut = made.cut(exact=exact)
    assume(len(cut.shots) > 1)
    at = data.draw(st.integers(1, len(cut.shots) - 1))
    before, after = cut.shots[at - 1], cut.shots[at]
    by = data.draw(st.integers(1 - len(before.range), len(after.range) - 1))
    root = by_lxml(FORMATS[".fcpxml"].write(cut))
    left, right = root.find(".//spine")[at - 1], root.find(".//spine")[at]
    moved = by / cut.rate
    left.set("duration", rolled(seconds(left.get("duration")) + moved))
    right.set("duration", rolled(seconds(right.get("duration")) - moved))
    for name in ("offset", "start"):
        right.set(name, rolled(seconds(right.get(name)) + moved))
    border = after.range.start
    expected = dict.fromkeys(range(border, border + by), before.camera)
    expected |= dict.fromkeys(range(border + by, border), after.camera)
    changes = read(made, ".fcpxml", etree.tostring(root), folder)
    assert (said(changes), changes.removed) == (expected, ())
    again = with_cameras(made.edl, changes.cameras)
    assert [expected.get(n, camera) for n, camera in enumerate(shown(made.edl))] == shown(again)


@pytest.mark.parametrize("suffix", [".otio", ".xml"])
@given(made=films(), data=st.data())
@settings(max_examples=40)
def test_a_cut_moved_between_conformed_clips(made, suffix, folder, data):
    cut = made.cut(exact=True)
    assume(len(cut.shots) > 1)
    at = data.draw(st.integers(1, len(cut.shots) - 1))
    before, after = cut.shots[at - 1], cut.shots[at]
    by = data.draw(st.integers(1 - len(before.range), len(after.range) - 1))
    border = after.range.start
    if suffix == ".otio":
        timeline = by_otio(FORMATS[suffix].write(cut))
        left, right = list(timeline.video_tracks()[-1])[at - 1 : at + 1]
        moved = otio.opentime.RationalTime(by, float(cut.rate))
        span = left.source_range
        left.source_range = otio.opentime.TimeRange(span.start_time, span.duration + moved)
        span = right.source_range
        right.source_range = otio.opentime.TimeRange(span.start_time + moved, span.duration - moved)
        document = otio.adapters.write_to_string(timeline, "otio_json").encode()
    else:
        root = by_lxml(FORMATS[suffix].write(cut))
        track = root.findall("./sequence/media/video/track")[-1]
        left, right = track.findall("clipitem")[at - 1 : at + 1]
        for item, tag in ((left, "end"), (left, "out"), (right, "start"), (right, "in")):
            item.find(tag).text = str(int(item.findtext(tag)) + by)
        document = etree.tostring(root)
    expected = dict.fromkeys(range(border, border + by), before.camera)
    expected |= dict.fromkeys(range(border + by, border), after.camera)
    changes = read(made, suffix, document, folder)
    assert (said(changes), changes.removed) == (expected, ())


# ------------------------------------------------------------------------------------------------ what is removed


@given(made=films(), data=st.data(), exact=st.booleans())
@settings(max_examples=40)
def test_shots_removed_from_fcpxml_close_up_and_are_named(made, exact, folder, data):
    cut = made.cut(exact=exact)
    assume(len(cut.shots) > 1)
    gone = data.draw(st.sets(st.integers(0, len(cut.shots) - 1), min_size=1, max_size=len(cut.shots) - 1))
    root = by_lxml(FORMATS[".fcpxml"].write(cut))
    spine = root.find(".//spine")
    at_s = cut.start_s
    for n, clip in enumerate(list(spine)):
        if n in gone:
            spine.remove(clip)
        else:
            clip.set("offset", rolled(at_s))
            at_s += seconds(clip.get("duration"))
    changes = read(made, ".fcpxml", etree.tostring(root), folder)
    assert changes.cameras == ()
    assert {n for piece in changes.removed for n in piece} == {n for i in gone for n in cut.shots[i].range}


def test_a_shot_removed_from_every_track_of_an_otio(tmp_path):
    made = film(Fraction(30000, 1001), 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut(exact=True)))
    del timeline.tracks[0:3]  # the cameras
    del timeline.video_tracks()[0][1]
    changes = read(made, ".otio", otio.adapters.write_to_string(timeline, "otio_json").encode(), tmp_path)
    assert (changes.cameras, changes.removed) == ((), (R(30, 60),))


def test_a_list_with_an_event_left_out_and_another_camera(tmp_path):
    rate = Fraction(30000, 1001)
    files = {"cam3": [facts_of("2/cam3.mp4", rate, 150)]}
    made = film(rate, 90, files=files, cameras={"cam3": {"clock": Clock(offset_s=-1.001)}})
    lines = FORMATS[".edl"].write(made.cut(start="01:00:00;00", sound=None)).decode().splitlines()
    first, second, third = (next(n for n, line in enumerate(lines) if line.startswith(f"00{i}")) for i in (1, 2, 3))
    # The first event now shows cam3, whose pictures are 30 ahead; the second is gone.
    lines[first] = "001  CAM3     V     C        00:00:01;00 00:00:02;00 01:00:00;00 01:00:01;00"
    back = [*lines[: first + 1], "* FROM CLIP NAME: cam3.mp4", *lines[third:]]
    assert second < third
    changes = read(made, ".edl", "\n".join(back).encode(), tmp_path)
    assert (changes.cameras, changes.removed) == (((R(0, 30), "cam3"),), (R(30, 60),))


@pytest.mark.parametrize("frames", [30, 12])
def test_a_foreign_clip_in_place_of_a_shot_covers_it_and_removes_nothing(frames, tmp_path):
    made = film(Fraction(25), 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut(exact=True)))
    del timeline.tracks[0:3]  # the cameras
    track = timeline.video_tracks()[0]
    of = otio.opentime
    span = of.TimeRange(of.RationalTime(0, 25), of.RationalTime(frames, 25))
    title = otio.schema.Clip("title", otio.schema.ExternalReference("title.mov", span), span)
    track[1] = title
    changes = read(made, ".otio", otio.adapters.write_to_string(timeline, "otio_json").encode(), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert any("frames [30, 60), in whose place" in note for note in changes.notes)
    del track[1]
    changes = read(made, ".otio", otio.adapters.write_to_string(timeline, "otio_json").encode(), tmp_path)
    assert changes.removed == (R(30, 60),)
    track.append(title)  # elsewhere: at the end, where nothing of the programme lay
    changes = read(made, ".otio", otio.adapters.write_to_string(timeline, "otio_json").encode(), tmp_path)
    assert changes.removed == (R(30, 60),)


# ---------------------------------------------------------------------------------------------- whatever else


def test_another_file_and_a_disabled_clip_in_xmeml(tmp_path):
    """Premiere's ways to another angle: the clip's source replaced, or disabled, so that the highest below it shows."""
    files = {"cam3": [facts_of("2/cam3.mp4", Fraction(25), 120, timecode="10:00:00:00")]}
    made = film(files=files, cameras={"cam3": {"clock": Clock(offset_s=-0.4)}})
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    tracks = root.findall("./sequence/media/video/track")
    first, second, _ = tracks[-1].findall("clipitem")
    file = next(f for f in root.iter("file") if f.findtext("name") == "cam3.mp4")
    first.find("file").set("id", file.get("id"))
    first.find("in").text, first.find("out").text = "10", "43"
    second.find("enabled").text = "FALSE"
    changes = read(made, ".xml", etree.tostring(root), tmp_path)
    assert changes.cameras == ((R(0, 33), "cam3"), (R(33, 66), "cam1"))
    assert changes.removed == ()


def test_what_an_editor_relinks_elsewhere_is_known_by_its_name(tmp_path):
    made = film(Fraction(25), 90)
    text = FORMATS[".xml"].write(made.cut()).decode()
    text = text.replace("file:///films/", "file://localhost/D%3A/Op%C3%A9ration/")
    assert read(made, ".xml", text.encode(), tmp_path) == read(
        made, ".xml", FORMATS[".xml"].write(made.cut()), tmp_path
    )


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("named", ["* FROM CLIP NAME: {camera}", "* FROM CLIP NAME: {file}", ""])
def test_a_list_that_lost_its_files_is_known_by_reels_and_names(exact, named, tmp_path):
    """As editors write lists: a clip's file name in a comment, or nothing but the reel."""
    files = {"cam2": [facts_of("2/cam2.mp4", Fraction(25), 90, timecode="10:00:00:00")]}
    made = film(Fraction(25), 90, files=files)
    lines = []
    for line in FORMATS[".edl"].write(made.cut(exact=exact, sound=None)).decode().splitlines():
        if line.startswith("* FROM CLIP NAME: "):
            camera = line.removeprefix("* FROM CLIP NAME: ")
            lines.append(named.format(camera=camera, file="cut.programme.mp4" if exact else f"{camera}.mp4"))
        elif not line.startswith(("* SOURCE FILE", "* MCSL CUT", "* LOC")):
            lines.append(line)
    changes = read(made, ".edl", "\n".join(lines).encode(), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())


def test_what_cannot_be_said_is_named(tmp_path):
    made = film(Fraction(25), 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    programme = timeline.video_tracks()[-1]
    programme[0].effects.append(otio.schema.LinearTimeWarp("slow", time_scalar=0.5))
    black = otio.schema.ExternalReference("file:///logo.mov", programme[0].media_reference.available_range)
    programme.insert(3, otio.schema.Clip("logo", black, programme[0].source_range))
    programme.insert(2, otio.schema.Transition("SMPTE_Dissolve", "mix", otio.opentime.RationalTime(2, 25)))
    at = otio.opentime.TimeRange(duration=otio.opentime.RationalTime(1, 25))
    timeline.tracks.markers.append(otio.schema.Marker("look here", at))
    changes = read(made, ".otio", otio.adapters.write_to_string(timeline, "otio_json").encode(), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    told = "\n".join(changes.notes)
    for what in (
        "LinearTimeWarp",
        "a transition at frame 60",
        "/logo.mov is none of",
        "marker 'look here' at 0:00:00.0",
    ):
        assert what in told


def test_a_picture_that_was_moved_is_named(tmp_path):
    made = film(Fraction(25), 90)
    for exact, count in ((False, 1), (True, 2)):
        root = by_lxml(FORMATS[".xml"].write(made.cut(exact=exact)))
        track = root.findall("./sequence/media/video/track")[-1]
        for item in track.findall("clipitem")[:count]:
            effects = root.find(".//filter")
            if exact:
                item.append(copy.deepcopy(effects))
            item.find("./filter/effect/parameter[parameterid='center']/value/horiz").text = "0.1"
        changes = read(made, ".xml", etree.tostring(root), tmp_path)
        assert (changes.cameras, changes.removed) == ((), ())
        told = f"{count} clip{'s' * (count > 1)} whose picture was moved, scaled or turned, the first at 0:00:00.0"
        assert changes.notes == (told,)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    etree.SubElement(root.find(".//spine/mc-clip/mc-source"), "adjust-transform", scale="2 2")
    assert read(made, ".fcpxml", etree.tostring(root), tmp_path).notes == ("adjust-transform of 'cam1' at frame 0",)


def test_shots_in_another_order_and_twice_are_named(tmp_path):
    made = film(Fraction(25), 90)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    spine = root.find(".//spine")
    spine.append(copy.deepcopy(spine[0]))
    spine[3].set("offset", rolled(made.cut().start_s + Fraction(90, 25)))
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert changes.notes[:2] == ("another order of the shots", "30 frames that are shown more than once")


@pytest.mark.parametrize(
    ("suffix", "text", "what"),
    [
        (".fcpxml", "<fcpxml", "is not XML"),
        (".fcpxml", "<xmeml/>", "is xmeml, not"),
        (".fcpxml", "<fcpxml/>", "no project"),
        (".fcpxml", '<!DOCTYPE a [<!ENTITY b "c">]><fcpxml>&b;</fcpxml>', "declares entities"),
        (".fcpxml", "<fcpxml><project><sequence format='r'><spine/></sequence></project></fcpxml>", "no format"),
        (".xml", "<xmeml/>", "no sequence"),
        (".xml", "<xmeml><sequence><rate><timebase>x</timebase></rate></sequence></xmeml>", "no whole number"),
        (".otio", "{}", "KeyError"),
        (".otio", '{"OTIO_SCHEMA": "Clip.2"}', "is a Clip"),
        (".otio", "[1, 2]", "is not an OpenTimelineIO document"),
        (".edl", "TITLE: x", "no events"),
        (".edl", "001  A  V  C  00:00:00:00 00:00:01:00 00:00:00:99 00:00:01:00", "no timecode"),
    ],
)
def test_what_is_no_document_is_refused(suffix, text, what, tmp_path):
    with pytest.raises(DocumentError, match=what):
        read(film(), suffix, text.encode(), tmp_path)


@pytest.mark.parametrize("suffix", FORMATS)
@given(data=st.data())
@settings(max_examples=60)
def test_a_damaged_document_is_refused_or_read_and_never_breaks_the_reader(suffix, folder, data):
    document = bytearray(FORMATS[suffix].write(film(Fraction(30000, 1001), 60).cut()))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(document) - 1))
        kind = data.draw(st.sampled_from(["cut", "swap", "digit", "word"]))
        if kind == "cut":
            del document[at : at + data.draw(st.integers(1, 200))]
        elif kind == "swap":
            document[at : at + 1] = data.draw(st.binary(min_size=1, max_size=2))
        elif kind == "digit":
            spots = [n for n, byte in enumerate(document) if 48 <= byte <= 57]
            if spots:
                document[data.draw(st.sampled_from(spots))] = data.draw(st.sampled_from(b"0159-.e"))
        else:
            word = data.draw(st.sampled_from([b"null", b"-1", b"1e999", b"", b"{}", b'"x"', b"99999999999999999999"]))
            document[at : at + len(word)] = word
        if not document:
            break
    with contextlib.suppress(McslError):
        read(film(Fraction(30000, 1001), 60), suffix, bytes(document), folder)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    for form in FORMATS.values():
        with pytest.raises(InputError, match="does not exist"):
            form.read(tmp_path / "none.fcpxml", Fraction(25))


def test_a_shot_list_of_thousands_is_compared_in_time_that_grows_with_it(tmp_path):
    """Cost: every clip is looked for among its camera's files only, every stretch painted once."""
    frames, length = 20_000, 10
    shots = tuple(Shot(R(n, n + length), ("cam1", "cam2", "cam3")[n // length % 3]) for n in range(0, frames, length))
    made = film(Fraction(25), frames, shots=shots)
    changes = read(made, ".xml", FORMATS[".xml"].write(made.cut()), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())
