"""A content key sees any changed byte, is worked out once for each state of a file, and compares with former kinds."""

import os
import shutil
import time

import numpy as np
import pytest

from mcsl_core.errors import InputError
from mcsl_core.media import fingerprint as module
from mcsl_core.media.fingerprint import FORMER, fingerprint, newest_change_s

SIZE = 12 << 20


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "camera.mp4"
    path.write_bytes(np.random.default_rng(0).integers(0, 256, SIZE, dtype=np.uint8).tobytes())
    return path


@pytest.fixture
def reads(tmp_path, monkeypatch):
    """The files that were read, with keys remembered in a folder of the test's own."""
    monkeypatch.setattr(module.platformdirs, "user_cache_dir", lambda name: str(tmp_path / "remembered"))
    read, whole = [], module._of_all
    monkeypatch.setattr(module, "_of_all", lambda path, told: read.append(path) or whole(path, told))
    return read


def settle(path, monkeypatch):
    """As if some time had passed since the file was written."""
    monkeypatch.setattr(module, "_SETTLED_S", -60)


@pytest.mark.parametrize("at", [0, 2 << 20, 3_500_000, 8 << 20, SIZE - 1])
def test_any_changed_byte_is_seen(file, at):
    before = fingerprint(file)
    with file.open("r+b") as stream:
        stream.seek(at)
        old = stream.read(1)
        stream.seek(at)
        stream.write(bytes([old[0] ^ 1]))
    assert fingerprint(file) != before


def test_half_a_megabyte_of_zeros_beside_the_three_blocks_is_seen(file):
    before, former = fingerprint(file), fingerprint(file, like=FORMER)
    with file.open("r+b") as stream:
        stream.seek(2 << 20)
        stream.write(bytes(1 << 19))
    assert fingerprint(file) != before
    assert fingerprint(file, like=former) == former  # why the kind was given up


def test_equal_content_has_an_equal_key_wherever_it_lies(file, tmp_path):
    shutil.copy(file, tmp_path / "copy ü.mp4")
    assert fingerprint(tmp_path / "copy ü.mp4") == fingerprint(file)
    file.write_bytes(file.read_bytes()[:-1])
    assert fingerprint(tmp_path / "copy ü.mp4") != fingerprint(file)
    (tmp_path / "empty").write_bytes(b"")
    assert fingerprint(tmp_path / "empty") == fingerprint(tmp_path / "empty")


def test_a_file_is_read_once(file, reads, monkeypatch):
    settle(file, monkeypatch)
    first = fingerprint(file)
    told = []
    assert fingerprint(file, told=told.append) == first
    assert (reads, told) == ([file], [SIZE])


def test_a_repaired_copy_of_equal_size_under_the_old_date_is_read_again(file, reads, monkeypatch):
    settle(file, monkeypatch)
    before, state = fingerprint(file), file.stat()
    for way in ("in place", "in its place"):
        data = bytearray(file.read_bytes())
        data[5 << 20] ^= 1
        if way == "in place":
            with file.open("r+b") as stream:
                stream.write(data)
        else:
            (file.parent / "repaired").write_bytes(data)
            (file.parent / "repaired").replace(file)
        os.utime(file, ns=(state.st_atime_ns, state.st_mtime_ns))
        now = fingerprint(file)
        assert now != before, way
        before = now
    assert len(reads) == 3


def test_a_file_that_may_still_change_is_not_remembered(file, reads):
    assert time.time() - newest_change_s(file) < 3
    fingerprint(file)
    fingerprint(file)
    assert len(reads) == 2


@pytest.mark.parametrize("broken", [b"", b"blake2b:", b"\xff" * 48])
def test_what_cannot_be_remembered_is_worked_out(file, reads, monkeypatch, tmp_path, broken):
    settle(file, monkeypatch)
    key = fingerprint(file)
    (note,) = (tmp_path / "remembered" / "fingerprints").iterdir()
    assert note.parent.stat().st_mode & 0o077 == 0
    note.write_bytes(broken)
    assert fingerprint(file) == key
    shutil.rmtree(tmp_path / "remembered")
    (tmp_path / "remembered").write_text("no folder")
    assert fingerprint(file) == key


def test_what_cannot_be_read_is_told(tmp_path):
    for like in ("", FORMER):
        with pytest.raises(InputError, match="cannot be read"):
            fingerprint(tmp_path / "none", like=like)
