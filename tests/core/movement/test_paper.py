"""The paper's movement detection: its formulas against plain loops, and series whose movement is known."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.movement.paper import (
    Correspondences,
    DegreeOfMisalignment,
    degree_of_misalignment,
    first_exceedance,
    homography_inliers,
    median_vote,
    moving_average,
    threshold,
    without_outliers,
)


def homography(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    h = np.eye(3) + rng.normal(0, 0.1, (3, 3))
    h[:2, 2] = rng.uniform(-40, 40, 2)
    h[2] = [*rng.normal(0, 1e-5, 2), 1]
    return h


def moved(h: np.ndarray, x: float, y: float) -> tuple[float, float]:
    u, v, w = (h[i, 0] * x + h[i, 1] * y + h[i, 2] for i in range(3))
    return u / w, v / w


def test_dom_is_the_mean_projection_error_over_all_ordered_pairs() -> None:
    rng = np.random.default_rng(0)
    to_reference = {"a": np.eye(3), "b": homography(1), "c": homography(2)}
    shared, samples = {}, 4
    for a, b in (("a", "b"), ("a", "c"), ("b", "c")):
        sample = np.sort(rng.choice([0, 1, 3], 30))  # nothing is shared at sample 2
        shared[a, b] = Correspondences(sample, rng.uniform(0, 900, (30, 2)), rng.uniform(0, 500, (30, 2)))
    dom = degree_of_misalignment(shared, to_reference, samples)
    for t in (0, 1, 3):
        errors = []
        for (a, b), points in shared.items():
            for i in np.flatnonzero(points.sample == t):
                for source, target, p, q in ((a, b, points.a[i], points.b[i]), (b, a, points.b[i], points.a[i])):
                    x, y = moved(np.linalg.inv(to_reference[target]) @ to_reference[source], *p)
                    errors.append(((x - q[0]) ** 2 + (y - q[1]) ** 2) ** 0.5)
        assert dom[t] == pytest.approx(sum(errors) / len(errors))
    assert np.isnan(dom[2])  # no data is not 0


def test_dom_is_zero_where_all_lies_as_calibrated_and_leaves_out_cameras_without_homography() -> None:
    h = homography(3)
    points = np.random.default_rng(1).uniform(0, 400, (20, 2))
    there = np.array([moved(h, *p) for p in points])
    shared = {
        ("a", "b"): Correspondences(np.zeros(20, np.int64), there, points),
        ("a", "c"): Correspondences(np.zeros(20, np.int64), there, points + 100),
    }
    assert degree_of_misalignment(shared, {"a": np.eye(3), "b": h}, 1)[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize(
    ("values", "tau"),
    [
        ([2.0, 2.0, 2.0, 2.0], 3.0),  # max + 1 is less than twice the mean
        ([1.0, 1.0, 1.0, 9.0], 6.0),  # twice the mean, 3
        ([1.0, np.nan, np.nan, 3.0], 4.0),  # both, without what has no data
        ([0.0, 0.0], 0.0),
    ],
)
def test_the_threshold_is_the_papers(values, tau) -> None:
    assert threshold(np.array(values)) == pytest.approx(tau)


def test_the_threshold_of_nothing_is_nothing() -> None:
    assert np.isnan(threshold(np.full(3, np.nan)))


def test_the_average_skips_what_has_no_data() -> None:
    averaged = moving_average(np.array([1.0, np.nan, 4.0, 10.0, np.nan, np.nan, np.nan]), 3)
    np.testing.assert_allclose(averaged, [1.0, 2.5, 7.0, 7.0, 10.0, np.nan, np.nan])
    np.testing.assert_allclose(moving_average(np.array([2.0, 4.0]), 9), [3.0, 3.0])
    assert len(moving_average(np.zeros(0), 9)) == 0


def test_lone_spikes_are_isolated_and_gaps_stay_gaps() -> None:
    dom = np.random.default_rng(2).normal(5, 0.3, 200)
    dom[[40, 120]] = 300
    dom[60:70] = np.nan
    kept = without_outliers(dom)
    assert np.isnan(kept[[40, 120]]).all()
    assert np.isnan(kept[60:70]).all()
    assert (~np.isnan(kept)).mean() > 0.5
    np.testing.assert_array_equal(kept[~np.isnan(kept)], dom[~np.isnan(kept)])


def test_a_segment_votes_for_the_frame_from_which_four_exceed_within_m() -> None:
    frames = np.arange(0, 1000, 10)
    above = np.zeros(100, bool)
    above[[5, 20, 21, 60, 61, 63, 64]] = True  # two lone ones, then four within 75 frames
    assert first_exceedance(frames, above, within=75, least=4) == 600
    assert first_exceedance(frames, above, within=40, least=4) is None
    assert first_exceedance(frames, above & False, within=75, least=4) is None


def test_the_median_of_the_votes_within_m_is_elected() -> None:
    assert median_vote([900, 100, 110, 105], within=75) == 105
    assert median_vote([300], within=75) == 300
    assert median_vote([], within=75) is None


def test_matches_by_chance_correspond_to_nothing() -> None:
    rng = np.random.default_rng(5)
    a = rng.uniform(0, 640, (60, 2))
    assert homography_inliers(a, rng.uniform(0, 640, (60, 2)), 6.0).sum() <= 12
    there = np.array([moved(homography(4), *p) for p in a])
    there[40:] = rng.uniform(0, 640, (20, 2))
    agree = homography_inliers(a, there, 6.0)
    assert agree[:40].all()
    assert agree[40:].mean() < 0.3
    assert not homography_inliers(a[:5], there[:5], 6.0).any()


def searched(dom: np.ndarray, begin: int = 0) -> int | None:
    return DegreeOfMisalignment()._search_segments(dom, np.arange(len(dom), dtype=np.int64), begin, 1.0)[2]


def series(length: int, *steps: tuple[int, float], seed: int = 0) -> np.ndarray:
    dom = np.random.default_rng(seed).normal(5, 0.4, length)
    for at, height in steps:
        dom[at:] += height
    return dom


@pytest.mark.parametrize(("length", "at"), [(600, 400), (1500, 700), (1500, 1040)])
def test_a_lasting_rise_is_found_where_it_begins(length, at) -> None:
    found = searched(series(length, (at, 25.0)))
    assert found == pytest.approx(at, abs=15)


def test_a_still_lamp_is_left_alone() -> None:
    for seed in range(5):
        assert searched(series(1500, seed=seed)) is None


def test_gaps_do_not_lower_the_mean_that_the_threshold_stands_on() -> None:
    """Frames without matches taken as 0 would halve tau and make every value exceed it."""
    dom = series(900)
    dom[::2] = np.nan
    assert searched(dom) is None
    assert searched(np.full(900, np.nan)) is None


def test_what_lies_before_the_beginning_does_not_count() -> None:
    dom = series(900, (0, 40.0))
    dom[200:] -= 40
    assert searched(dom, begin=250) is None


def test_the_lamp_stands_again_where_dom_against_the_next_calibration_has_settled() -> None:
    dom = series(200)
    dom[:80] += 60
    used = np.arange(120, 124)
    assert DegreeOfMisalignment()._end_of_movement(dom, 60, used) == pytest.approx(80, abs=3)
    assert DegreeOfMisalignment()._end_of_movement(series(200), 119, used) == 120
