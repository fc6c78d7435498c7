"""Manual alignment, the yardstick that mcsl's is held against: what a person with an editing program can set.

A similarity (move, turn, scale) is all that a strip transform offers; it is fitted to point pairs, or taken from
the numbers an editor set in Blender. Matrices map camera pixel to programme pixel, full size, centres at integers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import cos, sin
from pathlib import Path
from typing import Any

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike, NDArray

from mcsl_core.documents import make_converter, read_json, structure_document
from mcsl_core.edl import IDENTITY, Edl, Matrix, Pose, Weak
from mcsl_core.edl.checks import LARGEST_SIDE
from mcsl_core.edl.movement import unfollowed
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import DocumentError, Fault, InputError, UsageError
from mcsl_core.imaging.geometry import to_edl_matrix
from mcsl_core.tables import Grouping, number, read_table

FITS = ("similarity", "homography")
COLUMNS = ("pose", "camera", "x", "y", "programme_x", "programme_y")

_ONE_POINT = "the points lie in one place on one side"
_WANTED = "a file of alignments by hand"
_LINE = "the points lie on a line"
_SCALES = (1e-3, 1e3)  # programme pixels a camera pixel, in the middle of the picture

ByHand = Mapping[int, Mapping[str, Matrix]]  # pose index -> camera -> camera pixel to programme pixel


def similarity_from_points(source: ArrayLike, target: ArrayLike) -> Matrix:
    """The similarity (move, turn, scale) that brings points nearest to others, by least squares.

    Parameters
    ----------
    source, target : (N, 2) array_like
        Point pairs (x, y), N >= 2.

    Returns
    -------
    Matrix
        source -> target.

    Raises
    ------
    ValueError
        Where the points fix none: too few, or all at one point.

    References
    ----------
    S. Umeyama: Least-squares estimation of transformation parameters between two point patterns. PAMI 13(4), 1991;
    in the plane, without reflection.
    """
    a, b = _points(source, target, 2)
    from_middle, to_middle = a - a.mean(axis=0), b - b.mean(axis=0)
    spread = np.square(from_middle).sum()
    if not spread > 0:
        raise ValueError(_ONE_POINT)
    along = (from_middle * to_middle).sum() / spread  # scale times the cosine of the turn, then its sine
    across = (from_middle[:, 0] * to_middle[:, 1] - from_middle[:, 1] * to_middle[:, 0]).sum() / spread
    if np.hypot(along, across) < 1e-9:
        raise ValueError(_ONE_POINT)
    linear = np.array([[along, -across], [across, along]])
    return _affine(linear, b.mean(axis=0) - linear @ a.mean(axis=0))


def homography_from_points(source: ArrayLike, target: ArrayLike) -> Matrix:
    """The homography that brings points nearest to others, by least squares.

    Parameters
    ----------
    source, target : (N, 2) array_like
        Point pairs (x, y), N >= 4.

    Returns
    -------
    Matrix
        source -> target.

    Raises
    ------
    ValueError
        Where the points fix none: too few, or all on a line.
    """
    a, b = _points(source, target, 4)
    try:
        found, _ = cv2.findHomography(a, b, 0)
    except cv2.error as error:  # its own check of points that it cannot work with
        raise ValueError(_LINE) from error
    flat = min(_flatness(a), _flatness(b)) < 1e-3
    if flat or found is None or abs(np.linalg.det(found)) < 1e-12 or abs(found[2, 2]) < 1e-12:
        raise ValueError(_LINE)
    return to_edl_matrix(np.asarray(found, np.float64))


def _flatness(points: NDArray) -> float:
    """How wide a cloud of points is, as a share of its length."""
    length, width = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[:2]
    return float(width / length) if length else 0.0


def _points(source: ArrayLike, target: ArrayLike, least: int) -> tuple[NDArray, NDArray]:
    a, b = np.asarray(source, np.float64), np.asarray(target, np.float64)
    if a.ndim != 2 or a.shape[1:] != (2,) or a.shape != b.shape:
        raise ValueError(f"expected as many points (x, y) on either side, got shapes {a.shape} and {b.shape}")
    if len(a) < least:
        raise ValueError(f"expected at least {least} point pairs, got {len(a)}")
    largest = max(np.abs(a).max(), np.abs(b).max())
    if not largest < 1e6:  # NaN as well
        raise ValueError(f"a point lies at {largest:g} pixels")
    return a, b


def _affine(linear: NDArray[np.float64], shift: NDArray[np.float64]) -> Matrix:
    """A (2, 2) matrix and the (2,) shift after it."""
    return to_edl_matrix(np.vstack([np.column_stack([linear, shift]), [0.0, 0.0, 1.0]]))


@frozen
class StripTransform:
    """A strip's transform as Blender shows it.

    Parameters
    ----------
    offset_x, offset_y : float
        In render pixels; x to the right, y up.
    scale : float
        About the picture's middle; across, and up as well without ``scale_y``.
    rotation : float
        In radians, counter-clockwise.
    scale_y : float, optional
        Up.
    """

    offset_x: float = 0.0
    offset_y: float = 0.0
    scale: float = 1.0
    rotation: float = 0.0
    scale_y: float | None = None

    def matrix(self, camera_size: tuple[int, int], programme_size: tuple[int, int]) -> Matrix:
        """Camera pixel -> programme pixel, exactly as Blender lays the picture: scaled, turned, then moved.

        Parameters
        ----------
        camera_size, programme_size : (int, int)
            Width and height.

        Returns
        -------
        Matrix
        """
        turn = np.array(  # y points down here
            [[cos(self.rotation), sin(self.rotation)], [-sin(self.rotation), cos(self.rotation)]]
        )
        linear = turn @ np.diag([self.scale, self.scale if self.scale_y is None else self.scale_y])
        camera_middle = (np.array(camera_size) - 1) / 2
        programme_middle = (np.array(programme_size) - 1) / 2
        offset = np.array([self.offset_x, -self.offset_y])
        return _affine(linear, programme_middle + offset - linear @ camera_middle)


@frozen
class _Entry:
    """One camera's alignment in one pose, by its index or by a programme frame in it, or in all poses."""

    camera: str
    pose: int | None = None
    frame: int | None = None
    points: tuple[tuple[float, float, float, float], ...] | None = None
    transform: StripTransform | None = None
    homography: Matrix | None = None

    def __attrs_post_init__(self) -> None:
        given = [name for name in ("points", "transform", "homography") if getattr(self, name) is not None]
        if len(given) != 1:
            raise Fault(f"expected one of points, transform, homography, got {' and '.join(given) or 'none'}")
        if self.pose is not None and self.frame is not None:
            raise Fault("expected a pose or a frame in it, got both")
        if self.points is not None and len(self.points) < 4:
            raise Fault(f"expected four or more point pairs, got {len(self.points)}", ".points")


@frozen
class _File:
    alignments: tuple[_Entry, ...]


def load_manual(path: Path, edl: Edl, *, fit: str = "similarity") -> ByHand:
    """Read alignments by hand from a JSON or CSV file (docs/how-to/evaluation.md).

    Parameters
    ----------
    path : Path
        The file; by its suffix CSV or else JSON.
    edl : Edl
        The programme they are for.
    fit : {"similarity", "homography"}
        What point pairs become.

    Returns
    -------
    mapping of int to mapping of str to Matrix
        pose index -> camera -> camera pixel to programme pixel. What is said of one pose wins over what is said of all.

    Raises
    ------
    DocumentError
        Names the entry that is wrong.
    InputError
        Where the file cannot be read.
    UsageError
        Where there is no such ``fit``.
    """
    if fit not in FITS:
        raise UsageError(f"{fit!r} is no fit for point pairs", remedy=f"Take one of {', '.join(FITS)}")
    read = _read_csv if path.suffix.lower() in (".csv", ".tsv") else _read_json
    by_hand: dict[int, dict[str, Matrix]] = {index: {} for index in range(len(edl.poses))}
    sizes = {camera.name: camera.size for camera in edl.cameras}
    solved: dict[tuple[str, int | None], Matrix] = {}
    for entry in read(path):
        where = f"{path}, camera {entry.camera}" + ("" if entry.pose is None else f", pose {entry.pose}")
        if entry.camera not in sizes:
            raise DocumentError("the EDL has no such camera", where=where, remedy=f"It has {', '.join(sizes)}")
        pose_index = _pose_index(entry, edl, where)
        try:
            matrix = _solved(entry, sizes[entry.camera], edl.size, fit)
            _check_usable(np.array(matrix), sizes[entry.camera])
        except ValueError as error:
            remedy = "Take points that are spread over the field" if entry.points else "Correct the numbers"
            raise DocumentError(str(error), where=where, remedy=remedy) from error
        if solved.setdefault((entry.camera, pose_index), matrix) != matrix:
            raise DocumentError("is aligned in two ways", where=where, remedy="Keep one, or name the pose of each")
    for (camera, pose_index), matrix in sorted(solved.items(), key=lambda item: item[0][1] is not None):
        for index in by_hand if pose_index is None else [pose_index]:
            by_hand[index][camera] = matrix
    return by_hand


def _check_usable(matrix: NDArray[np.float64], size: tuple[int, int]) -> None:
    """ValueError unless the camera's whole picture of ``size`` is laid somewhere, at a scale that shows anything."""
    width, height = size
    corners = np.array([(x, y, 1.0) for x in (0, width - 1) for y in (0, height - 1)])
    if not np.isfinite(matrix).all():
        raise ValueError("is no alignment: a number in it is too large or none")
    with np.errstate(all="ignore"):
        (x, y, w), depths = matrix @ ((width - 1) / 2, (height - 1) / 2, 1.0), corners @ matrix[2]
        slope = (matrix[:2, :2] * w - np.outer((x, y), matrix[2, :2])) / w**2  # of programme pixels by camera pixels
        scales = np.linalg.svd(slope, compute_uv=False) if np.isfinite(slope).all() else np.zeros(2)
    if not (_SCALES[0] < scales.min() and scales.max() < _SCALES[1]):
        raise ValueError("is singular or nearly so: the picture becomes a line or a point, or huge")
    if depths.min() * depths.max() <= 0 or not matrix[2, 2]:
        raise ValueError("lays a part of the picture behind the viewer")


def _pose_index(entry: _Entry, edl: Edl, where: str) -> int | None:
    if entry.frame is not None:
        found = [index for index, pose in enumerate(edl.poses) if entry.frame in pose.range]
        if not found:
            remedy = f"It has 0 to {edl.frames - 1}"
            raise DocumentError(f"the EDL has no frame {entry.frame}", where=where, remedy=remedy)
        return found[0]
    if entry.pose is not None and not 0 <= entry.pose < len(edl.poses):
        raise DocumentError("the EDL has no such pose", where=where, remedy=f"It has 0 to {len(edl.poses) - 1}")
    return entry.pose


def _solved(entry: _Entry, size: tuple[int, int], programme: tuple[int, int], fit: str) -> Matrix:
    if entry.transform is not None:
        return entry.transform.matrix(size, programme)
    if entry.homography is not None:
        given = np.array(entry.homography)
        _check_usable(given, size)
        return to_edl_matrix(given)
    points = np.array(entry.points)
    made = similarity_from_points if fit == "similarity" else homography_from_points
    return made(points[:, :2], points[:, 2:])


def _read_json(path: Path) -> Sequence[_Entry]:
    value: Any = read_json(path, wanted=_WANTED, remedy="docs/how-to/evaluation.md has an example")
    name = "alignments by hand (evaluation.md)"
    return structure_document(value, _File, make_converter(), where=str(path), name=name).alignments


def _read_csv(path: Path) -> Sequence[_Entry]:
    """Rows of `COLUMNS`; an empty pose means all poses."""
    remedy = f"The columns are {','.join(COLUMNS)}; docs/how-to/evaluation.md has an example"
    rows = read_table(path, wanted=_WANTED, remedy=remedy)
    if lacking := [name for name in COLUMNS if name not in (*rows.columns, "pose")]:
        raise DocumentError(f"lacks columns: {', '.join(lacking)}", where=str(path), remedy=remedy)
    found: dict[tuple[str, int | None], list[tuple[float, float, float, float]]] = {}
    grouping = Grouping(most=LARGEST_SIDE)
    for row in rows:
        try:
            pose = _whole(row.cells.get("pose", ""))
            x, y, u, v = (number(row.cells[name]) for name in COLUMNS[2:])
        except ValueError as error:
            raise DocumentError(str(error), where=f"{path}, line {row.line}", remedy=remedy) from error
        for name in COLUMNS[2:]:
            grouping.see(row.cells[name], row.line)
        found.setdefault((row.cells["camera"], pose), []).append((x, y, u, v))
    grouping.check(path)
    if not found:
        raise DocumentError("holds no point pairs", where=str(path), remedy=remedy)
    entries = []
    for (camera, pose), points in found.items():
        try:
            entries.append(_Entry(camera, pose, points=tuple(points)))
        except Fault as fault:
            where = f"{path}, camera {camera}" + ("" if pose is None else f", pose {pose}")
            raise DocumentError(str(fault), where=where, remedy="Add lines") from fault
    return entries


def _whole(text: str) -> int | None:
    if text and not re.fullmatch(r"\d{1,9}(\.0*)?", text, re.ASCII):
        raise ValueError(f"{text[:40]!r} is no pose")
    return int(float(text)) if text else None


def aligned_by_hand(edl: Edl, by_hand: ByHand) -> Edl:
    """The same shots with every camera's picture where a person put it.

    Parameters
    ----------
    edl : Edl
        The programme.
    by_hand : mapping of int to mapping of str to Matrix
        See `load_manual`.

    Returns
    -------
    Edl
        The reference camera stays as it is where it has no alignment.

    Raises
    ------
    InputError
        Where another camera is shown that has none.
    """
    for piece, decision in resolve(edl):
        for index, pose in enumerate(edl.poses):
            shown = decision.camera != edl.reference and piece.intersection(pose.range)
            if shown and decision.camera not in by_hand.get(index, {}):
                raise InputError(
                    f"camera {decision.camera} is shown at frames {shown} and was not aligned by hand",
                    where=f"pose {index}",
                    remedy="Add its point pairs (docs/how-to/evaluation.md)",
                )
    poses = []
    for index, pose in enumerate(edl.poses):
        try:
            with np.errstate(divide="ignore", invalid="ignore"):  # a corner at infinity: the document refuses it, below
                poses.append(_aligned_pose(edl, pose, by_hand.get(index, {})))
        except (Fault, np.linalg.LinAlgError) as fault:  # each is an alignment, but not with the reference's
            raise InputError(
                f"the cameras' alignments by hand do not go together ({fault})",
                where=f"pose {index}",
                remedy=f"Check that of camera {edl.reference}, which the others lead through",
            ) from fault
    return attrs.evolve(edl, poses=tuple(poses), movements=unfollowed(edl.movements), corrections=())


def _aligned_pose(edl: Edl, pose: Pose, matrices: Mapping[str, Matrix]) -> Pose:
    """The reference's matrix is the anchor, and the others' lead through it."""
    given = {name: np.array(matrix, np.float64) for name, matrix in matrices.items()}
    anchor = given.pop(edl.reference, np.eye(3))
    back = np.linalg.inv(anchor)
    homographies = {name: to_edl_matrix(back @ matrix) for name, matrix in given.items()}
    lacking = [c.name for c in edl.cameras if c.name not in given and c.name != edl.reference]
    return attrs.evolve(
        pose,
        homographies={edl.reference: IDENTITY, **homographies},
        anchor=to_edl_matrix(anchor),
        relief=None,
        weak=tuple(Weak(name, "not aligned by hand") for name in lacking),
    )
