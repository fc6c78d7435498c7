"""How well each camera shows the field, whatever is in its way: sharply, finely, from where the reference camera looks.

Measured once a pose, from a few samples. Each merit is 0 (not at all) to 1 (as well as any camera of the pose):

- **sharpness**: how much of the field's finest detail is left, against the sharpest camera.
- **resolution**: how many pixels the camera has across the field, against the one that has most. A camera that sees the
  field steeply has fewer: it shows it shortened.
- **viewpoint**: how near it looks from where the reference camera does, whose perspective the programme keeps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose, Picture
from mcsl_core.alignment.observations import SolvedPose, spread
from mcsl_core.edl import Movement
from mcsl_core.filling.viewpoint import viewpoint_difference
from mcsl_core.imaging.masks import Mask
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

Array = NDArray[np.float64]
MERITS = ("sharpness", "resolution", "viewpoint")
_SAMPLES = 16  # of a pose that sharpness is measured in
# Of the sharpest camera's detail (as energy) that counts as sharp: five sharp simulated cameras had 0.85 and more, four
# real ones over a photograph 0.69 to 1, the fifth, blurred by about a pixel of 360 rows, 0.42.
_SHARP = 0.7
_LEAST_DETAIL = 0.5  # levels squared, of 255: below it a field is too plain to say how sharp it is
_SOME_PIXELS = 200
_FAR = 2.0  # times the middle of the cameras' differences to the reference camera: nothing left


def pose_merits(
    samples: SampleStore, solved: Sequence[SolvedPose], movements: Sequence[Movement], progress: Progress
) -> dict[str, Array]:
    """Measures the merits of every camera in every pose.

    Parameters
    ----------
    samples : SampleStore
        The recording's samples.
    solved : sequence of SolvedPose
        P poses.
    movements : sequence of Movement
        Samples in them are left out.
    progress : Progress
        Told of every pose.

    Returns
    -------
    dict of str to (P, C) float array
        Merit -> 0..1 for every pose and camera; 1 where nothing is known.
    """
    progress.stage("Measuring how well the cameras see", len(solved), "poses")
    found = {merit: np.ones((len(solved), len(samples.cameras))) for merit in MERITS}
    for number, pose in enumerate(solved):
        aligned = pose.aligned
        standing = spread(samples.standing(pose.pose.range, movements), _SAMPLES)
        measured = sharpness(aligned, samples, standing), resolution(aligned), viewpoint(aligned)
        for merit, of_cameras in zip(MERITS, measured, strict=True):
            for camera, value in of_cameras.items():
                found[merit][number, samples.cameras.index(camera)] = value
        progress.advance(number + 1)
    return found


def with_merits(table: ScoreTable, poses: Sequence[FrameRange], merits: Mapping[str, Array]) -> ScoreTable:
    """The table with what `pose_merits` measured.

    Parameters
    ----------
    table : ScoreTable
        Of S samples and C cameras.
    poses : sequence of FrameRange
        P ranges that tile the programme.
    merits : mapping of str to (P, C) float array
        Of them.

    Returns
    -------
    ScoreTable
        With its ``merits``.
    """
    which = np.searchsorted([pose.start for pose in poses], table.frames, side="right") - 1
    return attrs.evolve(table, merits={name: merit[which] for name, merit in merits.items()})


def sharpness(aligned: AlignedPose, samples: SampleStore, positions: Sequence[int]) -> dict[str, float]:
    """How sharp each camera is about the field.

    Parameters
    ----------
    aligned : AlignedPose
        The pose.
    samples : SampleStore
        The recording's samples.
    positions : sequence of int
        Those of the pose to measure in.

    Returns
    -------
    dict of str to float
        Camera -> 0..1, without those of which nothing can be said.
    """
    detail = {}
    for camera in aligned.homographies:
        pictures = [p for p in (samples.picture(position, camera) for position in positions) if p is not None]
        if len(pictures) >= 2:
            detail[camera] = fine_detail(pictures, _field_of(aligned, camera, pictures[0]))
    known = {camera: value for camera, value in detail.items() if value is not None}
    most = max(known.values(), default=0.0)
    return {camera: min(1.0, value / most / _SHARP) for camera, value in known.items()} if most > 0 else {}


def fine_detail(pictures: Sequence[Picture], mask: Mask) -> float | None:
    """The energy of a picture's finest detail as a multiple of that an octave coarser: it falls with blur.

    Parameters
    ----------
    pictures : sequence of (h, w, 3) uint8 array
        Of one camera that stands still, two or more.
    mask : (h, w) bool array
        Where to measure.

    Returns
    -------
    float or None
        None where the mask is small or what lies in it is plain.

    Notes
    -----
    A ratio, so that neither exposure nor how much there is to see matter. The pictures' halves are multiplied with each
    other, so that noise, which differs between them, counts on average nothing.
    """
    if np.count_nonzero(mask) < _SOME_PIXELS:
        return None
    grey = [cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float32) for picture in pictures]
    halves = [_bands(np.median(half, axis=0)) for half in (grey[::2], grey[1::2])]
    fine, coarse = (float((a * b)[mask].mean()) for a, b in zip(*halves, strict=True))
    return max(fine, 0.0) / coarse if coarse > _LEAST_DETAIL else None


def resolution(aligned: AlignedPose) -> dict[str, float]:
    """How finely each camera shows the field.

    Parameters
    ----------
    aligned : AlignedPose
        The pose.

    Returns
    -------
    dict of str to float
        Camera -> 0..1: pixels across the field, the root of their number over it, against the camera that has most.
    """
    rows, columns = np.nonzero(aligned.field)
    if not len(rows):
        return {}
    middle = np.array([columns.mean(), rows.mean(), 1.0])
    across = {}
    for camera, size in aligned.camera_sizes.items():
        if camera in aligned.homographies:
            back = np.linalg.inv(aligned.warp_of(camera, size))
            back = back / abs(np.linalg.det(back)) ** (1 / 3)
            # The area that a small piece about the middle is magnified by: det H / w^3.
            across[camera] = float(abs(back[2] @ middle)) ** -1.5
    most = max(across.values(), default=1.0)
    return {camera: value / most for camera, value in across.items()}


def viewpoint(aligned: AlignedPose) -> dict[str, float]:
    """How near each camera's viewpoint is to the reference camera's.

    Parameters
    ----------
    aligned : AlignedPose
        The pose.

    Returns
    -------
    dict of str to float
        Camera -> 0..1, by `viewpoint_difference`: 1 for the reference camera, 1/2 for the middle of the others.
    """
    reference = aligned.homographies[aligned.reference]
    size = aligned.camera_sizes[aligned.reference]
    apart = {name: viewpoint_difference(reference, own, size) for name, own in aligned.homographies.items()}
    middle = float(np.median([d for name, d in apart.items() if name != aligned.reference] or [0.0]))
    return {name: max(0.0, 1 - d / (_FAR * middle)) if middle > 0 else 1.0 for name, d in apart.items()}


def _field_of(aligned: AlignedPose, camera: str, picture: Picture) -> Mask:
    """The field in a camera's own reduced picture."""
    height, width = picture.shape[:2]
    warp = aligned.warp_of(camera, (width, height))
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return cv2.warpPerspective(aligned.field.astype(np.uint8), warp, (width, height), flags=flags) > 0


def _bands(grey: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """What of a picture is finer than a pixel or so, and what lies an octave above."""
    once, twice = cv2.GaussianBlur(grey, (0, 0), 0.7), cv2.GaussianBlur(grey, (0, 0), 1.4)
    return grey - once, once - twice  # pyright: ignore[reportReturnType]
