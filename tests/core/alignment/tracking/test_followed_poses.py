"""Poses that are badly tied, placed by following the lamp there: a simulated recording's, spoilt, against the truth."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from fractions import Fraction
from pathlib import Path

import attrs
import numpy as np
import pytest
from attrs import frozen

from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.tracking.followed_poses import PosePlacer
from mcsl_core.analysis.cache import POSES
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.compositing.placement import camera_placement
from mcsl_core.edl import Edl, Weak
from mcsl_core.edl.movement import unfollowed
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.geometry import inverse, scaling, to_edl_matrix, to_edl_projection, transform_points
from mcsl_core.imaging.masks import polygon_mask
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.simulation import Scenario, Truth, simulate

SCENARIO = Scenario(
    seed=31, duration_s=20, movements=((9.0, 1.5),), size=(480, 270), rate=Fraction(10), heads=1, relief_mm=20
)
SHIFTED = np.array([[1, 0, 14.0], [0, 1, -9.0], [0, 0, 1]])
BY_THE_RIM = np.array([[1.03, 0.02, 5.0], [-0.01, 0.98, -8.0], [8e-5, -6e-5, 1]])  # of a head before it
WEAK = Weak("cam3", "a head hid the field")

pytestmark = pytest.mark.slow


@frozen(eq=False)
class Solved:
    """What was analysed, the poses as their own pictures tie them, and what places them anew."""

    truth: Truth
    edl: Edl
    poses: list[SolvedPose]
    placer: PosePlacer

    def off(self, poses: list[SolvedPose], index: int, camera: str) -> float:
        """Median over the field's points, pixels of 960, of how far the programme shows them from where they belong."""
        made = attrs.evolve(self.edl, poses=tuple(pose.pose for pose in poses))
        placement = camera_placement(made, made.poses[index], camera, surface=True)
        assert placement is not None
        number, home = self.truth.camera_index(camera), self.truth.poses[0].field_points_px[0]
        shown = placement.to_programme(self.truth.poses[index].field_points_px[number])
        return float(np.median(np.hypot(*(shown - home).T))) * 960 / made.size[0]


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Solved]:
    folder: Path = tmp_path_factory.mktemp("followed")
    truth = simulate(SCENARIO, folder / "recording", Silent())
    made = analyse(
        [folder / "recording"],
        folder / "edl.json",
        settings=AnalysisSettings(movement_view="hold"),
        plugins=discover(),
        progress=Silent(),
    )
    cache = folder / "edl.cache"
    with np.load(next(cache.glob("poses-*.npz"))) as arrays:
        poses = POSES.unpack(dict(arrays))
    samples = SampleStore.load(next(cache.glob("samples-*.json")).with_suffix(""))
    assert samples is not None
    footage = Footage(made.cameras, rate=made.rate, frames=made.frames, base=folder)
    with closing(samples):
        placer = PosePlacer(samples, footage, unfollowed(made.movements), made.reference)
        yield Solved(truth, made, poses, placer)


def spoilt(pose: SolvedPose) -> SolvedPose:
    """Without a relief, its planes and its anchor 17 px off, and a camera weak."""
    homographies = {
        name: h if name == pose.aligned.reference else SHIFTED @ h
        for name, h in pose.aligned.homographies.items()
        if name != WEAK.camera
    }
    made = attrs.evolve(
        pose.pose,
        homographies={name: to_edl_matrix(h) for name, h in homographies.items()},
        anchor=to_edl_matrix(SHIFTED @ np.array(pose.pose.anchor)),
        relief=None,
        weak=(WEAK,),
    )
    return attrs.evolve(pose, pose=made, aligned=attrs.evolve(pose.aligned, homographies=homographies))


def test_poses_that_are_well_tied_stay_but_for_heights_that_the_other_knows_better(solved: Solved) -> None:
    assert len(solved.poses) == 2
    placed = solved.placer.place(solved.poses, Silent())
    for number, (before, after) in enumerate(zip(solved.poses, placed, strict=True)):
        own, shared = before.pose.relief, after.pose.relief
        assert own is not None, "or this says nothing"
        assert shared is not None
        assert attrs.evolve(after.pose, relief=own) == before.pose
        assert after.aligned is before.aligned
        assert shared.projections == own.projections
        assert (np.array(shared.confidence) >= np.array(own.confidence)).all()
        for camera in solved.truth.cameras:
            assert solved.off(placed, number, camera) < solved.off(solved.poses, number, camera) + 0.1


def test_a_reference_camera_that_a_head_hid_is_laid_as_the_lamp_holds_it(solved: Solved) -> None:
    """In the first pose, where it was tied by what is about the head: the programme is laid over where it stands."""
    first, second = solved.poses
    relief = first.pose.relief
    assert relief is not None
    wrong = BY_THE_RIM @ np.array(relief.projections[solved.edl.reference])
    projections = {**relief.projections, solved.edl.reference: to_edl_projection(wrong)}
    tied = attrs.evolve(first, pose=attrs.evolve(first.pose, relief=attrs.evolve(relief, projections=projections)))
    placed = solved.placer.place([tied, second], Silent())
    for number in range(2):
        for camera in solved.truth.cameras:
            assert solved.off(placed, number, camera) < 2.5


def test_a_later_pose_comes_right_by_the_one_before(solved: Solved) -> None:
    first, second = solved.poses
    placed = solved.placer.place([first, spoilt(second)], Silent())
    assert placed[0] is first
    assert not placed[1].pose.weak
    assert placed[1].aligned.homographies.keys() == second.aligned.homographies.keys()
    for camera in solved.truth.cameras:
        assert solved.off(placed, 1, camera) < 2.5


def test_the_first_pose_comes_right_by_the_one_after_and_stays_what_the_programme_is_laid_over(solved: Solved) -> None:
    """What was anchored to the bad first pose was 17 px off as a whole."""
    first, second = solved.poses
    shifted = attrs.evolve(second.pose, anchor=to_edl_matrix(SHIFTED @ np.array(second.pose.anchor)))
    assert shifted.relief is not None
    back = np.insert(np.insert(inverse(SHIFTED), 3, 0, axis=0), 3, 0, axis=1)
    back[3, 3] = 1
    own = {name: np.array(p) @ back for name, p in shifted.relief.projections.items()}
    relief = attrs.evolve(shifted.relief, projections={name: to_edl_projection(p / p[2, 2]) for name, p in own.items()})
    moved = attrs.evolve(second, pose=attrs.evolve(shifted, relief=relief))
    bad = attrs.evolve(spoilt(first), pose=attrs.evolve(spoilt(first).pose, anchor=first.pose.anchor))
    placed = solved.placer.place([bad, moved], Silent())
    np.testing.assert_allclose(np.array(placed[0].pose.anchor), np.eye(3), atol=1e-6)
    for index in (0, 1):
        for camera in solved.truth.cameras[1 - index :]:
            assert solved.off(placed, index, camera) < 2.5


def test_a_camera_that_one_pose_hides_is_placed_as_the_lamp_holds_it(solved: Solved) -> None:
    first, second = solved.poses
    assert second.pose.relief is not None
    fewer = {name: p for name, p in second.pose.relief.projections.items() if name != WEAK.camera}
    homographies = {name: h for name, h in second.aligned.homographies.items() if name != WEAK.camera}
    pose = attrs.evolve(
        second.pose,
        relief=attrs.evolve(second.pose.relief, projections=fewer),
        homographies={name: to_edl_matrix(h) for name, h in homographies.items()},
        weak=(WEAK,),
    )
    hidden = attrs.evolve(second, pose=pose, aligned=attrs.evolve(second.aligned, homographies=homographies))
    placed = solved.placer.place([first, hidden], Silent())
    assert not placed[1].pose.weak
    assert solved.off(placed, 1, WEAK.camera) < 3.5


def test_a_pose_that_lacks_cameras_and_contradicts_a_whole_one_is_placed_anew(solved: Solved) -> None:
    """A head hid the field from a camera, and what the reference showed was tied 17 px off."""
    first, second = solved.poses
    assert second.pose.relief is not None
    own = {n: np.array(p) for n, p in second.pose.relief.projections.items() if n != WEAK.camera}
    own[second.aligned.reference] = inverse(SHIFTED) @ own[second.aligned.reference]
    relief = attrs.evolve(
        second.pose.relief, projections={name: to_edl_projection(p / p[2, 2]) for name, p in own.items()}
    )
    bad = attrs.evolve(second, pose=attrs.evolve(second.pose, relief=relief))
    placed = solved.placer.place([first, bad], Silent())
    assert solved.off([first, bad], 1, second.aligned.reference) > 10, "or this says nothing"
    for camera in solved.truth.cameras:
        assert solved.off(placed, 1, camera) < 2.5


def test_a_relief_that_no_rigid_rig_explains_spoils_no_other_and_its_pose_is_placed_anew(solved: Solved) -> None:
    """Of three cameras, two of which saw a head: with it no rig was found, and nothing placed or followed."""
    first, second = solved.poses
    assert second.pose.relief is not None
    own = {n: np.array(second.pose.relief.projections[n]) for n in ("cam1", "cam2", "cam4")}
    rng = np.random.default_rng(6)
    for name in ("cam2", "cam4"):
        own[name] = own[name] * rng.uniform(0.7, 1.4, (3, 4))
    relief = attrs.evolve(
        second.pose.relief, projections={name: to_edl_projection(p / p[2, 2]) for name, p in own.items()}
    )
    bad = attrs.evolve(second, pose=attrs.evolve(second.pose, relief=relief))
    placed = solved.placer.place([first, bad], Silent())
    assert placed[1] is not bad
    for camera in solved.truth.cameras:
        assert solved.off(placed, 1, camera) < 2.5


def test_a_field_that_is_drawn_stays_where_it_was_drawn(solved: Solved) -> None:
    """Over programme pixels, whatever the anchor becomes."""
    first, second = solved.poses
    bad = spoilt(second)
    size, full = bad.aligned.size, bad.aligned.camera_sizes[bad.aligned.reference]
    polygon = np.array([[180, 90], [300, 90], [300, 180], [180, 180.0]])

    def in_pose(pose: SolvedPose) -> np.ndarray:
        to_aligned = scaling(full, size) @ inverse(np.array(pose.pose.anchor))
        return polygon_mask([transform_points(to_aligned, polygon)], size)

    bad = attrs.evolve(bad, drawn=((bad.pose.range, in_pose(bad)),))
    placed = solved.placer.place([first, bad], Silent())[1]
    ((piece, mask),) = placed.drawn
    assert piece == bad.pose.range
    wanted = in_pose(placed)
    assert (mask & wanted).sum() > 0.97 * (mask | wanted).sum()
    assert (mask & in_pose(bad)).sum() < 0.9 * (mask | in_pose(bad)).sum(), "or this says nothing"
