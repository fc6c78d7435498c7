"""A long day: 2,000 shots and 5,000 centering keys come back as they went in. The times are printed (`pytest -rP`),
not judged."""

from __future__ import annotations

import random
import time

import attrs
from blender_recording import LIGHT, R, an_edl, in_blender

from mcsl_core import edl as edls
from mcsl_core.blender.timeline import build_timeline, pull_overrides
from mcsl_core.edl import IDENTITY, Override, Pose, Shot

FRAMES, SHOTS = 120_000, 2_000


def test_two_thousand_shots(project, blender):
    chance = random.Random(1)
    cuts = [0, *sorted(chance.sample(range(1, FRAMES), SHOTS - 1)), FRAMES]
    names = list(LIGHT)
    shots = tuple(Shot(R(a, b), names[i % 3]) for i, (a, b) in enumerate(zip(cuts, cuts[1:], strict=False)))
    edl = an_edl(
        frames=FRAMES,
        poses=tuple(Pose(R(a, a + 40_000), dict.fromkeys(LIGHT, IDENTITY)) for a in (0, 40_000, 80_000)),
        shots=shots,
        overrides=(),
        movements=(),
        centering=tuple((24 * i, chance.randint(-9, 9) / 2, chance.randint(-9, 9) / 2) for i in range(5_000)),
    )
    edls.save(edl, project / "edl.json")
    begun = time.perf_counter()
    build_timeline(project / "edl.json", project / "edit.blend", blender=blender)
    print(f"build: {time.perf_counter() - begun:.2f} s")
    begun = time.perf_counter()
    assert pull_overrides(project / "edit.blend", blender=blender).overrides == ()
    print(f"pull: {time.perf_counter() - begun:.2f} s")
    # every second shot goes to the camera of the one before it
    code = """
        shown = sorted((s for s in strips if s.type == "MULTICAM"), key=lambda s: span(s))
        for before, strip in zip(shown[::2], shown[1::2]): strip.multicam_source = before.multicam_source
    """
    in_blender(blender, project / "edit.blend", code)
    expected = tuple(
        Override(after.range, camera=before.camera) for before, after in zip(shots[::2], shots[1::2], strict=True)
    )
    begun = time.perf_counter()
    assert pull_overrides(project / "edit.blend", blender=blender).overrides == expected
    print(f"pull changed: {time.perf_counter() - begun:.2f} s")
    assert attrs.evolve(edls.load(project / "edl.json"), overrides=()) == edl
