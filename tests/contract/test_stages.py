"""One contract per hook, run over every implementation that is installed: the built-ins, every plugin, and those that
docs/hooks.md shows. As the pipeline does, through the guards.

What the stages' protocols promise is checked with pictures that nobody's implementation was written for; of fillers in
test_fillers.py.
"""

from __future__ import annotations

from contextlib import closing
from fractions import Fraction
from itertools import combinations, pairwise

import attrs
import cv2
import numpy as np
import pytest
from lamp_scene import turned
from lamp_video import write_lamp
from stage_offers import offers
from swept_scene import SIZE, Relief, at_pixels, hill

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.correspondences import Correspondences
from mcsl_core.alignment.protocol import Alignment
from mcsl_core.centering.protocol import FieldPosition
from mcsl_core.hooks.registry import Offer, discover
from mcsl_core.hooks.stages import STAGES
from mcsl_core.imaging.geometry import transform_points
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange, check_tiles


def cloth(seed: int, size: tuple[int, int] = (480, 270)) -> np.ndarray:
    """A (H, W, 3) picture with structure of several sizes, like printed cloth, in greens."""
    rng = np.random.default_rng(seed)
    width, height = size
    grey = sum(
        cv2.resize(rng.normal(0, 1, (height // k + 2, width // k + 2)).astype(np.float32), (width, height)) * k**0.5
        for k in (2, 5, 13, 40)
    )
    grey = cv2.normalize(grey, None, 30, 220, cv2.NORM_MINMAX).astype(np.uint8)
    return cv2.merge([grey // 2, grey, grey // 3])


@pytest.fixture(scope="module")
def lamp_films(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[SampleStore, Footage]]:
    """Films of 36 s: on one the lamp moves from 24 to 25.5 s, on the other it stands; heads pass on both."""
    films = {}
    for name, way in (("moved", lambda t: min(max((t - 24) / 1.5, 0), 1)), ("stood", lambda t: 0.0)):
        folder = tmp_path_factory.mktemp(name)
        footage = write_lamp(folder, way, seconds=36, heads=0.12, far_px=120, seed=2)
        films[name] = SampleStore.record(footage, folder / "samples", Silent()), footage
    return films


@pytest.mark.slow
@offers("movement")
@pytest.mark.parametrize(("film", "count"), [("moved", 1), ("stood", 0)])
def test_movement_detectors_find_what_moves_and_nothing_else(offer: Offer, lamp_films, film: str, count: int) -> None:
    samples, footage = lamp_films[film]
    found = offer.checked.detect(samples, footage, Silent())
    assert len(found.movements) == count
    for before, after in pairwise([FrameRange(0, 1), *(m.range for m in found.movements)]):
        assert before.stop <= after.start
        assert after.stop <= footage.frames
    for movement in found.movements:  # the paper's detector is sure to some seconds only
        assert movement.range.start / footage.rate == pytest.approx(24, abs=5)
        assert movement.range.stop / footage.rate == pytest.approx(25.5, abs=5)
    curve = found.curve
    assert curve.label
    assert len(curve.frames) >= 30
    assert (np.diff(curve.frames) > 0).all()
    again = offer.checked.detect(samples, footage, Silent())
    assert again.movements == found.movements


@offers("movement")
@pytest.mark.parametrize("seconds", [0.2, 1.5])
def test_movement_detectors_take_a_recording_of_one_or_two_samples(offer: Offer, tmp_path, seconds: float) -> None:
    footage = write_lamp(tmp_path, lambda t: 0.0, seconds=seconds)
    with closing(SampleStore.record(footage, tmp_path / "samples", Silent())) as samples:
        assert offer.checked.detect(samples, footage, Silent()).movements == ()


@offers("matcher")
@pytest.mark.parametrize("turn_deg", [0, 30, 72, 144])
def test_matchers_find_the_same_points(offer: Offer, turn_deg: float) -> None:
    matcher = offer.checked
    picture = cloth(3)
    turn = np.vstack([cv2.getRotationMatrix2D((240, 135), turn_deg, 0.9), [0, 0, 1]])
    turned = cv2.warpPerspective(picture, turn, (480, 270))
    a, b = matcher.features(picture), matcher.features(turned)
    pairs = matcher.match(a, b)
    assert pairs.shape[1] == 2
    assert len(pairs) >= 60
    for column, features in ((0, a), (1, b)):
        assert len(set(pairs[:, column].tolist())) == len(pairs), "a point is matched twice"
        assert pairs[:, column].max() < len(features.points)
    error = np.hypot(*(transform_points(turn, a.points[pairs[:, 0]].astype(float)) - b.points[pairs[:, 1]]).T)
    assert (error < 3).mean() > 0.7
    again = matcher.match(matcher.features(picture), matcher.features(turned))
    np.testing.assert_array_equal(again, pairs)


@offers("matcher")
def test_matchers_survive_an_empty_picture_and_a_mask(offer: Offer) -> None:
    matcher = offer.checked
    blank = matcher.features(np.zeros((120, 160, 3), np.uint8))
    assert matcher.match(blank, blank).shape == (0, 2)
    picture, mask = cloth(4), np.zeros((270, 480), np.uint8)
    mask[:, :240] = 255
    assert matcher.features(picture, mask).points[:, 0].max() < 240


def lamp_cameras(size: tuple[int, int]) -> dict[str, np.ndarray]:
    """(3, 4) projections of five cameras on a circle of 30 cm, a metre up, each turned by 72 degrees to the last."""
    cameras = {}
    for number in range(5):
        turn = np.deg2rad(72 * number + 5)
        at = np.array([300 * np.cos(turn), 300 * np.sin(turn), 1000.0])
        ahead = -at / np.linalg.norm(at)
        right = np.cross(ahead, [np.cos(turn), np.sin(turn), 0])
        right /= np.linalg.norm(right)
        rows = np.stack([right, np.cross(ahead, right), ahead])
        focal = (1.6 + 0.02 * number) * size[0]
        inner = np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1]])
        cameras[f"cam{number + 1}"] = inner @ np.column_stack([rows, -rows @ at])
    return cameras


class ReliefField:
    """A surgical field with 3 cm of relief on drapes 3 cm below, its true places and the matches of all camera pairs.

    Found to 0.4 px, a tenth of them false. Nothing here is shared with any aligner.
    """

    def __init__(self, seed: int, size: tuple[int, int] = (960, 540)) -> None:
        rng = np.random.default_rng(seed)
        x, y = rng.uniform(-60, 60, (2, 500))
        z = 15 * np.sin(x / 23 + seed) * np.cos(y / 31) + 0.08 * x
        self.field = np.column_stack([x, y, z])
        drapes = np.column_stack([rng.uniform(-220, 220, 700), rng.uniform(-120, 120, 700), rng.normal(-30, 3, 700)])
        drapes = drapes[np.abs(drapes[:, :2]).max(axis=1) > 70]
        places = np.vstack([self.field, drapes])
        weight = np.where(np.arange(len(places)) < len(self.field), 1.0, 0.01)
        self.cameras = lamp_cameras(size)
        self.sizes = dict.fromkeys(self.cameras, size)
        self.pairs = {}
        for a, b in combinations(sorted(self.cameras), 2):
            both = [self.seen(camera, places) + rng.normal(0, 0.4, (len(places), 2)) for camera in (a, b)]
            inside = np.all([(p > 0).all(axis=1) & (p < size).all(axis=1) for p in both], axis=0)
            kept = inside & (rng.random(len(places)) < 0.5)
            wrong = kept & (rng.random(len(places)) < 0.1)
            both[1][wrong] = rng.uniform(0, size, (wrong.sum(), 2))
            pa, pb = both[0][kept], both[1][kept]
            self.pairs[a, b] = Correspondences(pa, pb, weight[kept], np.full(kept.sum(), 5, np.int64))

    def seen(self, camera: str, places: np.ndarray) -> np.ndarray:
        moved = np.column_stack([places, np.ones(len(places))]) @ self.cameras[camera].T
        return moved[:, :2] / moved[:, 2:]

    def error_over_best(self, camera: str, homography: np.ndarray, reference: str) -> float:
        """rms over the field of a homography to the reference, over that of the best plane (OpenCV's least squares)."""
        source, target = (self.seen(name, self.field) for name in (camera, reference))
        best, _ = cv2.findHomography(source, target, 0)
        rms = [np.sqrt(np.square(transform_points(h, source) - target).sum(axis=1).mean()) for h in (homography, best)]
        return float(rms[0] / rms[1])


def aligned(offer: Offer, relief: ReliefField, reference: str) -> Alignment:
    return offer.checked.align(relief.pairs, relief.sizes, reference)


@offers("aligner")
@pytest.mark.parametrize(("seed", "reference"), [(1, "cam1"), (2, "cam3")])
def test_aligners_lay_the_views_by_the_plane_of_the_field(offer: Offer, seed: int, reference: str) -> None:
    """The best plane is each camera's own; one plane in space for all, through the true places, leaves up to 1.13 times
    its error in these fields."""
    relief = ReliefField(seed)
    result = aligned(offer, relief, reference)
    assert set(result.homographies) == set(relief.cameras)
    assert result.weak == ()
    np.testing.assert_array_equal(result.homographies[reference], np.eye(3))
    for camera in set(relief.cameras) - {reference}:
        homography = result.homographies[camera]
        assert homography[2, 2] == pytest.approx(1)
        assert relief.error_over_best(camera, homography, reference) < 1.15
        assert 0.4 < result.residual_px[camera] < 20
        assert result.support[camera] > 100


@offers("aligner")
def test_aligners_name_the_cameras_that_cannot_be_tied_in(offer: Offer) -> None:
    """One camera that nothing matches, one whose matches are all chance; the others are tied as if they were not."""
    relief = ReliefField(3)
    rng = np.random.default_rng(4)
    relief.sizes |= {"cam6": (960, 540), "cam7": (640, 360)}
    for camera in relief.cameras:
        chance = (rng.uniform(0, (960, 540), (200, 2)), rng.uniform(0, (640, 360), (200, 2)))
        relief.pairs[camera, "cam7"] = Correspondences(*chance, np.ones(200), np.ones(200, np.int64))
    result = aligned(offer, relief, "cam1")
    assert {w.camera for w in result.weak} == {"cam6", "cam7"}
    assert all(len(w.reason) > 20 for w in result.weak)
    assert set(result.homographies) == set(relief.cameras)
    assert set(result.residual_px) == set(result.support) == set(relief.cameras) - {"cam1"}
    for camera in set(relief.cameras) - {"cam1"}:
        assert relief.error_over_best(camera, result.homographies[camera], "cam1") < 1.15


@offers("aligner")
def test_aligners_say_that_nothing_matches(offer: Offer) -> None:
    empty = Correspondences(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.int64))
    for pairs in ({}, {("a", "b"): empty}):
        result = offer.checked.align(pairs, {"a": (640, 360), "b": (640, 360)}, "b")
        np.testing.assert_array_equal(result.homographies["b"], np.eye(3))
        assert set(result.homographies) == {"b"}
        assert [w.camera for w in result.weak] == ["a"]


@offers("aligner")
def test_aligners_say_the_same_again_and_leave_what_they_are_handed(offer: Offer) -> None:
    relief, same = ReliefField(5), ReliefField(5)
    first, second = (aligned(offer, relief, "cam2") for _ in range(2))
    for camera, homography in first.homographies.items():
        np.testing.assert_array_equal(homography, second.homographies[camera])
    assert (first.residual_px, first.support, first.weak) == (second.residual_px, second.support, second.weak)
    assert relief.sizes == same.sizes
    for key, pair in relief.pairs.items():
        for column in ("a", "b", "weight", "seen"):
            np.testing.assert_array_equal(getattr(pair, column), getattr(same.pairs[key], column))


def field_seen_alike() -> tuple[AlignedPose, np.ndarray]:
    """A red field on green cloth seen alike by three cameras; (aligned pose, picture)."""
    size = (480, 270)
    field = np.zeros((270, 480), np.uint8)
    cv2.ellipse(field, (240, 135), (110, 70), 0, 0, 360, 1, -1)
    picture = cloth(5)
    picture[field > 0] = (50, 60, 190) + (cloth(6)[field > 0] // 8)
    cameras = ("cam1", "cam2", "cam3")
    pose = AlignedPose(size, "cam1", {c: np.eye(3) for c in cameras}, dict.fromkeys(cameras, size), field.astype(bool))
    return pose, picture


@offers("occlusion")
def test_detectors_see_less_where_more_is_hidden(offer: Offer) -> None:
    pose, picture = field_seen_alike()
    clear = pose.views({"cam1": picture, "cam2": picture, "cam3": picture})
    scorer = offer.checked.scorer(pose, [clear] * 3)
    seen = []
    for hidden in (0, 40, 90, 150, 220):
        occluded = picture.copy()
        cv2.rectangle(occluded, (130, 60), (130 + hidden, 210), (120, 90, 30), -1)  # a blue sleeve
        pictures = {"cam1": picture.copy(), "cam2": occluded, "cam3": picture.copy()}
        views = pose.views(pictures)
        before = [v.aligned.copy() for v in views]
        scores = scorer.score(views)
        assert set(scores) == {"cam1", "cam2", "cam3"}
        assert all(0 <= s <= 1 for s in scores.values())
        for view, copy in zip(views, before, strict=True):
            np.testing.assert_array_equal(view.aligned, copy, "a detector changed what it was handed")
        seen.append(scores["cam2"])
        assert scores["cam1"] > 0.85
    assert all(a >= b - 0.02 for a, b in pairwise(seen))
    assert seen[0] > 0.85
    assert seen[-1] < 0.25
    assert seen[2] == pytest.approx(0.6, abs=0.25)


@offers("occlusion")
def test_detectors_take_a_sample_of_one_camera(offer: Offer) -> None:
    pose, picture = field_seen_alike()
    views = pose.views({"cam1": picture, "cam2": None, "cam3": None})
    for samples in ([views], []):
        scores = offer.checked.scorer(pose, samples).score(views)
        assert set(scores) == {"cam1"}


@offers("selector")
def test_selectors_tile_the_programme(offer: Offer) -> None:
    rng = np.random.default_rng(1)
    for samples, cameras in ((1, 1), (2, 3), (60, 5)):
        frames = np.arange(samples) * 30 + 7
        visible = rng.random((samples, cameras))
        visible[samples // 3 : samples // 2] = np.nan  # the lamp moves: no data
        table = ScoreTable(frames, tuple(f"cam{c}" for c in range(cameras)), visible, np.ones((samples, cameras), bool))
        total = int(frames[-1]) + 20
        shots = offer.checked.select(table, frames=total, rate=Fraction(30))
        check_tiles((s.range for s in shots), total, "shots")
        assert {s.camera for s in shots} <= set(table.cameras)
        again = offer.checked.select(table, frames=total, rate=Fraction(30))
        assert [attrs.astuple(s) for s in again] == [attrs.astuple(s) for s in shots]


@offers("centerer")
def test_centerers_give_few_rising_keys_that_move_towards_the_middle(offer: Offer) -> None:
    positions = [
        FieldPosition(FrameRange(0, 300), (700.0, 300.0)),
        FieldPosition(FrameRange(300, 310), None),
        FieldPosition(FrameRange(310, 900), (450.0, 200.0)),
    ]
    keys = offer.checked.centre(positions, size=(960, 540), rate=30.0)
    assert len(keys) <= 12
    assert all(a[0] < b[0] for a, b in pairwise(keys))
    assert all(0 <= k[0] < 900 for k in keys)
    first, last = keys[0], keys[-1]
    assert abs(700 + first[1] - 479.5) < abs(700 - 479.5)
    assert abs(200 + last[2] - 269.5) < abs(200 - 269.5)


@offers("centerer")
def test_centerers_leave_a_recording_without_a_field_alone(offer: Offer) -> None:
    assert not offer.checked.centre([FieldPosition(FrameRange(0, 50), None)], size=(960, 540), rate=30.0)


@offers("relief")
def test_reliefs_are_nearer_than_the_plane_or_leave_it(offer: Offer) -> None:
    scene = Relief(hill(), cloth(21, SIZE)).scene(points=300)
    found = offer.checked.estimate(scene)
    if found is not None:
        middle = (slice(60, -60), slice(110, -110))
        left = np.abs(at_pixels(found.gamma) - hill())[middle]
        assert np.sqrt((left**2).mean()) < 0.5 * np.sqrt((hill()[middle] ** 2).mean())


@offers("relief")
def test_reliefs_of_what_shows_nothing_are_planes(offer: Offer) -> None:
    found = offer.checked.estimate(Relief(np.zeros(SIZE[::-1]), np.full((*SIZE[::-1], 3), 90, np.uint8)).scene())
    if found is not None:
        assert found.confidence.max() < 0.2
        assert np.abs(found.gamma * found.confidence).max() < 1


@offers("tracker")
def test_trackers_find_the_lamp_or_say_that_it_is_lost(offer: Offer) -> None:
    """Five cameras, one of them late, over a plane that nobody hides."""
    way = turned(10)
    found = offer.checked.follow(way.lamp, way.before, way.after, way.instants)
    assert len(found) == len(way.instants)
    known = {index: view for index, view in enumerate(found) if view is not None}
    assert len(known) > 0.5 * len(found)
    assert max(way.off(index, view) for index, view in known.items()) < 3
    again = offer.checked.follow(way.lamp, way.before, way.after, way.instants)
    for one, other in zip(found, again, strict=True):
        assert (one is None) == (other is None)
        assert one is None or (one.numbers == other.numbers).all()


@offers("tracker")
def test_trackers_take_instants_that_show_nothing(offer: Offer) -> None:
    way = turned(1, dark=True)
    unseen = [attrs.evolve(instant, pictures={}) for instant in way.instants]
    for instants in (way.instants, unseen, way.instants[:1]):
        assert len(offer.checked.follow(way.lamp, way.before, way.after, instants)) == len(instants)


def test_every_stage_has_its_default() -> None:
    for stage in STAGES:
        assert discover().choose(stage).name == STAGES[stage].default
