"""Matchers on views turned by 0 to 180 degrees against each other, from simulated cameras whose truth is known.

    python -m benchmarks.matchers FOLDER [NAME ...]       makes what is missing, matches, writes results/matchers.md

Two cameras of a lamp film the field at the same time, a clear one. The second one's picture is turned about its middle
until it stands at the wanted angle to the first; what the turn leaves empty is masked. Judged are the matches within
the field's outline, by the true places of the field's points, on their relief. Named matchers, else all installed.
"""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator

from benchmarks.accuracy import table
from mcsl_core.hooks.registry import Offer, discover
from mcsl_core.imaging.geometry import transform_points
from mcsl_core.progress import Silent
from mcsl_core.recording.cameras import open_cameras
from mcsl_core.recording.footage import Footage
from mcsl_core.simulation import Scenario, Truth, load_truth, simulate

RESULTS = Path(__file__).parent / "results"
TURNS = (0, 30, 60, 90, 120, 150, 180)
CLOSE_PX = 3.0

# Seeds that nothing was tuned on. One frame is used: of six seconds without heads, hands at work.
SCENES: Mapping[str, Mapping[str, Any]] = {
    "411": {"drape": "green", "skin": "light", "gloves": "white"},
    "412": {"drape": "blue", "skin": "dark", "gloves": "blue"},
}
PAIRS = ((0, 1), (0, 2))  # neighbours on the pentagon, and cameras across it


@frozen(eq=False)
class Turned:
    """Two pictures of one time, the second one turned.

    Attributes
    ----------
    a, b : (H, W, 3) uint8
        BGR.
    mask : (H, W) uint8
        255 where ``b`` has a picture.
    field_a, field_b : (N, 2) float64
        Where the field's points lie in both.
    """

    a: NDArray[np.uint8]
    b: NDArray[np.uint8]
    mask: NDArray[np.uint8]
    field_a: NDArray[np.float64]
    field_b: NDArray[np.float64]


@frozen
class Judged:
    """What a matcher made of two pictures.

    Attributes
    ----------
    matches : int
        In the field.
    share : float
        Of those within `CLOSE_PX` of the truth, 0..1.
    error : float
        Of the homography they make, rms over the field, as a multiple of the best plane's; infinite where they make
        none.
    picture_s, pair_s : float
        CPU seconds of points in one picture, and of matching a pair.
    """

    matches: int
    share: float
    error: float
    picture_s: float
    pair_s: float


def clear_frame(truth: Truth) -> int:
    """The programme frame in which the cameras compared see most of the field, all of them."""
    used = sorted({camera for pair in PAIRS for camera in pair})
    return int(truth.visible_field[:, used].min(axis=1).argmax())


def recording(folder: Path, name: str) -> tuple[Truth, list[NDArray[np.uint8]]]:
    """The truth and the pictures of one clear frame."""
    target = folder / name
    if not (target / "truth.json").exists():
        options = {"duration_s": 6, "size": (640, 360), "rate": 8, "movements": 0, "heads": 0, "audio": False}
        options |= SCENES[name]
        simulate(Scenario(seed=int(name), **options), target, Silent())
    truth = load_truth(target)
    cameras = open_cameras([target], folder, Silent())
    footage = Footage(cameras, rate=truth.rate, frames=truth.frames, base=folder)
    frame = clear_frame(truth)
    pictures = []
    for camera in range(len(cameras)):
        own = truth.own_frame(camera, frame)
        (_, picture), *_ = footage.pictures(cameras[camera].name, [own if own is not None else frame])
        assert picture is not None, f"{name}: {cameras[camera].name} has no picture at {frame}"
        pictures.append(picture)
    return truth, pictures


def natural_turn(field_a: NDArray[np.float64], field_b: NDArray[np.float64]) -> float:
    """Degrees by which b's view of the field is turned against a's."""
    similarity, _ = cv2.estimateAffinePartial2D(field_a, field_b)
    return float(np.degrees(np.arctan2(similarity[1, 0], similarity[0, 0])))


def turned_pairs(truth: Truth, pictures: Sequence[NDArray[np.uint8]], degrees: float) -> Iterator[Turned]:
    """The pairs of `PAIRS`, the second camera's picture at ``degrees`` to the first's."""
    for a, b in PAIRS:
        points = truth.poses[0].field_points_px
        field_a, field_b = points[a], points[b]
        size = truth.size
        middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
        # OpenCV's angle runs against the picture's: y points down.
        turn = cv2.getRotationMatrix2D(middle, natural_turn(field_a, field_b) - degrees, 1)
        picture = cv2.warpAffine(pictures[b], turn, size, flags=cv2.INTER_CUBIC)
        full = np.full((size[1] - 8, size[0] - 8), 255, np.uint8)
        inside = cv2.copyMakeBorder(full, 4, 4, 4, 4, cv2.BORDER_CONSTANT, value=0)
        mask = cv2.warpAffine(inside, turn, size, flags=cv2.INTER_NEAREST)
        yield Turned(
            pictures[a], np.asarray(picture, np.uint8), np.asarray(mask, np.uint8), field_a,
            field_b @ turn[:, :2].T + turn[:, 2],
        )  # fmt: skip


def judge(offer: Offer, turned: Turned) -> Judged:
    """One matcher on one pair, against the true places of the field's points."""
    matcher = offer.checked
    began = time.process_time()
    a, b = matcher.features(turned.a), matcher.features(turned.b, turned.mask)
    between = time.process_time()
    pairs = matcher.match(a, b)
    ended = time.process_time()
    at = a.points[pairs[:, 0]].astype(np.float64)
    found = b.points[pairs[:, 1]].astype(np.float64)
    truly = LinearNDInterpolator(turned.field_a, turned.field_b)(at)  # NaN outside of the field's outline
    inside = ~np.isnan(truly[:, 0])
    at, found, truly = at[inside], found[inside], truly[inside]
    close = np.hypot(*(found - truly).T) < CLOSE_PX
    best, _ = cv2.findHomography(turned.field_a, turned.field_b, 0)
    error = np.inf
    if len(at) >= 8:
        made, _ = cv2.findHomography(at, found, cv2.USAC_MAGSAC, 2 * CLOSE_PX, maxIters=20000, confidence=0.9999)
        if made is not None:
            error = rms_over_field(made, turned) / rms_over_field(best, turned)
    share = float(close.mean()) if len(close) else 0.0
    return Judged(len(at), share, error, (between - began) / 2, ended - between)


def rms_over_field(homography: object, turned: Turned) -> float:
    """Distance in pixels of the field's points, carried by a homography, from where they lie."""
    apart = transform_points(np.asarray(homography, np.float64), turned.field_a) - turned.field_b
    return float(np.sqrt(np.square(apart).sum(axis=1).mean()))


def markdown(found: Mapping[str, Mapping[int, Sequence[Judged]]]) -> str:
    """Medians over the pairs of views; the homography's worst as well."""
    heads = ["turned by", *(f"{name}: {what}" for name in found for what in ("matches", "true", "error"))]
    rows = []
    for turn in TURNS:
        row: list[object] = [f"{turn}°"]
        for judged in (by_turn[turn] for by_turn in found.values()):
            errors = sorted(j.error for j in judged)
            row += [
                f"{np.median([j.matches for j in judged]):.0f}",
                f"{np.median([j.share for j in judged]):.0%}",
                f"{_times(float(np.median(errors)))} / {_times(errors[-1])}",
            ]
        rows.append(row)
    every = {name: [j for judged in by_turn.values() for j in judged] for name, by_turn in found.items()}
    costs = [
        [name, f"{np.median([j.picture_s for j in all_]):.2f} s", f"{np.median([j.pair_s for j in all_]):.2f} s"]
        for name, all_ in every.items()
    ]
    scenes = "; ".join(f"{name}: {', '.join(f'{v} {k}' for k, v in s.items())}" for name, s in SCENES.items())
    made = f"{date.today()}, {platform.machine()}, Python {platform.python_version()}"
    return f"""# Matchers on turned views

Made by `python -m benchmarks.matchers FOLDER` on {made}. Simulated, 640x360, seeds used for nothing else
({scenes}); {len(SCENES) * len(PAIRS)} pairs of views at every angle, the second turned about its middle.

Median over the pairs: matches within the surgical field; how many of them lie within {CLOSE_PX:g} px of the true place;
rms error over the field of the homography that they make (MAGSAC), as a multiple of the best single plane's, median /
worst.

{table(heads, rows)}

CPU time, median, of points in one picture and of matching one pair:

{table(["", "a picture", "a pair"], costs)}
"""


def _times(value: float) -> str:
    return "none" if np.isinf(value) else f"{value:.2f}" if value < 100 else "> 100"


def main() -> None:
    folder, names = Path(sys.argv[1]), sys.argv[2:]
    folder.mkdir(parents=True, exist_ok=True)
    offers = [o for o in discover().offers if o.stage == "matcher" and (not names or o.name in names)]
    found: dict[str, dict[int, list[Judged]]] = {o.name: {turn: [] for turn in TURNS} for o in offers}
    for scene in SCENES:
        truth, pictures = recording(folder, scene)
        for turn in TURNS:
            for pair in turned_pairs(truth, pictures, turn):
                for offer in offers:
                    found[offer.name][turn].append(judge(offer, pair))
                    print(scene, turn, offer.name, found[offer.name][turn][-1], flush=True)
    (RESULTS / "matchers.md").write_text(markdown(found), "utf-8")


if __name__ == "__main__":
    main()
