"""Training on frames whose truth is known, scoring in another operation, what is refused, the command line."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path

import cv2
import marking
import mcsl_learned_occlusion as plugin
import numpy as np
import pytest
from mcsl_learned_occlusion.cli import main
from mcsl_learned_occlusion.features import NAMES, features, to_cut, usual_of, whole
from mcsl_learned_occlusion.labelling import PAINT, labels_of, read_marked, read_png, save_png
from mcsl_learned_occlusion.model import CLASSES, Model
from mcsl_learned_occlusion.training import Training, train

from mcsl_core import edl
from mcsl_core.analysis.stage_keys import identity
from mcsl_core.hooks import InputError, Silent, UsageError, discover
from mcsl_core.simulation import Scenario, simulate

SKIN = (55, 95, 165)  # a drape of the skin's hue: 11 of OpenCV's 180
QUICK = Training(rounds=10, folds=3)


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Frames of an operation under drapes of the skin's hue, painted."""
    folder = tmp_path_factory.mktemp("frames")
    marking.mark(marking.Operation(1, SKIN), folder, count=9)
    return folder


@pytest.fixture(scope="module")
def model(frames: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.npz"
    train(read_marked(frames), Silent(), QUICK)[0].save(path)
    return path


def scores_and_truth(moments: int = 12, seed: int = 7, **other):
    """What `learned` and `hue-area` say of another operation, and what is so: three lists of shares."""
    operation = marking.Operation(seed, SKIN)
    filmed = [operation.moment() for _ in range(moments)]
    learned, hue = (
        discover().choose("occlusion", name).implementation.scorer(operation.scene, [v for v, _ in filmed])
        for name in ("learned", "hue-area")
    )
    said, by_hue, true = [], [], []
    for views, hidden in filmed:
        a, b = learned.score(views), hue.score(views)
        for camera, mask in hidden.items():
            said.append(a[camera])
            by_hue.append(b[camera])
            true.append((~mask & (operation.field > 0)).sum() / operation.field.sum())
    return np.array(said), np.array(by_hue), np.array(true)


# ------------------------------------------------------------------------------------------------------- learning


def test_what_was_marked_in_one_operation_is_found_in_another(model, monkeypatch) -> None:
    """The field lies elsewhere in no way, but everything that passes is new, and so is the cloth."""
    monkeypatch.setenv(plugin.VARIABLE, str(model))
    said, by_hue, true = scores_and_truth()
    assert np.ptp(true) > 0.6
    assert np.abs(said - true).mean() < 0.05
    assert np.abs(said - true).mean() < 0.5 * np.abs(by_hue - true).mean()


def test_the_field_is_found_where_hue_shows_everything_as_field(model, monkeypatch) -> None:
    monkeypatch.setenv(plugin.VARIABLE, str(model))
    operation = marking.Operation(8, SKIN)
    blind = operation.scene.__class__(
        operation.scene.size,
        "cam1",
        operation.scene.homographies,
        operation.scene.camera_sizes,
        np.ones((270, 480), bool),
    )
    scorer = plugin.LearnedOcclusion().scorer(blind, [operation.moment()[0] for _ in range(12)])
    found = np.zeros(whole(blind).mask(blind.field).shape, bool)
    found[scorer.box] = scorer.place
    true = whole(blind).mask(operation.field > 0)
    assert (found & true).sum() / (found | true).sum() > 0.9


def test_without_paint_for_elsewhere_the_field_is_mcsls_own(tmp_path, monkeypatch) -> None:
    marking.mark(marking.Operation(1, SKIN), tmp_path, count=6, elsewhere=False)
    made, judged = train(read_marked(tmp_path), Silent(), QUICK)
    assert made.classes == ("field", "in the way")
    assert set(judged.iou) == {"field", "in the way"}
    made.save(tmp_path / "model.npz")
    monkeypatch.setenv(plugin.VARIABLE, str(tmp_path / "model.npz"))
    operation = marking.Operation(9, SKIN)
    moments = [operation.moment()[0] for _ in range(10)]
    scorer = plugin.LearnedOcclusion().scorer(operation.scene, moments)
    np.testing.assert_array_equal(scorer.place, scorer.cut.mask(operation.scene.field)[scorer.box])
    said, _, true = scores_and_truth()
    assert np.abs(said - true).mean() < 0.08


@pytest.mark.slow
def test_frames_are_judged_by_models_that_did_not_see_their_moment(frames) -> None:
    """With the paint of every frame drawn at random nothing can be learned, whatever was seen."""
    marked = read_marked(frames)
    _, judged = train(marked, Silent(), QUICK)
    assert judged.frames == len(marked) == 9
    assert min(judged.iou.values()) > 0.75
    rng = np.random.default_rng(0)
    senseless = [
        m.__class__(
            m.name,
            m.moment,
            m.camera,
            np.where(m.labels >= 0, rng.permutation(3)[m.labels], -1).astype(np.int8),
            m.seen,
            m.behind,
        )
        for m in marked
    ]
    _, chance = train(senseless, Silent(), QUICK)
    assert np.mean(list(chance.iou.values())) < 0.55


def test_training_gives_the_same_again_and_so_do_its_bytes(frames, tmp_path) -> None:
    marked = read_marked(frames)
    first, second = (train(marked, Silent(), QUICK)[0] for _ in range(2))
    for one, other in zip(first.weights, second.weights, strict=True):
        for before, after in zip(one, other, strict=True):
            np.testing.assert_allclose(before, after, rtol=1e-4, atol=1e-6)
    first.save(tmp_path / "a.npz")
    first.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_lone_camera_is_scored_much_as_among_the_others(model, monkeypatch) -> None:
    """Between samples a scorer is asked about the two cameras of a switch only."""
    monkeypatch.setenv(plugin.VARIABLE, str(model))
    operation = marking.Operation(10, SKIN)
    filmed = [operation.moment()[0] for _ in range(12)]
    scorer = plugin.LearnedOcclusion().scorer(operation.scene, filmed)
    together = [scorer.score(views)[view.camera] for views in filmed for view in views]
    alone = [scorer.score([view])[view.camera] for views in filmed for view in views]
    assert np.abs(np.array(together) - alone).mean() < 0.05


# ------------------------------------------------------------------------------------------------------- features


def test_brighter_light_moves_no_feature_but_its_own_and_changes_leave_the_past_alone() -> None:
    operation = marking.Operation(3)
    views, _ = operation.moment()
    cut = whole(operation.scene)
    seen = plugin.seen_of(views, cut)
    behind = {name: plugin.Seen(cut.picture(operation.still), view.inside) for name, view in seen.items()}
    found = features(seen, usual_of(behind), list(seen))
    assert {values.shape for values in found.values()} == {(135, 240, len(NAMES))}
    assert all(np.isfinite(values).all() for values in found.values())
    fixed = [i for i, name in enumerate(NAMES) if "usually" in name]
    again = features(plugin.seen_of(operation.moment()[0], cut), usual_of(behind), ["cam1"])["cam1"]
    np.testing.assert_array_equal(again[..., fixed], found["cam1"][..., fixed])
    light = {n: plugin.Seen(np.clip(v.picture * 1.2, 0, 255).astype(np.uint8), v.inside) for n, v in seen.items()}
    lit = features(light, usual_of({n: light[n] for n in behind}), ["cam1"])["cam1"]
    plain = features(seen, usual_of({n: seen[n] for n in behind}), ["cam1"])["cam1"]
    moved = np.abs(lit - plain).reshape(-1, len(NAMES))
    assert np.percentile(moved, 90, axis=0).max() < 0.12  # clipping and the levels added in the dark


def test_a_part_of_the_scene_has_the_features_of_the_whole(model, monkeypatch) -> None:
    """Only the surroundings of the field are looked at: what is scored there must not depend on it."""
    monkeypatch.setenv(plugin.VARIABLE, str(model))
    operation = marking.Operation(4, SKIN)
    filmed = [operation.moment()[0] for _ in range(8)]
    part = plugin.LearnedOcclusion().scorer(operation.scene, filmed)
    usual = usual_of(plugin.backgrounds(operation.scene, filmed))
    place = np.zeros((135, 240), bool)
    place[part.box] = part.place
    full = plugin.LearnedScorer(part.model, part.cut, usual, place)
    assert part.place.size < 0.6 * place.size
    for views in filmed:
        assert part.score(views) == pytest.approx(full.score(views), abs=1e-3)


# ----------------------------------------------------------------------------------------------- painting and files


def test_paint_is_read_by_colour_and_what_is_not_paint_is_not_used() -> None:
    mask = np.full((8, 10, 4), 255, np.uint8)
    mask[..., :3] = (90, 120, 180)  # a photograph
    mask[0, :, :3], mask[1, :, :3], mask[2, :, :3] = PAINT["field"], PAINT["in the way"], PAINT["elsewhere"]
    mask[3, :, :3] = (20, 240, 30)  # green after a colour profile
    mask[4, :, :3], mask[4, :, 3] = PAINT["field"], 0  # rubbed out
    labels = labels_of(mask)
    assert [labels[row, 0] for row in range(6)] == [0, 1, 2, 0, -1, -1]
    np.testing.assert_array_equal(labels_of(mask[..., :3])[:4], labels[:4])
    assert tuple(PAINT) == CLASSES


def test_a_mask_lies_where_the_picture_shows_it(frames) -> None:
    """Of the camera that is turned by half a turn as well: what was painted as field is the field in the scene."""
    operation = marking.Operation(1, SKIN)
    true = whole(operation.scene).mask(operation.field > 0)
    cameras = set()
    for marked in read_marked(frames):
        cameras.add(marked.camera)
        painted = marked.labels == 0
        assert (painted & true).sum() > 0.97 * painted.sum() > 0
        assert to_cut(operation.scene, marked.camera, marking.SIZE).shape == (3, 3)
    assert cameras == set(marking.CAMERAS)


@pytest.mark.parametrize(
    ("spoil", "what"),
    [
        (lambda f, n: save_png(f / f"{n}.mask.png", np.zeros((270, 480, 3), np.uint8)), "three colours"),
        (lambda f, n: save_png(f / f"{n}.mask.png", np.zeros((90, 160, 3), np.uint8)), "is 160x90, but .* is 480x270"),
        (lambda f, n: (f / f"{n}.mask.png").write_bytes(b"text"), "no colour picture"),
        (lambda f, n: (f / f"{n}.npz").unlink(), r"\.npz: is not there"),
        (lambda f, n: (f / f"{n}.npz").write_bytes(b"PK"), "Export the frames again"),
    ],
)
def test_a_wrong_mask_is_refused_by_name(frames, tmp_path, spoil, what) -> None:
    folder = tmp_path / "frames"
    shutil.copytree(frames, folder)
    name = min(p.name for p in folder.glob("*.mask.png")).removesuffix(".mask.png")
    spoil(folder, name)
    with pytest.raises(InputError, match=what) as caught:
        read_marked(folder)
    assert name in str(caught.value)


def test_too_little_paint_is_refused(frames) -> None:
    marked = read_marked(frames)
    with pytest.raises(InputError, match="one moment"):
        train([m for m in marked if m.moment == marked[0].moment], Silent())
    blind = [m.__class__(m.name, m.moment, m.camera, np.full_like(m.labels, 0), m.seen, m.behind) for m in marked]
    with pytest.raises(InputError, match="'in the way' is painted nowhere"):
        train(blind, Silent())


# --------------------------------------------------------------------------------------------------------- models


def test_a_model_comes_back_as_it_was_and_is_another_in_the_cache(model, tmp_path, monkeypatch) -> None:
    loaded = Model.load(model)
    assert loaded.classes == CLASSES
    assert loaded.about["frames"] == 9
    loaded.save(tmp_path / "copy.npz")
    assert (tmp_path / "copy.npz").read_bytes() == model.read_bytes()
    offer = discover().choose("occlusion", "learned")
    identities = set()
    for path in (model, tmp_path / "copy.npz"):
        monkeypatch.setenv(plugin.VARIABLE, str(path))
        identities.add(identity(offer))
    assert len(identities) == 1
    with np.load(model) as stored:
        arrays = dict(stored)
    arrays["bias0"] = arrays["bias0"] + 1
    np.savez(tmp_path / "copy.npz", **arrays)
    assert identity(offer) not in identities


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"weight1": np.zeros((3, 3), np.float32)}, "do not fit each other"),
        ({"bias2": np.zeros(7, np.float32)}, "do not fit each other"),
        ({"mean": np.full(len(NAMES), np.nan, np.float32)}, "no numbers"),
        ({"deviation": np.zeros(len(NAMES), np.float32)}, "above 0"),
        ({"deviation": np.ones(4, np.float32)}, "numbers each"),
        ({"head": np.array('{"schema": "mcsl.learned-occlusion/9", "classes": [], "about": {}}')}, "its schema is"),
        ({"head": np.array("{")}, "not a model of mcsl-label"),
        ({"mean": np.array([pickle], dtype=object)}, "not a model of mcsl-label"),
    ],
    ids=["layers", "classes", "nan", "zero", "short", "newer", "head", "pickled"],
)
def test_a_wrong_model_is_refused_by_name(model, tmp_path, change, what) -> None:
    with np.load(model) as stored:
        arrays = dict(stored) | change
    path = tmp_path / "wrong.npz"
    if "pickled" in what or any(a.dtype == object for a in arrays.values()):
        arrays["mean"] = np.array([print], dtype=object)  # pickles by name: loading it would run code
    np.savez(path, **arrays)
    with pytest.raises(InputError, match=what) as caught:
        Model.load(path)
    assert caught.value.where == str(path)


def test_without_a_model_it_says_how_to_get_one(monkeypatch, tmp_path) -> None:
    monkeypatch.delenv(plugin.VARIABLE, raising=False)
    offer = discover().choose("occlusion", "learned")
    assert offer.package == "mcsl-learned-occlusion"
    with pytest.raises(UsageError, match=plugin.VARIABLE):
        offer.implementation.prepare()
    monkeypatch.setenv(plugin.VARIABLE, str(tmp_path / "none.npz"))
    with pytest.raises(InputError, match="is not there"):
        offer.implementation.prepare()


# ------------------------------------------------------------------------------------------------ the command line


def test_mcsl_label_trains_and_says_how_good_it_is(frames, tmp_path, capsys) -> None:
    assert main(["--progress", "none", "train", str(frames), "-o", str(tmp_path / "model.npz")]) == 0
    told = capsys.readouterr().out
    assert "trained on 9 frames" in told
    assert "IoU on frames held out: field" in told
    assert Model.load(tmp_path / "model.npz").about["iou"]["field"] > 0.75


def test_mcsl_label_says_what_is_missing(tmp_path, capsys) -> None:
    assert main(["train", str(tmp_path), "-o", str(tmp_path / "model.npz")]) == 2
    assert "no picture is painted" in capsys.readouterr().err
    assert main(["train", str(tmp_path / "none"), "-o", str(tmp_path / "model.npz")]) == 3
    assert main(["export", str(tmp_path / "none.json"), str(tmp_path)]) == 3
    assert main(["train"]) == 2
    assert not (tmp_path / "model.npz").exists()


@pytest.mark.slow
def test_frames_of_a_recording_are_exported_over_cameras_and_poses(tmp_path, capsys) -> None:
    """A recording in, pictures out; then a few strokes of paint, a model, an analysis by it."""
    scenario = Scenario(
        seed=342, duration_s=24, size=(480, 270), rate=6, cameras=3, movements=((12, 1.5),), audio=False, drape="skin"
    )
    truth = simulate(scenario, tmp_path / "recording", Silent())
    out = tmp_path / "frames"
    assert main(["--progress", "none", "export", str(tmp_path / "recording"), str(out), "--frames", "6"]) == 0
    assert "6 pictures" in capsys.readouterr().out
    pictures = sorted(out.glob("*.png"))
    assert len(pictures) == 6
    document = edl.load(out / "analysis" / "edl.json")
    frames, cameras = zip(*(p.stem.split("_") for p in pictures), strict=True)
    assert set(cameras) == {"cam1", "cam2", "cam3"}
    poses = {next(i for i, p in enumerate(truth.poses) if p.range[0] <= int(f) < p.range[1]) for f in frames}
    assert poses == {0, 1}
    assert len(document.poses) == 2
    for picture in pictures:  # the middle is the field, a corner is drape, a stroke across an arm or head
        painted = read_png(picture)
        assert painted.shape == (270, 480, 3)
        cv2.circle(painted, (240, 135), 20, PAINT["field"], -1)
        cv2.rectangle(painted, (0, 0), (60, 30), PAINT["elsewhere"], -1)
        cv2.rectangle(painted, (400, 220), (470, 260), PAINT["in the way"], -1)
        save_png(picture.with_suffix(".mask.png"), painted)
    assert main(["--progress", "none", "train", str(out), "-o", str(tmp_path / "model.npz")]) == 0
    again = tmp_path / "again"
    assert main(["--progress", "none", "export", str(out / "analysis" / "edl.json"), str(again), "--frames", "5"]) == 0
    assert len(list(again.glob("*.png"))) == 5
