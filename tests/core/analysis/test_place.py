"""An analysis beside other writers of its EDL, and beside what lies in its place."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from notes import Notes

import mcsl_core as mcsl
from mcsl_core import edl as edls
from mcsl_core.cli.commands.look import change_file
from mcsl_core.errors import InputError
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    simulate(Scenario(seed=5, duration_s=6, size=(320, 180), rate=10, cameras=3, movements=0), folder, Silent())
    return folder


def test_what_is_decided_while_it_is_at_work_is_kept(recording: Path, tmp_path: Path) -> None:
    path = tmp_path / "edl.json"
    mcsl.analyse(recording, path)
    seen: list[str] = []

    class Meanwhile(Silent):
        def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
            if not seen:
                change_file(path, fill=False, start="1", stop="2")
                change_file(path, colour=not edls.load(path).look.colour)
                with pytest.raises(InputError, match="is at work on it"):
                    mcsl.analyse(recording, path)
            seen.append(name)

    before = edls.load(path).look.colour
    made = mcsl.analyse(recording, path, settings=mcsl.AnalysisSettings(cache=False), progress=Meanwhile())
    assert seen
    assert [(o.range.start, o.range.stop, o.fill) for o in made.edl.overrides] == [(10, 20, False)]
    assert made.edl.look.colour is not before
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


@pytest.mark.parametrize("content", [b"\x00\x00\x00\x20ftypisom", b"{", b"{}", b"notes"])
def test_something_else_is_replaced_by_force_alone(recording: Path, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "edl.json"
    path.write_bytes(content)
    with pytest.raises(InputError, match="is there already, and is no EDL"):
        mcsl.analyse(recording, path)
    assert path.read_bytes() == content


class Stages(Notes):
    """stages: those that began, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.stages: list[str] = []

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        super().stage(name, total, unit)
        self.stages.append(name)


@pytest.mark.parametrize("change", [{"reference": "cam2"}, {"rate": 5}])
def test_decisions_that_would_say_something_else_stop_an_analysis_before_its_work(
    recording: Path, tmp_path: Path, change: dict
) -> None:
    """Another reference camera has another first picture: the overrides were kept, over other moments."""
    path = tmp_path / "edl.json"
    mcsl.analyse(recording, path)
    change_file(path, fill=False, start="1", stop="2")
    before, progress = path.read_bytes(), Stages()
    settings = mcsl.AnalysisSettings(cache=False, **change)
    with pytest.raises(InputError, match="the overrides count"):
        mcsl.analyse(recording, path, settings=settings, progress=progress)
    assert path.read_bytes() == before
    assert "Sampling the recording" not in progress.stages


def test_decisions_over_another_recording_are_told(recording: Path, tmp_path: Path) -> None:
    path, other, progress = tmp_path / "edl.json", tmp_path / "other", Stages()
    mcsl.analyse(recording, path)
    change_file(path, fill=False, start="1", stop="2")
    other.mkdir()
    for one, two in (("cam1", "cam2"), ("cam2", "cam1"), ("cam3", "cam3")):
        shutil.copy2(recording / f"{one}.mp4", other / f"{two}.mp4")
    mcsl.analyse(other, path, progress=progress)
    told = "the decisions were made when other files were cam1, cam2: see whether they still hold"
    assert told in progress.notes
