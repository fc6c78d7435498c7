"""What programme pictures depend on: who takes part, where the fill looks, what centering needs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest
from builders import R, small_edl
from hypothesis import given
from strategies import edls

from mcsl_core.edl import Camera, Edl, Look, Override
from mcsl_core.edl.dependencies import (
    fill_views,
    follows_centering,
    offset_bounds,
    offsets_over,
    poses_filled_from,
    views_of,
)
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.edl.resolve import offset_at, resolve_by_pose
from mcsl_core.timing import FrameRange

EDL = small_edl(centering=((0, 5.0, 0.0), (150, 9.0, 1.0), (200, 1.0, 4.0)))


def decided(edl: Edl, frame: int):
    return next((decision, edl.poses[number]) for piece, decision, number in resolve_by_pose(edl) if frame in piece)


def names(edl: Edl, frame: int) -> list[str]:
    decision, pose = decided(edl, frame)
    return [view.camera.name for view in views_of(edl, pose, decision)]


def test_with_fill_all_take_part_without_it_the_shots_camera_and_the_reference() -> None:
    assert names(EDL, 210) == ["cam1", "cam2", "cam3"]
    assert names(attrs.evolve(EDL, look=Look(fill=False)), 210) == ["cam1", "cam3"]
    assert names(attrs.evolve(EDL, look=Look(fill=False)), 10) == ["cam1"]


def fills(edl: Edl, camera: Camera) -> bool:
    """Whether the camera's files last from the programme's first frame to its last."""
    length_s = sum(media.frames for media in camera.media) / camera.rate
    begin, end = camera.clock.programme_time(0), camera.clock.programme_time(length_s)
    return begin <= 0 and end >= edl.frames / edl.rate


def test_where_neither_the_shots_camera_nor_the_reference_is_whole_any_may_stand_in() -> None:
    plain = attrs.evolve(EDL, look=Look(fill=False))
    gap = (FrameRange(205, 215),)
    for lacking, found in [({"cam3"}, ["cam1", "cam3"]), ({"cam1", "cam3"}, ["cam1", "cam2", "cam3"])]:
        cameras = tuple(attrs.evolve(c, gaps=gap) if c.name in lacking else c for c in plain.cameras)
        assert names(attrs.evolve(plain, cameras=cameras), 210) == found


@given(edls())
def test_every_view_lies_where_the_edl_says_and_is_in_the_decisions_colours(edl: Edl) -> None:
    for _, decision, number in resolve_by_pose(edl):
        pose = edl.poses[number]
        views = views_of(edl, pose, decision)
        assert [v.camera for v in views] == [c for c in edl.cameras if c in [v.camera for v in views]]
        assert {decision.camera, edl.reference} <= {v.camera.name for v in views}
        for view in views:
            assert view.placement == placement_matrix(edl, pose, view.camera.name)
            matched = pose.colour.get(view.camera.name) if decision.colour else None
            assert view.colour == (None if matched is None else matched.matrix)
        first = {decision.camera, edl.reference}
        if not decision.fill and {v.camera.name for v in views} != first:
            assert all(edl.camera(name).gaps or not fills(edl, edl.camera(name)) for name in first)


@given(edls())
def test_the_fill_looks_at_known_places_while_the_lamp_stands(edl: Edl) -> None:
    for number, pose in enumerate(edl.poses):
        seen = fill_views(edl, number)
        known = [c for c in edl.cameras if placement_matrix(edl, pose, c.name) is not None]
        assert [view.camera for view in seen.views] == known
        assert pose.range.start <= seen.still.start < seen.still.stop <= pose.range.stop
        first, *others = poses_filled_from(edl, number, alone=False)
        assert poses_filled_from(edl, number, alone=True) == (first,)
        same = [i for i, other in enumerate(edl.poses) if other.perspective == pose.perspective]
        assert sorted([*others, number]) == same
        assert first in same


@given(edls())
def test_the_offsets_of_a_part_give_every_frame_in_it(edl: Edl) -> None:
    """Linear between what is told: by numpy's own interpolation."""
    part = edl.poses[0].range
    told = offsets_over(edl, part)
    low, high = offset_bounds(edl, part)
    frames = list(part)
    for axis in (0, 1):
        found = np.interp(frames, [t[0] for t in told], [t[1 + axis] for t in told])
        assert found == pytest.approx([offset_at(edl.centering, f)[axis] for f in frames], abs=1e-6)
        assert (min(found), max(found)) == pytest.approx((low[axis], high[axis]), abs=1e-6)


@pytest.mark.parametrize(
    ("override", "follows"),
    [
        (Override(R(100, 200), note="as it was"), True),
        (Override(R(100, 200), centering=False), False),
        (Override(R(0, 300), offset=(3.0, 4.0)), False),
        (Override(R(110, 190), offset=(3.0, 4.0)), True),  # it glides from the automatic centering and back to it
    ],
    ids=str,
)
def test_who_depends_on_the_centerings_keys(override: Override, follows: bool) -> None:
    edl = attrs.evolve(EDL, shots=(attrs.evolve(EDL.shots[0], range=R(0, 300)),), overrides=(override,))
    assert follows_centering(decided(edl, 150)[0]) is follows


def test_blenders_python_needs_no_numpy_for_it() -> None:
    script = "import sys; sys.modules.update(numpy=None, cv2=None, av=None, cachetools=None)\n"
    script += "import mcsl_core.edl.dependencies, blender_addon.core.stale"
    done = subprocess.run([sys.executable, "-c", script], cwd=Path(__file__).parents[3], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
