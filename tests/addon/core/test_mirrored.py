"""Which files Blender would show the wrong way round: those whose display matrix mirrors, and no others."""

import pytest
from turned_video import ON_ITS_SIDE, UPRIGHT, write_turned

from blender_addon.core.mirrored import is_mirrored


@pytest.mark.parametrize("suffix", [".mp4", ".mov"])
@pytest.mark.parametrize("matrix", [*UPRIGHT, *ON_ITS_SIDE])
def test_mirroring_is_read_from_the_files_header(tmp_path, matrix, suffix):
    a, b, _, c, d, *_ = matrix
    path = write_turned(tmp_path / f"a{suffix}", matrix)
    assert is_mirrored(path) == (a * d < 0 or b * c > 0)


def test_what_is_no_mp4_is_not_mirrored(tmp_path):
    assert not is_mirrored(tmp_path / "missing.mp4")
    film = write_turned(tmp_path / "a.mp4", UPRIGHT[1]).read_bytes()
    for content in (b"", b"text", film[:40], film[: len(film) // 2], b"\0\0\0\1moov" + b"\xff" * 40, b"\0" * 64):
        (tmp_path / "b.mp4").write_bytes(content)
        is_mirrored(tmp_path / "b.mp4")
    assert not is_mirrored(write_turned(tmp_path / "a.mkv", UPRIGHT[1]))
