"""The relief of the simulator's truth through `Programme`: the field's points of every camera come together."""

from __future__ import annotations

from fractions import Fraction

import attrs
import numpy as np
import pytest

import mcsl_core as mcsl
from mcsl_core.edl import IDENTITY, Camera, Edl, Look, Media, Pose, Shot
from mcsl_core.imaging.geometry import to_edl_matrix
from mcsl_core.progress import Silent
from mcsl_core.simulation.recording import simulate
from mcsl_core.simulation.relief_truth import true_relief
from mcsl_core.simulation.scenario import Scenario
from mcsl_core.simulation.truth import best_plane
from mcsl_core.timing import FrameRange

SIZE = (320, 180)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("simulated")
    scenario = Scenario(
        seed=911, duration_s=1, rate=Fraction(5), movements=0, size=SIZE, cameras=3, heads=0, audio=False
    )
    return folder, simulate(scenario, folder, Silent())


def programme_of(folder, truth, **look) -> mcsl.Programme:
    piece = FrameRange(0, truth.frames)
    planes = {c: IDENTITY if c == truth.reference else to_edl_matrix(best_plane(truth, 0, c)) for c in truth.cameras}
    cameras = (
        Camera(name, (Media(file, frames),), truth.size, truth.rate)
        for name, file, frames in zip(truth.cameras, truth.files, truth.camera_frames, strict=True)
    )
    edl = Edl(
        rate=truth.rate,
        size=truth.size,
        frames=truth.frames,
        reference=truth.reference,
        cameras=tuple(cameras),
        poses=(Pose(piece, planes, relief=true_relief(truth, 0, every=2)),),
        shots=(Shot(piece, truth.reference),),
        look=attrs.evolve(Look(centering=False, fill=False, colour=False), **look),
    )
    return mcsl.Programme(edl, folder / "edl.json")


def test_the_field_of_every_camera_lies_on_the_references(recording):
    """By every other point; the ones between are looked at."""
    folder, truth = recording
    seen = truth.poses[0].field_points_px[:, 1::2]
    own = seen[truth.camera_index(truth.reference)]
    inside = np.all((own >= 0) & (own <= np.array(SIZE) - 1), axis=1)
    surface, plane = (programme_of(folder, truth, surface=on) for on in (True, False))
    for name, points in zip(truth.cameras, seen, strict=True):
        off, before = (
            np.linalg.norm(p.to_programme(points, name, 0) - own, axis=1)[inside] * 960 / SIZE[0]
            for p in (surface, plane)
        )
        np.testing.assert_allclose(surface.to_camera(surface.to_programme(points, name, 0), name, 0), points, atol=1e-6)
        if name == truth.reference:
            assert off.max() < 1e-9
            continue
        assert np.median(before) > 1.5
        assert np.median(off) < 0.8
        assert np.sqrt((off**2).mean()) < 0.6 * np.sqrt((before**2).mean())


def test_an_aligned_picture_is_the_programmes(recording):
    folder, truth = recording
    programme = programme_of(folder, truth)
    other = next(c for c in truth.cameras if c != truth.reference)
    programme.override((0, truth.frames), camera=other)
    assert np.array_equal(programme.frame(2), programme.camera_frame(other, 2, aligned=True))
