"""The whole way on simulated recordings, judged by their truth: what the first release promises.

The truth's own functions (`alignment_error`, `best_plane_error`, `visible_field`) come from the simulator's geometry
and share no code with the analysis.
"""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest

from mcsl_core import edl as document
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.compositing.placement import camera_placement, has_relief
from mcsl_core.edl import Edl, Look, Override
from mcsl_core.edl.following import placed_pose
from mcsl_core.evaluation.evaluate import Variant, evaluate, without_alignment
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, Truth, alignment_error, best_plane_error, simulate
from mcsl_core.simulation.rig import Rig
from mcsl_core.simulation.schedule import lamp_path
from mcsl_core.timing import FrameRange

SCENARIOS = {
    "two movements, blue drapes": Scenario(
        seed=102, duration_s=48, movements=((14.0, 2.0), (30.0, 3.0)), drape="blue", skin="medium", size=(640, 360)
    ),
    "one movement, dark skin, white drapes": Scenario(
        seed=104, duration_s=34, movements=((15.0, 2.5),), skin="dark", drape="white", gloves="blue", size=(640, 360)
    ),
}

pytestmark = pytest.mark.slow


@attrs.frozen
class Case:
    truth: Truth
    edl: Edl
    path: Path


@pytest.fixture(scope="module", params=SCENARIOS, ids=str)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Case:
    folder = tmp_path_factory.mktemp("whole")
    truth = simulate(SCENARIOS[request.param], folder / "recording", Silent())
    path = folder / "edl.json"
    made = analyse([folder / "recording"], path, settings=AnalysisSettings(), plugins=discover(), progress=Silent())
    return Case(truth, made, path)


def test_every_movement_is_found_and_no_other(case: Case) -> None:
    found = [m.range for m in case.edl.movements]
    assert len(found) == len(case.truth.movements)
    for (start, stop), piece in zip(case.truth.movements, found, strict=True):
        # An eased movement's first and last moments are below a pixel; half a second is the promise.
        assert abs(piece.start - start) <= 15
        assert abs(piece.stop - stop) <= 15


def test_alignment_over_the_field_is_near_the_best_single_planes(case: Case) -> None:
    assert not any(p.weak for p in case.edl.poses)
    ratios = {}
    for index, pose in enumerate(case.truth.poses):
        solved = case.edl.pose_at(sum(pose.range) // 2)
        for camera in case.truth.cameras[1:]:
            error = alignment_error(case.truth, index, camera, np.array(solved.homographies[camera]))
            ratios[index, camera] = error / best_plane_error(case.truth, index, camera)
    assert max(ratios.values()) <= 1.5, ratios
    assert np.mean(list(ratios.values())) <= 1.15, ratios


def test_the_perspective_survives_the_movements(case: Case) -> None:
    """The field's points stay where they were in the programme, to a tenth of what the movement did to them."""
    assert {p.perspective for p in case.edl.poses} == {0}
    first = case.truth.poses[0].field_points_px[0]
    for pose in case.truth.poses[1:]:
        anchor = np.array(case.edl.pose_at(sum(pose.range) // 2).anchor)
        points = pose.field_points_px[0]
        moved = np.column_stack([points, np.ones(len(points))]) @ anchor.T
        after = np.sqrt(np.mean(((moved[:, :2] / moved[:, 2:] - first) ** 2).sum(axis=1)))
        before = np.sqrt(np.mean(((points - first) ** 2).sum(axis=1)))
        assert after <= max(0.012 * case.edl.size[0], 0.1 * before)


def test_the_field_stands_still_while_the_lamp_moves(case: Case) -> None:
    """Where the field's points lie in the programme by the followed camera, against where they lay at first."""
    rig, path = Rig.of(case.truth.scenario), lamp_path(case.truth.scenario)
    home = case.truth.poses[0].field_points_px[0]
    assert case.edl.movements
    for movement in case.edl.movements:
        assert movement.views, "the lamp is followed"
        off = []
        for frame in range(movement.range.start, movement.range.stop, 3):
            pose = placed_pose(case.edl, frame)
            for index, name in enumerate(case.truth.cameras):
                own = case.truth.own_frame(name, frame)
                if own is None or not has_relief(case.edl, pose, name):
                    continue
                at = case.truth.clocks[index].programme(own / float(case.truth.rate))
                seen = rig.camera(index, path.pose(at)[0]).project(case.truth.field_points_mm)
                placement = camera_placement(case.edl, pose, name, surface=True)
                assert placement is not None
                off.append(np.hypot(*(placement.to_programme(seen) - home).T))
        off = np.concatenate(off) * 960 / case.edl.size[0]
        assert np.median(off) <= 2
        assert np.percentile(off, 95) <= 6


def test_the_chosen_cameras_see_nearly_what_the_best_would(case: Case) -> None:
    visible = case.truth.visible_field[: case.edl.frames]
    chosen = np.concatenate([np.full(len(s.range), case.truth.cameras.index(s.camera)) for s in case.edl.shots])[
        : len(visible)
    ]
    seen = visible[np.arange(len(visible)), chosen].sum() / visible.max(axis=1).sum()
    assert seen >= 0.96


def test_the_clocks_are_found(case: Case) -> None:
    for camera, true in zip(case.edl.cameras, case.truth.clocks, strict=True):
        assert abs(camera.clock.offset_s - true.offset_s) < 0.02, camera.name


def test_the_programme_is_steadier_than_without_alignment(case: Case) -> None:
    """ITF over the whole, with the same look for both (none): fill shows more of what moves, and matching a darker
    camera's colours amplifies its noise, by 2 and 1 dB of ITF, which says nothing of alignment."""
    plain = Look(centering=False, fill=False, colour=False)
    variants = [Variant("auto", "", case.edl, plain), Variant("no", "", without_alignment(case.edl), plain)]
    auto, no = (row.whole for row in evaluate(case.edl, case.path.parent, variants).measured)
    assert auto is not None
    assert no is not None
    assert auto.itf_db > no.itf_db


def test_a_switch_is_less_of_a_jump_than_without_alignment(case: Case) -> None:
    """The finished programme, with its look, at every switch: what the viewer's eye stumbles over."""
    if len(case.truth.movements) < 2:
        pytest.skip("one camera sees best throughout")
    variants = [Variant("delivered", "", case.edl), Variant("no", "", without_alignment(case.edl))]
    done = evaluate(case.edl, case.path.parent, variants, every=0)
    assert done.switches, "the scenario is meant to need a switch"
    delivered, no = (row.switches.itf_db for row in done.measured)
    assert delivered is not None
    assert no is not None
    assert delivered > no + 1


def test_analysing_again_keeps_the_editors_decisions(case: Case) -> None:
    other = next(c.name for c in case.edl.cameras if c.name != case.edl.shots[0].camera)
    wish = Override(FrameRange(10, 60), camera=other, fill=False, note="the hand hides the suture")
    document.save(attrs.evolve(case.edl, overrides=(wish,)), case.path)
    again = analyse(
        [case.path.parent / "recording"], case.path, settings=AnalysisSettings(), plugins=discover(), progress=Silent()
    )
    assert again.overrides == (wish,)
    assert attrs.evolve(again, overrides=()) == case.edl, "the same input gives the same analysis"
    document.save(case.edl, case.path)
