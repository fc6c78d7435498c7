"""The contract of fillers, run over every one installed and those that docs/hooks.md shows; see test_stages.py."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from stage_offers import offers

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Camera, Edl, Look, Media, Pose, Shot
from mcsl_core.hooks.registry import Offer
from mcsl_core.imaging.planes import Planes
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

FILM = {"ref": (60, 0), "left": (120, -110), "right": (180, 90)}  # brightness, and columns its picture is shifted by
FILM_SIZE, FILM_RATE, FILM_FRAMES = (256, 128), 4, 60


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory):
    """Programme frames by a filler: cameras of one brightness each, which rises by 1 a second; three shots."""
    folder = tmp_path_factory.mktemp("filled")
    lossless = Encoding(options={"preset": "ultrafast", "qp": "0"})
    half = (FILM_SIZE[1] // 2, FILM_SIZE[0] // 2)
    for name, (value, _) in FILM.items():
        with VideoWriter(folder / f"{name}.mp4", size=FILM_SIZE, rate=Fraction(FILM_RATE), encoding=lossless) as film:
            for n in range(FILM_FRAMES):
                luma = np.full(FILM_SIZE[::-1], value + n // FILM_RATE, np.uint8)
                film.write(Planes(luma, *(np.full(half, 128, np.uint8) for _ in range(2))))
    pose = Pose(FrameRange(0, FILM_FRAMES), {n: ((1, 0, x), (0, 1, 0), (0, 0, 1)) for n, (_, x) in FILM.items()})
    edl = Edl(
        rate=Fraction(FILM_RATE),
        size=FILM_SIZE,
        frames=FILM_FRAMES,
        reference="ref",
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", FILM_FRAMES, ""),), FILM_SIZE, Fraction(FILM_RATE)) for n in FILM),
        poses=(pose,),
        shots=(
            Shot(FrameRange(0, 10), "left"),
            Shot(FrameRange(10, 45), "right"),
            Shot(FrameRange(45, FILM_FRAMES), "ref"),
        ),
        look=Look(centering=False, fill=True, colour=False),
    )

    def make(offer: Offer, start: int, stop: int) -> list[Planes]:
        footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=folder)
        with Compositor(edl, footage, filler=offer.checked) as compositor:
            return list(compositor.frames(FrameRange(start, stop)))

    return make


@offers("filler")
def test_fillers_fill_around_the_chosen_camera_with_what_some_camera_shows(offer: Offer, filled) -> None:
    frames = filled(offer, 0, FILM_FRAMES)
    for n, planes in enumerate(frames):
        now = {name: value + n // FILM_RATE for name, (value, _) in FILM.items()}
        # Well inside the camera's picture it is the camera's: left shows columns to 145, right from 90, ref all.
        part, camera = ((slice(0, 100), "left"), (slice(140, 256), "right"), (slice(0, 256), "ref"))[(n > 9) + (n > 44)]
        assert np.abs(planes.y[40:88, part].astype(int) - now[camera]).max() <= 1, f"frame {n}"
        assert planes.y.max() <= max(now.values()) + 1, "brighter than anything that was ever shown"
        assert planes.y.min() >= 15
        assert (np.abs(planes.u.astype(int) - 128) <= 1).all(), "a colour that no camera has"
    assert frames[40].y[64, 30] >= 58, "what another camera shows, or showed before, stays black"


@offers("filler")
@pytest.mark.parametrize("start", [7, 39, 40, 47])
def test_a_frame_is_filled_the_same_in_whatever_range_it_is_made(offer: Offer, filled, start: int) -> None:
    """Chunks of ten seconds are conformed in any order, some anew."""
    whole = filled(offer, 0, start + 4)[start:]
    for a, b in zip(whole, filled(offer, start, start + 4), strict=True):
        for one, other in zip(a, b, strict=True):
            np.testing.assert_array_equal(one, other)
