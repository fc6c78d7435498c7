"""How steadily a programme stands while the lamp moves, beside what a general video stabiliser makes of the pictures.

    python -m benchmarks.stability FOLDER NAME ...    FOLDER and NAME as of benchmarks.ideal; writes the page

Of every movement, a second before it to a second after it, the camera that sees most of the field all along: its own
pictures, the same stabilised by vid.stab, the programme that holds its camera while the lamp moves, and the one that
follows. What moves is measured on the pictures of all four by one estimator that knows nothing of mcsl.

It takes an ffmpeg with vid.stab: `ffmpeg` of Debian, or that of imageio-ffmpeg from PyPI.

References
----------
S. Liu, L. Yuan, P. Tan, J. Sun: Bundled camera paths for video stabilization. ACM TOG 32(4), 2013 (its stability score
and distortion).
vid.stab: G. Martius, https://github.com/georgmartius/vid.stab.
"""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from datetime import date
from itertools import pairwise
from pathlib import Path

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core import edl
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Edl, Look, Override
from mcsl_core.edl.movement import unfollowed
from mcsl_core.evaluation.evaluate import without_alignment
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.recording.footage import Footage
from mcsl_core.simulation import Truth, load_truth
from mcsl_core.timing import FrameRange

Picture = NDArray[np.uint8]  # (H, W, 3) BGR

RESULTS = Path(__file__).parent / "results"
AROUND_S = 1.0  # before and after a movement
LOOK = Look(centering=False, fill=False, colour=True, surface=True)
WIDTH = 960  # pixels that lengths are told in
LOW = slice(1, 6)  # frequencies 2 to 6, without the mean
BLACK = 6  # codes, of every channel
ROWS = ("its own pictures", "vid.stab", "held", "followed")


@frozen
class Stability:
    """How a film moves.

    Attributes
    ----------
    low : float
        0..1: share of the lowest frequencies in the energy of the way of its middle and of its turn, the least of the
        three; 1 of a film that stands still.
    drift, acceleration : float
        Pixels at 960: how far its middle and the middle half's corners are from where they were, rms; and most that
        their speed changes from one frame to the next.
    anisotropy : float
        1 and up: most that a frame is stretched one way against the other, against the frame before.
    black : float
        0..1 of the pictures that show nothing.
    """

    low: float
    drift: float
    acceleration: float
    anisotropy: float
    black: float


def stability(film: Sequence[Picture]) -> Stability:
    """Of films of at least three frames of one size."""
    greys = [np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8) for picture in film]
    height, width = greys[0].shape
    steps = [between(a, b) for a, b in pairwise(greys)]
    middle = np.array([[width / 2, height / 2, 1.0]])
    corners = np.array([[x * width, y * height, 1.0] for x in (0.25, 0.75) for y in (0.25, 0.75)])
    ways = [np.vstack([middle, corners])]
    for step in steps:  # where what was at these places at first has gone
        ways.append(np.column_stack([ways[-1] @ step.T, np.ones(5)]))
    way = np.array(ways)[..., :2] * WIDTH / width
    turn = np.cumsum([0.0, *(np.arctan2(step[1, 0], step[0, 0]) for step in steps)]) * WIDTH / 4
    stretched = [np.linalg.svd(step[:, :2], compute_uv=False) for step in steps]
    shown = np.mean([(picture.max(axis=2) <= BLACK).mean() for picture in film])
    return Stability(
        min(low_frequencies(signal) for signal in (way[:, 0, 0], way[:, 0, 1], turn)),
        float(np.sqrt(np.square(way - way[0]).sum(axis=2).mean())),
        float(np.hypot(*np.diff(way, 2, axis=0).reshape(-1, 2).T).max()),
        float(max(a / b for a, b in stretched)),
        float(shown),
    )


def low_frequencies(signal: NDArray[np.float64]) -> float:
    """0..1: share of the second to the sixth lowest frequency in a signal's energy without its mean; 1 of none."""
    energy = np.abs(np.fft.rfft(signal - signal.mean())) ** 2
    return float(energy[LOW].sum() / energy.sum()) if energy.sum() > 1e-12 else 1.0


def between(before: NDArray[np.uint8], after: NDArray[np.uint8]) -> NDArray[np.float64]:
    """(2, 3): how most of a picture has moved since the one before; nothing where nothing is followed."""
    inside = cv2.erode((before > BLACK).astype(np.uint8), np.ones((15, 15), np.uint8))
    places = cv2.goodFeaturesToTrack(before, 600, 0.01, 7, mask=inside)
    still = np.eye(2, 3)
    if places is None or len(places) < 8:
        return still
    there, found, _ = cv2.calcOpticalFlowPyrLK(before, after, places, places.copy())
    back, also, _ = cv2.calcOpticalFlowPyrLK(after, before, there, there.copy())
    right = (found[:, 0] > 0) & (also[:, 0] > 0) & (np.abs(back - places)[:, 0].max(axis=1) < 0.5)
    if right.sum() < 8:
        return still
    matrix, _ = cv2.estimateAffine2D(places[right], there[right], ransacReprojThreshold=1.5)
    return still if matrix is None else np.array(matrix, np.float64)  # pyright: ignore[reportUnnecessaryComparison]


# ------------------------------------------------------------------------------------------------------------ the rows


def films(made: Edl, truth: Truth, base: Path, piece: FrameRange) -> tuple[str, dict[str, list[Picture]]]:
    """The camera that sees most of the field all along, and each row's pictures of the piece."""
    seen = truth.visible_field_without_hands[piece.start : piece.stop]
    camera = truth.cameras[int(seen.min(axis=0).argmax())]
    fixed = attrs.evolve(made, overrides=(Override(FrameRange(0, made.frames), camera=camera),))
    held = attrs.evolve(fixed, movements=unfollowed(fixed.movements))
    own = rendered(without_alignment(fixed), base, piece)
    return camera, dict(
        zip(ROWS, (own, stabilised(own), rendered(held, base, piece), rendered(fixed, base, piece)), strict=True)
    )


def rendered(made: Edl, base: Path, piece: FrameRange) -> list[Picture]:
    """What the compositor makes."""
    footage = Footage(made.cameras, rate=made.rate, frames=made.frames, base=base)
    look = attrs.evolve(LOOK, surface=any(pose.relief for pose in made.poses))
    with Compositor(made, footage, look=look) as compositor:
        return [planes_to_bgr(planes) for planes in compositor.frames(piece)]


def stabilised(film: Sequence[Picture]) -> list[Picture]:
    """The film after vid.stab with its own settings, black where it shows nothing."""
    height, width = film[0].shape[:2]
    raw = ("-f", "rawvideo", "-pix_fmt", "bgr24", "-s", f"{width}x{height}", "-r", "10", "-i", "-")
    data = b"".join(np.ascontiguousarray(picture).tobytes() for picture in film)
    with tempfile.TemporaryDirectory() as folder:
        for way in ("vidstabdetect=result=t", "vidstabtransform=input=t:crop=black:optzoom=0"):
            out = ("-f", "rawvideo", "-pix_fmt", "bgr24", "-") if "transform" in way else ("-f", "null", "-")
            command = [ffmpeg(), "-v", "error", *raw, "-vf", way, *out]
            done = subprocess.run(command, input=data, capture_output=True, cwd=folder, check=False)
            if done.returncode:
                raise SystemExit(f"{command[0]}: {done.stderr.decode(errors='replace').strip()[-400:]}")
    return list(np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3))


def ffmpeg() -> str:
    """One that has vid.stab."""
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingImports]

        found: str | None = imageio_ffmpeg.get_ffmpeg_exe()
    except ImportError:
        found = shutil.which("ffmpeg")
    told = subprocess.run([found, "-v", "error", "-filters"], capture_output=True, check=False).stdout if found else b""
    if found is None or b"vidstabtransform" not in told:
        raise SystemExit("there is no ffmpeg with vid.stab here: `pip install imageio-ffmpeg` brings one")
    return found


def page(rows: Sequence[tuple[str, FrameRange, str, dict[str, Stability]]]) -> str:
    """The tables: means first, then each movement."""
    heads = ("low frequencies", "drift, px", "acceleration, px", "anisotropy", "black")
    lines = [
        "# Steadiness while the lamp moves\n",
        f"Made by `python -m benchmarks.stability FOLDER NAME ...` on {date.today()}, {platform.machine()}, Python "
        f"{platform.python_version()}. Recordings of `benchmarks.ideal`, none of them tuned on; ffmpeg's "
        "vidstabdetect and vidstabtransform with their own settings.\n",
        "A second before a movement to a second after it, one camera all along. Low frequencies: share of the second "
        "to the sixth in the energy of the way (Liu et al. 2013: 1 is smooth; of a film that hardly moves it is the "
        "share of noise, and says nothing). Drift: how far places go from where they were, rms. Acceleration: the "
        "largest. Lengths at 960. Anisotropy: the largest between two frames. Black: of the pictures. All by optical "
        "flow between neighbouring pictures, heads and hands among what moves.\n",
        "A stabiliser makes the way smooth; it knows no perspective to keep, so the picture goes off with the lamp, "
        "only more gently, and is a new one afterwards.\n",
        f"|  | {' | '.join(heads)} |",
        f"|{'---|' * (len(heads) + 1)}",
    ]
    for row in ROWS:
        lines.append(f"| {row} | {_cells([found[row] for *_, found in rows])} |")
    lines += ["", f"|  |  | {' | '.join(heads)} |", f"|{'---|' * (len(heads) + 2)}"]
    for name, piece, camera, found in rows:
        for row in ROWS:
            lines.append(f"| {name}, {camera}, {piece} | {row} | {_cells([found[row]])} |")
    return "\n".join(lines) + "\n"


def _cells(found: Sequence[Stability]) -> str:
    low, drift, acceleration, anisotropy, black = np.mean([attrs.astuple(each) for each in found], axis=0)
    return f"{low:.2f} | {drift:.1f} | {acceleration:.1f} | {anisotropy:.3f} | {black:.1%}"


def main(arguments: Sequence[str]) -> None:
    folder, rows = Path(arguments[0]), []
    cv2.setNumThreads(1)
    ffmpeg()
    for name in arguments[1:]:
        base = folder / f"{name}.edl"
        made, truth = edl.load(base / "edl.json"), load_truth(folder / name)
        around = round(AROUND_S * float(made.rate))
        for movement in made.movements:
            start, stop = movement.range.start - around, movement.range.stop + around
            piece = FrameRange(max(0, start), min(stop, made.frames, truth.frames))
            camera, own = films(made, truth, base, piece)
            rows.append((name, piece, camera, {row: stability(film) for row, film in own.items()}))
            print(name, piece, camera, {row: _cells([value]) for row, value in rows[-1][-1].items()}, flush=True)
    (RESULTS / "stability.md").write_text(page(rows), "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
