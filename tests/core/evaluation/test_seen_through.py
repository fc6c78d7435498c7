"""What is seen through heads, as `mcsl evaluate` and the report tell it, against the pictures with and without."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import peopled_scene as scene
import pytest
from peopled_scene import HEAD, Filmed, Thing, above, programme, write_films

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Edl, FieldStretch
from mcsl_core.evaluation.evaluate import evaluate
from mcsl_core.evaluation.results import SeenThrough, load_evaluation, to_json
from mcsl_core.evaluation.seen_through import seen_through
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.report.steady import steady_facts
from mcsl_core.timing import FrameRange

FROM = 35
FIELD = ((100.0, 50.0), (220.0, 50.0), (220.0, 130.0), (100.0, 130.0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Films of a field before which a head comes, for the first camera alone."""
    at = above("cam1", (0.0, 0.0), HEAD)
    film = Filmed([Thing(HEAD, lambda frame: at if frame >= FROM else None, 50, (150, 90, 40))])
    return write_films(film, tmp_path_factory.mktemp("films"))


def edl_of(camera: str, **changes) -> Edl:
    whole = FrameRange(0, scene.FRAMES)
    return programme(camera, fields=(FieldStretch(whole, "pictures", (FIELD,)),), **changes)


def test_a_head_is_told_with_its_time_and_share(folder: Path) -> None:
    edl = edl_of("cam1")
    (found,) = seen_through(edl, folder, Silent())
    assert found.camera == "cam1"
    assert abs(found.range.start - FROM) <= 5
    assert found.range.stop == scene.FRAMES
    assert sum(found.by.values()) == pytest.approx(found.share)
    assert "cam1" not in found.by

    pictures = []
    for on in (False, True):
        made = attrs.evolve(edl, look=attrs.evolve(edl.look, see_through=on))
        footage = Footage(made.cameras, rate=made.rate, frames=made.frames, base=folder)
        with Compositor(made, footage) as compositor:
            pictures.append(next(iter(compositor.frames(FrameRange(50, 51)))).y[50:130, 100:220].astype(int))
    changed = float((np.abs(pictures[0] - pictures[1]) > 6).mean())
    assert 0.1 < changed < 0.95, "or this says nothing"
    assert changed < found.most < 1.25 * changed, "a rim about the head, where nothing changes, is replaced as well"


@pytest.mark.parametrize("edl", [edl_of("cam3"), edl_of("cam1", see_through=False)])
def test_nothing_is_told_where_nothing_is_seen_through(folder: Path, edl: Edl) -> None:
    assert seen_through(edl, folder, Silent()) == ()


def test_an_evaluation_keeps_it_and_the_report_tells_it(folder: Path, tmp_path: Path) -> None:
    edl = edl_of("cam1")
    found = evaluate(edl, folder, every=0)
    (stretch,) = found.seen_through
    file = tmp_path / "figures.json"
    file.write_text(to_json(found), "utf-8")
    (again,) = load_evaluation(file).seen_through
    assert again.range == stretch.range
    assert again.share == pytest.approx(stretch.share, abs=1e-3)
    told = steady_facts(
        attrs.evolve(found, seen_through=(SeenThrough(FrameRange(30, 70), "cam1", 0.21, 0.4, {}),)), edl.rate
    )
    assert told.seen_through == ("0:03 to 0:07: 21% of it in the mean, 40% at most",)
