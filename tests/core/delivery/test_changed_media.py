"""Damage repaired under equal size is conformed again; keys of the former kind lose nothing that still holds."""

import os
import shutil
from pathlib import Path

import attrs
import pytest
from notes import Notes
from two_cameras import FRAMES, make

from mcsl_core.delivery.chunk_keys import plan_chunks, with_former_keys
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.direct import write_direct
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Edl
from mcsl_core.evaluation.evaluate import evaluate
from mcsl_core.media.fingerprint import fingerprint


@pytest.fixture
def media(sources, tmp_path) -> Path:
    """The sources, each with two megabytes after it, so that the three blocks of former keys do not see all of it."""
    folder = tmp_path / "media"
    shutil.copytree(sources, folder)
    for path in folder.iterdir():
        with path.open("ab") as stream:
            stream.write((4 << 20).to_bytes(4, "big") + b"free" + bytes((4 << 20) - 8))
    return folder


def with_keys(edl: Edl, base: Path, like: str = "") -> Edl:
    """``edl`` as an analysis writes it: with the content keys of its media."""
    cameras = []
    for camera in edl.cameras:
        media = tuple(attrs.evolve(m, fingerprint=fingerprint(base / m.path, like=like)) for m in camera.media)
        cameras.append(attrs.evolve(camera, media=media))
    return attrs.evolve(edl, cameras=tuple(cameras))


def test_a_repaired_copy_of_equal_size_is_conformed_again(media, tmp_path):
    edl, progress = with_keys(make(), media), Notes()
    assert conform(ProgrammeSource(edl, media), tmp_path / "out").made == 5
    state = (media / "b.mp4").stat()
    with (media / "b.mp4").open("r+b") as stream:
        stream.seek(state.st_size - (3 << 20))
        stream.write(b"repaired")
    os.utime(media / "b.mp4", ns=(state.st_atime_ns, state.st_mtime_ns))
    assert conform(ProgrammeSource(edl, media), tmp_path / "out", progress=progress).made == 4  # those that b is in
    assert progress.notes == ["b.mp4 of b has changed since the analysis"]


def test_an_old_edl_is_not_called_changed_and_keeps_its_chunks(media, tmp_path):
    old, progress = with_keys(make(), media, like="0" * 32), Notes()
    assert conform(ProgrammeSource(old, media), tmp_path / "out").made == 5
    assert conform(ProgrammeSource(old, media), tmp_path / "out", progress=progress).made == 0
    assert progress.notes == []


def test_analysed_again_the_chunks_made_before_still_hold(media, tmp_path):
    old, new = with_keys(make(), media, like="0" * 32), with_keys(make(), media)
    before = conform(ProgrammeSource(old, media), tmp_path / "out")
    assert not {c.name for c in before.chunks} & {c.name for c in plan_chunks(new, media)}
    assert plan_chunks(with_former_keys(new), media) == before.chunks
    after = conform(ProgrammeSource(new, media), tmp_path / "out")
    assert after.made == 0
    assert sum(len(chunk.range) for chunk in after.chunks) == FRAMES
    assert all(before.path(chunk).exists() for chunk in before.chunks)  # as timelines that were built before name them


def test_chunks_that_are_older_than_the_media_are_made_again(media, tmp_path):
    """The former keys do not see what was repaired between."""
    old = with_keys(make(), media, like="0" * 32)
    conform(ProgrammeSource(old, media), tmp_path / "out")
    with (media / "a.mp4").open("r+b") as stream:
        stream.seek((media / "a.mp4").stat().st_size - (3 << 20))
        stream.write(b"repaired")
    assert with_keys(make(), media, like="0" * 32) == old
    assert conform(ProgrammeSource(with_keys(make(), media), media), tmp_path / "out").made == 5


def test_whoever_shows_or_measures_changed_media_says_so(media, tmp_path):
    """They did not: views of another film were laid where those of the analysed one lay."""
    edl = with_keys(make(), media)
    with (media / "b.mp4").open("ab") as stream:
        stream.write(b"\0\0\0\x08free")
    for work in (
        lambda progress: write_direct(ProgrammeSource(edl, media), tmp_path / "v.mp4", progress=progress),
        lambda progress: evaluate(edl, media, every=0, progress=progress),
    ):
        progress = Notes()
        work(progress)
        assert [note for note in progress.notes if "changed" in note] == ["b.mp4 of b has changed since the analysis"]
