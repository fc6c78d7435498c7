"""How steadily a programme stands while the lamp moves, beside what a general video stabiliser makes of the pictures.

    python -m benchmarks.stability FOLDER NAME ...    FOLDER and NAME as of benchmarks.ideal; writes the page

Of every movement, a second before it to a second after it, the camera that sees most of the field all along: its own
pictures, the same stabilised by vid.stab as it comes and as it imitates a camera that stands, the programme that holds
its camera while the lamp moves, and the one that follows. What moves is measured on the pictures of all by one
estimator that knows nothing of mcsl.

It takes an ffmpeg with vid.stab: `ffmpeg` of Debian, or that of imageio-ffmpeg from PyPI.

References
----------
S. Liu, L. Yuan, P. Tan, J. Sun: Bundled camera paths for video stabilization. ACM TOG 32(4), 2013 (its stability score
and distortion).
vid.stab: G. Martius, https://github.com/georgmartius/vid.stab.
"""

from __future__ import annotations

import math
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from functools import cache
from itertools import pairwise
from pathlib import Path

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from benchmarks.accuracy import RESULTS, table
from benchmarks.ideal_geometry import in_movements
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

AROUND_S = 1.0  # before and after a movement
LOOK = Look(centering=False, fill=False, colour=True, surface=True)
WIDTH = 960  # pixels that lengths are told in
LOW = slice(1, 6)  # frequencies 2 to 6, without the mean
BLACK = 6  # codes, of every channel
STABILISERS = {
    "vid.stab": ("", "crop=black"),
    "vid.stab, static": ("", "crop=black:smoothing=0:optalgo=gauss:optzoom=0"),
    "vid.stab, tripod": (":tripod=1", "crop=black:tripod=1:optzoom=0"),
}
"""Settings of vidstabdetect and vidstabtransform. The first are its own; the others are meant for a camera that stands,
found against the frame before and against the first. Without zoom vid.stab's own smoothing, by L1, refuses to work."""
FORMAT = "scale=out_range=tv,format=yuv420p"
"""The cameras' own. By vid.stab's results it matters: static, 719 drifts 13 px in this, 33 in what ffmpeg chooses."""
ROWS = ("its own pictures", *STABILISERS, "held", "followed")


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


def best_camera(truth: Truth, piece: FrameRange) -> str:
    """The one that sees most of the field all along."""
    seen = truth.visible_field_without_hands[piece.start : piece.stop]
    return truth.cameras[int(seen.min(axis=0).argmax())]


def programmes(made: Edl, camera: str) -> dict[str, Edl]:
    """One camera all along, with the lamp held and followed."""
    fixed = attrs.evolve(made, overrides=(Override(FrameRange(0, made.frames), camera=camera),))
    return {"held": attrs.evolve(fixed, movements=unfollowed(fixed.movements)), "followed": fixed}


def films(made: Mapping[str, Edl], base: Path, piece: FrameRange) -> dict[str, list[Picture]]:
    """Each row's pictures of the piece."""
    own = rendered(without_alignment(made["followed"]), base, piece)
    found = {ROWS[0]: own} | {name: stabilised(own, *settings) for name, settings in STABILISERS.items()}
    return found | {name: rendered(programme, base, piece) for name, programme in made.items()}


def field_shift(programme: Edl, truth: Truth, piece: FrameRange) -> float:
    """Median displacement of the field's true points while the lamp moves in the piece, pixels at 960."""
    within = tuple(m for m in truth.in_movements if any(f in piece for f in m.frames))
    shifts = in_movements(programme, attrs.evolve(truth, in_movements=within), surface=True)
    return float(np.median(shifts)) if len(shifts) else math.nan


def rendered(made: Edl, base: Path, piece: FrameRange) -> list[Picture]:
    """What the compositor makes."""
    footage = Footage(made.cameras, rate=made.rate, frames=made.frames, base=base)
    look = attrs.evolve(LOOK, surface=any(pose.relief for pose in made.poses))
    with Compositor(made, footage, look=look) as compositor:
        return [planes_to_bgr(planes) for planes in compositor.frames(piece)]


def stabilised(film: Sequence[Picture], detect: str, transform: str) -> list[Picture]:
    """The film after vid.stab, black where it shows nothing; settings as in `STABILISERS`.

    vid.stab's border is not black: it repeats the picture's edge for some ten pixels, fades for as many, and ends in a
    dark grey. What is picture, a white film with a dark rim tells that goes the same way.
    """
    sheet = np.zeros_like(film[0])
    sheet[1:-1, 1:-1] = 255
    with tempfile.TemporaryDirectory() as folder:
        _filtered(film, f"vidstabdetect=result=t{detect}", folder)
        made, white = (
            _filtered(each, f"vidstabtransform=input=t:{transform}", folder) for each in (film, [sheet] * len(film))
        )
    rim = np.ones((3, 3), np.uint8)
    covered = (cv2.dilate((sheet[..., 0] > 127).astype(np.uint8), rim) for sheet in white)
    return [np.where(cover[..., None] > 0, picture, np.uint8(0)) for picture, cover in zip(made, covered, strict=True)]


def _filtered(film: Sequence[Picture], way: str, folder: str) -> list[Picture]:
    """What an ffmpeg filter makes of a film."""
    height, width = film[0].shape[:2]
    raw = ("-f", "rawvideo", "-pix_fmt", "bgr24")
    command = [ffmpeg(), "-v", "error", *raw, "-s", f"{width}x{height}", "-i", "-", "-vf", f"{FORMAT},{way}", *raw, "-"]
    data = b"".join(np.ascontiguousarray(picture).tobytes() for picture in film)
    done = subprocess.run(command, input=data, capture_output=True, cwd=folder, check=False)
    if done.returncode or done.stderr:  # it tells of settings that it does not follow, and goes on
        raise SystemExit(f"{command[0]}: {done.stderr.decode(errors='replace').strip()[-400:]}")
    return list(np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3))


@cache
def ffmpeg() -> str:
    """One that has vid.stab: imageio-ffmpeg's, else the system's."""
    candidates = [shutil.which("ffmpeg")]
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingImports]

        candidates.insert(0, imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # not installed; installed where its wheel brings no program
        pass
    for found in filter(None, candidates):
        told = subprocess.run([found, "-v", "error", "-filters"], capture_output=True, check=False).stdout
        if b"vidstabtransform" in told:
            return found
    raise SystemExit(
        "there is no ffmpeg with vid.stab here: `pip install imageio-ffmpeg` (or mcsl[yardstick]) brings one, Debian's "
        "package ffmpeg as well"
    )


@frozen
class Stretch:
    """A movement and what is around it.

    Attributes
    ----------
    name, piece, camera
        Recording, programme frames and the camera shown.
    found
        By row.
    shift
        By programme: see `field_shift`.
    """

    name: str
    piece: FrameRange
    camera: str
    found: Mapping[str, Stability]
    shift: Mapping[str, float]


def page(stretches: Sequence[Stretch]) -> str:
    """The tables: means first, then each movement."""
    heads = ("low frequencies", "drift, px", "acceleration, px", "anisotropy", "black", "field, px")
    names = ", ".join(dict.fromkeys(stretch.name for stretch in stretches))
    lines = [
        "# Steadiness while the lamp moves\n",
        f"Made by `python -m benchmarks.stability FOLDER NAME ...` on {date.today()}, {platform.machine()}, Python "
        f"{platform.python_version()}. {names} of `benchmarks.ideal`, 640x360, 10 frames a second.\n",
        "A second before a movement to a second after it, one camera all along. Low frequencies: share of the second "
        "to the sixth in the energy of the way, the least of three (Liu et al. 2013: 1 is smooth; of a film that "
        "hardly moves it is the share of noise, and says nothing). Drift: how far the picture's middle and the middle "
        "half's corners go from where they were, rms. Acceleration: the largest. Lengths at 960. Anisotropy: the "
        "largest between two frames. Black: of the pictures. All these by optical flow between neighbouring pictures, "
        "heads and hands among what moves. Field: the truth's, median displacement of the field's points from their "
        "place in the programme, every third frame of the movement; other rows have no such place.\n",
        "vid.stab smooths one film's way by shifts and turns. As it comes, with the zoom that keeps borders out (its "
        "lengths contain it), it lessens a lamp's way and goes along with the rest. Told that the camera stands, it "
        "holds the picture: frame against frame (static), or against the first frame (tripod), which it loses where "
        "the lamp goes far. Perspective and relief are beyond shifts and turns, and what it holds is how the stretch "
        "began, not a programme's perspective: the poses before and after, and other cameras, still lie elsewhere. It "
        "sees the stretch alone. Black is not comparable between vid.stab and the programme, which lays pictures in "
        "the reference camera's perspective: this camera fills that only in part, the lamp standing as well.\n",
        f"Means of {len(stretches)} movements:\n",
        table(("", *heads), [(row, *_cells(row, stretches)) for row in ROWS]),
        "",
        table(
            ("", "", *heads),
            [(f"{s.name}, {s.camera}, {s.piece}", row, *_cells(row, [s])) for s in stretches for row in ROWS],
        ),
    ]
    return "\n".join(lines) + "\n"


def _cells(row: str, stretches: Sequence[Stretch]) -> tuple[str, ...]:
    values = [attrs.astuple(stretch.found[row]) for stretch in stretches]
    low, drift, acceleration, anisotropy, black = np.mean(values, axis=0)
    shifts = [v for stretch in stretches if not math.isnan(v := stretch.shift.get(row, math.nan))]
    field = f"{np.mean(shifts):.1f}" if shifts else "–"
    return f"{low:.2f}", f"{drift:.1f}", f"{acceleration:.1f}", f"{anisotropy:.3f}", f"{black:.1%}", field


def measured(folder: Path, name: str) -> Iterator[Stretch]:
    """A recording's movements."""
    base = folder / f"{name}.edl"
    made, truth = edl.load(base / "edl.json"), load_truth(folder / name)
    around = round(AROUND_S * float(made.rate))
    for movement in made.movements:
        start, stop = movement.range.start - around, movement.range.stop + around
        piece = FrameRange(max(0, start), min(stop, made.frames, truth.frames))
        camera = best_camera(truth, piece)
        own = programmes(made, camera)
        found = {row: stability(film) for row, film in films(own, base, piece).items()}
        yield Stretch(name, piece, camera, found, {row: field_shift(p, truth, piece) for row, p in own.items()})


def main(arguments: Sequence[str]) -> None:
    folder, stretches = Path(arguments[0]), []
    cv2.setNumThreads(1)
    ffmpeg()
    for name in arguments[1:]:
        for stretch in measured(folder, name):
            stretches.append(stretch)
            print(name, stretch.piece, stretch.camera, {r: _cells(r, [stretch]) for r in ROWS}, flush=True)
    (RESULTS / "stability.md").write_text(page(stretches), "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
