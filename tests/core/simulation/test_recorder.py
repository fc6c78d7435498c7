"""Unkind recordings of a simulated lamp show, hear and measure as the kind one does."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from av.video.frame import PictureType
from click.testing import CliRunner

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.errors import UsageError
from mcsl_core.recording.footage import footage_of
from mcsl_core.simulation import Recorder, Scenario, alignment_error, load_truth
from mcsl_core.simulation.clocks import Clock
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.scene import Scene

SCENE = "--seed 4 --duration 4.5 --size 320x180 --rate 25 --cameras 2 --movements 0"
LARGER = "--seed 4 --duration 8 --size 480x272 --rate 25 --cameras 3 --movements 0"
KINDS = {
    "interlaced": ["--interlaced"],
    "hlg": ["--hdr", "hlg"],
    "pq": ["--hdr", "pq"],
    "vfr": ["--vfr"],
    "split": ["--split", "1.5"],
    "continuing": ["--split", "1.5", "--continuing-clock"],
    "worst": ["--interlaced", "--vfr", "--split", "2", "--continuing-clock"],
}


def run(*arguments) -> None:
    result = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Kind -> its folder; made when asked for."""
    made: dict[str, Path] = {}

    def recording(kind: str, scene: str = SCENE) -> Path:
        if kind + scene not in made:
            folder = made[kind + scene] = tmp_path_factory.mktemp(kind) / "recording"
            run("simulate", folder, *scene.split(), *KINDS.get(kind, []))
        return made[kind + scene]

    return recording


def decoded(folder: Path, camera: str):
    """(time, luma, frame) of a camera's pictures, its parts one after another, by PyAV alone."""
    begin = Fraction(0)
    for part in sorted(folder.glob(f"{camera}[._]*")):
        with av.open(str(part)) as container:
            frames: list[Any] = list(container.decode(video=0))
        times = [frame.pts * frame.time_base - frames[0].pts * frame.time_base for frame in frames]
        yield from ((begin + time, frame) for time, frame in zip(times, frames, strict=True))
        begin += times[-1] + Fraction(1, 25)


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_are_as_ordered_and_hold_the_same_moments(recordings, kind):
    plain, folder = recordings("plain"), recordings(kind)
    kinds = KINDS[kind]
    with np.load(plain / "truth.npz") as a, np.load(folder / "truth.npz") as b:
        assert all(np.array_equal(a[name], b[name]) for name in a.files)
    truth = load_truth(folder)
    assert (truth.clocks, truth.frames) == (load_truth(plain).clocks, load_truth(plain).frames)
    assert all((folder / file).is_file() for file in truth.files)
    assert len(list(folder.glob("cam1*"))) == {"split": 3, "continuing": 3, "worst": 2}.get(kind, 1)
    shown = list(decoded(folder, "cam2"))
    times = [round(float(time * 25), 1) for time, _ in shown]
    assert times[0] == 0
    if "--vfr" in kinds:
        assert 0.6 * truth.camera_frames[1] < len(times) < 0.9 * truth.camera_frames[1]
    else:
        assert times == list(range(truth.camera_frames[1]))
    assert shown[5][1].interlaced_frame == ("--interlaced" in kinds)
    assert shown[5][1].color_trc == ({"hlg": 18, "pq": 16}.get(kind, 1))


@pytest.fixture(scope="module")
def delivered(recordings, tmp_path_factory):
    """Kind -> its EDL, offsets, errors against the truth, some pictures of a camera and the folder; made when asked."""
    made: dict[str, Any] = {}

    def deliver(kind: str):
        if kind not in made:
            folder, edl_path = recordings(kind, LARGER), tmp_path_factory.mktemp(kind) / "edl.json"
            run("analyse", folder, "-o", edl_path, "--rate", "25")
            run("conform", edl_path)
            edl, truth = edls.load(edl_path), load_truth(folder)
            offsets = np.array([camera.clock.offset_s for camera in edl.cameras])
            errors = [
                alignment_error(truth, 0, camera.name, np.array(edl.poses[0].homographies[camera.name]))
                for camera in edl.cameras
            ]
            pictures = [p for _, p in footage_of(edl, edl_path.parent).pictures("cam2", [20, 60, 130, 180])]
            made[kind] = edl, offsets, errors, pictures, edl_path.parent
        return made[kind]

    return deliver


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["interlaced", "pq", "worst"])  # the last is all the others at once
def test_analysed_and_conformed_it_is_as_the_plain_one(delivered, kind):
    """Where the cameras stand against the truth, and the programme's pictures against the plain one's."""
    plain, plain_offsets, plain_errors, plain_pictures, _ = delivered("plain")
    edl, offsets, errors, pictures, folder = delivered(kind)
    assert edl.frames == plain.frames
    assert np.abs(offsets - plain_offsets).max() < 0.02  # eight seconds of sound do not tell the true ones
    assert max(errors) < 1.25 * max(plain_errors) + 0.5
    for picture, other in zip(pictures, plain_pictures, strict=True):
        assert np.abs(picture.mean((0, 1)) - other.mean((0, 1))).max() < 4
        assert np.abs(picture.astype(int) - other).mean() < 5
    conformed = sorted(folder.glob("**/*.mp4"))
    assert conformed
    with av.open(str(conformed[0])) as container:
        frames = [frame.interlaced_frame for frame in container.decode(video=0)]
    assert len(frames) == edl.frames
    assert not any(frames)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"interlaced": True, "hdr": "pq"}, "not both"),
        ({"continuing_clock": True}, "split_s"),
        ({"split_s": 0.1}, "half a second"),
        ({"split_s": float("nan")}, "half a second"),
        ({"hdr": "sdr"}, "one of"),
    ],
)
def test_what_cannot_be_is_refused(wrong, told):
    with pytest.raises(ValueError, match=told):
        Recorder(**wrong)


@pytest.mark.parametrize("wrong", [["--hdr", "hlg"], ["--size", "320x182"], ["--split", "0"], ["--continuing-clock"]])
def test_the_command_says_what_it_refuses(wrong, tmp_path):
    result = CliRunner().invoke(cli, ["simulate", str(tmp_path / "out"), "--interlaced", *wrong])
    assert isinstance(result.exception, UsageError)
    assert not (tmp_path / "out").exists()


def test_the_plain_way_leaves_out_nothing():
    assert not Recorder().missing(Scenario(duration_s=2, movements=0), 0, 50).any()


def test_quick_coding_is_nearer_to_what_was_drawn(tmp_path):
    """No B-frames and no loop filter, paid for in bytes; the truth is the same, byte for byte."""
    for kind, options in (("usual", []), ("quick", ["--quick-coding"])):
        run("simulate", tmp_path / kind, *SCENE.split(), *options)
    scenario = load_truth(tmp_path / "usual").scenario
    scene = Scene.of(scenario)
    camera = CameraPictures(scene, Ground.of(scenario, scene.surface, scene.rig), 0, Clock())
    drawn = [camera.frame(k)[0].y.astype(np.float32) for k in range(scenario.frames)]
    error, kinds = {}, {}
    for kind in ("usual", "quick"):
        frames = [frame for _, frame in decoded(tmp_path / kind, "cam1")]
        lumas = (frame.to_ndarray()[: scenario.size[1]] for frame in frames)
        error[kind] = np.mean([((luma - true) ** 2).mean() for luma, true in zip(lumas, drawn, strict=True)])
        kinds[kind] = {PictureType(frame.pict_type).name for frame in frames}
    assert error["quick"] < error["usual"]
    assert "B" in kinds["usual"]
    assert kinds["quick"] == {"I", "P"}
    for file in ("truth.json", "truth.npz"):
        assert (tmp_path / "usual" / file).read_bytes() == (tmp_path / "quick" / file).read_bytes()
