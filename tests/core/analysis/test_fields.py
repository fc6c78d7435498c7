"""The surgical field through a whole analysis: found or not and said, drawn and used, kept."""

from __future__ import annotations

import shutil
from fractions import Fraction
from pathlib import Path

import attrs
import numpy as np
import pytest

import mcsl_core as mcsl
from mcsl_core import edl as edls
from mcsl_core.analysis.fields import without_claims
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.edl import Edl, FieldStretch, Shot
from mcsl_core.edl.edits import draw_field
from mcsl_core.errors import DocumentError
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.geometry import transform_points
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

SETTINGS = AnalysisSettings(sync="none")
SQUARE = ((120.0, 70.0), (170.0, 70.0), (170.0, 110.0), (120.0, 110.0))


def test_reasons_claim_no_share_of_a_field_where_nothing_shows_one() -> None:
    kinds = ((0, 60, "middle"), (60, 100, "hand"))
    fields = tuple(FieldStretch(FrameRange(start, stop), by, (SQUARE,)) for start, stop, by in kinds)
    shots = tuple(Shot(FrameRange(a, b), "cam1", 0.9, "sees 90% of the field") for a, b in ((0, 50), (50, 100)))
    assert [shot.why for shot in without_claims(shots, fields)] == [
        "sees 90% of the middle of the picture",
        "sees 90% of the field",
    ]


def analysed(recording: Path, out: Path, **settings) -> Edl:
    how = attrs.evolve(SETTINGS, **settings)
    analyse([recording], out, settings=how, plugins=discover(), progress=Silent())
    return edls.load(out)  # to as many digits as are kept


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two poses of six seconds, analysed once; so small that what counts is that the way is gone, not how well."""
    folder = tmp_path_factory.mktemp("drawn")
    small = {"size": (320, 180), "rate": Fraction(5), "cameras": 3, "heads": 0}
    simulate(Scenario(seed=5, duration_s=16, movements=((7, 1.5),), **small), folder / "recording", Silent())
    analysed(folder / "recording", folder / "edl.json")
    return folder


@pytest.fixture
def recording(begun: Path, tmp_path: Path) -> Path:
    """A recording, in a folder of its own with its EDL and what was kept in making that."""
    shutil.copytree(begun, tmp_path, dirs_exist_ok=True)
    return tmp_path / "recording"


@pytest.fixture
def out(recording: Path) -> Path:
    return recording.with_name("edl.json")


def apart_in_field(one: Edl, other: Edl, pose: int) -> float:
    """Programme pixels between where two EDLs lay the cameras in a pose, at most, over the field of the first."""
    corners = np.concatenate([np.array(polygon) for polygon in one.fields[pose].polygons])
    apart = [0.0]
    for name in one.poses[pose].homographies.keys() & other.poses[pose].homographies.keys():
        a, b = (np.array(e.poses[pose].anchor) @ np.array(e.poses[pose].homographies[name]) for e in (one, other))
        own = transform_points(np.linalg.inv(a), corners)
        apart.append(float(np.abs(transform_points(b, own) - corners).max()))
    return max(apart)


@pytest.mark.slow
def test_what_is_drawn_is_used_and_kept_by_the_next_analysis(recording: Path, out: Path) -> None:
    first = edls.load(out)
    assert [f.range for f in first.fields] == [pose.range for pose in first.poses]
    cut = first.poses[0].range.stop - 8
    with mcsl.open(out) as programme:
        programme.set_field(SQUARE, (0, cut), note="wound")
        programme.save()
    second = analysed(recording, out)
    assert edls.load(out).drawn_fields == second.drawn_fields
    assert second.drawn_fields[0].note == "wound"
    assert second.fields[0] == FieldStretch(FrameRange(0, cut), "hand", (SQUARE,))
    assert second.fields[1] == attrs.evolve(first.fields[0], range=FrameRange(cut, first.fields[0].range.stop))
    assert second.fields[2].by == first.fields[1].by
    assert apart_in_field(first, second, 1) < 2, "the other pose is tied to this one, and lies as it did"
    assert second.poses[0] != first.poses[0], "the cameras are laid by the field that is drawn"
    third = analysed(recording, out)
    assert third == second, "and once more, from what is kept"


@pytest.mark.slow
def test_the_middle_of_what_is_drawn_is_centred(recording: Path, out: Path) -> None:
    """A field at the left edge moves the picture to the right as far as centering goes."""
    left = ((2.0, 60.0), (40.0, 60.0), (40.0, 120.0), (2.0, 120.0))
    edls.save(draw_field(edls.load(out), (left,)), out)
    again = analysed(recording, out)
    assert again.centering[0][1] > 50
    assert {f.by for f in again.fields} == {"hand"}
    with pytest.raises(DocumentError, match="perspective of 'cam1'"):
        analysed(recording, out, reference="cam2")
    assert edls.load(out) == again, "nothing is written then"
