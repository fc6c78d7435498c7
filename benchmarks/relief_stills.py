"""Real material whose geometry is known: a wall in two photographs, a board before four cameras, a relief's truth."""

from __future__ import annotations

import csv
import json
from collections import defaultdict
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from benchmarks.ideal_geometry import Points
from mcsl_core import edl
from mcsl_core.simulation.truth import transfer

Views = list[tuple[int, str, Points, Points]]
_SECONDS, _RATE = 8, 10
_NOISE = 2.0  # grey levels, as a camera's
_MARGIN, _STEP = 20, 16  # pixels
_WALL_PX = 500  # below that a ledge stands before the wall of graf1, and a car


def planar_recording(source: Path, target: Path) -> Path:
    """The two photographs as the recording of two cameras that stand still, with a camera's noise."""
    rng = np.random.default_rng(1)
    target.mkdir(parents=True, exist_ok=True)
    for name in ("graf1", "graf3"):
        picture = cv2.imread(str(source / f"{name}.png"))
        assert picture is not None
        height, width = (n // 2 * 2 for n in picture.shape[:2])
        with av.open(str(target / f"{name}.mp4"), "w") as out:
            stream = out.add_stream("libx264", Fraction(_RATE), options={"crf": "16", "g": str(_RATE)})
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            for _ in range(_SECONDS * _RATE):
                noisy = picture[:height, :width] + rng.normal(0, _NOISE, (height, width, 1))
                frame = av.VideoFrame.from_ndarray(np.clip(noisy, 0, 255).astype(np.uint8), "bgr24")
                out.mux(stream.encode(frame))
            out.mux(stream.encode())
    return target


def planar_views(source: Path, made: edl.Edl) -> Views:
    """A grid of the wall's points that both photographs show; the published homography leads from graf1 to graf3."""
    storage = cv2.FileStorage(str(source / "H1to3p.xml"), cv2.FILE_STORAGE_READ)
    to_third = np.asarray(storage.getFirstTopLevelNode().mat(), np.float64)
    storage.release()
    sizes = {camera.name: camera.size for camera in made.cameras}
    x, y = np.meshgrid(*(np.arange(_MARGIN, n - _MARGIN, _STEP, dtype=np.float64) for n in sizes["graf1"]))
    first = np.stack([x.ravel(), y.ravel()], axis=1)
    third = transfer(to_third, first)
    wall = (first[:, 1] < _WALL_PX) & ((third > _MARGIN) & (third < np.array(sizes["graf3"]) - _MARGIN)).all(axis=1)
    seen, home = third[wall], first[wall]
    if made.reference == "graf3":
        seen, home = home, seen
    return [(0, name, seen, home) for name in made.poses[0].homographies if name != made.reference]


def board_views(source: Path, made: edl.Edl) -> Views:
    """The board's corners that a camera that is tied sees together with the reference; the board is moved about."""
    corners: dict[str, dict[tuple[str, str], tuple[float, float]]] = defaultdict(dict)
    with (source / "board" / "xy.csv").open(newline="", encoding="utf-8") as rows:
        for row in csv.DictReader(rows):
            at = float(row["img_loc_x"]), float(row["img_loc_y"])
            corners[f"cam_{row['cam_id']}"][row["sync_index"], row["keypoint_id"]] = at
    found: Views = []
    for camera in made.poses[0].homographies:
        common = sorted(corners[camera].keys() & corners[made.reference].keys())
        if camera != made.reference and common:
            seen, home = (np.array([corners[name][key] for key in common]) for name in (camera, made.reference))
            found.append((0, camera, seen, home))
    return found


def suturing_views(truth: Path, made: edl.Edl) -> Views:
    """The field's true points in every camera that is tied, and where the reference has them."""
    document, found = json.loads(truth.read_text("utf-8")), []
    names = [camera.name for camera in made.cameras]
    home = np.array(document["poses"][0]["points"], np.float64)[names.index(made.reference)]
    for index, pose in enumerate(made.poses):
        middle = (pose.range.start + pose.range.stop) // 2
        true = next(p for p in document["poses"] if p["first"] <= middle <= p["last"])
        for name, seen in zip(names, np.array(true["points"], np.float64), strict=True):
            if name in pose.homographies and (index, name) != (0, made.reference):
                found.append((index, name, seen, home))
    return found
