"""Cameras tied by pictures of a relief: rendered exactly, laid some pixels wrong, found to a fraction of one."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from cloth_scene import RIG, SIZE, cloth, hill, taken, waves

from mcsl_core.alignment.relief.matching import Views, field_pairs, relief_cameras
from mcsl_core.alignment.relief.rig import Rig
from mcsl_core.alignment.steady import SteadyView
from mcsl_core.imaging.geometry import project

FOURTH = np.array([[-0.2, 0.98, 155.0, -0.6], [-0.98, -0.2, 397.0, -0.7], [3e-5, -3e-5, 1.0, 2e-4]])


def limb(points: np.ndarray) -> np.ndarray:
    """A surface that falls away by 40 pixels of gamma to both sides."""
    return 40 * np.maximum(0, 1 - ((points[:, 1] - 135) / 100) ** 2) - 13


@pytest.fixture(scope="module")
def pictures() -> dict[str, np.ndarray]:
    """What the cameras see of a cloth over the hill."""
    over = cloth()
    return {name: taken(own, over) for name, own in RIG.items()}


def views(pictures: dict[str, np.ndarray]) -> Views:
    steady = {name: SteadyView(picture, np.ones(SIZE[::-1], bool)) for name, picture in pictures.items()}
    return Views("ref", dict.fromkeys(pictures, SIZE), steady, [pictures] * 3)


def planes(wrong: float = 3.0, rig: dict[str, np.ndarray] = RIG) -> dict[str, np.ndarray]:
    shift = np.array([[1, 0, wrong], [0, 1, -wrong], [0, 0, 1.0]])
    return {n: np.eye(3) if n == "ref" else shift @ np.linalg.inv(p[:, :3]) for n, p in rig.items()}


def test_projections_and_gamma_are_found_by_pictures_alone(pictures) -> None:
    cameras = relief_cameras(views(pictures), planes())
    assert cameras is not None
    assert set(cameras.projections) == {"ref", "b", "c"}
    assert len(cameras.points) > 1000
    scene = cameras.points[:, :2]
    for name in ("b", "c"):
        there = project(RIG[name], np.column_stack([scene, hill(scene)]))
        off = np.hypot(*(project(cameras.projections[name], cameras.points) - there).T)
        assert np.median(off) < 0.15, name
        assert np.percentile(off, 95) < 0.6, name

    field = np.zeros((54, 96), bool)
    field[20:34, 38:58] = True
    for (a, name), matches in field_pairs(cameras, field, views(pictures)).items():
        inside = matches.weight == 1
        assert a == "ref"
        assert inside.sum() > 500
        there = project(RIG[name], np.column_stack([matches.a, hill(matches.a)]))[inside]
        assert np.median(np.hypot(*(matches.b[inside] - there).T)) < 0.2
        assert matches.weight[~inside].sum() < 0.01 * inside.sum()


def test_a_camera_that_shows_nothing_of_it_is_left_out(pictures) -> None:
    blank = {**pictures, "c": np.full_like(pictures["c"], 90)}
    found = relief_cameras(views(blank), planes())
    assert found is not None
    assert set(found.projections) == {"ref", "b"}
    nothing = {name: np.full_like(picture, 90) for name, picture in pictures.items()}
    assert relief_cameras(views(nothing), planes()) is None


def test_what_is_not_steady_is_not_matched(pictures) -> None:
    shaking = views(pictures)
    half = np.ones(SIZE[::-1], bool)
    half[:, :200] = False
    shaking.steady["ref"] = SteadyView(pictures["ref"], half)  # pyright: ignore[reportIndexIssue]
    found = relief_cameras(shaking, planes())
    assert found is not None
    assert found.points[:, 0].min() >= 195


def test_where_hands_work_all_over_the_middle_single_samples_speak(pictures) -> None:
    busy = views(pictures)
    for name, picture in pictures.items():
        still = np.ones(SIZE[::-1], bool)
        still[20:250, 100:380] = False
        busy.steady[name] = SteadyView(picture, still)  # pyright: ignore[reportIndexIssue]
    found = relief_cameras(busy, planes())
    assert found is not None
    middle = found.points[np.hypot(*(found.points[:, :2] - (240, 135)).T) < 60]
    assert len(middle) > 100
    there = project(RIG["c"], np.column_stack([middle[:, :2], hill(middle[:, :2])]))
    assert np.median(np.hypot(*(project(found.projections["c"], middle) - there).T)) < 0.2


def test_a_field_hidden_from_the_reference_is_known_by_what_three_others_see() -> None:
    rig = {**RIG, "d": FOURTH}
    over = cloth()
    pictures = {name: taken(own, over, waves) for name, own in rig.items()}
    head = np.ones(SIZE[::-1], np.uint8)
    cv2.circle(head, (240, 135), 66, 0, -1)
    pictures["ref"] = pictures["ref"] * head[..., None]
    hidden = views(pictures)
    hidden.steady["ref"] = SteadyView(pictures["ref"], head > 0)  # pyright: ignore[reportIndexIssue]
    cameras = relief_cameras(hidden, planes(rig=rig))
    assert cameras is not None
    assert set(cameras.projections) == set(rig)
    field = np.zeros((54, 96), bool)
    field[20:34, 38:58] = True
    for (_, name), matches in field_pairs(cameras, field, hidden).items():
        inside = matches.weight == 1
        there = project(rig[name], np.column_stack([matches.a, waves(matches.a)]))[inside]
        assert np.median(np.hypot(*(matches.b[inside] - there).T)) < 0.5, name


@pytest.mark.parametrize(
    "wrong",
    [
        # Started from these again in the second pass, b and d saw 0.5 and c none of the points where the others said,
        # and c was lost; started by the plane of what the first had found all see all of them.
        {"b": (15, 5, 4.9, 1.018), "c": (-6, 11, -7.6, 0.993), "d": (-6, -1, -6.0, 0.961)},
        {"b": (-10, -16, -7.3, 0.954), "c": (-14, 2, -0.8, 1.064), "d": (20, 13, 2.7, 1.048)},
        # In the first pass d saw 0.68 of them, in the second all.
        {"b": (-20, -4, -4.1, 1.055), "c": (11, 2, 2.6, 1.031), "d": (13, 20, -5.6, 1.02)},
    ],
    ids=["other start", "other start too", "judged again"],
)
def test_cameras_of_a_limb_are_found_from_planes_that_lie_far_off(wrong) -> None:
    rig, over = {**RIG, "d": FOURTH}, cloth()
    pictures = {name: taken(own, over, limb) for name, own in rig.items()}
    laid = planes(0.0, rig)
    for name, (x, y, turn, zoom) in wrong.items():
        off = np.vstack([cv2.getRotationMatrix2D((240, 135), turn, zoom), [0, 0, 1]])
        off[:2, 2] += x, y
        laid[name] = off @ laid[name]
    found = relief_cameras(views(pictures), laid)
    assert found is not None
    assert set(found.projections) == set(rig)
    scene = np.column_stack([found.points[:, :2], limb(found.points[:, :2])])
    for name, own in rig.items():
        assert np.median(np.hypot(*(project(found.projections[name], found.points) - project(own, scene)).T)) < 0.3


def told(zoom: float) -> Rig:
    """The cameras as another pose has them: before a zoom, over a plane and scale of its own."""
    there = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [2e-3, -1e-3, 0.4, 1.3]])
    middle = np.array([[1 / zoom, 0, (1 - 1 / zoom) * 239.5], [0, 1 / zoom, (1 - 1 / zoom) * 134.5], [0, 0, 1]])
    space = np.eye(4)
    space[:3, :3] = np.linalg.inv(middle)
    known = {name: middle @ own @ space @ there for name, own in {**RIG, "d": FOURTH}.items()}
    return Rig({name: p / p[2, 2] for name, p in known.items()}, dict.fromkeys(known, 2000))


@pytest.mark.parametrize("zoom", [1.0, 1.04])
def test_a_camera_that_no_plane_ties_is_started_by_the_rig_of_another_pose(zoom: float) -> None:
    over = cloth()
    seen = views({name: taken(own, over) for name, own in {**RIG, "d": FOURTH}.items()})
    alone = relief_cameras(seen, planes())
    assert alone is not None
    assert "d" not in alone.projections
    found = relief_cameras(seen, planes(), [told(zoom)])
    assert found is not None
    scene = np.column_stack([found.points[:, :2], hill(found.points[:, :2])])
    for name, own in {**RIG, "d": FOURTH}.items():
        assert np.median(np.hypot(*(project(found.projections[name], found.points) - project(own, scene)).T)) < 0.3
    assert found.matches["d"] > 600


def test_of_a_camera_behind_a_head_the_rig_tells_and_says_that_it_was_told() -> None:
    over = cloth()
    seen = views({**{name: taken(own, over) for name, own in RIG.items()}, "d": np.zeros((270, 480, 3), np.uint8)})
    found = relief_cameras(seen, planes(), [told(1.04)])
    assert found is not None
    assert found.matches["d"] == 0
    scene = np.column_stack([found.points[:, :2], hill(found.points[:, :2])])
    assert np.median(np.hypot(*(project(found.projections["d"], found.points) - project(FOURTH, scene)).T)) < 0.5


@pytest.mark.parametrize("places", [0, 1, 269])
def test_of_what_it_is_not_sure_itself_a_rig_tells_nothing(places: int) -> None:
    over, rig = cloth(), told(1.0)
    black = np.zeros((270, 480, 3), np.uint8)
    seen = views({**{name: taken(own, over) for name, own in RIG.items()}, "d": black, "e": black})
    wrong = np.array([[1, 0, 30], [0, 1, 0], [0, 0, 1.0]]) @ rig.projections["d"]
    known = Rig({**rig.projections, "e": wrong}, {**rig.matches, "e": places})
    found = relief_cameras(seen, planes(), [known])
    assert found is not None
    assert found.matches["d"] == 0
    assert "e" not in found.projections
