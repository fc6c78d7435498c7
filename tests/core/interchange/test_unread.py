"""Compound clips, nests, titles and whatever else is not read, in a shot's place or above it, and clips disabled."""

from __future__ import annotations

import copy
from fractions import Fraction

import attrs
import pytest
from interchange_cuts import R, facts_of, film
from interchange_readers import by_lxml, by_otio, otio
from lxml import etree

from mcsl_core.errors import DocumentError
from mcsl_core.interchange.changes import find_changes
from mcsl_core.interchange.formats import FORMATS

RATE = Fraction(25)
SHOTS = (R(0, 30), R(30, 60), R(60, 90))  # of cam1, cam2, cam3
FCPXML_KINDS = ("ref-clip", "sync-clip", "title", "audition", "clip", "video", "ref-clip without duration")
XMEML_KINDS = ("sequence", "multiclip", "generatoritem")
OTIO_KINDS = ("Stack", "Track", "no length", "MissingReference", "GeneratorReference", "other")
CMX_KINDS = ("AX", "BL", "TITLE")
KINDS = [
    *((".fcpxml", kind) for kind in FCPXML_KINDS),
    *((".xml", kind) for kind in XMEML_KINDS),
    *((".otio", kind) for kind in OTIO_KINDS),
    *((".edl", kind) for kind in CMX_KINDS),
]


def read(made, suffix, document, folder):
    """What is found changed in a document."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return find_changes(made.cut(), form.read(path, made.edl.rate), form.layout)


def written(timeline):
    return otio.adapters.write_to_string(timeline, "otio_json").encode()


# ----------------------------------------------------------------------------------------- what stands for a shot


def fcpxml_item(root, clip, kind):
    """The clip put into something, as Final Cut does it."""
    attributes = {name: clip.get(name) for name in ("offset", "duration")} | {"name": "mine"}
    if kind == "audition":
        item = etree.Element("audition")
        item.append(clip)
        return item
    if kind.startswith("ref-clip"):
        media = etree.SubElement(root.find("resources"), "media", id="r90", name="mine")
        inner = etree.SubElement(media, "sequence", format="f1", duration=clip.get("duration"), tcStart="0s")
        etree.SubElement(inner, "spine").append(copy.deepcopy(clip))
        item = etree.Element("ref-clip", ref="r90", **attributes)
        if kind != "ref-clip":
            del item.attrib["duration"]
        return item
    if kind in ("title", "video"):
        etree.SubElement(root.find("resources"), "effect", id="r90", name="Custom", uid="x")
        return etree.Element(kind, ref="r90", start="3600s", **attributes)
    item = etree.Element(kind, **attributes)
    if kind == "clip":
        item.set("name", "cam3")  # called as a camera, it is none of its files
    etree.SubElement(item, "spine").append(copy.deepcopy(clip))
    return item


def xmeml_item(clip, kind):
    if kind == "generatoritem":
        item = etree.Element("generatoritem", id="x")
        for child in ("name", "duration", "rate", "start", "end", "in", "out"):
            item.append(copy.deepcopy(clip.find(child)))
        return item
    item = copy.deepcopy(clip)
    item.remove(item.find("file"))
    inner = etree.SubElement(item, kind, id="x")
    etree.SubElement(inner, "name").text = "nest"
    return item


def otio_item(clip, kind):
    span = copy.deepcopy(clip.source_range)
    if kind in ("Stack", "Track", "no length"):
        made = otio.schema.Stack if kind == "no length" else getattr(otio.schema, kind)
        return made("mine", [copy.deepcopy(clip)], None if kind == "no length" else span)
    if kind == "other":
        return otio.schema.Clip("mine", otio.schema.ExternalReference("file:///mine.mov", span), span)
    return otio.schema.Clip("cam3", getattr(otio.schema, kind)(), span)


def replaced(suffix, document, kind, at=1):
    """The document with something unreadable in the place of shot ``at``."""
    if suffix == ".fcpxml":
        root = by_lxml(document)
        spine = root.find(".//project/sequence/spine")
        clip = spine[at]
        spine.insert(at, fcpxml_item(root, clip, kind))
        if clip.getparent() is spine:
            spine.remove(clip)
        return etree.tostring(root)
    if suffix == ".xml":
        root = by_lxml(document)
        track = root.findall("./sequence/media/video/track")[-1]
        clip = track.findall("clipitem")[at]
        track.replace(clip, xmeml_item(clip, kind))
        return etree.tostring(root)
    if suffix == ".otio":
        timeline = by_otio(document)
        track = timeline.video_tracks()[-1]
        track[at] = otio_item(track[at], kind)
        return written(timeline)
    lines = document.decode().splitlines()
    event = [n for n, line in enumerate(lines) if line[:1].isdigit() and " V " in line][at]
    lines[event] = f"{lines[event][:5]}{kind:<8}{lines[event][13:]}"
    lines[event + 1 : event + 3] = ["* FROM CLIP NAME: mine"]
    return "\n".join(lines).encode()


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(("suffix", "kind"), KINDS)
def test_in_a_shots_place_it_is_named_and_the_edl_keeps_what_it_decided(suffix, kind, exact, tmp_path):
    made = film(RATE, 90)
    for at, piece in enumerate(SHOTS):
        document = replaced(suffix, FORMATS[suffix].write(made.cut(exact=exact, sound=None)), kind, at)
        changes = read(made, suffix, document, tmp_path)
        assert (changes.cameras, changes.removed, changes.brought_back) == ((), (), ())
        named, *sound, kept = changes.notes
        with_it = ["the conformed sound is not heard at frames [30, 90)"]  # it hung on the first shot
        assert sound == (with_it if suffix == ".fcpxml" and exact and at == 0 else [])
        assert "mine" in named or "cam" in named or kind == "audition"
        assert str(piece.start) in named
        assert kept == f"frames {piece}, in whose place lies what is not read: they stay as the EDL has them"


@pytest.mark.parametrize(("suffix", "kind"), [(".fcpxml", "ref-clip"), (".xml", "sequence"), (".otio", "Stack")])
def test_all_in_one_compound_clip_is_refused_with_what_to_do(suffix, kind, tmp_path):
    made = film(RATE, 90, names=("cam1", "cam2"))
    document = FORMATS[suffix].write(made.cut(sound=None))
    if suffix == ".xml":  # nesting takes the tracks of the cameras with it
        root = by_lxml(document)
        for track in root.findall("./sequence/media/video/track")[:-1]:
            track.getparent().remove(track)
        document = etree.tostring(root)
    if suffix == ".otio":
        timeline = by_otio(document)
        del timeline.tracks[0:2]
        document = written(timeline)
    for at in (0, 1):
        document = replaced(suffix, document, kind, at)
    with pytest.raises(DocumentError, match="none of its clips") as refused:
        read(made, suffix, document, tmp_path)
    assert "Take nested and compound clips apart" in str(refused.value)


def test_beside_what_is_not_read_changes_are(tmp_path):
    """A compound clip for the first shot, another angle for the second, and the third deleted."""
    made = film(RATE, 90)
    root = by_lxml(replaced(".fcpxml", FORMATS[".fcpxml"].write(made.cut()), "ref-clip", at=0))
    spine = root.find(".//project/sequence/spine")
    spine[1].find("mc-source").set("angleID", root.find(".//mc-angle[@name='cam3']").get("angleID"))
    spine.remove(spine[2])
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed) == (((R(30, 60), "cam3"),), (R(60, 90),))


def test_a_list_without_pictures_or_with_a_broken_event_is_refused(tmp_path):
    made = film(RATE, 90)
    document = FORMATS[".edl"].write(made.cut(sound=None)).decode()
    with pytest.raises(DocumentError, match="none of its clips"):
        read(made, ".edl", document.replace(" V ", " A ").encode(), tmp_path)
    with pytest.raises(DocumentError, match="begins as an event") as refused:
        read(made, ".edl", document.replace("002  CAM2     V", "002  V").encode(), tmp_path)
    assert "line 11" in str(refused.value)


def test_events_with_sound_and_pictures_on_further_tracks_are_pictures(tmp_path):
    made = film(RATE, 90)
    document = FORMATS[".edl"].write(made.cut(sound=None)).decode()
    for channel in ("B  ", "AA/V", "A2/V", "V1 ", "VA1"):
        changes = read(made, ".edl", document.replace("V     ", f"{channel:<6}").encode(), tmp_path)
        assert (changes.cameras, changes.removed) == ((), ())


# ------------------------------------------------------------------------------------------------- laid over shots


def laid_over(suffix, document, start, stop):
    """A title on a track of its own, or connected, above programme frames that nothing was removed of."""
    if suffix == ".fcpxml":
        root = by_lxml(document)
        etree.SubElement(root.find("resources"), "effect", id="r90", name="Custom", uid="x")
        clip = root.find(".//project/sequence/spine")[0]
        offset = Fraction(clip.get("start").rstrip("s")) + Fraction(start, 25)
        title = etree.Element("title", ref="r90", lane="1", offset=f"{offset}s", name="mine")
        title.set("duration", f"{stop - start}/25s")
        clip.insert(1, title)
        return etree.tostring(root)
    if suffix == ".xml":
        root = by_lxml(document)
        track = etree.SubElement(root.find("./sequence/media/video"), "track")
        item = etree.SubElement(track, "generatoritem", id="x")
        for tag, text in (("name", "mine"), ("start", start), ("end", stop)):
            etree.SubElement(item, tag).text = str(text)
        return etree.tostring(root)
    timeline = by_otio(document)
    of = otio.opentime
    gap = otio.schema.Gap(source_range=of.TimeRange(of.RationalTime(0, 25), of.RationalTime(start, 25)))
    span = of.TimeRange(of.RationalTime(0, 25), of.RationalTime(stop - start, 25))
    title = otio.schema.Clip("mine", otio.schema.GeneratorReference(), span)
    timeline.tracks.append(otio.schema.Track("titles", [gap, title]))
    return written(timeline)


def switched(suffix, document):
    """The second shot disabled; of a multicam clip another angle, as nothing is below."""
    if suffix == ".fcpxml":
        root = by_lxml(document)
        angle = root.find(".//mc-angle[@name='cam1']").get("angleID")
        root.findall(".//project/sequence/spine/mc-clip")[1].find("mc-source").set("angleID", angle)
        return etree.tostring(root)
    if suffix == ".xml":
        root = by_lxml(document)
        clip = root.findall("./sequence/media/video/track")[-1].findall("clipitem")[1]
        clip.find("enabled").text = "FALSE"
        return etree.tostring(root)
    timeline = by_otio(document)
    timeline.video_tracks()[-1][1].enabled = False
    return written(timeline)


@pytest.mark.parametrize("suffix", [".fcpxml", ".xml", ".otio"])
@pytest.mark.parametrize(("start", "stop"), [(0, 90), (10, 55), (5, 20), (15, 80)])
def test_a_title_over_shots_hides_no_change_of_camera_below(suffix, start, stop, tmp_path):
    """A watermark over everything among them."""
    made = film(RATE, 90)
    document = switched(suffix, FORMATS[suffix].write(made.cut(sound=None)))
    changes = read(made, suffix, laid_over(suffix, document, start, stop), tmp_path)
    assert (changes.cameras, changes.removed) == (((R(30, 60), "cam1"),), ())
    assert len(changes.notes) == 1
    assert "mine" in changes.notes[0]


@pytest.mark.parametrize("suffix", [".xml", ".otio"])
def test_a_nest_above_the_hole_that_its_shot_left_hides_the_camera_below(suffix, tmp_path):
    made = film(RATE, 90)
    document = switched(suffix, FORMATS[suffix].write(made.cut(sound=None)))
    changes = read(made, suffix, laid_over(suffix, document, 28, 61), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert any("frames [30, 60), in whose place" in note for note in changes.notes)


def test_with_all_shots_nested_in_one_the_cameras_below_are_not_read(tmp_path):
    made = film(RATE, 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut(sound=None)))
    timeline.tracks[3] = otio.schema.Stack("nest", [copy.deepcopy(timeline.tracks[3])])
    root = by_lxml(FORMATS[".xml"].write(made.cut(sound=None)))
    track = root.findall("./sequence/media/video/track")[-1]
    nest = xmeml_item(track.find("clipitem"), "sequence")
    nest.find("end").text = "90"
    for item in track.findall("clipitem"):
        track.remove(item)
    track.append(nest)
    for suffix, document in ((".otio", written(timeline)), (".xml", etree.tostring(root))):
        changes = read(made, suffix, document, tmp_path)
        assert (changes.cameras, changes.removed) == ((), ())
        assert changes.notes[1].startswith("frames [0, 90), in whose place")


def test_what_is_said_of_clips_and_tracks_as_a_whole_is_named(tmp_path):
    made = film(RATE, 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    track = timeline.video_tracks()[-1]
    one = otio.opentime.TimeRange(duration=otio.opentime.RationalTime(1, 25))
    track[1].markers.append(otio.schema.Marker("look", one))
    track.effects.append(otio.schema.Effect("soft", "Blur"))
    timeline.tracks.source_range = otio.opentime.TimeRange(duration=otio.opentime.RationalTime(50, 25))
    expected = (
        "the marker 'look' of 'cam2' at frame 30",
        "what 'tracks' is trimmed to as a whole",
        "'Blur' of all of 'Programme'",
    )
    assert read(made, ".otio", written(timeline), tmp_path).notes == expected
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    item = root.findall("./sequence/media/video/track")[-1].findall("clipitem")[1]
    etree.SubElement(etree.SubElement(item, "marker"), "name").text = "look"
    assert read(made, ".xml", etree.tostring(root), tmp_path).notes == expected[:1]


def test_what_is_cut_out_under_a_watermark_is_removed(tmp_path):
    made = film(RATE, 90)
    document = laid_over(".fcpxml", FORMATS[".fcpxml"].write(made.cut()), 0, 90)
    root = by_lxml(document)
    spine = root.find(".//project/sequence/spine")
    spine.remove(spine[1])
    spine[1].set("offset", f"{3600 * 25 + 30}/25s")
    assert read(made, ".fcpxml", etree.tostring(root), tmp_path).removed == (R(30, 60),)


# ------------------------------------------------------------------------------------------------------- disabled


def disabled(suffix, document):
    if suffix == ".fcpxml":
        root = by_lxml(document)
        root.find(".//project/sequence/spine")[1].set("enabled", "0")
        return etree.tostring(root)
    return switched(suffix, document)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("suffix", [".fcpxml", ".xml", ".otio"])
def test_a_disabled_clip_shows_what_lies_below_and_with_nothing_below_it_is_removed(suffix, exact, tmp_path):
    files = {"cam3": [facts_of("2/cam3.mp4", RATE, 90)]}
    made = film(RATE, 90, files=files)
    document = disabled(suffix, FORMATS[suffix].write(made.cut(exact=exact, sound=None)))
    changes = read(made, suffix, document, tmp_path)
    if suffix == ".fcpxml":  # the multicam clip below a conformed one shows the same camera until it is switched
        assert (changes.cameras, changes.removed) == ((), () if exact else (R(30, 60),))
        return
    assert (changes.cameras, changes.removed) == (((R(30, 60), "cam1"),), ())  # the reference camera lies highest
    for _ in range(3):  # track by track, from the reference camera down
        document = without_track(suffix, document)
    changes = read(made, suffix, document, tmp_path)
    assert (changes.cameras, changes.removed) == ((), (R(30, 60),))


def without_track(suffix, document):
    """The document with the first track of a camera that is still shown switched off."""
    if suffix == ".xml":
        root = by_lxml(document)
        tracks = root.findall("./sequence/media/video/track")[:-1]
        next(t for t in tracks if t.find("enabled").text == "TRUE").find("enabled").text = "FALSE"
        return etree.tostring(root)
    timeline = by_otio(document)
    next(track for track in timeline.video_tracks() if track.enabled).enabled = False
    return written(timeline)


def test_what_is_disabled_and_not_read_hides_nothing(tmp_path):
    made = film(RATE, 90)
    document = replaced(".fcpxml", FORMATS[".fcpxml"].write(made.cut()), "ref-clip")
    root = by_lxml(document)
    root.find(".//project/sequence/spine/ref-clip").set("enabled", "0")
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed) == ((), (R(30, 60),))


def test_with_a_seam_beside_it_what_was_removed_before_stays_so(tmp_path):
    made = film(RATE, 90)
    made = attrs.evolve(made, edl=attrs.evolve(made.edl, removed=(R(30, 40),)))
    for suffix, kind in ((".fcpxml", "ref-clip"), (".xml", "sequence"), (".otio", "Stack"), (".edl", "AX")):
        document = replaced(suffix, FORMATS[suffix].write(made.cut(sound=None)), kind)
        changes = read(made, suffix, document, tmp_path)
        assert (changes.cameras, changes.removed, changes.brought_back) == ((), (), ())
        assert changes.notes[1].startswith("frames [40, 60), in whose place")
