"""A small archive: three operations of a few seconds, one that is no recording, and what Snakemake made of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from archive_desk import ODD, SCENE

from mcsl_core.progress import Silent
from mcsl_core.simulation import simulate


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("filmed") / "recording"
    simulate(SCENE, folder, Silent())
    return folder


@pytest.fixture
def archive(recording: Path, tmp_path: Path) -> Path:
    """Two operations, one under an odd name, and one of which a single camera is left."""
    folder = tmp_path / "archive"
    for name in ("op1", ODD, "op3-lost"):
        (folder / name).mkdir(parents=True)
        for file in recording.glob("cam*.mp4"):
            if name != "op3-lost" or file.stem == "cam1":
                shutil.copy2(file, folder / name)
    return folder
