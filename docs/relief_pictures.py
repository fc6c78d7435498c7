"""Makes the pictures of explanation/relief.md out of a simulated recording.

    python docs/relief_pictures.py FOLDER      FOLDER keeps the recording and its analysis; what is there is used

Two cores take some two minutes. The pictures are looked at before they are committed: nothing checks them.
"""

from __future__ import annotations

import base64
import sys
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

import mcsl_core as mcsl
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Edl, Look, Shot
from mcsl_core.imaging.lettering import write_text
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.report.relief_picture import relief_picture
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

SCENE = Scenario(seed=9, duration_s=14, rate=10, movements=0, relief_mm=40, heads=2, hands=2, noise=0.8)
IMAGES = Path(__file__).parent / "images"
CLEAR = 0.8  # of the field both cameras of the switch see
BEFORE, AFTER = 2, 2  # frames shown of a switch
CROP = (0.22, 0.2, 0.6, 0.62)  # of the picture: about the field
SCALE = 0.85
GAP = 6


def main(folder: Path) -> None:
    path = folder / "edl.json"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        simulate(SCENE, folder / "recording", Silent())
        mcsl.analyse(folder / "recording", path).close()
    programme = mcsl.open(path)
    made, frame, (a, b) = programme.edl, *occasion(programme)
    print(f"the switch from {a} to {b} at frame {frame}")
    whole = {by: switched(made, folder, frame, (a, b), surface=by == "surface") for by in ("plane", "surface")}
    columns = []
    for by, pictures in whole.items():
        seen = [about(picture) for picture in pictures]
        cells = [*seen, doubled(seen[BEFORE - 1], seen[BEFORE])]
        for n, cell in enumerate(cells):
            what = f"{a if n < BEFORE else b}, frame {frame - BEFORE + n}" if n < len(seen) else "difference, doubled"
            write_text(cell, f"by the {by}: {what}", (8, cell.shape[0] - 9), 0.5)
        columns.append(strip(cells, axis=0))
    write("relief-switch.jpg", strip(columns, axis=1))
    shown = relief_picture(made, made.pose_at(frame))
    assert shown is not None
    relief = cv2.imdecode(np.frombuffer(base64.b64decode(shown.url.partition(",")[2]), np.uint8), cv2.IMREAD_COLOR)
    assert relief is not None
    small = cv2.resize(whole["surface"][BEFORE - 1], relief.shape[1::-1], interpolation=cv2.INTER_AREA)
    write("relief-found.jpg", strip([small, relief], axis=1))


def occasion(programme: mcsl.Programme) -> tuple[int, tuple[str, str]]:
    """A frame, and two cameras far apart that both see the field then."""
    scores, made = programme.scores, programme.edl
    relief = made.poses[0].relief
    assert scores is not None
    assert relief is not None

    def apart(pair: tuple[str, str]) -> float:
        first, second = (np.array(relief.projections[name]) for name in pair)
        middle = np.array([made.size[0] / 2, made.size[1] / 2, 1.0])
        moved = [np.linalg.inv(p[:, :3]) @ p[:, 3] for p in (first, second)]
        ways = [(v[:2] - middle[:2] * v[2]) for v in moved]
        return float(np.hypot(*(ways[0] - ways[1])))

    for pair in sorted(combinations(relief.projections, 2), key=apart, reverse=True):
        seen = scores.seen[:, [scores.cameras.index(name) for name in pair]].min(axis=1)
        at = int(np.nanargmax(seen))
        if seen[at] > CLEAR and BEFORE < scores.frames[at] < made.frames - AFTER:
            return int(scores.frames[at]), pair
    raise SystemExit("no two cameras see the field at once: choose another seed")


def switched(
    made: Edl, folder: Path, frame: int, cameras: tuple[str, str], *, surface: bool
) -> list[NDArray[np.uint8]]:
    """Frames about a switch, by plane or by surface."""
    shots = (Shot(FrameRange(0, frame), cameras[0]), Shot(FrameRange(frame, made.frames), cameras[1]))
    look = Look(centering=False, fill=True, colour=True, surface=surface)
    changed = attrs.evolve(made, shots=shots, look=look, overrides=())
    with Compositor(changed, footage_of(changed, folder)) as compositor:
        return [planes_to_bgr(p) for p in compositor.frames(FrameRange(frame - BEFORE, frame + AFTER))]


def about(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width = picture.shape[:2]
    x, y = round(CROP[0] * width), round(CROP[1] * height)
    cut = picture[y : y + round(CROP[3] * height), x : x + round(CROP[2] * width)]
    return np.asarray(cv2.resize(cut, None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_AREA), np.uint8)


def doubled(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """What differs, doubled."""
    return np.asarray(np.clip(2 * cv2.absdiff(a, b).astype(int), 0, 255), np.uint8)


def strip(pictures: Sequence[NDArray], *, axis: int) -> NDArray[np.uint8]:
    """Below each other (0) or beside each other (1)."""
    shape = list(pictures[0].shape)
    shape[axis] = GAP
    gap = np.full(shape, 255, np.uint8)
    return np.concatenate([part for picture in pictures for part in (picture, gap)][:-1], axis=axis).astype(np.uint8)


def write(name: str, picture: NDArray[np.uint8]) -> None:
    data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 82])[1].tobytes()
    (IMAGES / name).write_bytes(data)
    print(f"written: docs/images/{name}, {len(data) // 1000} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
