"""Documents that would cost a reader its stack, its numbers or its time, and those that are none of this EDL's."""

from __future__ import annotations

import json
import re
from fractions import Fraction

import pytest
from interchange_cuts import film
from interchange_readers import by_lxml
from lxml import etree

from mcsl_core.errors import DocumentError
from mcsl_core.interchange.changes import find_changes
from mcsl_core.interchange.formats import FORMATS, format_within

MADE = film(Fraction(25), 90)


def read(suffix, document, folder):
    """What is found changed in a document."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return find_changes(MADE.cut(), form.read(path, MADE.edl.rate), form.layout)


@pytest.mark.parametrize("depth", [300, 3000, 100_000])
def test_what_is_nested_deeply_is_refused(depth, tmp_path):
    before, after = FORMATS[".fcpxml"].write(MADE.cut()).split(b"<spine>")
    clip = b'<mc-clip lane="1" ref="m1" offset="3600s" start="3600s" duration="1s" name="cam1">'
    with pytest.raises(DocumentError, match="nested more than 100 deep"):
        read(".fcpxml", before + b"<spine>" + clip * depth + b"</mc-clip>" * depth + after, tmp_path)
    media = b"<media>" * depth + b"</media>" * depth
    document = FORMATS[".xml"].write(MADE.cut()).replace(b"<video>", media + b"<video>")
    with pytest.raises(DocumentError, match="nested more than 100 deep"):
        read(".xml", document, tmp_path)


@pytest.mark.parametrize("number", ["1099511627776", "9" * 18, "-" + "9" * 18])
@pytest.mark.parametrize("tag", ["end", "in", "start"])
def test_numbers_that_no_programme_reaches_in_xmeml(number, tag, tmp_path):
    document = FORMATS[".xml"].write(MADE.cut()).decode()
    document = re.sub(rf"<{tag}>\d+</{tag}>", f"<{tag}>{number}</{tag}>", document)
    with pytest.raises(DocumentError, match="more than 1099511627776"):
        read(".xml", document.encode(), tmp_path)


@pytest.mark.parametrize("text", ["99999999999999999999s", "1099511627776s", "43980465111040s", "99999999999/1s"])
@pytest.mark.parametrize("name", ["duration", "start", "offset"])
def test_times_that_no_programme_reaches_in_fcpxml(text, name, tmp_path):
    root = by_lxml(FORMATS[".fcpxml"].write(MADE.cut()))
    root.find(".//spine/mc-clip").set(name, text)
    with pytest.raises(DocumentError, match="more than 1099511627776"):
        read(".fcpxml", etree.tostring(root), tmp_path)


@pytest.mark.parametrize("value", ["1e9999999", "5", True, None, [], 1e300, 1 << 70, float("inf"), float("nan")])
@pytest.mark.parametrize("of", ["value", "rate"])
@pytest.mark.parametrize("where", ["start_time", "duration"])
def test_times_that_are_no_numbers_in_otio(value, of, where, tmp_path):
    document = json.loads(FORMATS[".otio"].write(MADE.cut()))
    clip = next(child for child in document["tracks"]["children"][-2]["children"] if child["name"] == "cam1")
    clip["source_range"][where][of] = value
    with pytest.raises(DocumentError):
        read(".otio", json.dumps(document).encode(), tmp_path)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_document_of_other_media_is_refused_and_not_read_as_removed(suffix, tmp_path):
    other = film(Fraction(25), 90, names=("left", "middle", "right"))
    with pytest.raises(DocumentError, match="none of its clips is of this EDL's media"):
        read(suffix, FORMATS[suffix].write(other.cut(sound=None)), tmp_path)


def test_of_several_sequences_the_first_is_named(tmp_path):
    document = FORMATS[".xml"].write(MADE.cut()).decode()
    one = document[document.index("<sequence") : document.index("</xmeml>")]
    second = one.replace("<name>cut</name>", "<name>titles</name>")
    children = f"<project><children>{one}{second}</children></project>"
    changes = read(".xml", document.replace(one, children).encode(), tmp_path)
    assert changes.notes == ("of 2 sequences the first is read, 'cut', not 'titles'",)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_format_is_known_by_what_it_holds(suffix, tmp_path):
    path = tmp_path / "cut"
    path.write_bytes(FORMATS[suffix].write(MADE.cut()))
    assert format_within(path) is FORMATS[suffix]
    path.write_bytes(b"{}")
    assert format_within(path) is None
    assert format_within(tmp_path) is None
