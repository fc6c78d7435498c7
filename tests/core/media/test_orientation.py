"""Display matrices obeyed as players obey them: eight orientations, against the numbers of the matrix."""

from fractions import Fraction

import av
import numpy as np
import pytest
from coded_video import DATA
from cycles import left_in_cycles
from turned_video import ON_ITS_SIDE, ONE, SIZE, UPRIGHT, marked_picture, write_turned

from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader

HFLIP = DATA / "faults" / "mirrored" / "hflip.mp4"


def shown_by(matrix) -> np.ndarray:
    """The marked picture with every pixel where the matrix sends it (ISO/IEC 14496-12)."""
    a, b, _, c, d, *_ = (round(number / 65536) for number in matrix)
    across, down = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    x, y = a * across + c * down, b * across + d * down
    x, y = x - x.min(), y - y.min()
    picture = np.zeros((y.max() + 1, x.max() + 1, 3), np.uint8)
    picture[y, x] = marked_picture()
    return picture


@pytest.mark.parametrize(
    "matrix", [*UPRIGHT, *ON_ITS_SIDE], ids=lambda m: " ".join(str(m[i] // ONE) for i in (0, 1, 3, 4))
)
@pytest.mark.parametrize("suffix", [".mp4", ".mkv"])
def test_every_orientation_is_shown_as_the_matrix_says(tmp_path, matrix, suffix):
    facts = probe(write_turned(tmp_path / f"a{suffix}", matrix))
    expected = shown_by(matrix)
    assert facts.size == (expected.shape[1], expected.shape[0])
    _, frame = next(VideoReader(facts).read(Fraction(0)))
    picture = planes_to_bgr(to_planes(frame, facts))
    off = np.abs(picture.astype(int) - expected)
    assert off.mean() < 2  # coded at 4:2:0; a wrong orientation is off by 15 or more
    assert off[..., 2].max() < 60
    wrong = np.abs(picture[:, ::-1].astype(int) - expected)
    assert wrong.mean() > 12


def test_a_picture_that_was_looked_at_is_freed_at_once(tmp_path):
    """PyAV keeps a frame's side data in the frame, and the frame in the side data."""
    path = write_turned(tmp_path / "a.mp4", ON_ITS_SIDE[0])
    assert left_in_cycles(lambda: probe(path)) == set()


def test_a_turn_in_the_stream_itself_is_obeyed(tmp_path):
    """H.264's own message, as cameras without a container write it."""
    plain = write_turned(tmp_path / "plain.mp4")
    with av.open(str(plain)) as film, av.open(str(tmp_path / "turned.mkv"), "w") as raw:
        stream = raw.add_stream_from_template(film.streams.video[0])
        turned = "h264_metadata=display_orientation=insert:flip=horizontal"
        bsf = av.BitStreamFilterContext(turned, film.streams.video[0])
        for packet in film.demux(video=0):
            if packet.dts is not None:
                for done in bsf.filter(packet):
                    done.stream = stream
                    raw.mux(done)
    facts = probe(tmp_path / "turned.mkv")
    assert (facts.rotation, facts.mirrored) == (0, True)


@pytest.mark.skipif(not HFLIP.is_file(), reason="the folder ../shared/data/faults/mirrored is not here")
def test_a_mirrored_film_reads_as_players_show_it():
    facts = probe(HFLIP)
    assert (facts.rotation, facts.mirrored, facts.conversions) == (0, True, ("mirrored",))
    with av.open(str(HFLIP)) as container:
        coded = [frame.to_ndarray(format="bgr24") for frame in container.decode(video=0)]
    shown = [planes_to_bgr(to_planes(frame, facts)).astype(int) for _, frame in VideoReader(facts).read(Fraction(0))]
    as_shown = [np.abs(picture - other[:, ::-1]).mean() for picture, other in zip(shown, coded, strict=True)]
    as_coded = [np.abs(picture - other).mean() for picture, other in zip(shown, coded, strict=True)]
    assert max(as_shown) < 3
    assert np.median(as_coded) > 10
