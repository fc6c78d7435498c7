"""One contract per hook, run over every implementation that is installed: the built-ins and every plugin.

What is promised in `hookspecs.py` is checked with pictures that nobody's implementation was written for.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import attrs
import cv2
import numpy as np
import pytest

from mcsl_core.alignment import apply
from mcsl_core.centering import FieldPlace
from mcsl_core.plugins import Offer, discover
from mcsl_core.scene import Scene
from mcsl_core.scores import ScoreTable
from mcsl_core.timing import FrameRange, check_tiles

ALL = discover().offers


def offers(stage: str):
    return pytest.mark.parametrize("offer", [o for o in ALL if o.stage == stage], ids=lambda o: o.name)


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


@offers("matcher")
@pytest.mark.parametrize("turn_deg", [0, 30, 72, 144])
def test_matchers_find_the_same_places(offer: Offer, turn_deg: float) -> None:
    matcher = offer.implementation
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
    error = np.hypot(*(apply(turn, a.points[pairs[:, 0]].astype(float)) - b.points[pairs[:, 1]]).T)
    assert (error < 3).mean() > 0.7
    again = matcher.match(matcher.features(picture), matcher.features(turned))
    np.testing.assert_array_equal(again, pairs)


@offers("matcher")
def test_matchers_survive_an_empty_picture_and_a_mask(offer: Offer) -> None:
    matcher = offer.implementation
    blank = matcher.features(np.zeros((120, 160, 3), np.uint8))
    assert matcher.match(blank, blank).shape == (0, 2)
    picture, mask = cloth(4), np.zeros((270, 480), np.uint8)
    mask[:, :240] = 255
    assert matcher.features(picture, mask).points[:, 0].max() < 240


def field_scene() -> tuple[Scene, np.ndarray]:
    """A red field on green cloth seen alike by three cameras; (scene, picture)."""
    size = (480, 270)
    field = np.zeros((270, 480), np.uint8)
    cv2.ellipse(field, (240, 135), (110, 70), 0, 0, 360, 1, -1)
    picture = cloth(5)
    picture[field > 0] = (50, 60, 190) + (cloth(6)[field > 0] // 8)
    cameras = ("cam1", "cam2", "cam3")
    scene = Scene(size, "cam1", {c: np.eye(3) for c in cameras}, dict.fromkeys(cameras, size), field.astype(bool))
    return scene, picture


@offers("occlusion")
def test_detectors_see_less_where_more_is_hidden(offer: Offer) -> None:
    scene, picture = field_scene()
    scorer = offer.implementation.scorer(scene)
    seen = []
    for hidden in (0, 40, 90, 150, 220):
        covered = picture.copy()
        cv2.rectangle(covered, (130, 60), (130 + hidden, 210), (120, 90, 30), -1)  # a blue sleeve
        pictures = {"cam1": picture.copy(), "cam2": covered, "cam3": picture.copy()}
        views = scene.views(pictures)
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
def test_detectors_take_a_moment_with_one_camera(offer: Offer) -> None:
    scene, picture = field_scene()
    scores = offer.implementation.scorer(scene).score(scene.views({"cam1": picture, "cam2": None, "cam3": None}))
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
        shots = offer.implementation.select(table, frames=total, rate=Fraction(30))
        check_tiles((s.range for s in shots), total, "shots")
        assert {s.camera for s in shots} <= set(table.cameras)
        again = offer.implementation.select(table, frames=total, rate=Fraction(30))
        assert [attrs.astuple(s) for s in again] == [attrs.astuple(s) for s in shots]


@offers("centerer")
def test_centerers_give_few_rising_keys_that_move_towards_the_middle(offer: Offer) -> None:
    places = [
        FieldPlace(FrameRange(0, 300), (700.0, 300.0)),
        FieldPlace(FrameRange(300, 310), None),
        FieldPlace(FrameRange(310, 900), (450.0, 200.0)),
    ]
    keys = offer.implementation.centre(places, size=(960, 540), rate=30.0)
    assert len(keys) <= 12
    assert all(a[0] < b[0] for a, b in pairwise(keys))
    assert all(0 <= k[0] < 900 for k in keys)
    first, last = keys[0], keys[-1]
    assert abs(700 + first[1] - 479.5) < abs(700 - 479.5)
    assert abs(200 + last[2] - 269.5) < abs(200 - 269.5)


@offers("centerer")
def test_centerers_leave_a_recording_without_a_field_alone(offer: Offer) -> None:
    assert not offer.implementation.centre([FieldPlace(FrameRange(0, 50), None)], size=(960, 540), rate=30.0)


def test_every_stage_has_its_default() -> None:
    from mcsl_core.stages import STAGES

    for stage in STAGES:
        assert discover().choose(stage).name == STAGES[stage].default
