"""Conform and render with hardware asked for: the same media, and a word where the processor does the work."""

import json

import av
import pytest
from click.testing import CliRunner
from two_cameras import EXPECTED, make, shown

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.delivery.presets import load_preset, presets_folder
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl.edits import rebased
from mcsl_core.errors import DocumentError, UsageError


def run(*arguments):
    done = CliRunner().invoke(cli, ["--progress", "json", *map(str, arguments)], standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_the_same_chunks_and_pictures_whatever_decodes(sources, tmp_path):
    edl = tmp_path / "edl.json"
    edls.save(rebased(make(), sources, tmp_path), edl)
    plain = run("conform", edl, "-o", tmp_path / "plain", "--allow-outside")
    asked = run("conform", edl, "-o", tmp_path / "asked", "--hwaccel", "auto")
    names = [{path.name: path.read_bytes() for path in (tmp_path / n).glob("*.mp4")} for n in ("plain", "asked")]
    assert names[0].keys() == names[1].keys()
    assert names[0] == names[1]
    assert not any("hardware" in str(line) for line in plain)
    assert len(asked) >= len(plain)
    run("render", edl, "-o", tmp_path / "out.mp4", "--engine", "direct", "--hwaccel", "cuda")
    assert shown(tmp_path / "out.mp4") == EXPECTED


def test_hardware_of_no_such_name_is_refused(sources):
    with pytest.raises(UsageError, match="no decoding hardware called 'magic'"):
        ProgrammeSource(make(), sources, hwaccel="magic")


@pytest.fixture
def edl(sources, tmp_path):
    path = tmp_path / "edl.json"
    edls.save(rebased(make(), sources, tmp_path), path)
    return path


def own_preset(folder, hardware):
    value = json.loads((presets_folder() / "h264.json").read_text())
    value["direct"]["hardware"] = hardware
    path = folder / "own.json"
    path.write_text(json.dumps(value))
    return path


def rendered(edl, out, preset, *options):
    """The video's encoder, and what was told of encoding."""
    said = run("render", edl, "-o", out, "--engine", "direct", "--preset", preset, "--allow-outside", *options)
    with av.open(str(out)) as video:
        name = video.streams.video[0].codec_context.name
    return name, [line["note"] for line in said if "encode" in line.get("note", "")]


def test_the_first_encoder_of_the_machine_that_works_is_taken(edl, tmp_path):
    """mpeg4 stands for one: nothing but trying tells hardware that works from hardware that does not."""
    preset = own_preset(tmp_path, {"h264_magic": {}, "mpeg4": {"no_such": "option"}, "mpeg2video": {"b": "9000000"}})
    assert rendered(edl, tmp_path / "plain.mp4", preset) == ("h264", [])
    found = rendered(edl, tmp_path / "asked.mp4", preset, "--hwaccel", "auto")
    assert found == ("mpeg2video", ["hardware (mpeg2video) encodes the video"])


def test_where_no_encoder_of_the_machine_works_the_processor_writes_the_same(edl, tmp_path):
    preset = own_preset(tmp_path, {"h264_magic": {}, "mpeg2video": {"b": "9000000"}})
    rendered(edl, tmp_path / "plain.mp4", preset)
    name, told = rendered(edl, tmp_path / "asked.mp4", preset, "--hwaccel", "cuda")
    assert name == "h264"
    assert told == ["no hardware (cuda) here encodes this preset; libx264 does, on the processor"]
    assert (tmp_path / "asked.mp4").read_bytes() == (tmp_path / "plain.mp4").read_bytes()


@pytest.mark.parametrize("name", ["h264", "h265", "review"])
def test_the_house_s_presets_render_with_and_without_such_hardware(edl, tmp_path, name):
    codec, told = rendered(edl, tmp_path / "asked.mp4", name, "--hwaccel", "auto")
    assert codec == ("hevc" if name == "h265" else "h264")
    assert len(told) == 1


def test_an_encoder_of_the_machine_opens_no_file_either(tmp_path):
    with pytest.raises(DocumentError, match="has an encoder open a file"):
        load_preset(own_preset(tmp_path, {"h264_nvenc": {"passlogfile": "over/there"}}))
