"""The truth about a simulated recording: ``truth.json`` with ``truth.npz`` beside it.

Times and frames are the programme's, which are the reference camera's. Pixels are full-size, centres at integers;
world points in mm (see rig.py). Cameras may be named by their index or their name.
"""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from mcsl_core.arrays import read_arrays
from mcsl_core.documents import read_json
from mcsl_core.errors import DocumentError
from mcsl_core.timing import parse_rate

from .clocks import Clock
from .rig import PinholeCamera
from .scenario import Scenario

SCHEMA = "mcsl.truth/1"
ARRAYS = "truth.npz"


@attrs.frozen(eq=False, kw_only=True)
class PoseTruth:
    """Programme frames in which the lamp stands still, and where its cameras see the field's points then.

    Attributes
    ----------
    range
        [start, stop) in programme frames.
    K
        (cameras, 3, 3), pixels.
    R
        (cameras, 3, 3), world to camera.
    t
        (cameras, 3), mm.
    field_points_px
        (cameras, N, 2): the truth's ``field_points_mm`` in each camera.
    k1
        (cameras,), radial distortion; see `PinholeCamera`.
    """

    range: tuple[int, int]
    K: NDArray
    R: NDArray
    t: NDArray
    field_points_px: NDArray
    k1: NDArray

    def pinhole(self, camera: int) -> PinholeCamera:
        """The camera of that index."""
        return PinholeCamera(self.K[camera], self.R[camera], self.t[camera], float(self.k1[camera]))


@attrs.frozen(eq=False, kw_only=True)
class MovementTruth:
    """A movement of the lamp: where its cameras stand in every third frame, and where they see the field's points.

    Of each camera its picture that is shown at that programme frame counts, taken a little earlier by its own clock.

    Attributes
    ----------
    frames
        (n,) programme frames, from the movement's first on.
    K
        (n, cameras, 3, 3), pixels.
    R
        (n, cameras, 3, 3), world to camera.
    t
        (n, cameras, 3), mm.
    field_points_px
        (n, cameras, N, 2): the truth's ``field_points_mm`` in each camera.
    k1
        (cameras,), radial distortion; see `PinholeCamera`.
    """

    frames: NDArray
    K: NDArray
    R: NDArray
    t: NDArray
    field_points_px: NDArray
    k1: NDArray

    def pinhole(self, n: int, camera: int) -> PinholeCamera:
        """The camera of that index at ``frames[n]``."""
        return PinholeCamera(self.K[n, camera], self.R[n, camera], self.t[n, camera], float(self.k1[camera]))


@attrs.frozen(eq=False, kw_only=True)
class Truth:
    """All that is known about a simulated recording.

    Attributes
    ----------
    scenario
        What was simulated.
    rate, frames, size
        The programme's; all cameras have this rate and size.
    cameras, reference
        Their names, and the first of them.
    files
        File names beside truth.json, one a camera; of one that is split the first part.
    camera_frames
        How many frames each camera took, whether or not its file kept them all.
    clocks
        Each camera's.
    movements
        [first frame with any motion, first frame standing still again) of each movement.
    poses
        Between the movements.
    field_points_mm
        (N, 3): points spread evenly over the surgical field, on its relief; the same for all poses.
    visible_field
        (frames, cameras), 0..1: the fraction of the field's surface (counted on `Surface.visibility_points_mm`) that
        lies inside that camera's picture and is occluded by nothing drawn above it: heads, shoulders, reaching arms,
        hands at work and at rest and their instruments. 0 for a camera without picture at that time. A camera shows its
        latest frame.
    visible_field_without_hands
        The same, with those hands left out: what heads, shoulders and reaching arms alone leave visible.
    best_plane_error_px
        Per pose, camera -> `best_plane_error`.
    in_movements
        By movement, where the recording was simulated with its ideal programme; else empty.
    """

    scenario: Scenario
    rate: Fraction
    frames: int
    size: tuple[int, int]
    cameras: tuple[str, ...]
    files: tuple[str, ...]
    reference: str
    camera_frames: tuple[int, ...]
    clocks: tuple[Clock, ...]
    movements: tuple[tuple[int, int], ...]
    poses: tuple[PoseTruth, ...]
    field_points_mm: NDArray
    visible_field: NDArray
    visible_field_without_hands: NDArray
    best_plane_error_px: tuple[dict[str, float], ...]
    in_movements: tuple[MovementTruth, ...] = ()

    def camera_index(self, camera: int | str) -> int:
        """The index of a camera named by its index or its name."""
        return self.cameras.index(camera) if isinstance(camera, str) else camera

    def own_frame(self, camera: int | str, frame: int) -> int | None:
        """The camera's own frame shown at a programme frame, or None when it has none then."""
        index = self.camera_index(camera)
        k = own_frame(self.clocks[index], self.rate, frame)
        return k if 0 <= k < self.camera_frames[index] else None


def own_frame(clock: Clock, rate: Fraction, frame: int) -> int:
    """The latest frame of a camera whose time has come at a programme frame; a billionth of slack for rounding."""
    return int(np.floor(clock.own(float(frame / rate)) * float(rate) + 1e-9))


def transfer(H: NDArray, px: NDArray) -> NDArray:
    """(N, 2) pixels through a homography. Written again here: the truth shares no code with what it judges."""
    moved = np.concatenate([px, np.ones((len(px), 1))], 1) @ np.asarray(H, float).T
    return moved[:, :2] / moved[:, 2:]


def rms_distance(a: NDArray, b: NDArray) -> float:
    """Root mean square distance of (N, 2) points."""
    return float(np.sqrt(((a - b) ** 2).sum(1).mean()))


def alignment_error(truth: Truth, pose_index: int, camera: int | str, H: NDArray) -> float:
    """How far a homography misses over the surgical field.

    Parameters
    ----------
    truth
        Of the recording.
    pose_index, camera
        Where it holds; the camera by index or name.
    H
        (3, 3), camera pixel -> reference camera pixel.

    Returns
    -------
    float
        rms over the field's points, reference pixels.
    """
    px = truth.poses[pose_index].field_points_px
    return rms_distance(transfer(H, px[truth.camera_index(camera)]), px[truth.camera_index(truth.reference)])


def best_plane(truth: Truth, pose_index: int, camera: int | str) -> NDArray:
    """(3, 3): the homography camera -> reference camera with the least rms transfer error over the field points."""
    px = truth.poses[pose_index].field_points_px
    return fit_homography(px[truth.camera_index(camera)], px[truth.camera_index(truth.reference)])


def best_plane_error(truth: Truth, pose_index: int, camera: int | str) -> float:
    """rms, in reference pixels, that the best single homography leaves over the field's relief."""
    return alignment_error(truth, pose_index, camera, best_plane(truth, pose_index, camera))


def fit_homography(source: NDArray, target: NDArray) -> NDArray:
    """(3, 3): the homography with the least rms transfer error from (N, 2) ``source`` to ``target``."""
    # Both sides about the origin with unit spread, else the eight numbers differ by six orders of magnitude.
    a, b = _normaliser(source), _normaliser(target)
    p, q = transfer(a, source), transfer(b, target)
    start, _ = cv2.findHomography(p, q)
    solved = least_squares(
        lambda h: (transfer(np.append(h, 1).reshape(3, 3), p) - q).ravel(), (start / start[2, 2]).ravel()[:8]
    )
    H = np.linalg.inv(b) @ np.append(solved.x, 1).reshape(3, 3) @ a
    return H / H[2, 2]


def _normaliser(px: NDArray) -> NDArray:
    middle, spread = px.mean(0), px.std()
    return np.array([[1 / spread, 0, -middle[0] / spread], [0, 1 / spread, -middle[1] / spread], [0, 0, 1]])


def save_truth(truth: Truth, document_file: Path, arrays_file: Path) -> None:
    """Writes the two files of a truth; `load_truth` looks for the arrays as `ARRAYS` beside the document."""
    arrays: dict[str, NDArray] = {
        "field_points_mm": truth.field_points_mm,
        "visible_field": truth.visible_field,
        "visible_field_without_hands": truth.visible_field_without_hands,
    }
    for n, pose in enumerate(truth.poses):
        arrays[f"pose{n}_field_points_px"] = pose.field_points_px
    for n, movement in enumerate(truth.in_movements):
        arrays |= {f"movement{n}_{name}": value for name, value in attrs.asdict(movement, recurse=False).items()}
    np.savez_compressed(arrays_file, **arrays)  # type: ignore[arg-type]
    scenario = attrs.asdict(truth.scenario, recurse=False)
    scenario["rate"] = str(truth.scenario.rate)
    if not scenario["families"]:
        del scenario["families"]  # a plain recording's truth reads as it did before there were any
    document = {
        "schema": SCHEMA,
        "scenario": scenario,
        "rate": str(truth.rate),
        "frames": truth.frames,
        "size": truth.size,
        "reference": truth.reference,
        "cameras": [
            {"name": name, "file": file, "frames": count, "clock": attrs.asdict(clock)}
            for name, file, count, clock in zip(
                truth.cameras, truth.files, truth.camera_frames, truth.clocks, strict=True
            )
        ],
        "movements": truth.movements,
        "poses": [
            {
                "range": pose.range,
                "cameras": {
                    name: {"K": pose.K[c].tolist(), "R": pose.R[c].tolist(), "t": pose.t[c].tolist()}
                    | ({"k1": float(pose.k1[c])} if pose.k1[c] else {})
                    for c, name in enumerate(truth.cameras)
                },
                "best_plane_error_px": truth.best_plane_error_px[n],
            }
            for n, pose in enumerate(truth.poses)
        ],
        "arrays": ARRAYS,
    }
    document_file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def load_truth(path: Path | str) -> Truth:
    """Reads truth.json (or the folder it is in) and the arrays beside it.

    Raises
    ------
    DocumentError
        Where it is none.
    """
    path = Path(path)
    path = path / "truth.json" if path.is_dir() else path
    try:
        document = read_json(path, wanted="the truth of a simulated recording")
        if not isinstance(document, dict) or document.get("schema") != SCHEMA:
            raise ValueError(f"its schema is not {SCHEMA!r}")
        if Path(document["arrays"]).name != document["arrays"]:
            raise ValueError(f"its arrays lie beside it, not at {document['arrays']!r}")
        arrays = read_arrays(path.parent / document["arrays"], wanted="the truth's arrays", remedy="", most=1 << 31)
        return _structure(document, arrays)
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise DocumentError(
            f"cannot be read as the truth of a simulated recording ({error})", where=str(path),
            remedy="Make the recording again with `mcsl simulate`",
        ) from error  # fmt: skip


def _structure(document: dict, arrays: dict[str, NDArray]) -> Truth:
    scenario = Scenario(**document["scenario"])
    names = tuple(camera["name"] for camera in document["cameras"])
    poses = []
    for n, pose in enumerate(document["poses"]):
        K, R, t = (np.array([pose["cameras"][name][key] for name in names]) for key in "KRt")
        k1 = np.array([pose["cameras"][name].get("k1", 0.0) for name in names])
        px = arrays[f"pose{n}_field_points_px"]
        poses.append(PoseTruth(range=tuple(pose["range"]), K=K, R=R, t=t, field_points_px=px, k1=k1))
    return Truth(
        scenario=scenario,
        rate=parse_rate(document["rate"]),
        frames=document["frames"],
        size=tuple(document["size"]),
        cameras=names,
        files=tuple(camera["file"] for camera in document["cameras"]),
        reference=document["reference"],
        camera_frames=tuple(camera["frames"] for camera in document["cameras"]),
        clocks=tuple(Clock(**camera["clock"]) for camera in document["cameras"]),
        movements=tuple((start, stop) for start, stop in document["movements"]),
        poses=tuple(poses),
        field_points_mm=arrays["field_points_mm"],
        visible_field=arrays["visible_field"],
        visible_field_without_hands=arrays["visible_field_without_hands"],
        best_plane_error_px=tuple(pose["best_plane_error_px"] for pose in document["poses"]),
        in_movements=_movements(arrays, len(document["movements"])),
    )


def _movements(arrays: dict[str, NDArray], count: int) -> tuple[MovementTruth, ...]:
    """What the arrays hold of the movements: all of them or, as before there were any, none."""
    if "movement0_frames" not in arrays:
        return ()
    names = [field.name for field in attrs.fields(MovementTruth)]
    return tuple(MovementTruth(**{name: arrays[f"movement{n}_{name}"] for name in names}) for n in range(count))
