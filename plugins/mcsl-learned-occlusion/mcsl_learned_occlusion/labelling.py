"""Frames to mark: which are worth it, written as PNG with what the classifier must know about them; masks read back.

A folder of frames holds, for every frame NAME: NAME.png, the camera's picture, to be painted on; NAME.npz, what all
views show at that moment and usually; and NAME.mask.png once somebody has painted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

import mcsl_core as mcsl
from mcsl_core.hooks import (
    U8,
    AlignedPose,
    AlignedView,
    Cut,
    FrameRange,
    InputError,
    Manifest,
    Progress,
    claim,
    claim_folder,
    read_arrays,
    size_at_columns,
    write_atomic,
)

from .features import Seen, backgrounds, seen_of, to_cut, whole
from .model import CLASSES

# BGR. Pure, so that no pixel of a recording is taken for paint.
PAINT: Mapping[str, tuple[int, int, int]] = {
    "field": (0, 255, 0),
    "in the way": (0, 0, 255),
    "elsewhere": (255, 0, 0),
}
_REMEDY = "Export the frames again with `mcsl-label export`"
TOLERANCE = 40  # levels: what an editor's colour profile may do to a pure colour
HEIGHT, COLUMNS = 360, 480  # of the pictures and of the aligned pose that detectors see
STRETCH_S = 180.0  # a window in which a view's usual look is taken from
SAMPLES = 40  # of a window
FRAMES_A_WINDOW = 4
COVERED = (0.9, 0.5, 0.75, 0.25)  # frames of a camera are taken where it is covered so much, by rank


@frozen(eq=False)
class Marked:
    """A frame that was painted. moment: a name that frames of one moment share.

    labels: (h, w) in cut pixels, the index into `CLASSES`, -1 where nothing was painted. seen, behind: all views, at
    that moment and with nothing before them.
    """

    name: str
    moment: str
    camera: str
    labels: NDArray[np.int8]
    seen: Mapping[str, Seen]
    behind: Mapping[str, Seen]


# ----------------------------------------------------------------------------------------------------- exporting


def check_folder(out: Path, *, force: bool = False) -> None:
    """InputError where frames cannot be written into ``out``, or were painted there: they are no others' to replace."""
    claim_folder(out)
    for path in sorted((*out.glob("*.png"), *out.glob("*.npz"))):
        claim(path, manifest=Manifest.inside(out), force=force)


def export(programme: mcsl.Programme, out: Path, *, frames: int, force: bool = False, progress: Progress) -> list[Path]:
    """Writes about ``frames`` pictures of an analysed recording into ``out``, spread over cameras and poses.

    Returns the pictures written. force: into a folder with painted ones, too.
    """
    check_folder(out, force=force)
    windows = _windows(programme)
    if not windows:
        where = str(programme.folder)
        raise InputError("has no pose in which two cameras are tied together", where=where, remedy="Analyse it again")
    wanted = min(len(windows), -(-frames // FRAMES_A_WINDOW))
    picked = [windows[i] for i in np.unique(np.linspace(0, len(windows) - 1, wanted).round().astype(int))]
    footage = programme.footage
    progress.stage("Looking for frames to mark", len(picked), "stretches")
    written: list[Path] = []
    for number, (pose_index, window) in enumerate(picked):
        at = np.unique(np.linspace(window.start, window.stop - 1, min(SAMPLES, len(window))).astype(int)).tolist()
        aligned = _aligned(programme, pose_index)
        pictures = {c: dict(footage.pictures(c, at, height=HEIGHT)) for c in aligned.homographies}
        samples = [aligned.views({c: pictures[c][frame] for c in pictures}) for frame in at]
        left = len(picked) - number
        count = -(-(frames - len(written)) // left)
        written += write_frames(out, aligned, samples, at, count=count, first_camera=len(written))
        progress.advance(number + 1)
        Manifest.inside(out).record(*(path for png in written for path in (png, png.with_suffix(".npz"))))
    return written


def write_frames(
    out: Path,
    aligned: AlignedPose,
    samples: Sequence[Sequence[AlignedView]],
    frames: Sequence[int],
    *,
    count: int,
    first_camera: int = 0,
) -> list[Path]:
    """Writes ``count`` frames of a stretch: camera after camera, each at samples that cover it more or less.

    samples: the views of each. frames: their programme frames. first_camera: with whose turn to begin.
    """
    behind, cut = backgrounds(aligned, samples), whole(aligned)
    cameras = sorted({view.camera for views in samples for view in views})
    covered = {c: _covered(c, samples, behind, cut) for c in cameras}
    taken: set[tuple[str, int]] = set()
    written = []
    for turn in range(first_camera, first_camera + count):
        camera = cameras[turn % len(cameras)]
        ranked = [i for i in np.argsort(covered[camera]) if not np.isnan(covered[camera][i])]
        ranked = [i for i in ranked if (camera, i) not in taken]
        if not ranked:
            continue
        position = int(ranked[round(COVERED[turn % len(COVERED)] * (len(ranked) - 1))])
        taken.add((camera, position))
        view = next(v for v in samples[position] if v.camera == camera)
        name = f"{frames[position]:07d}_{camera}"
        context: dict[str, NDArray] = {
            "camera": np.array(camera),
            "moment": np.array(f"{frames[position]}"),
            "to_cut": to_cut(aligned, camera, (view.picture.shape[1], view.picture.shape[0])),
        }
        for other, seen in seen_of(samples[position], cut).items():
            context |= {f"seen.{other}": seen.picture, f"inside.{other}": seen.inside}
        context |= {f"behind.{other}": still.picture for other, still in behind.items()}
        save_arrays(out / f"{name}.npz", context)
        save_png(out / f"{name}.png", view.picture)
        written.append(out / f"{name}.png")
    return written


def _covered(camera: str, samples: Sequence[Sequence[AlignedView]], behind: Mapping[str, Seen], cut: Cut) -> NDArray:
    """(samples,) how far the camera's picture is from its usual look, NaN without picture."""
    found = np.full(len(samples), np.nan)
    for i, views in enumerate(samples):
        for view in views:
            if view.camera == camera:
                off = cv2.absdiff(cut.picture(view.aligned), behind[camera].picture).max(axis=2)
                found[i] = np.mean(off[cut.mask(view.inside)] > 30) if view.inside.any() else 0
    return found


def _windows(programme: mcsl.Programme) -> list[tuple[int, FrameRange]]:
    """Stretches in which the lamp stands, of `STRETCH_S` at most, each with the index of its pose."""
    edl = programme.edl
    longest = max(1, round(STRETCH_S * float(edl.rate)))
    windows = []
    for pose_index, pose in enumerate(edl.poses):
        start, stop = pose.range.start, pose.range.stop
        for movement in edl.movements:  # a pose begins and ends within movements
            if movement.range.start <= start < movement.range.stop:
                start = movement.range.stop
            if movement.range.start < stop <= movement.range.stop:
                stop = movement.range.start
        if stop - start < 1 or len(set(pose.homographies) - set(pose.weak_cameras)) < 2:
            continue
        edges = np.linspace(start, stop, max(1, round((stop - start) / longest)) + 1).round().astype(int)
        windows += [(pose_index, FrameRange(int(a), int(b))) for a, b in zip(edges, edges[1:], strict=False)]
    return windows


def _aligned(programme: mcsl.Programme, pose_index: int) -> AlignedPose:
    edl, pose = programme.edl, programme.edl.poses[pose_index]
    sizes = {c.name: c.size for c in edl.cameras}
    size = size_at_columns(sizes[edl.reference], COLUMNS)
    tied = {c: np.array(h) for c, h in pose.homographies.items() if c not in pose.weak_cameras}
    return AlignedPose(size, edl.reference, tied, sizes, np.ones((size[1], size[0]), bool))


def save_arrays(path: Path, arrays: Mapping[str, NDArray]) -> None:
    import io

    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)  # pyright: ignore[reportArgumentType]
    write_atomic(path, stream.getvalue())


def save_png(path: Path, picture: U8) -> None:
    """cv2.imwrite fails silently on some paths."""
    write_atomic(path, cv2.imencode(".png", picture)[1].tobytes())


# ------------------------------------------------------------------------------------------------------- reading


def read_marked(folder: Path) -> list[Marked]:
    """Every painted frame of a folder, in order of name; InputError names a mask that does not fit."""
    if not folder.is_dir():
        raise InputError("is no folder", where=str(folder), remedy="Make it with `mcsl-label export`")
    marked = []
    for painted in sorted(folder.glob("*.mask.png")):
        name = painted.name.removesuffix(".mask.png")
        picture, context = folder / f"{name}.png", folder / f"{name}.npz"
        for needed in (picture, context):
            if not needed.is_file():
                raise InputError(
                    "is not there", where=str(needed), remedy=f"It was exported together with {painted.name}"
                )
        marked.append(_marked(painted, picture, context, name))
    return marked


def _marked(painted: Path, picture: Path, context: Path, name: str) -> Marked:
    mask, shown = (read_png(path) for path in (painted, picture))
    if mask.shape[:2] != shown.shape[:2]:
        sizes = [f"{image.shape[1]}x{image.shape[0]}" for image in (mask, shown)]
        raise InputError(f"is {sizes[0]}, but {picture.name} is {sizes[1]}", where=str(painted), remedy="Keep its size")
    labels = labels_of(mask)
    if (labels < 0).all():
        raise InputError(
            "nothing in it has one of the three colours",
            where=str(painted),
            remedy="Paint with pure green, red and blue; see the README of mcsl-learned-occlusion",
        )
    arrays = read_arrays(context, wanted="what mcsl-label exported with a frame", remedy=_REMEDY)
    try:
        parts: dict[str, dict[str, Any]] = {"seen": {}, "inside": {}, "behind": {}}
        for key, value in arrays.items():
            kind, _, camera = key.partition(".")
            if kind in parts and camera:
                parts[kind][camera] = value
        seen = {camera: Seen(value, parts["inside"][camera]) for camera, value in parts["seen"].items()}
        camera = str(arrays["camera"])
        height, width = seen[camera].inside.shape
        laid = cv2.warpPerspective(
            (labels + 1).astype(np.uint8), arrays["to_cut"], (width, height), flags=cv2.INTER_NEAREST
        )
        behind = {c: Seen(value, seen[c].inside) for c, value in parts["behind"].items() if c in seen}
        moment = f"{painted.parent.resolve()}:{arrays['moment']}"
        _check_shapes([*seen.values(), *behind.values()])
    except (KeyError, ValueError, cv2.error) as error:
        raise InputError(
            f"cannot be used ({type(error).__name__}: {' '.join(str(error).split())})",
            where=str(context),
            remedy=_REMEDY,
        ) from error
    return Marked(name, moment, camera, laid.astype(np.int8) - 1, seen, behind)


def _check_shapes(views: Sequence[Seen]) -> None:
    """ValueError unless all are pictures of one size."""
    for view in views:
        shape = views[0].inside.shape
        if view.inside.dtype != bool or view.inside.shape != shape:
            raise ValueError("where a camera has picture is no mask of the size of the others")
        if view.picture.dtype != np.uint8 or view.picture.shape != (*shape, 3):
            raise ValueError("what a camera shows is no picture of the size of the others")


def labels_of(mask: NDArray[np.uint8]) -> NDArray[np.int8]:
    """(h, w) of a painted BGR or BGRA picture: the index into `CLASSES`, -1 where no paint is."""
    labels = np.full(mask.shape[:2], -1, np.int8)
    for index, name in enumerate(CLASSES):
        off = np.abs(mask[..., :3].astype(np.int16) - PAINT[name]).max(axis=2)
        labels[off <= TOLERANCE] = index
    if mask.shape[2] == 4:
        labels[mask[..., 3] < 128] = -1
    return labels


def read_png(path: Path) -> NDArray[np.uint8]:
    """(h, w, 3 or 4) BGR or BGRA; InputError names what is no such picture. (cv2.imread gives None for some paths.)"""
    image = cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.dtype != np.uint8 or image.ndim != 3:
        raise InputError(
            "is no colour picture of 8 bits a channel", where=str(path), remedy="Save it as PNG, RGB or RGBA, 8 bits"
        )
    return image  # pyright: ignore[reportReturnType]


def painting(labels: NDArray[np.int8]) -> U8:
    """(h, w, 3) BGR of labels: what somebody would have painted, on black."""
    colours = np.array([*(PAINT[name] for name in CLASSES), (0, 0, 0)], np.uint8)
    return colours[labels]
