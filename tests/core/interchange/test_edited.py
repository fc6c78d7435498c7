"""What editors write of edits that an EDL cannot hold: dissolves, speed changes, pictures at another rate."""

from __future__ import annotations

from fractions import Fraction

import pytest
from interchange_cuts import R, facts_of, film
from interchange_readers import by_lxml, by_otio, otio
from lxml import etree

from mcsl_core.edl import Override
from mcsl_core.errors import DocumentError
from mcsl_core.interchange.changes import find_changes
from mcsl_core.interchange.formats import FORMATS

RATE = Fraction(25)


def read(made, suffix, document, folder):
    """What is found changed in a document."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return find_changes(made.cut(), form.read(path, made.edl.rate), form.layout)


# -------------------------------------------------------------------------------------------------- dissolves


def dissolved(document, begin, end, alignment):
    """An xmeml document with a transition between the first two shots, as Premiere writes it."""
    root = by_lxml(document)
    track = root.findall("./sequence/media/video/track")[-1]
    first, second = track.findall("clipitem")[:2]
    first.find("end").text = second.find("start").text = "-1"
    cut, out = int(first.findtext("out")), 30
    first.find("out").text = str(cut + end - out)
    second.find("in").text = str(int(second.findtext("in")) + begin - out)
    item = etree.Element("transitionitem")
    for tag, text in (("start", begin), ("end", end), ("alignment", alignment)):
        if text is not None:
            etree.SubElement(item, tag).text = str(text)
    track.insert(1, item)
    return etree.tostring(root)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(
    ("begin", "end", "alignment"),
    [
        (24, 36, "center"),
        (25, 36, "center"),  # of odd length
        (25, 35, None),
        (30, 40, "start"),
        (30, 40, "start-black"),
        (20, 30, "end"),
        (20, 30, "end-black"),
    ],
)
def test_a_dissolve_leaves_the_cut_where_it_is(exact, begin, end, alignment, tmp_path):
    made = film(RATE, 90)
    document = dissolved(FORMATS[".xml"].write(made.cut(exact=exact)), begin, end, alignment)
    changes = read(made, ".xml", document, tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert changes.notes == (f"a transition at frame {begin}",)


def test_a_dissolve_at_a_moved_cut_moves_it_just_so(tmp_path):
    made = film(RATE, 90)
    document = dissolved(FORMATS[".xml"].write(made.cut()), 20, 32, "center")
    assert read(made, ".xml", document, tmp_path).cameras == ((R(26, 30), "cam2"),)


@pytest.mark.parametrize("two_lines", [False, True])
def test_the_cut_under_a_lists_dissolve_is_in_its_middle(two_lines, tmp_path):
    made = film(RATE, 90)
    lines = FORMATS[".edl"].write(made.cut(sound=None)).decode().splitlines()
    first, second = (next(n for n, line in enumerate(lines) if line.startswith(f"00{i}")) for i in (1, 2))
    lines[first] = "001  CAM1     V     C        00:00:00:00 00:00:01:00 01:00:00:00 01:00:01:00"
    into = "002  CAM2     V     D    010 00:00:01:00 00:00:02:10 01:00:01:00 01:00:02:10"
    lines[second] = into
    if two_lines:
        lines.insert(second, "002  CAM1     V     C        00:00:01:00 00:00:01:00 01:00:01:00 01:00:01:00")
        lines.insert(second + 1, "* FROM CLIP NAME: cam1")
    changes = read(made, ".edl", "\n".join(lines).encode(), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert changes.notes == ("the transition D of event 002",)


@pytest.mark.parametrize("to", [["* TO CLIP NAME: cam3"], ["* TO CLIP NAME: cam3", "* TO FILE: /x/2/cam3.mp4"]])
def test_of_a_lists_dissolve_that_names_both_clips_each_has_its_own(to, tmp_path):
    """As OpenTimelineIO and others write it: what goes in a line of no length, with what comes in the next."""
    made = film(RATE, 90)
    lines = FORMATS[".edl"].write(made.cut(sound=None)).decode().splitlines()
    second = next(n for n, line in enumerate(lines) if line.startswith("002"))
    after = next(n for n, line in enumerate(lines) if line.startswith("003"))
    lines[second:after] = [
        "002  CAM1     V     C        00:00:01:00 00:00:01:00 01:00:01:00 01:00:01:00",
        "002  CAM3     V     D    010 00:00:01:00 00:00:02:10 01:00:01:00 01:00:02:10",
        *("* FROM CLIP NAME: cam1", *to),
    ]
    first = next(n for n, line in enumerate(lines) if line.startswith("001"))
    lines[first] = "001  CAM1     V     C        00:00:00:00 00:00:01:00 01:00:00:00 01:00:01:00"
    changes = read(made, ".edl", "\n".join(lines).encode(), tmp_path)
    assert (changes.cameras, changes.removed) == (((R(30, 60), "cam3"),), ())
    assert changes.notes == ("the transition D of event 002",)


def test_an_event_that_ends_before_it_begins_is_refused_with_its_line(tmp_path):
    made = film(RATE, 90)
    text = FORMATS[".edl"].write(made.cut(sound=None)).decode()
    line = next(n for n, line in enumerate(text.splitlines(), start=1) if line.startswith("002"))
    swapped = text.replace("01:00:01:05 01:00:02:10", "01:00:02:10 01:00:01:05")
    assert swapped != text
    with pytest.raises(DocumentError, match=f"line {line}: begins as an event and is none"):
        read(made, ".edl", swapped.encode(), tmp_path)


def test_a_line_of_speed_that_says_the_usual_one_is_none(tmp_path):
    made = film(Fraction(30000, 1001), 90)
    text = (
        FORMATS[".edl"].write(made.cut()).decode().replace("002  CAM2", "002  CAM3").replace("1/cam2.mp4", "2/cam3.mp4")
    )
    text = text.replace("cam2", "cam3").replace("\n\n003", "\nM2   CAM3   029.97   00:00:01:00\n\n003")
    changes = read(made, ".edl", text.encode(), tmp_path)
    assert (changes.cameras, changes.removed) == (((R(30, 60), "cam3"),), ())


# ---------------------------------------------------------------------------------------------- speed changes


def sped(suffix, document):
    """The second clip of the document at half its speed: of another angle, so that there were something to decide."""
    if suffix == ".fcpxml":
        root = by_lxml(document)
        clip = root.findall(".//spine/mc-clip")[1]
        clip.find("mc-source").set("angleID", root.find(".//mc-angle[@name='cam3']").get("angleID"))
        etree.SubElement(clip, "timeMap")
        return etree.tostring(root)
    if suffix == ".xml":
        root = by_lxml(document)
        files = {f.findtext("name"): f.get("id") for f in root.iter("file") if f.find("name") is not None}
        item = root.findall("./sequence/media/video/track")[-1].findall("clipitem")[1]
        item.find("file").set("id", files["cam3.mp4"])
        effect = etree.SubElement(etree.SubElement(item, "filter"), "effect")
        etree.SubElement(effect, "name").text = "Time Remap"
        etree.SubElement(effect, "effectid").text = "timeremap"
        speed = etree.SubElement(effect, "parameter")
        etree.SubElement(speed, "parameterid").text = "speed"
        etree.SubElement(speed, "value").text = "50"
        return etree.tostring(root)
    if suffix == ".otio":
        timeline = by_otio(document)
        clip = timeline.video_tracks()[-1].find_clips()[1]
        clip.active_media_reference_key = "cam3"
        clip.effects.append(otio.schema.LinearTimeWarp("slow", time_scalar=0.5))
        return otio.adapters.write_to_string(timeline, "otio_json").encode()
    text = document.decode().replace("002  CAM2", "002  CAM3").replace("1/cam2.mp4", "2/cam3.mp4")
    return text.replace("\n\n003", "\nM2   CAM3   012.5   00:00:01:05\n\n003").encode()


@pytest.mark.parametrize("suffix", FORMATS)
def test_of_a_clip_at_another_speed_nothing_is_read_and_it_is_named(suffix, tmp_path):
    made = film(RATE, 90)
    changes = read(made, suffix, sped(suffix, FORMATS[suffix].write(made.cut(sound=None))), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert len(changes.notes) == 2
    assert changes.notes[1].startswith("frames [30, 60), in whose place")


def test_of_a_clip_played_faster_no_frame_is_removed(tmp_path):
    """Half as long at twice the speed: it ends with the shot, though its length reaches to the middle alone."""
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    _, second, third = root.findall(".//spine/mc-clip")
    second.set("duration", "15/25s")
    third.set("offset", f"{3600 * 25 + 45}/25s")
    etree.SubElement(second, "timeMap")
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())


def test_at_a_speed_of_a_hundred_percent_it_is_read(tmp_path):
    made = film(RATE, 90)
    document = sped(".xml", FORMATS[".xml"].write(made.cut())).replace(b"<value>50</value>", b"<value>100</value>")
    assert read(made, ".xml", document, tmp_path).cameras == ((R(30, 60), "cam3"),)


# ------------------------------------------------------------------------------------- pictures at another rate


@pytest.mark.parametrize("by", [-3, -2, -1, 1, 2, 3])
@pytest.mark.parametrize("rate", [Fraction(30000, 1001), Fraction(50), Fraction(60)])
def test_a_head_trimmed_by_a_frame_of_a_camera_of_another_rate(by, rate, tmp_path):
    files = {"cam2": [facts_of("1/cam2.mp4", rate, 400)]}
    made = film(RATE, 90, files=files, overrides=(Override(R(40, 70), camera="cam1"),))
    assert [shot.camera for shot in made.cut().shots] == ["cam1", "cam2", "cam1", "cam3"]
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    first, second = root.findall("./sequence/media/video/track")[-1].findall("clipitem")[:2]
    for item, tag, value in (
        (first, "end", 30 + by),
        (first, "out", 30 + by),
        (second, "start", 30 + by),
        (second, "in", int((30 + by) * rate / RATE)),
    ):
        item.find(tag).text = str(value)
    changes = read(made, ".xml", etree.tostring(root), tmp_path)
    expected = (R(30, 30 + by), "cam1") if by > 0 else (R(30 + by, 30), "cam2")
    assert (changes.cameras, changes.removed) == ((expected,), ())


# ------------------------------------------------------------------------------------------- pictures taken away


def test_a_multicam_clip_whose_picture_is_switched_off_is_named_and_decides_nothing(tmp_path):
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    for source in root.findall(".//spine/mc-clip")[1].findall("mc-source"):
        source.set("srcEnable", "none" if source.get("srcEnable") == "video" else "audio")
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert "a mc-clip 'cam2' at frame 30" in changes.notes


def test_a_shot_that_is_mixed_with_what_is_below_is_named(tmp_path):
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    item = root.findall("./sequence/media/video/track")[-1].findall("clipitem")[1]
    item.insert(3, etree.fromstring("<compositemode>screen</compositemode>"))
    changes = read(made, ".xml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed) == ((), ())
    assert changes.notes == ("'screen' of 'cam2' at frame 30",)
