"""A conformed chunk depends on a relief where it is laid by it, and nowhere else."""

from __future__ import annotations

import attrs
import peopled_scene
import pytest
import relief_scene as scene
from two_cameras import FRAMES, SIZE, make, write_sources

from mcsl_core.delivery.chunk_keys import plan_chunks
from mcsl_core.edl import Colour, Correction, Override, from_json, to_json
from mcsl_core.timing import FrameRange


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sources")
    write_sources(folder)
    return folder


def keys(edl, base):
    return [chunk.key for chunk in plan_chunks(edl, base)]


def with_relief(edl, height=6.0):
    relief = scene.pose_of(FRAMES, SIZE, height=height).relief
    return attrs.evolve(edl, poses=(attrs.evolve(edl.poses[0], relief=relief),))


@pytest.mark.parametrize("fill", [False, True])
def test_a_relief_changes_what_is_laid_by_it(base, fill):
    look = attrs.evolve(make().look, fill=fill)
    plain = make(look=look)
    made = with_relief(plain)
    assert keys(made, base) != keys(plain, base)
    assert keys(with_relief(plain, 5.0), base) != keys(made, base)
    assert keys(from_json(to_json(made)), base) == keys(made, base), "it is what the document keeps"


@pytest.mark.parametrize("fill", [False, True])
def test_where_surface_is_off_or_there_is_no_relief_nothing_changes(base, fill):
    on = attrs.evolve(make().look, fill=fill)
    off = attrs.evolve(on, surface=False)
    expected = keys(make(look=on), base)
    assert keys(make(look=off), base) == expected
    assert keys(with_relief(make(look=off)), base) == expected
    switched = attrs.evolve(with_relief(make(look=on)), overrides=(Override(FrameRange(0, FRAMES), surface=False),))
    assert keys(switched, base) == expected
    one_stretch = make(look=on, overrides=(Override(FrameRange(3, 9), surface=False),))
    assert keys(one_stretch, base) == expected


@pytest.mark.parametrize("fill", [False, True])
def test_seeing_through_changes_chunks_where_pictures_lie_by_a_relief_and_only_there(base, fill):
    on = attrs.evolve(make().look, fill=fill, see_through=True)
    off = attrs.evolve(on, see_through=False)
    plain = make(look=off)
    assert keys(make(look=on), base) == keys(plain, base), "no relief"
    by_planes = attrs.evolve(on, surface=False)
    assert keys(with_relief(make(look=by_planes)), base) == keys(plain, base)
    seen = keys(with_relief(make(look=on)), base)
    assert all(a != b for a, b in zip(seen, keys(with_relief(plain), base), strict=True))
    override = Override(FrameRange(0, FRAMES), see_through=True)
    assert keys(attrs.evolve(with_relief(plain), overrides=(override,)), base) == seen, "whoever decided it"


def longer(*, see_through: bool, late: int = 0):
    """40 s at 10 frames a second; the lamp is followed from frame 201 on."""
    made, by = peopled_scene.followed_programme("cam1", see_through=see_through), 203 - peopled_scene.MOVES.start
    (movement,), (before, after) = made.movements, made.poses
    views = [attrs.evolve(view, frame=view.frame + by) for view in movement.views]
    views[-1] = attrs.evolve(views[-1], frame=views[-1].frame + late)
    moves = FrameRange(movement.range.start + by, movement.range.stop + by)
    movement = attrs.evolve(movement, range=moves, views=tuple(views))
    ranges = FrameRange(0, movement.middle), FrameRange(movement.middle, 400)
    poses = tuple(attrs.evolve(pose, range=piece) for pose, piece in zip((before, after), ranges, strict=True))
    shots = (attrs.evolve(made.shots[0], range=FrameRange(0, 400)),)
    return attrs.evolve(made, frames=400, movements=(movement,), poses=poses, shots=shots)


@pytest.fixture(scope="module")
def films(tmp_path_factory):
    folder = tmp_path_factory.mktemp("films")
    return peopled_scene.write_films(peopled_scene.Filmed([]), folder)


@pytest.mark.parametrize(("see_through", "touched"), [(False, [20, 21]), (True, [19, 20, 21, 22])])
def test_how_the_lamp_is_followed_changes_what_is_seen_through_a_moment_before_as_well(films, see_through, touched):
    first, other = (keys(longer(see_through=see_through, late=late), films) for late in (0, 1))
    assert [n for n, (a, b) in enumerate(zip(first, other, strict=True)) if a != b] == touched


def test_in_movements_what_is_seen_through_depends_on_the_poses_beside(films):
    """Their cameras show what there is where nobody is."""
    made = longer(see_through=True)
    darker = Colour(((0.9, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
    after = attrs.evolve(made.poses[1], colour={"cam2": darker})
    first, other = (keys(edl, films) for edl in (made, attrs.evolve(made, poses=(made.poses[0], after))))
    assert [a != b for a, b in zip(first, other, strict=True)] == [n >= 19 for n in range(40)], "a chunk a second"


@pytest.mark.parametrize("see_through", [False, True])
def test_a_nudge_over_a_movement_alone_changes_what_is_shown_in_it(films, see_through):
    made = longer(see_through=see_through)
    nudge = Correction(FrameRange(202, 210), "cam1", ((1.0, 0.0, 3.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    first, other = (keys(edl, films) for edl in (made, attrs.evolve(made, corrections=(nudge,))))
    changed = {n for n, (a, b) in enumerate(zip(first, other, strict=True)) if a != b}
    assert {20, 21} <= changed <= {19, 20, 21, 22}


def test_where_poses_meet_without_a_movement_both_tell_what_is_behind_heads(films):
    made = attrs.evolve(longer(see_through=True), movements=())
    cut = made.poses[1].range.start
    darker = Colour(((0.9, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
    other = attrs.evolve(made, poses=(made.poses[0], attrs.evolve(made.poses[1], colour={"cam2": darker})))
    same = [a == b for a, b in zip(keys(made, films), keys(other, films), strict=True)]
    assert same.index(False) == (cut - 1) // 10
    assert not any(same[cut // 10 :])
