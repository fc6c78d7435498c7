"""What movements are judged and timed by, on pictures and curves whose motion is known."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from scipy.ndimage import affine_transform

from mcsl_core.edl import Movement
from mcsl_core.movement.displacement import Displacement, Template, texture
from mcsl_core.movement.onset import onset
from mcsl_core.movement.stillness import IN_PLACE_PX, Stillness, _merged, stillness
from mcsl_core.timing import FrameRange


def cloth(seed: int = 0, size: tuple[int, int] = (640, 360)) -> np.ndarray:
    """A (H, W, 3) picture of folded, woven cloth, faint as drapes are."""
    rng = np.random.default_rng(seed)
    width, height = size
    folds = cv2.resize(rng.normal(0, 1, (12, 20)).astype(np.float32), size, interpolation=cv2.INTER_CUBIC)
    weave = cv2.GaussianBlur(rng.normal(0, 1, (height, width)).astype(np.float32), (0, 0), 1.5 * height / 360)
    grey = 90 + 18 * folds + 25 * weave
    return cv2.merge([grey * 0.5, grey, grey * 0.6]).clip(0, 255).astype(np.uint8)


def displaced(picture: np.ndarray, warp) -> np.ndarray:
    """Moved by the 2x3 ``warp``, by cubic splines: OpenCV places samples on 1/32 of a pixel only."""
    back = np.linalg.inv(np.vstack([np.float64(warp), [0, 0, 1]]))
    swap = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]])  # scipy speaks of (row, column)
    planes = [affine_transform(p.astype(float), swap @ back @ swap, mode="reflect") for p in cv2.split(picture)]
    return np.stack(planes, axis=-1)  # not yet rounded: a sensor's noise comes first and keeps what lies between


def noisy(picture: np.ndarray, seed: int) -> np.ndarray:
    return (picture + np.random.default_rng(seed).normal(0, 1.5, picture.shape)).round().clip(0, 255).astype(np.uint8)


def displacement_of(before: np.ndarray, after: np.ndarray) -> Displacement:
    displacement = Template.of([texture(noisy(before, 1))]).displacement(texture(noisy(after, 2)))
    assert displacement is not None
    return displacement


def share(before: np.ndarray, after: np.ndarray) -> float:
    return displacement_of(before, after).share(IN_PLACE_PX)


def test_a_still_picture_is_in_place_whatever_the_light_does() -> None:
    picture = cloth()
    assert share(picture, picture) > 0.95
    assert share(picture, (picture * 0.7 + 10).astype(np.uint8)) > 0.9
    shade = np.linspace(0.6, 1.2, 640)[None, :, None]
    assert share(picture, (picture * shade).clip(0, 255).astype(np.uint8)) > 0.8


@pytest.mark.parametrize("moved_px", [1, 4, 9, 40])
def test_a_picture_that_moved_is_not_in_place(moved_px: int) -> None:
    assert share(cloth(), displaced(cloth(), [[1, 0, moved_px], [0, 1, moved_px / 2]])) < 0.05


def test_a_turn_of_one_degree_is_a_movement() -> None:
    assert share(cloth(), displaced(cloth(), cv2.getRotationMatrix2D((320, 180), 1.0, 1.0))) < 0.1


@pytest.mark.parametrize("size", [(640, 360), (480, 360), (270, 480), (1280, 720)])
@pytest.mark.parametrize(("dx", "dy"), [(0.06, 0.0), (-0.3, 0.2), (0.0, -1.0)])
def test_displacement_is_known_to_a_fraction_of_a_pixel(size: tuple[int, int], dx: float, dy: float) -> None:
    # Displacements are told in pixels of a picture of 360 rows.
    scale = size[1] / 360
    moved = displaced(cloth(size=size), [[1, 0, dx * scale], [0, 1, dy * scale]])
    common = displacement_of(cloth(size=size), moved).common()
    # One linear step falls short by up to a tenth; 0.02 px is what noise leaves of some hundred patches.
    assert common is not None
    np.testing.assert_allclose(common, [dx, dy, 0, 0], atol=0.02 + 0.12 * math.hypot(dx, dy))


def test_a_turn_and_a_zoom_are_told_from_a_displacement_and_as_large_as_they_appear() -> None:
    turn_deg, zoom = 0.1, 1.002
    warp = cv2.getRotationMatrix2D((319.5, 179.5), turn_deg, zoom)
    common = displacement_of(cloth(), displaced(cloth(), warp)).common()
    y, x = np.mgrid[:360, :640]
    points = np.stack([x.ravel(), y.ravel()], 1).astype(float)
    truth = math.sqrt((((points @ warp[:, :2].T + warp[:, 2]) - points) ** 2).sum(axis=1).mean())
    assert common is not None
    assert np.linalg.norm(common) == pytest.approx(truth, rel=0.15)
    assert np.linalg.norm(common[:2]) < 0.15 * truth


def test_what_a_head_does_in_half_of_the_picture_is_not_the_lamps_motion() -> None:
    after = cloth()
    after[:, :290] = displaced(cloth(7), [[1, 0, 1.0], [0, 1, 1.0]])[:, :290]
    before = cloth()
    before[:, :290] = cloth(7)[:, :290]
    common = displacement_of(before, after).common()
    assert common is not None
    np.testing.assert_allclose(common, 0, atol=0.1)


def test_a_head_over_most_of_the_picture_is_no_movement() -> None:
    covered = cloth()
    cv2.circle(covered, (300, 180), 270, (140, 90, 40), -1)
    cv2.circle(covered, (300, 180), 90, (110, 80, 30), 25)
    assert Stillness().still < share(cloth(), covered) < 0.7


def test_blank_sheets_dark_pictures_and_frozen_streams_say_nothing() -> None:
    blank = np.full((360, 640, 3), 120, np.uint8)
    for before, after in ((blank, cloth()), (cloth(), blank), (cloth(), np.zeros_like(blank))):
        assert math.isnan(share(before, after))
    assert Template.of([texture(cloth())]).displacement(texture(cloth())) is None
    assert Template.of([texture(cloth())]).displacement(texture(cloth(size=(480, 360)))) is None
    assert math.isnan(stillness([math.nan, math.nan]))


def test_a_template_at_rest_is_a_median_without_what_passes() -> None:
    textures = []
    for i in range(5):
        picture = noisy(cloth(), i)
        cv2.circle(picture, (120 * i, 180), 60, (140, 90, 40), -1)
        textures.append(texture(picture))
    displacement = Template.of(textures).displacement(texture(noisy(cloth(), 9)))
    assert displacement is not None
    assert displacement.share(IN_PLACE_PX) > 0.9


def test_one_frozen_stream_does_not_hide_a_movement_and_three_heads_fake_none() -> None:
    assert stillness([1.0, 0.02, 0.03, 0.01, 0.0]) < Stillness().still
    assert stillness([0.05, 0.02, 0.6, 0.5, 0.04]) > Stillness().still


# ------------------------------------------------------------------------------------------------------------ onset


def eased(u: np.ndarray) -> np.ndarray:
    u = u.clip(0, 1)
    return u * u * (3 - 2 * u)


def sine(u: np.ndarray) -> np.ndarray:
    return (1 - np.cos(np.pi * u.clip(0, 1))) / 2


def even(u: np.ndarray) -> np.ndarray:
    return u.clip(0, 1)


def jerkless(u: np.ndarray) -> np.ndarray:
    """How an arm moves: the least jerk."""
    u = u.clip(0, 1)
    return u**3 * (10 - 15 * u + 6 * u * u)


def trapezoid(u: np.ndarray) -> np.ndarray:
    """A quarter of the time faster and faster, then evenly, then slower."""
    speed = np.interp(np.linspace(0, 1, 1001), [0, 0.25, 0.75, 1], [0, 1, 1, 0])
    way = np.concatenate([[0], np.cumsum(speed[:-1])])
    return np.interp(u.clip(0, 1), np.linspace(0, 1, 1001), way / way[-1])


@pytest.mark.parametrize("profile", [eased, sine, even, trapezoid, jerkless])
@pytest.mark.parametrize("length_s", [0.5, 1.0, 5.0, 20.0, 40.0])
@pytest.mark.parametrize("way_px", [20.0, 100.0])
def test_a_start_is_found_within_half_a_second_however_the_lamp_is_pushed(profile, length_s, way_px) -> None:
    if way_px * profile(np.array([0.5 / length_s]))[0] < 0.005:
        pytest.skip("nothing is to be seen for half a second")
    for seed in range(3):
        rng = np.random.default_rng(seed)
        start = 2.5 + rng.uniform(0, 1)
        times = np.arange(0, 9.0, 0.1)
        curve = way_px * profile((times - start) / length_s)
        seen = int(np.flatnonzero(curve <= 1.3).max()) + 1
        curve = curve[:seen] + rng.normal(0, 0.01, seen)
        assert onset(times[:seen], curve, noise=0.02) == pytest.approx(start, abs=0.5)


def test_an_onset_lives_with_frames_that_are_missing() -> None:
    times = np.arange(0, 6.0, 0.1)
    curve = 0.4 * np.maximum(times - 3, 0) ** 2
    curve[::3] = np.nan
    assert onset(times[curve < 1.3], curve[curve < 1.3], noise=0.02) == pytest.approx(3, abs=0.2)


def test_what_stays_at_rest_has_no_onset() -> None:
    times = np.arange(0, 5.0, 0.1)
    assert onset(times, np.random.default_rng(3).normal(0, 0.01, 50), noise=0.02) == times[-1]
    assert onset(times, np.full(50, np.nan), noise=0.02) == times[-1]


def test_movements_that_overlap_after_timing_become_one() -> None:
    spans = [FrameRange(100, 160), FrameRange(150, 200), FrameRange(300, 310)]
    joined = _merged([Movement(s, 0.5) for s in spans])
    assert [m.range for m in joined] == [FrameRange(100, 200), FrameRange(300, 310)]
