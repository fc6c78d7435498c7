"""A small programme with all that a picture may be made of, and a record of how its pictures and sound came out.

Run as a script it makes the record anew, which is what a number that has risen asks for (`mcsl_core.code_keys`):

    PYTHONPATH=. python tests/recorded_programme.py
"""

from __future__ import annotations

import sys
import tempfile
import wave
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.code_keys import PICTURES, SOUND
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.delivery.audio import write_wav
from mcsl_core.edl import IDENTITY, Camera, Clock, Colour, Edl, Look, Media, Movement, Override, Pose, Shot
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange

RECORD = Path(__file__).parent / "recorded" / "programme.npz"
SIZE, CAMERA_SIZE = (128, 96), (160, 120)
RATE = Fraction(10)
FRAMES = 64
LOSSLESS = Encoding(options={"preset": "ultrafast", "qp": "0"}, audio_codec="flac", audio_options={})
RAISED_PX = {"a": 0.0, "b": 5.0, "c": -4.0}  # how far beside its place each camera sees what lies above the plane
SHOWN = (2, 17, 24, 40, 61)  # centering still and moving, by hand, in the other pose, in a camera's gap

# kind -> the look, the filler and the resampling it is made with
KINDS: Mapping[str, tuple[Look, Filler, str]] = {
    "bare": (Look(True, False, True), FootprintFiller(), "linear"),
    "lanczos": (Look(True, False, False), FootprintFiller(), "lanczos"),
    "footprint": (Look(True, True, True), FootprintFiller(), "linear"),
    "reference": (Look(False, True, False), PaperFiller(), "linear"),
}


def numbers() -> dict[str, int]:
    """kind -> the number that must rise when it comes out differently."""
    return {
        "bare": PICTURES,
        "lanczos": PICTURES,
        "footprint": FootprintFiller.version,
        "reference": PaperFiller.version,
        "sound": SOUND,
    }


def _placed(dx: float, dy: float, degrees: float, scale: float, tilt: float = 0.0) -> NDArray[np.float64]:
    """Camera pixel -> programme pixel: turned and scaled about the middle, moved, with a little perspective."""
    matrix = np.vstack([cv2.getRotationMatrix2D((CAMERA_SIZE[0] / 2, CAMERA_SIZE[1] / 2), degrees, scale), [0, 0, 1]])
    matrix[:2, 2] += dx - 16, dy - 12
    matrix[2, 0] = tilt
    return matrix / matrix[2, 2]


PLACES = {"a": _placed(0, 0, 0, 0.85), "b": _placed(14, -8, 12, 0.75, 2e-4), "c": _placed(-22, 10, -20, 0.8, -3e-4)}


def edl_of(look: Look) -> Edl:
    to_reference = {name: np.linalg.inv(PLACES["a"]) @ place for name, place in PLACES.items()}
    homographies = {name: _rows(h) for name, h in to_reference.items()} | {"a": IDENTITY}
    warm = Colour(((1.05, 0.0, 0.02, -4.0), (0.0, 1.1, 0.0, -10.0), (0.0, 0.0, 0.95, 8.0)))
    anchor, later = _rows(PLACES["a"]), _rows(np.array([[1, 0, 9.0], [0, 1, -5.0], [0, 0, 1]]) @ PLACES["a"])
    return Edl(
        rate=RATE,
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=(
            Camera("a", (Media("a.mkv", FRAMES),), CAMERA_SIZE, RATE),
            Camera("b", (Media("b.mkv", FRAMES),), CAMERA_SIZE, RATE, clock=Clock(offset_s=-0.2)),
            Camera("c", (Media("c.mkv", FRAMES),), CAMERA_SIZE, RATE, gaps=(FrameRange(60, 63),)),
        ),
        movements=(Movement(FrameRange(28, 32), 1.0),),
        poses=(
            Pose(FrameRange(0, 30), homographies, anchor, colour={"b": warm}),
            Pose(FrameRange(30, FRAMES), homographies, later, colour={"b": warm, "c": warm}),
        ),
        shots=(
            Shot(FrameRange(0, 20), "b"),
            Shot(FrameRange(20, 36), "c"),
            Shot(FrameRange(36, 50), "b"),
            Shot(FrameRange(50, FRAMES), "c"),
        ),
        centering=((0, 4.0, -3.0), (12, 4.0, -3.0), (20, 11.5, 2.25), (FRAMES - 1, 11.5, 2.25)),
        overrides=(Override(FrameRange(22, 27), offset=(-6.0, 5.0)),),
        look=look,
    )


def _rows(matrix: NDArray[np.float64]):
    return tuple(tuple(float(v) for v in row) for row in matrix / matrix[2, 2])


def write_media(folder: Path) -> None:
    """Three lossless films of one scene with a cloth above it, each from its own side; the first has a tone."""
    rng = np.random.default_rng(11)
    scene = cv2.resize(rng.integers(40, 216, (24, 32, 3)).astype(np.uint8), (320, 240), interpolation=cv2.INTER_CUBIC)
    cloth = np.zeros_like(scene)
    texture = rng.integers(60, 250, (12, 12, 3)).astype(np.uint8)
    cloth[80:170, 150:260] = cv2.resize(texture, (110, 90), interpolation=cv2.INTER_LINEAR)
    at = np.arange(FRAMES * 4800)
    tone = (0.5 * np.sin(2 * np.pi * (200 + at / 300) * at / 48000)).astype(np.float32)
    for name, place in PLACES.items():
        way = np.linalg.inv(place) @ np.array([[1, 0, -96.0], [0, 1, -72.0], [0, 0, 1]])
        view = cv2.warpPerspective(scene, way, CAMERA_SIZE, flags=cv2.INTER_CUBIC)
        raised = way @ np.array([[1, 0, RAISED_PX[name]], [0, 1, 0], [0, 0, 1]])
        above = cv2.warpPerspective(cloth, raised, CAMERA_SIZE, flags=cv2.INTER_CUBIC)
        view = np.where(above.max(axis=2, keepdims=True) > 30, above, view)
        sound = 48000 if name == "a" else None
        path = folder / f"{name}.mkv"
        with VideoWriter(path, size=CAMERA_SIZE, rate=RATE, encoding=LOSSLESS, audio_rate=sound) as writer:
            for frame in range(FRAMES):
                picture = view.copy()
                left = 20 + 2 * (frame % 40) + 15 * "abc".index(name)
                picture[70:, left : left + 14] = (60, 80, 200)
                writer.write(bgr_to_planes(picture))
            if sound:
                writer.write_audio(tone)


def made(folder: Path) -> dict[str, NDArray]:
    """kind -> its pictures, (frames, 3/2 height, width) codes, or 16-bit sound."""
    found: dict[str, NDArray] = {}
    for kind, (look, filler, resampling) in KINDS.items():
        edl = edl_of(look)
        with Compositor(edl, footage_of(edl, folder, 1), filler=filler, resampling=resampling) as compositor:  # pyright: ignore
            pictures = [next(iter(compositor.frames(FrameRange(frame, frame + 1)))) for frame in SHOWN]
        found[kind] = np.stack([np.vstack([p.y, np.hstack([p.u, p.v])]) for p in pictures])
    edl = edl_of(Look())
    clock = Clock(offset_s=0.1234, drift_ppm=80.0)
    edl = attrs.evolve(edl, cameras=(attrs.evolve(edl.cameras[0], clock=clock), *edl.cameras[1:]))
    write_wav(footage_of(edl, folder, 1), "a", edl, folder / "sound.wav", Silent())
    with wave.open(str(folder / "sound.wav")) as sound:
        found["sound"] = np.frombuffer(sound.readframes(sound.getnframes()), "<i2")[::37]
    return found


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_media(Path(folder))
        RECORD.parent.mkdir(exist_ok=True)
        stood = {f"number of {kind}": np.array(number) for kind, number in numbers().items()}
        np.savez_compressed(RECORD, **made(Path(folder)), **stood)  # pyright: ignore[reportArgumentType]
    print(f"{RECORD}: {RECORD.stat().st_size / 1000:.0f} kB", file=sys.stderr)


if __name__ == "__main__":
    main()
