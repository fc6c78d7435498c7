"""Canonical text, strict reading and atomic writing."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from strategies import json_values

from mcsl_core.documents import canonical_json, key_path, parse_json, read_json, write_atomic
from mcsl_core.errors import DocumentError, InputError, McslError


@given(json_values)
def test_canonical_text_is_json_and_settles_at_once(value):
    text = canonical_json(value)
    assert text.endswith("\n")
    assert parse_json(text, where="") == value
    assert canonical_json(parse_json(text, where="")) == text


def test_numbers_are_short_and_never_minus_nothing():
    assert (
        canonical_json([0.1 + 0.2, -0.0, 1 / 3, 1e-6, 12345678901.5])
        == "[0.3, 0.0, 0.3333333333, 1e-06, 12345678900.0]\n"
    )


def test_what_fits_stays_on_a_line_and_what_does_not_is_split_but_for_rows_of_numbers():
    value = {"short": [1, 2], "numbers": list(range(60)), "texts": ["a surgical field"] * 8, "empty": {}}
    assert canonical_json(value).splitlines() == [
        "{",
        '  "short": [1, 2],',
        '  "numbers": ' + json.dumps(list(range(60))) + ",",
        '  "texts": [',
        *['    "a surgical field",'] * 7,
        '    "a surgical field"',
        "  ],",
        '  "empty": {}',
        "}",
    ]


@pytest.mark.parametrize(
    ("name", "step"), [("cam1", ".cam1"), ("Kamera-ö", ".Kamera-ö"), ("a.b", '["a.b"]'), ('"', '["\\""]'), ("", '[""]')]
)
def test_a_step_of_a_path_can_be_told_from_the_next(name, step):
    assert key_path(name) == step


def test_a_byte_order_mark_is_no_fault_and_another_encoding_is(tmp_path):
    path = tmp_path / "edl.json"
    path.write_bytes(b'\xef\xbb\xbf{"a": 1}')
    assert read_json(path) == {"a": 1}
    path.write_bytes(b'{"a": "caf\xe9"}')
    with pytest.raises(DocumentError, match="is not UTF-8 text"):
        read_json(path)


def test_a_folder_cannot_be_read_as_a_document(tmp_path):
    with pytest.raises(InputError, match="is a folder, not a JSON document"):
        read_json(tmp_path)


# ---------------------------------------------------------------------------------------------- atomic writing


def test_folders_are_made_and_nothing_else_is_left(tmp_path):
    path = tmp_path / "new" / "folder" / ("x" * 250 + ".json")  # no room for a longer temporary name
    write_atomic(path, b"one")
    write_atomic(path, b"two")
    assert path.read_bytes() == b"two"
    assert list(path.parent.iterdir()) == [path]


def test_a_new_file_has_the_permissions_that_the_user_asks_for(tmp_path):
    before = os.umask(0o027)
    try:
        write_atomic(tmp_path / "a", b"")
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


def test_a_link_keeps_pointing_at_what_it_names(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    real, link = tmp_path / "elsewhere" / "edl.json", tmp_path / "edl.json"
    real.write_bytes(b"old")
    link.symlink_to(real)
    write_atomic(link, b"new")
    assert link.is_symlink()
    assert real.read_bytes() == b"new"


# A real failure in the middle of writing: the child may write files of at most 4 KiB.
TOO_SMALL_DISK = """
import resource, sys
from pathlib import Path
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
from mcsl_core.documents import write_atomic
from mcsl_core.errors import McslError
try:
    write_atomic(Path(sys.argv[1]), b"x" * 100_000)
except McslError as error:
    print(error)
    sys.exit(error.exit_code)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on file sizes to provoke a failure with")
def test_when_writing_fails_the_old_file_stands_and_no_half_of_the_new_one(tmp_path):
    path = tmp_path / "edl.json"
    path.write_bytes(b"the editor's work")
    child = subprocess.run(
        [sys.executable, "-c", TOO_SMALL_DISK, str(path)],
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[2],
        check=False,
    )
    assert child.returncode == 4, child.stderr
    assert f"{path}: cannot be written (File too large)" in child.stdout
    assert path.read_bytes() == b"the editor's work"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name == "nt", reason="pipes are files elsewhere")
def test_a_pipe_or_what_a_link_leads_to_is_never_replaced_by_a_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link.html").symlink_to(tmp_path / "pipe")
    for name in ("pipe", "link.html"):
        with pytest.raises(InputError, match=f"{name}: cannot be written: it is a pipe, no file"):
            write_atomic(tmp_path / name, b"a page")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_what_cannot_be_replaced_is_named_and_nothing_is_left(tmp_path):
    (tmp_path / "folder").mkdir()
    with pytest.raises(McslError, match="folder: cannot be written"):
        write_atomic(tmp_path / "folder", b"")
    with pytest.raises(InputError, match="cannot be written"):
        write_atomic(Path("/proc/mcsl/edl.json") if Path("/proc").is_dir() else tmp_path / "\0", b"")
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]
