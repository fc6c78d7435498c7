"""Pieces of a film joined: every picture in its order and time, none coded again, the sound beside them."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from coded_video import SIZE, read_number, write_coded
from two_cameras import click_track

from mcsl_core.errors import InputError, MediaError
from mcsl_core.media.appending import append
from mcsl_core.media.writing import Encoding, VideoWriter


def pieces(folder: Path, *ranges: range, **how) -> list[Path]:
    made = [folder / f"{n}.mp4" for n in range(len(ranges))]
    for path, numbers in zip(made, ranges, strict=True):
        write_coded(path, numbers, **how)
    return made


def packets(path: Path) -> list[bytes]:
    with av.open(str(path)) as container:
        return [bytes(packet) for packet in container.demux(video=0) if packet.size]


def test_pictures_follow_each_other_and_keep_their_bytes(tmp_path: Path) -> None:
    made = pieces(tmp_path, range(25), range(25, 50), range(50, 57))
    assert append(made, tmp_path / "out.mp4") == 57
    with av.open(str(tmp_path / "out.mp4")) as container:
        frames = list(container.decode(video=0))
        assert not container.streams.audio
    assert [read_number(frame.to_ndarray(format="gray")) for frame in frames] == list(range(57))
    assert [round(Fraction(frame.time).limit_denominator(1000) * 30) for frame in frames] == list(range(57))
    given = [data for path in made for data in packets(path)]
    joined = packets(tmp_path / "out.mp4")
    # What the encoder says of itself stands before the first picture of each piece, and is left out.
    assert all(old == new or (old.endswith(new) and len(new) > 500) for old, new in zip(given, joined, strict=True))
    assert sum(old != new for old, new in zip(given, joined, strict=True)) == 3


def test_the_sound_is_one_and_the_pieces_own_is_left_out(tmp_path: Path) -> None:
    made = pieces(tmp_path, range(30), range(30, 60), sound=click_track(1, 0.2))
    write_coded(tmp_path / "whole.mp4", range(60), sound=click_track(2, 1.5))
    append(made, tmp_path / "out.mp4", sound=tmp_path / "whole.mp4")
    heard = []
    for name in ("whole.mp4", "out.mp4"):
        with av.open(str(tmp_path / name)) as container:
            heard.append([bytes(packet) for packet in container.demux(audio=0) if packet.size])
    assert heard[0] == heard[1]


def test_a_piece_of_another_encoder_is_refused(tmp_path: Path) -> None:
    made = pieces(tmp_path, range(10))
    write_coded(tmp_path / "other.mp4", range(10), size=(SIZE[0], SIZE[1] + 16))
    with pytest.raises(InputError, match="coded otherwise"):
        append([*made, tmp_path / "other.mp4"], tmp_path / "out.mp4")


def test_a_piece_cut_short_is_told(tmp_path: Path) -> None:
    made = pieces(tmp_path, range(10), range(10, 20))
    made[1].write_bytes(made[1].read_bytes()[:200])
    with pytest.raises((MediaError, InputError)):
        append(made, tmp_path / "out.mp4")


def test_a_piece_that_holds_less_than_it_should_is_refused(tmp_path: Path) -> None:
    made = pieces(tmp_path, range(10), range(10, 18))
    with pytest.raises(InputError, match="holds 8 pictures where its name says 10"):
        append(made, tmp_path / "out.mp4", lengths=(10, 10))
    assert append(made, tmp_path / "out.mp4", lengths=(10, 8)) == 18


def test_matroska_leaves_open_when_pictures_are_decoded(tmp_path: Path) -> None:
    """With pictures that are not shown in the order in which they are coded."""
    made = [tmp_path / "0.mkv", tmp_path / "1.mkv"]
    for path, numbers in zip(made, (range(25), range(25, 50)), strict=True):
        with VideoWriter(path, size=(320, 180), rate=Fraction(30), encoding=Encoding(options={"bf": "2"})) as writer:
            for number in numbers:
                picture = np.full((180, 320, 3), 5 * number, np.uint8)
                picture[: 3 * number + 1] = 255
                writer.write(picture)
    with av.open(str(made[0])) as container:
        assert any(packet.dts is None for packet in container.demux(video=0) if packet.size)
    assert append(made, tmp_path / "out.mkv") == 50
    with av.open(str(tmp_path / "out.mkv")) as container:
        shown = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    assert [round(float(np.median(picture[-10:])) / 5) for picture in shown] == list(range(50))
