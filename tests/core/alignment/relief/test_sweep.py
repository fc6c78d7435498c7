"""A relief by plane sweep, from a textured relief of known gamma and exact cameras."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from attrs import evolve
from swept_scene import SIZE, Relief, at_pixels, hill, rough

from mcsl_core.alignment.relief.protocol import PlaneRelief, ReliefScene, ReliefView
from mcsl_core.alignment.relief.sweep import PlaneSweep

INNER = (slice(60, -60), slice(110, -110))  # what all cameras see


@pytest.fixture(scope="module")
def over_a_hill() -> ReliefScene:
    return Relief(hill(), rough(1)).scene()


def off(found, true: np.ndarray) -> np.ndarray:
    assert found is not None
    return np.abs(at_pixels(found.gamma) - true)[INNER]


def test_a_textured_relief_is_found_to_a_third_of_a_pixel(over_a_hill: ReliefScene) -> None:
    found = PlaneSweep().estimate(over_a_hill)
    far = off(found, hill())
    assert np.sqrt((far**2).mean()) < 0.3
    assert np.percentile(far, 95) < 0.6
    assert found is not None
    assert found.cameras == over_a_hill.cameras.keys()
    assert at_pixels(found.confidence)[INNER].min() > 0.5


@pytest.mark.parametrize("height", [-25.0, 4.0, 25.0])
def test_hills_and_hollows_of_any_height_are_found(height: float) -> None:
    found = PlaneSweep().estimate(Relief(hill(height), rough(2)).scene())
    assert np.sqrt((off(found, hill(height)) ** 2).mean()) < 0.02 * abs(height) + 0.25


def test_a_plane_stays_a_plane() -> None:
    found = PlaneSweep().estimate(Relief(np.zeros(SIZE[::-1]), rough(3)).scene())
    far = off(found, np.zeros(SIZE[::-1]))
    assert np.sqrt((far**2).mean()) < 0.1
    assert far.max() < 0.5


def test_what_has_no_texture_goes_on_smoothly_and_is_not_sure() -> None:
    """A wide plain band: nothing wild in it, and the plane where nothing is near."""
    texture = rough(4)
    texture[:, 330:] = 120
    found = PlaneSweep().estimate(Relief(hill(), texture).scene(noise=2.0))
    assert found is not None
    gamma, confidence = at_pixels(found.gamma), at_pixels(found.confidence)
    assert confidence[60:-60, 480:].max() < 0.1
    assert np.abs(gamma[60:-60, 480:]).max() < 3
    assert np.abs(np.diff(gamma, axis=1)).max() < 1
    assert np.abs(gamma - hill())[60:-60, 150:280].mean() < 0.4


def test_a_step_does_not_ring() -> None:
    """The edge of something 8 pixels high: beside it the ground is level."""
    step = cv2.blur(np.where(np.arange(SIZE[0]) < 320, 0.0, 8.0)[None].repeat(SIZE[1], 0).astype(np.float32), (9, 1))
    found = PlaneSweep().estimate(Relief(step, rough(5)).scene())
    assert found is not None
    gamma = at_pixels(found.gamma)[INNER]
    assert gamma.min() > -1
    assert gamma.max() < 9


def test_a_camera_whose_projection_is_wrong_is_left_out(over_a_hill: ReliefScene) -> None:
    wrong = over_a_hill.cameras["cam3"]
    projection = wrong.projection.copy()
    projection[:, 3] = -1.5 * projection[:, 3] + [0.5, 0, 0]
    scene = evolve(over_a_hill, cameras={**over_a_hill.cameras, "cam3": evolve(wrong, projection=projection)})
    found = PlaneSweep().estimate(scene)
    assert found is not None
    assert found.cameras == {"cam1", "cam2", "cam4"}
    assert np.sqrt((off(found, hill()) ** 2).mean()) < 0.4


def test_what_rests_in_one_group_of_moments_is_no_relief(over_a_hill: ReliefScene) -> None:
    """A plain thing with marks lies in every camera's first view of three, 15 pixels above the ground."""
    raised = hill()
    raised[120:220, 250:380] += 15
    painted = rough(1)
    painted[120:220, 250:380] = rough(9)[120:220, 250:380]
    with_hand = Relief(raised, painted).scene()
    cameras = {
        name: evolve(camera, views=(with_hand.cameras[name].views[0], *camera.views * 2))
        for name, camera in over_a_hill.cameras.items()
    }
    found = PlaneSweep().estimate(evolve(over_a_hill, cameras=cameras))
    assert np.sqrt((off(found, hill()) ** 2).mean()) < 0.3


def test_a_place_that_most_cameras_do_not_see_is_found_by_those_that_do(over_a_hill: ReliefScene) -> None:
    """Heads rest before it, steadily, one in each of two cameras of four."""
    cameras = dict(over_a_hill.cameras)
    for n, name in enumerate(("cam1", "cam4")):
        picture = cameras[name].views[0].picture.copy()
        picture[90:270, 180:460] = rough(40 + n)[90:270, 180:460]
        cameras[name] = evolve(cameras[name], views=(ReliefView(picture, cameras[name].views[0].steady),))
    found = PlaneSweep().estimate(evolve(over_a_hill, cameras=cameras))
    assert found is not None
    far = np.abs(at_pixels(found.gamma) - hill())[120:240, 220:420]
    assert np.sqrt((far**2).mean()) < 0.6
    assert at_pixels(found.confidence)[120:240, 220:420].mean() > 0.5


def test_what_is_not_steady_is_not_looked_at(over_a_hill: ReliefScene) -> None:
    cameras = {}
    for n, (name, camera) in enumerate(over_a_hill.cameras.items()):
        picture, steady = camera.views[0].picture.copy(), camera.views[0].steady.copy()
        area = (slice(130, 200), slice(240, 330))
        picture[area], steady[area] = rough(20 + n)[area], False
        cameras[name] = evolve(camera, views=(ReliefView(picture, steady),))
    found = PlaneSweep().estimate(evolve(over_a_hill, cameras=cameras))
    assert off(found, hill()).max() < 3


def test_what_is_hidden_now_is_as_the_first_pose_showed_it(over_a_hill: ReliefScene) -> None:
    """A head before all cameras, over the hill; beside it these pictures decide, whatever was known."""
    before = PlaneSweep().estimate(over_a_hill)
    assert before is not None
    texture = rough(1)
    texture[100:260, 200:440] = 120
    hidden = Relief(hill(), texture).scene(noise=2.0)
    there = (slice(140, 220), slice(260, 380))
    without, found = (PlaneSweep().estimate(scene) for scene in (hidden, evolve(hidden, before=before)))
    assert found is not None
    assert without is not None
    assert np.abs(at_pixels(without.gamma) - hill())[there].mean() > 1.5
    assert np.abs(at_pixels(found.gamma) - hill())[there].mean() < 0.3
    wrong = PlaneSweep().estimate(evolve(over_a_hill, before=evolve(before, gamma=before.gamma + 6)))
    assert np.sqrt((off(wrong, hill()) ** 2).mean()) < 0.4


def test_a_relief_is_searched_about_what_the_matches_say() -> None:
    """It lies 60 pixels off the plane, where nothing would be looked for without them."""
    high = hill() + 60
    scene = Relief(high, rough(6)).scene(points=200)
    assert np.sqrt((off(PlaneSweep().estimate(scene), high) ** 2).mean()) < 0.4


def test_fewer_than_two_cameras_are_a_plane(over_a_hill: ReliefScene) -> None:
    one = evolve(over_a_hill, cameras={"cam1": over_a_hill.cameras["cam1"]})
    assert PlaneSweep().estimate(one) is None
    blind = {name: evolve(camera, views=()) for name, camera in over_a_hill.cameras.items()}
    assert PlaneSweep().estimate(evolve(over_a_hill, cameras=blind)) is None


def test_the_plane_can_be_chosen(over_a_hill: ReliefScene) -> None:
    assert PlaneRelief().estimate(over_a_hill) is None
