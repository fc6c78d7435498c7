"""The two commands from end to end, on films whose pictures tell their numbers."""

from __future__ import annotations

import json
import os
import sys
import wave
from fractions import Fraction
from pathlib import Path

import attrs
import av
import pytest
from click.testing import CliRunner
from coded_video import SIZE, read_number
from interchange_readers import by_fcp_adapter, by_lxml, by_otio, expanded, of_multicam, of_track, otio, seconds
from lxml import etree
from two_cameras import EXPECTED, FRAMES, make, shown, write_sources

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.delivery import chunk_keys
from mcsl_core.edl import Media, Override
from mcsl_core.errors import DocumentError, InputError, UsageError
from mcsl_core.interchange.export import ExportSettings, export
from mcsl_core.interchange.pull import pull
from mcsl_core.timing import FrameRange

R = FrameRange
LISTS = ("changed", "kept", "overruled", "removed", "brought_back", "not_read")
NOTHING = {"overrides": 0} | {name: [] for name in LISTS}
NAMES = ["films", "films ü 手術", "100% of it", "a#b?c&d", "it's (1)"]
if sys.platform != "win32":
    NAMES.append("C:\\films")


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sources")
    write_sources(folder)
    return folder


@pytest.fixture
def recording(sources: Path, tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """An EDL beside its films, in a folder of an odd name where one is asked for."""
    folder = tmp_path / getattr(request, "param", "films ü 100%")
    folder.mkdir()
    for name in ("a.mp4", "b.mp4"):
        os.link(sources / name, folder / name)
    edls.save(make(), folder / "edl.json")
    return folder


def run(*arguments: str | Path) -> dict:
    """The result of a command, as programs read it."""
    done = CliRunner().invoke(cli, ["--progress", "json", *map(str, arguments)], standalone_mode=False)
    if done.exception is not None:
        raise done.exception
    return json.loads(done.stdout.splitlines()[-1])["result"]


def pictures(shown_there: dict[int, tuple[str, Fraction]]) -> list[int]:
    """The numbers that the files' pictures tell, frame by frame, decoded by PyAV alone."""
    films: dict[str, list[int]] = {}
    for path, _ in shown_there.values():
        if path not in films:
            with av.open(path) as container:
                films[path] = [read_number(f.to_ndarray(format="gray")) for f in container.decode(video=0)]
    return [films[path][int(picture)] for _, (path, picture) in sorted(shown_there.items())]


@pytest.mark.parametrize("recording", NAMES, indirect=True)
def test_every_document_leads_to_the_right_pictures_of_the_right_files(recording):
    edl = recording / "edl.json"
    for suffix in ("otio", "xml", "fcpxml"):
        run("export", edl, "-o", recording / f"cut.{suffix}")
    read = [
        of_track(by_otio((recording / "cut.otio").read_bytes()).video_tracks()[-1]),
        of_track(by_fcp_adapter((recording / "cut.xml").read_bytes()).video_tracks()[-1]),
        of_multicam((recording / "cut.fcpxml").read_bytes()),
    ]
    for one in read:
        assert pictures(expanded(one)) == EXPECTED


def test_what_is_removed_is_not_in_the_document(recording):
    path = recording / "edl.json"
    edls.save(make(removed=(FrameRange(30, 60),)), path)
    export(path, recording / "cut.otio", ExportSettings())
    read = of_track(by_otio((recording / "cut.otio").read_bytes()).video_tracks()[-1])
    assert pictures(expanded(read)) == [*EXPECTED[:30], *EXPECTED[60:]]
    assert run("pull", recording / "cut.otio", "--edl", path) == NOTHING


def test_the_conformed_programme_is_one_video_and_one_sound(recording, monkeypatch):
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)
    edl, out = recording / "edl.json", recording / "cut.otio"
    with pytest.raises(InputError, match="holds 0 of the programme's 130 frames"):
        export(edl, out, ExportSettings(exact=True))
    assert not out.exists()
    run("conform", edl, "--quality", "draft")
    said = run("export", edl, "-o", out, "--exact")
    assert said["media"] == [str(recording / "cut.programme.mp4"), str(recording / "cut.programme.wav")]
    assert shown(recording / "cut.programme.mp4") == EXPECTED
    timeline = by_otio(out.read_bytes())
    assert pictures(expanded(of_track(timeline.video_tracks()[-1]))) == EXPECTED
    with wave.open(str(recording / "cut.programme.wav")) as sound:
        assert sound.getnframes() * 30 >= FRAMES * 48000
        parts = next((recording / "edl.conformed").glob("sound-*.wav"))
        with wave.open(str(parts)) as conformed:
            samples = conformed.readframes(1 << 30)
            assert sound.readframes(1 << 30)[: len(samples)] == samples
    run("export", edl, "-o", out, "--exact")  # what is ours is written again
    modes = {path.suffix: path.stat().st_mode & 0o777 for path in recording.glob("cut.programme.*")}
    assert modes[".wav"] == modes[".mp4"]  # who may see the pictures may hear them


def test_the_conformed_sound_is_called_after_its_camera(recording):
    edl, out = recording / "edl.json", recording / "cut.xml"
    edls.save(make(reference="b"), edl)
    run("conform", edl, "--audio", "a", "--quality", "draft")
    run("export", edl, "-o", out, "--exact", "--audio", "a")
    assert [item.findtext("name") for item in by_lxml(out.read_bytes()).findall(".//audio/track/clipitem")] == ["a"]


def test_a_document_that_is_called_after_another_format_is_told_what_it_is(recording):
    edl = recording / "edl.json"
    for suffix, wrong in (("xml", "otio"), ("otio", "fcpxml"), ("fcpxml", "edl"), ("edl", "xml")):
        run("export", edl, "-o", recording / f"cut.{suffix}")
        (recording / f"wrong.{wrong}").write_bytes((recording / f"cut.{suffix}").read_bytes())
        with pytest.raises(InputError, match=rf"wrong\.{wrong}: is .* by what it holds.*end in \.{suffix}$"):
            pull(recording / f"wrong.{wrong}", edl)


def test_what_was_decided_since_the_export_stays_and_is_told(recording):
    edl, out = recording / "edl.json", recording / "cut.fcpxml"
    run("export", edl, "-o", out)
    edls.save(make(overrides=(Override(R(60, 70), camera="a", note="the surgeon wants this"),)), edl)
    before = edl.read_bytes()
    done = CliRunner().invoke(cli, ["--progress", "lines", "pull", str(out), "--edl", str(edl)])
    assert "kept: frames [60, 70) (0:00:02.0 to 0:00:02.3) show a, which was decided" in done.output + done.stderr
    assert "0 changes, 1 override" in done.output
    assert edl.read_bytes() == before
    root = by_lxml(out.read_bytes())
    source = root.findall(".//spine/mc-clip")[1].find("mc-source")
    source.set("angleID", root.find(".//mc-angle[@name='a']").get("angleID"))
    (recording / "back.fcpxml").write_bytes(etree.tostring(root))
    said = run("pull", recording / "back.fcpxml", "--edl", edl)
    assert (said["changed"], said["kept"]) == ([[50, 60, "a"], [70, 130, "a"]], [])
    assert Override(R(60, 70), camera="a", note="the surgeon wants this") in edls.load(edl).overrides


def test_media_of_another_edl_are_told(recording):
    edl, out = recording / "edl.json", recording / "cut.otio"
    run("export", edl, "-o", out)
    out.write_text(out.read_text("utf-8").replace("a.mp4", "x.mp4").replace("b.mp4", "y.mp4"), "utf-8")
    with pytest.raises(InputError, match=r"cut\.otio: none of its clips is of this EDL's media\. Relink"):
        pull(out, edl)


def test_a_part_that_is_not_conformed_any_more_is_missed(recording, monkeypatch):
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)
    edl = recording / "edl.json"
    run("conform", edl)
    edls.save(make(overrides=(Override(R(70, 75), camera="a"),)), edl)
    with pytest.raises(InputError, match="holds 100 of the programme's 130 frames"):
        export(edl, recording / "cut.xml", ExportSettings(exact=True))


def test_an_angle_switched_and_pulled_is_an_override_and_pulled_again_is_nothing_new(recording):
    edl, out = recording / "edl.json", recording / "cut.otio"
    run("export", edl, "-o", out)
    before = edl.read_bytes()
    assert run("pull", out, "--edl", edl) == NOTHING
    assert edl.read_bytes() == before
    timeline = by_otio(out.read_bytes())
    timeline.video_tracks()[-1][1].active_media_reference_key = "a"
    otio.adapters.write_to_file(timeline, str(recording / "back.otio"))
    said = run("pull", recording / "back.otio", "--edl", edl, "-o", recording / "new.json")
    assert said["changed"] == [[50, 130, "a"]]
    assert edl.read_bytes() == before
    assert edls.load(recording / "new.json").overrides == (Override(R(50, 130), camera="a"),)
    for _ in range(2):
        run("pull", recording / "back.otio", "--edl", edl)
        assert edls.load(edl).overrides == (Override(R(50, 130), camera="a"),)
    pulled = edl.read_bytes()
    said = run("pull", out, "--edl", edl)  # exported before: it cannot tell who decided that
    assert (said["changed"], said["kept"]) == ([], [[50, 130, "a"]])
    assert edl.read_bytes() == pulled


def test_a_removed_range_is_told_by_frames_and_time_and_left_out_from_then_on(recording):
    edl, out = recording / "edl.json", recording / "cut.fcpxml"
    run("export", edl, "-o", out)
    before = edl.read_bytes()
    root = by_lxml(out.read_bytes())
    spine = root.find(".//spine")
    spine[1].set("offset", spine[0].get("offset"))
    spine.remove(spine[0])
    bundle = recording / "back.fcpxmld"
    bundle.mkdir()
    (bundle / "Info.fcpxml").write_bytes(etree.tostring(root))
    assert seconds(spine[0].get("offset")) == 3600
    done = CliRunner().invoke(cli, ["--progress", "lines", "pull", str(bundle), "--edl", str(edl)])
    assert "removed: frames [0, 50) (0:00:00.0 to 0:00:01.7) are left out" in done.output + done.stderr
    was, now = json.loads(before), json.loads(edl.read_bytes())
    assert now.pop("removed") == [[0, 50]]
    assert now == was
    after = edl.read_bytes()
    run("pull", bundle, "--edl", edl)  # once more
    assert edl.read_bytes() == after
    run("export", edl, "-o", out)
    run("pull", out, "--edl", edl)
    assert edl.read_bytes() == after
    run("remove", edl, "--bring-back")
    run("remove", edl, "--range", "50:130")
    with pytest.raises(DocumentError, match="shows nothing of the programme"):
        run("pull", bundle, "--edl", edl)


def test_a_document_of_another_analysis_or_rate_is_refused(recording):
    edl, out = recording / "edl.json", recording / "cut.xml"
    run("export", edl, "-o", out)
    other = {"a": "b", "b": "a"}
    edls.save(make(shots=tuple(attrs.evolve(shot, camera=other[shot.camera]) for shot in make().shots)), edl)
    with pytest.raises(InputError, match="exported from another analysis"):
        pull(out, edl)
    text = out.read_text("utf-8").replace("<timebase>30<", "<timebase>25<")
    (recording / "slow.xml").write_text(text, "utf-8")
    with pytest.raises(InputError, match="runs at 25 frames/s, the programme at 30"):
        pull(recording / "slow.xml", edl)


def test_nothing_is_written_over_that_is_not_ours(recording):
    edl = recording / "edl.json"
    out = recording / "cut.edl"
    out.write_text("somebody's")
    with pytest.raises(InputError, match="--force"):
        export(edl, out, ExportSettings())
    assert out.read_text() == "somebody's"
    export(edl, out, ExportSettings(force=True))
    assert out.read_text().startswith("TITLE: cut")
    with pytest.raises(InputError, match="never written over"):
        pull(out, edl, out, force=True)


@pytest.mark.parametrize(
    ("settings", "what"),
    [
        ({"start": "25:00:00:00"}, "no timecode"),
        ({"start": "01:00:00;00"}, "does not fit"),
        ({"audio": "c"}, "no camera 'c'"),
    ],
)
def test_a_wrong_wish_is_refused_before_anything_is_written(recording, settings, what):
    with pytest.raises(UsageError, match=what):
        export(recording / "edl.json", recording / "cut.otio", ExportSettings(**settings))
    assert not (recording / "cut.otio").exists()


def test_a_name_of_no_format_is_refused(recording):
    with pytest.raises(UsageError, match="no editor's format"):
        export(recording / "edl.json", recording / "cut.aaf", ExportSettings())


def test_pull_asks_for_the_edl_and_knows_whose_options_are_whose(recording):
    out = recording / "cut.otio"
    run("export", recording / "edl.json", "-o", out)
    for arguments in (
        ["pull", out],
        ["pull", out, "--edl", recording / "edl.json", "--blender", "x"],
        ["pull", recording / "edit.blend", "--edl", recording / "edl.json"],
    ):
        done = CliRunner().invoke(cli, list(map(str, arguments)), standalone_mode=False)
        assert isinstance(done.exception, UsageError)


def test_media_of_another_length_than_the_edl_says_are_taken_as_they_are(recording):
    """An asset is as long as its file, whatever a document says."""
    edl = make()
    cameras = tuple(attrs.evolve(c, media=(Media(c.media[0].path, 9),)) for c in edl.cameras)
    edls.save(attrs.evolve(edl, cameras=cameras), recording / "edl.json")
    out = recording / "cut.fcpxml"
    export(recording / "edl.json", out, ExportSettings())
    root = by_lxml(out.read_bytes())
    assert {seconds(asset.get("duration")) for asset in root.iter("asset")} == {Fraction(FRAMES, 30)}
    formats = {(form.get("width"), form.get("height")) for form in root.iter("format")}
    assert formats == {tuple(map(str, SIZE))}
