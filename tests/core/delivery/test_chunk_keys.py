"""Keys change with what the pixels depend on and nothing else; media of different qualities lie side by side."""

import shutil

import attrs
import pytest
from two_cameras import FRAMES, make

from mcsl_core.blender.timeline import in_place
from mcsl_core.compositing.placement import fully_covered
from mcsl_core.delivery.chunk_keys import plan_chunks
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.quality import DRAFT, QUALITIES, STANDARD, quality_named
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import IDENTITY as EYE
from mcsl_core.edl import Clock, Colour, Look, Override, Pose, Shot
from mcsl_core.errors import InputError, UsageError
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.timing import FrameRange


def changed(before, after):
    return [a.range.start for a, b in zip(before, after, strict=True) if a.key != b.key]


def test_chunks_tile_the_programme(sources):
    chunks = plan_chunks(make(), sources)
    assert [c.range for c in chunks] == [FrameRange(s, min(s + 30, FRAMES)) for s in range(0, FRAMES, 30)]
    assert len({c.name for c in chunks}) == len(chunks)
    assert plan_chunks(make(), sources) == chunks


def test_keys_follow_what_the_pixels_depend_on(sources, tmp_path):
    base = plan_chunks(make(), sources)

    def diff(**changes):
        return changed(base, plan_chunks(make(**changes), sources))

    every = [0, 30, 60, 90, 120]
    assert diff(overrides=(Override(FrameRange(70, 75), camera="a"),)) == [60]
    assert diff(overrides=(Override(FrameRange(10, 40), camera="a"),)) == []  # what was chosen anyway
    assert diff(overrides=(Override(FrameRange(10, 40), note="nice"),)) == []
    assert diff(overrides=(Override(FrameRange(55, 95), fill=True),)) == [30, 60, 90]
    assert diff(shots=(Shot(FrameRange(0, 45), "a"), Shot(FrameRange(45, FRAMES), "b"))) == [30]
    assert diff(centering=((0, 5.0, 5.0),)) == []  # centering is off
    assert diff(poses=(Pose(FrameRange(0, FRAMES), {"a": EYE, "b": ((1.0, 0, 1), (0, 1.0, 0), (0, 0, 1.0))}),)) == [
        30,
        60,
        90,
        120,
    ]
    assert (
        diff(poses=(Pose(FrameRange(0, FRAMES), {"a": EYE, "b": EYE}, anchor=((1.0, 0, 1), (0, 1.0, 0), (0, 0, 1.0))),))
        == every
    )
    grey = Colour(((1.0, 0, 0, 0), (0, 0, 0, 128.0), (0, 0, 0, 128.0)))
    assert diff(poses=(Pose(FrameRange(0, FRAMES), {"a": EYE, "b": EYE}, colour={"b": grey}),)) == []  # colour is off
    cameras = make().cameras
    late = attrs.evolve(cameras[1], clock=Clock(offset_s=1.1))
    assert diff(cameras=(cameras[0], late)) == [30, 60, 90, 120]
    centred = make(look=Look(True, False, False), centering=((0, 0.0, 0.0), (60, 0.0, 0.0), (90, 9.0, 0.0)))
    moved = attrs.evolve(centred, centering=((0, 0.0, 0.0), (60, 0.0, 0.0), (90, 12.0, 0.0)))
    assert changed(plan_chunks(centred, sources), plan_chunks(moved, sources)) == [60, 90, 120]
    assert changed(base, plan_chunks(make(), sources, quality=DRAFT)) == every
    assert changed(base, plan_chunks(make(), sources, quality=attrs.evolve(STANDARD, resampling="lanczos"))) == every
    assert changed(base, plan_chunks(make(), sources, quality=attrs.evolve(STANDARD, group=7))) == every
    # Where the filler remembers the frames before, those of its block of ten seconds count too.
    remembered = plan_chunks(make(), sources, filler=PaperFiller())
    touched = plan_chunks(make(overrides=(Override(FrameRange(50, 59), camera="a"),)), sources, filler=PaperFiller())
    assert changed(remembered, touched) == [30, 60, 90, 120]


def test_a_drift_of_colours_touches_the_chunks_that_it_lies_in(sources):
    """Without fill; the fill takes from pictures of any time of the pose."""

    def plan(*keys, **look):
        pose = Pose(FrameRange(0, FRAMES), {"a": EYE, "b": EYE}, colour_keys={"b": keys} if keys else {})
        return plan_chunks(make(poses=(pose,), look=Look(**{"centering": False, "fill": False, **look})), sources)

    flat = [(frame, 1.0, 1.0, 1.0) for frame in (0, 60, 90, 110, 129)]
    other = [*flat[:3], (110, 1.1, 1.0, 1.0), flat[4]]
    shown = [chunk.range.start for chunk in plan() if chunk.range.start >= 30]  # before it camera a alone is shown
    assert changed(plan(*flat), plan(*other)) == [90, 120]
    assert changed(plan(), plan(*flat)) == shown
    assert changed(plan(*flat, fill=True), plan(*other, fill=True)) == [0, 30, 60, 90, 120]
    assert changed(plan(*flat, colour=False), plan(*other, colour=False)) == []
    assert changed(plan(colour=False), plan(*other, colour=False)) == []


def test_a_plan_looks_at_the_cameras_footprints_once_a_pose_however_many_shots(sources, monkeypatch):
    asked = []
    covered = fully_covered
    monkeypatch.setattr(
        "mcsl_core.delivery.chunk_keys.fully_covered", lambda *given: asked.append(given) or covered(*given)
    )
    shots = tuple(Shot(FrameRange(n, n + 2), "ab"[n // 2 % 2]) for n in range(0, FRAMES, 2))
    edl = make(shots=shots, look=Look(True, True, False), centering=((0, 0.0, 0.0), (FRAMES - 1, 13.0, -5.0)))
    assert len(plan_chunks(edl, sources)) == 5
    assert [given[2] for given in asked] == [((0.0, -5.0), (13.0, 0.0))]


def test_keys_follow_the_content_of_sources_not_their_place(sources, tmp_path):
    elsewhere = tmp_path / "moved"
    shutil.copytree(sources, elsewhere)
    base = plan_chunks(make(), sources)
    assert plan_chunks(make(), elsewhere) == base
    with (elsewhere / "b.mp4").open("ab") as stream:
        stream.write(b"x")
    assert changed(base, plan_chunks(make(), elsewhere)) == [30, 60, 90, 120]
    (elsewhere / "b.mp4").unlink()
    with pytest.raises(InputError, match=r"b\.mp4"):
        plan_chunks(make(), elsewhere)


def test_qualities_lie_beside_each_other_and_a_timeline_takes_the_finest(sources, tmp_path):
    made = {
        name: conform(ProgrammeSource(make(), sources), tmp_path, quality=quality)
        for name, quality in QUALITIES.items()
    }
    assert [done.made for done in made.values()] == [5, 5, 5]
    names = [chunk.name for done in made.values() for chunk in done.chunks]
    assert len(set(names)) == len(names)
    sizes = [sum(done.path(chunk).stat().st_size for chunk in done.chunks) for done in made.values()]
    assert sizes == sorted(sizes)

    def there(edl=None):
        pieces, _ = in_place(edl or make(), sources, tmp_path)
        return [piece.path.name for piece in pieces]

    fine, standard, draft = ([c.name for c in made[name].chunks] for name in ("fine", "standard", "draft"))
    assert there() == fine
    made["fine"].path(made["fine"].chunks[1]).unlink()
    made["fine"].path(made["fine"].chunks[3]).unlink()
    made["standard"].path(made["standard"].chunks[3]).unlink()
    assert there() == [fine[0], standard[1], fine[2], draft[3], fine[4]]
    decided = make(overrides=(Override(FrameRange(70, 75), camera="a"),))
    assert there(decided) == [fine[0], standard[1], draft[3], fine[4]]
    again = conform(ProgrammeSource(decided, sources), tmp_path, quality=DRAFT)
    assert again.made == 1
    assert there(decided) == [fine[0], standard[1], again.chunks[2].name, draft[3], fine[4]]


def test_a_quality_has_a_name():
    assert quality_named("draft") is DRAFT
    assert [quality.name for quality in QUALITIES.values()] == list(QUALITIES)
    with pytest.raises(UsageError, match="draft, standard, fine"):
        quality_named("best")
