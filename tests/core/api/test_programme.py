"""The front door as a notebook uses it. Where things lie is read off the pictures, not off the matrices behind them."""

from __future__ import annotations

import json
import shutil
from fractions import Fraction
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
from notes import Notes

import mcsl_core as mcsl
from mcsl_core.analysis.measurements import Measurements
from mcsl_core.delivery.presets import presets_folder
from mcsl_core.edl import Camera, Correction, Edl, Look, Media, Pose, Shot, save
from mcsl_core.errors import DocumentError, InputError, MediaError, UsageError
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.movement.protocol import NO_CURVE
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.timing import FrameRange

SIZE, RATE, FRAMES = (320, 180), 5, 20
SPOTS = {"cam1": (100.0, 60.0), "cam2": (200.0, 110.0)}  # each camera's pictures have one bright spot, there
COLOURS = {"cam1": (40, 40, 160), "cam2": (150, 50, 50)}  # BGR of the rest: a red and a blue room
TURN = ((0.8, -0.3, 70.0), (0.3, 0.8, -30.0), (2e-4, 1e-4, 1.0))
ANCHOR = ((1.0, 0.0, 9.0), (0.0, 1.0, -4.0), (0.0, 0.0, 1.0))
NUDGE = ((1.0, 0.0, -6.0), (0.0, 1.0, 5.0), (0.0, 0.0, 1.0))


def picture(camera: str) -> np.ndarray:
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    spot = np.exp(-((x - SPOTS[camera][0]) ** 2 + (y - SPOTS[camera][1]) ** 2) / (2 * 4.0**2))[..., None]
    return np.round(np.array(COLOURS[camera]) * (1 - spot) + 250 * spot).astype(np.uint8)


def spot_in(shown: np.ndarray) -> tuple[float, float]:
    """Where the spot lies in an RGB picture: the middle of what is much brighter in green than any room."""
    weight = np.clip(shown[..., 1].astype(float) - 120, 0, None)
    y, x = np.indices(weight.shape)
    return float((x * weight).sum() / weight.sum()), float((y * weight).sum() / weight.sum())


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("films")
    lossless = Encoding(options={"preset": "ultrafast", "qp": "0"})
    for name in SPOTS:
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=Fraction(RATE), encoding=lossless) as film:
            for _ in range(FRAMES):
                film.write(bgr_to_planes(picture(name)))
    return folder


@pytest.fixture
def programme(films: Path, tmp_path: Path) -> mcsl.Programme:
    """Opened from a file: cam1, then cam2 from frame 10 on, which a homography, an anchor and a hand have placed."""
    pose = Pose(FrameRange(0, FRAMES), {"cam1": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "cam2": TURN}, anchor=ANCHOR)
    edl = Edl(
        rate=Fraction(RATE),
        size=SIZE,
        frames=FRAMES,
        reference="cam1",
        cameras=tuple(
            Camera(name, (Media(str(films / f"{name}.mp4"), FRAMES),), SIZE, Fraction(RATE)) for name in SPOTS
        ),
        poses=(pose,),
        shots=(Shot(FrameRange(0, 10), "cam1"), Shot(FrameRange(10, FRAMES), "cam2")),
        corrections=(Correction(FrameRange(0, FRAMES), "cam2", NUDGE),),
        look=Look(centering=True, fill=False, colour=False),
        centering=((0, 0.0, 0.0), (19, 19.0, -9.5)),
        scores="edl.scores.npz",
    )
    visible = np.array([[0.9, 0.2], [0.5, 1.0]])
    scores = ScoreTable(np.array([0, 10]), ("cam1", "cam2"), visible, np.ones((2, 2), bool))
    Measurements(scores, NO_CURVE).save(tmp_path / "edl.scores.npz")
    save(edl, tmp_path / "edl.json")
    return mcsl.open(str(tmp_path / "edl.json"), allow_outside=True)  # its films are shared


# ------------------------------------------------------------------------------------------------------- pictures


def test_a_frame_is_rgb_of_the_programmes_size(programme) -> None:
    shown = programme.frame(3)
    assert (shown.shape, shown.dtype) == ((180, 320, 3), np.uint8)
    np.testing.assert_allclose(shown[150, 30], (160, 40, 40), atol=3)  # cam1's red room, red first


def test_a_cameras_own_picture_is_what_was_filmed(programme) -> None:
    own = programme.camera_frame("cam2", 4)
    assert np.abs(own.astype(int) - picture("cam2")[..., ::-1]).mean() < 2


@pytest.mark.parametrize("frame", [2, 17])
def test_an_aligned_picture_is_what_the_programme_shows_of_the_chosen_camera(programme, frame: int) -> None:
    chosen = programme.camera_at(frame)
    assert chosen == ("cam1" if frame < 10 else "cam2")
    np.testing.assert_array_equal(programme.camera_frame(chosen, frame, aligned=True), programme.frame(frame))


def test_the_frames_of_a_stretch_are_the_single_ones(programme) -> None:
    row = list(programme.frames((8, 12)))
    assert len(row) == 4
    for number, shown in enumerate(row, start=8):
        np.testing.assert_array_equal(shown, programme.frame(number))


def test_a_frame_is_what_conform_encodes(programme) -> None:
    done = programme.conform(quality="fine")
    assert [tuple(chunk.range) for chunk in done.chunks] == [tuple(range(FRAMES))]
    with av.open(str(done.path(done.chunks[0]))) as container:
        pictures = [frame.to_ndarray(format="yuv420p") for frame in container.decode(video=0)]
    own = bgr_to_planes(np.ascontiguousarray(programme.frame(15)[..., ::-1]))
    assert np.abs(pictures[15][: SIZE[1]].astype(int) - own.y).mean() < 1


# --------------------------------------------------------------------------------------------------------- places


@pytest.mark.parametrize("frame", [0, 5, 14, 19])
@pytest.mark.parametrize("camera", ["cam1", "cam2"])
def test_a_point_of_a_camera_lies_in_the_programme_where_its_picture_shows_it(programme, camera: str, frame) -> None:
    programme.override((0, FRAMES), camera=camera)
    laid = programme.to_programme(SPOTS[camera], camera, frame)
    np.testing.assert_allclose(laid, spot_in(programme.frame(frame)), atol=0.25)
    np.testing.assert_allclose(programme.to_camera(laid, camera, frame), SPOTS[camera], atol=1e-9)


def test_the_correction_by_hand_and_the_centering_are_in_it(programme) -> None:
    plain = mcsl.Programme(
        attrs.evolve(programme.edl, corrections=(), look=Look(centering=False, fill=False)), programme.path
    )
    points = [[10, 20], [300, 150]]
    moved = programme.to_programme(points, "cam2", 10) - plain.to_programme(points, "cam2", 10)
    np.testing.assert_allclose(moved, [[-6 + 10, 5 - 5]] * 2, atol=1e-9)


def test_shapes_of_points_stay(programme) -> None:
    assert programme.to_programme((1, 2), "cam1", 0).shape == (2,)
    assert programme.to_camera(np.zeros((7, 2)), "cam2", 0).shape == (7, 2)


# ------------------------------------------------------------------------------------------------------ decisions


def test_an_override_changes_the_programme_at_once_and_the_file_when_saved(programme) -> None:
    before = programme.path.read_bytes()
    red = programme.frame(5)
    programme.override((4, 8), camera="cam2", note="closer")
    assert (programme.camera_at(3), programme.camera_at(4), programme.camera_at(8)) == ("cam1", "cam2", "cam1")
    assert np.abs(programme.frame(5).astype(int) - red).mean() > 20
    assert programme.path.read_bytes() == before
    assert not programme.is_saved
    assert "not saved" in repr(programme)
    programme.save()
    assert programme.is_saved
    written = json.loads(programme.path.read_text("utf-8"))["overrides"]
    assert written == [{"range": [4, 8], "camera": "cam2", "note": "closer"}]
    assert mcsl.open(programme.path).edl == programme.edl


def test_what_is_removed_is_left_out_once_saved_and_can_be_brought_back(programme) -> None:
    programme.remove((4, 8))
    programme.remove((15, FRAMES))
    assert programme.delivered == (FrameRange(0, 4), FrameRange(8, 15))
    assert programme.edl.frames == FRAMES
    programme.save()
    assert json.loads(programme.path.read_text("utf-8"))["removed"] == [[4, 8], [15, FRAMES]]
    programme.bring_back((6, 20))
    assert programme.delivered == (FrameRange(0, 4), FrameRange(6, FRAMES))
    with pytest.raises(UsageError, match="nothing would be delivered"):
        programme.remove((0, FRAMES))
    with pytest.raises(UsageError):
        programme.remove((3, FRAMES + 1))
    assert programme.delivered == (FrameRange(0, 4), FrameRange(6, FRAMES))
    programme.bring_back()
    assert programme.delivered == (FrameRange(0, FRAMES),)


def test_saved_elsewhere_it_still_finds_its_media_and_scores(programme, tmp_path: Path) -> None:
    shown, before = programme.frame(12), programme.path.read_bytes()
    programme.override((0, 5), fill=False)
    programme.save(tmp_path / "copies" / "of it.json")
    assert (tmp_path / "edl.json").read_bytes() == before
    with mcsl.open(tmp_path / "copies" / "of it.json") as again:
        np.testing.assert_array_equal(again.frame(12), shown)
        assert again.scores.visible.mean(axis=0).tolist() == pytest.approx([0.7, 0.6])
    assert programme.scores.cameras == ("cam1", "cam2")


def test_what_was_closed_is_opened_again(programme) -> None:
    first = programme.frame(1)
    programme.close()
    np.testing.assert_array_equal(programme.frame(1), first)


# --------------------------------------------------------------------------------------------- render and measure


def test_what_is_rendered_is_saved_first(programme, tmp_path: Path) -> None:
    programme.override((0, 20), camera="cam2")
    with pytest.raises(UsageError, match=r"not saved.*save\(\)"):
        programme.render(tmp_path / "out.mp4", engine="direct")
    programme.save()
    heard = Notes()
    out = programme.render(str(tmp_path / "out.mp4"), engine="direct", progress=heard)
    assert heard.stages == ["Reading the files", "Writing the programme"]
    with av.open(str(out)) as container:
        assert sum(1 for _ in container.decode(video=0)) == FRAMES


def test_settings_of_a_render_are_one_value_or_named_singly(programme, tmp_path: Path) -> None:
    settings = mcsl.RenderSettings(engine="direct", preset="prores", audio="none")
    with pytest.raises(UsageError, match=r"out\.mp4: the preset writes \.mov files"):
        programme.render(tmp_path / "out.mp4", settings=settings)
    with av.open(str(programme.render(tmp_path / "out.mp4", settings=settings, preset="review"))) as container:
        assert sum(1 for _ in container.decode(video=0)) == FRAMES
    with pytest.raises(UsageError, match="quick"):
        mcsl.RenderSettings(preset="quick")


def test_a_preset_of_ones_own_is_never_written_over(programme, tmp_path: Path) -> None:
    shutil.copy2(presets_folder() / "review.json", tmp_path / "own.json")
    (tmp_path / "own.mp4").symlink_to("own.json")
    settings = mcsl.RenderSettings(engine="direct", preset=tmp_path / "own.json", force=True)
    with pytest.raises(InputError, match="is what this run reads"):
        programme.render(tmp_path / "own.mp4", settings=settings)


def test_evaluate_measures_the_programme_as_it_is_now(programme) -> None:
    found = mcsl.evaluate(programme, width=160)
    assert [row.name for row in found.measured] == ["no", "plane", "auto", "centered", "filled", "delivered"]
    assert [s.frame for s in found.switches] == [10]
    programme.override((0, 20), camera="cam2")
    assert mcsl.evaluate(programme, width=160).switches == ()


# --------------------------------------------------------------------------------------------------------- errors


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda p: p.frame(20), "there is no frame 20. Frames are 0 to 19"),
        (lambda p: p.frame(-1), "there is no frame -1"),
        (lambda p: p.frame(1.5), "a frame is a whole number, got 1.5"),
        (lambda p: p.frames((3, 21)), "there is no frame 20"),
        (lambda p: p.camera_frame("cam9", 3), "there is no camera 'cam9'. Cameras are cam1, cam2"),
        (lambda p: p.camera_frame("cam9", 3, aligned=True), "there is no camera 'cam9'"),
        (lambda p: p.to_programme([[1, 2]], "cam9", 3), "there is no camera 'cam9'"),
        (lambda p: p.to_programme([[1, 2, 3]], "cam1", 3), r"got an array of shape \(1, 3\)"),
        (lambda p: p.to_camera([[1, 2]], "cam1", 99), "there is no frame 99"),
        (lambda p: p.override((0, 5), camera="cam9"), "there is no camera 'cam9'"),
        (lambda p: p.override((5, 5), camera="cam1"), "a range ends after it starts"),
        (lambda p: p.override((5, 50), camera="cam1"), "there is no frame 49"),
        (lambda p: p.override(5, camera="cam1"), "a range is its first frame and its end, got 5"),
        (lambda p: p.override((0, 5)), "decides nothing. Give one of camera"),
        (lambda p: p.override((0, 5), fill="yes"), "fill: expected true or false, got 'yes'"),
        (lambda p: p.override((0, 5), colour=3), "colour: expected true or false, got 3"),
        (lambda p: p.override((0, 5), offset=3), "offset: expected two numbers, got 3"),
        (lambda p: p.override((0, 5), offset="ab"), "offset: expected two numbers, got 'ab'"),
        (lambda p: p.override((0, 5), offset=(float("nan"), 1)), "must be -10000000 to"),
    ],
)
def test_a_wrong_call_says_what_where_and_what_to_do(programme, call, told: str) -> None:
    before = programme.edl
    with pytest.raises(UsageError, match=told):
        call(programme)
    assert programme.edl is before


def test_a_gap_is_told_by_camera_and_frame(programme) -> None:
    cameras = (attrs.evolve(programme.edl.cameras[0], gaps=(FrameRange(3, 6),)), programme.edl.cameras[1])
    programme.edl = attrs.evolve(programme.edl, cameras=cameras)
    with pytest.raises(MediaError, match="cam1 at frame 4: has no picture then"):
        programme.camera_frame("cam1", 4)
    assert programme.camera_frame("cam1", 6).any()


def test_without_scores_it_says_how_to_get_them(programme) -> None:
    programme.edl = attrs.evolve(programme.edl, scores=None)
    with pytest.raises(InputError, match=r"keeps no scores. Run `mcsl analyse` again"):
        _ = programme.scores


def test_what_is_no_edl_is_refused_when_it_is_opened(tmp_path: Path) -> None:
    (tmp_path / "e.json").write_text("{}", "utf-8")
    with pytest.raises(DocumentError, match=r"e\.json"):
        mcsl.open(tmp_path / "e.json")


# ----------------------------------------------------------------------------------------------- the surgical field


def test_the_field_is_drawn_told_and_taken_away(programme) -> None:
    assert programme.field_mask(3) is None, "an EDL of before does not tell it"
    corners = [[40, 30], [80, 30], [80, 90], [40, 90]]
    programme.set_field(corners, (0, 12), note="wound")
    assert not programme.is_saved
    mask = programme.field_mask(3)
    assert mask.shape == (180, 320)
    assert mask[60, 60]
    assert mask.sum() == pytest.approx(41 * 61, rel=0.02)
    assert programme.field_mask(12) is None
    programme.set_field([np.array(corners) + 100, corners])
    assert programme.field_mask(15)[60, 60]
    assert programme.field_mask(15)[160, 160]
    programme.clear_field((0, 10))
    assert programme.field_mask(3) is None
    programme.save()
    assert [drawn.range for drawn in mcsl.open(programme.path).edl.drawn_fields] == [FrameRange(10, FRAMES)]


@pytest.mark.parametrize(
    "wrong", [[], [[1, 2], [3, 4]], [[1, 2, 3]] * 3, 7, "abc", [[999, 999], [1200, 999], [999, 1200]]]
)
def test_what_is_no_field_is_refused_and_changes_nothing(programme, wrong) -> None:
    with pytest.raises(UsageError, match="this is no field"):
        programme.set_field(wrong)
    with pytest.raises(UsageError, match="there is no frame"):
        programme.set_field([[40, 30], [80, 30], [80, 90]], (0, 900))
    assert programme.is_saved
