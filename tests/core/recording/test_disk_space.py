"""What will be written is told beforehand, and refused where the disk has not nearly so much."""

import shutil
from collections import namedtuple

import pytest
from notes import Notes
from two_cameras import make, write_sources

from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.errors import McslError
from mcsl_core.progress import Silent
from mcsl_core.recording.disk_space import tell_of_space
from mcsl_core.recording.footage import footage_of
from mcsl_core.recording.sample_store import SampleStore

Usage = namedtuple("Usage", "total used free")


def free(monkeypatch, count):
    monkeypatch.setattr(shutil, "disk_usage", lambda path: Usage(10**13, 0, count))


def test_an_hour_of_it_is_told_with_what_is_free(monkeypatch, tmp_path):
    free(monkeypatch, 40 * 10**9)
    notes = Notes()
    tell_of_space("The samples", tmp_path / "not" / "there", 6.3e9, 3 * 3600, notes)
    (note,) = notes.notes
    assert "about 6.3 GB (2.1 GB an hour)" in note
    assert "40.0 GB are free" in note
    tell_of_space("The samples", tmp_path, 5e6, 60, notes)
    assert len(notes.notes) == 1, "little is not worth a word"


def test_less_than_needed_is_warned_of_and_less_than_half_refused(monkeypatch, tmp_path):
    free(monkeypatch, 5 * 10**9)
    notes = Notes()
    tell_of_space("The samples", tmp_path, 6.3e9, 3600, notes)
    assert "may not be enough" in notes.notes[0]
    with pytest.raises(McslError, match=r"would take about 12\.0 GB") as caught:
        tell_of_space("The samples", tmp_path, 12e9, 3600, notes)
    assert caught.value.remedy


def test_analysis_and_conform_begin_nothing_on_a_full_disk(monkeypatch, tmp_path):
    write_sources(tmp_path)
    edl = make()
    free(monkeypatch, 10_000)
    with pytest.raises(McslError, match="The samples would take"):
        SampleStore.record(footage_of(edl, tmp_path), tmp_path / "samples", Silent())
    assert not (tmp_path / "samples").exists()
    with pytest.raises(McslError, match="The conformed pictures would take"):
        conform(ProgrammeSource(edl, tmp_path), tmp_path / "out")
    assert not list((tmp_path / "out").glob("*.mp4"))
