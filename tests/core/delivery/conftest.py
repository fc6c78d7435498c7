"""What all tests of delivery share: two cameras' files, made once, and chunks of a second."""

from __future__ import annotations

from pathlib import Path

import pytest
from two_cameras import write_sources

from mcsl_core.delivery import chunk_keys


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)


@pytest.fixture(scope="session")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("quellen ü")
    write_sources(folder)
    return folder
