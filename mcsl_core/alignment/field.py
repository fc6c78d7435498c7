"""Where the surgical field may lie before it is found: by hue, by vote of the cameras; and what a pose usually shows.

`field_voices` finds it.

Masks are bool; (H, W) in aligned pixels, (h, w) in those of a camera's reduced picture.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import inverse, transform_points
from mcsl_core.imaging.masks import Mask, central_ellipse, hue_mask, main_region

from .aligned_views import AlignedPose, Picture
from .dense_matching import pixels_of

_AIM = 0.3  # of a picture's width: how fast a camera's aim falls off from its middle
_BINS = 8  # a side of the colour cube of `modal_picture`


def field_of_camera(pictures: Sequence[Picture]) -> Mask:
    """The field in one camera's own pictures, while nothing is aligned yet.

    Parameters
    ----------
    pictures : sequence of (h, w, 3) uint8 array
        BGR, of a camera that stands still; one at least.

    Returns
    -------
    (h, w) bool array
        Where most of them have the field's hue, the main region only.
    """
    votes = np.mean([hue_mask(picture) > 0 for picture in pictures], axis=0)
    return main_region(votes > 0.5)


def field_by_vote(aligned: AlignedPose, fields: Mapping[str, Mask]) -> Mask:
    """The field by the cameras' own masks.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie; its own field is not used.
    fields : mapping of str to (h, w) bool array
        Camera -> the field in its own picture; empty masks have no vote.

    Returns
    -------
    (H, W) bool array
        Where most of the cameras that cover a pixel have the field there. The middle of the picture where none has any.
    """
    width, height = aligned.size
    votes, voters = np.zeros((height, width)), np.zeros((height, width))
    for name in aligned.homographies:
        own = fields.get(name)
        if own is None or not own.any():
            continue
        warp = aligned.warp_of(name, (own.shape[1], own.shape[0]))
        votes += cv2.warpPerspective(own.astype(np.float32), warp, aligned.size)
        voters += cv2.warpPerspective(np.ones(own.shape, np.float32), warp, aligned.size)
    field = main_region((votes > 0.5 * voters) & (voters > 0.5))
    return field if field.any() else central_ellipse(aligned.size)


def field_in_camera(aligned: AlignedPose, camera: str, shape: tuple[int, int]) -> Mask:
    """The hull of the field in a camera's picture.

    Parameters
    ----------
    aligned : AlignedPose
        With a field that is not empty.
    camera : str
        One that is tied in.
    shape : (int, int)
        Rows and columns of the reduced picture.

    Returns
    -------
    (h, w) bool array
        The hull: hands and instruments cut holes into the field's colour, but what lies between is the field too.
    """
    outline = cv2.convexHull(np.argwhere(aligned.field)[:, ::-1].astype(np.float32)).reshape(-1, 2)
    back = inverse(aligned.warp_of(camera, (shape[1], shape[0])))
    mask = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(transform_points(back, outline.astype(np.float64))).astype(np.int32), 1)
    return mask > 0


def shared_aim(aligned: AlignedPose) -> float:
    """How much the cameras aim at one place.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie; its own field is not used.

    Returns
    -------
    float
        1 where all have the same in the middle of their pictures, less the farther that lies from some of them: of 24
        lamps 0.99 and 1.00, of cameras about a room 0.90.
    """
    return float(aim_of(aligned).max())


def aim_of(aligned: AlignedPose) -> NDArray[np.float64]:
    """How much every place is what the cameras aim at.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie; its own field is not used.

    Returns
    -------
    (H, W) array
        1 in the middle of all pictures; the mean over the cameras.
    """
    width, height = aligned.size
    total = np.zeros(width * height)
    for name in aligned.homographies:
        size = aligned.camera_sizes[name]
        own = transform_points(inverse(aligned.warp_of(name, size)), pixels_of(aligned.size))
        off = np.hypot(own[:, 0] - size[0] / 2, own[:, 1] - size[1] / 2) / size[0]
        total += np.exp(-((off / _AIM) ** 2))
    return (total / max(len(aligned.homographies), 1)).reshape(height, width)


def modal_picture(aligned: AlignedPose, samples: Iterable[Mapping[str, Picture | None]]) -> Picture:
    """The commonest colour at every aligned pixel, over all samples and cameras, coarsely.

    Parameters
    ----------
    aligned : AlignedPose
        How the cameras lie.
    samples : iterable of mapping of str to (h, w, 3) uint8 array or None
        Per sample, camera -> its picture, BGR.

    Returns
    -------
    (H, W, 3) uint8 array
        BGR.

    Notes
    -----
    A head or a hand hides a pixel from some cameras in some samples and never appears quite the same; what lies behind
    it does. (The mean of many samples instead gave gloves that work above one part of the drapes for field.)
    """
    width, height = aligned.size
    counts = np.zeros((height * width, _BINS**3), np.uint16)
    pixels = np.arange(height * width)
    for pictures in samples:
        for view in aligned.views(pictures):
            lab = cv2.cvtColor(cv2.GaussianBlur(view.aligned, (0, 0), 0.7), cv2.COLOR_BGR2LAB).reshape(-1, 3)
            inside = view.inside.ravel()
            bins = _bins(lab.astype(np.int32))
            counts[pixels[inside], bins[inside]] += 1  # each pixel once a view
    cube = counts.reshape(height, width, _BINS, _BINS, _BINS).astype(np.float32)
    for axis in (2, 3, 4):  # a colour on the border of two bins must not lose to one in the middle of its own
        cube = scipy.ndimage.uniform_filter1d(cube, 2, axis=axis, mode="constant")
    lab = _colours(cube.reshape(height * width, -1).argmax(axis=1)).reshape(height, width, 3)
    return cv2.cvtColor(lab, cv2.COLOR_LAB2BGR)  # pyright: ignore[reportReturnType]


def _bins(lab: NDArray[np.int32]) -> NDArray[np.int32]:
    """Lightness in steps of 32, a and b in steps of 16 about grey."""
    light, a, b = lab[:, 0] // 32, (lab[:, 1] - 64) // 16, (lab[:, 2] - 64) // 16
    top = _BINS - 1
    return (light * _BINS + np.clip(a, 0, top)) * _BINS + np.clip(b, 0, top)


def _colours(bins: NDArray[np.int64]) -> NDArray[np.uint8]:
    """The corner between a bin and the one before it in each direction, which is the middle of the smoothed bin."""
    light, a, b = bins // _BINS**2 * 32, bins // _BINS % _BINS * 16 + 64, bins % _BINS * 16 + 64
    return np.stack([light, a, b], axis=1).astype(np.uint8)
