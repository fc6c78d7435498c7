"""Render presets: the ones that come with mcsl are whole, and a wrong one is refused with the path to the fault."""

from __future__ import annotations

import json

import pytest

from mcsl_core.delivery import presets
from mcsl_core.errors import DocumentError, InputError, UsageError


def test_the_presets_of_the_house_load_and_say_what_they_are():
    assert presets.preset_names() == ["archive", "h264", "h265", "prores", "review"]
    for name in presets.preset_names():
        preset = presets.load_preset(name)
        assert preset.title
        assert preset.description.endswith(".")
    assert presets.load_preset("review").scale_percent == 50


def test_an_unknown_name_lists_those_there_are():
    with pytest.raises(UsageError, match=r"no preset 'h266'.*archive, h264, h265, prores, review"):
        presets.load_preset("h266")


def test_an_own_file_is_taken_by_its_path(tmp_path):
    value = json.loads((presets.presets_folder() / "review.json").read_text())
    value["scale_percent"] = 25
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(value))
    assert presets.load_preset(path).scale_percent == 25
    assert presets.load_preset(str(path)).scaled((1920, 1080)) == (480, 270)


def test_a_prores_profile_goes_with_prores_only(tmp_path):
    value = json.loads((presets.presets_folder() / "prores.json").read_text())
    value["blender"]["prores_profile"] = ""
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(value))
    with pytest.raises(DocumentError, match="prores_profile belongs to codec 'PRORES'"):
        presets.load_preset(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scale_percent": 0}, "scale_percent must lie in 1..100, got 0"),
        ({"scale_percent": "50"}, "expected a whole number"),
        ({"container": "avi"}, "container must be one of"),
        ({"container": "mkv"}, "blender.format must be 'MKV'"),
        ({"colour": True}, "colour"),
        ({"schema": "mcsl.preset/2"}, "schema is 'mcsl.preset/2'"),
        ({"blender": {"format": "MPEG4"}}, "codec"),
    ],
)
def test_a_wrong_preset_is_refused(tmp_path, change, message):
    value = json.loads((presets.presets_folder() / "review.json").read_text())
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({**value, **change}))
    with pytest.raises(DocumentError, match=message) as caught:
        presets.load_preset(path)
    assert str(path) in str(caught.value)


FILES = [
    {"stats": "/home/somebody/.profile"},
    {"passlogfile": "x.log"},
    {"x264-params": "keyint=12:dump-yuv=/home/somebody/.profile"},
    {"x264-params": "stats=x.log:pass=1"},
    {"x264_params": "DUMP_YUV=x"},
    {"x264opts": "qpfile=/etc/passwd"},
    {"x265-params": "csv=x.csv"},
    {"x265-params": "log-level=none: recon = x.yuv"},
    {"flags": "+global_header+pass1"},
]


@pytest.mark.parametrize("options", FILES, ids=str)
def test_a_preset_has_no_encoder_open_files(tmp_path, options):
    """x264 wrote its copy of the pictures over whatever a preset from elsewhere named."""
    value = json.loads((presets.presets_folder() / "h264.json").read_text())
    value["direct"]["options"] |= options
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(value))
    with pytest.raises(DocumentError, match=r"direct.*has an encoder open a file"):
        presets.load_preset(path)


def test_film_grain_is_a_number_in_av1(tmp_path):
    value = json.loads((presets.presets_folder() / "h264.json").read_text())
    value["direct"]["options"] |= {"svtav1-params": "film-grain=8:tune=0"}
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(value))
    assert presets.load_preset(path).direct.options["svtav1-params"] == "film-grain=8:tune=0"


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.json.*does not exist"):
        presets.load_preset(tmp_path / "none.json")


def test_delivered_sizes_are_even():
    assert presets.load_preset("review").scaled((1922, 1082)) == (960, 540)
    assert presets.load_preset("h264").scaled((1920, 1080)) == (1920, 1080)
