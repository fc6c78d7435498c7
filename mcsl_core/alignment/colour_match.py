"""Matching one camera's colours to another's: a gain and an offset each of R', G' and B', fitted where both cover.

Six parameters cannot invent colours or follow noise; white balance, exposure and black level are what differs between
cameras of one lamp. Stored as one affine matrix on BT.709 limited 8-bit codes, so that it acts on planes directly.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Colour, ColourKey, Pose
from mcsl_core.edl.colour import gains_at
from mcsl_core.imaging.planes import BGR_TO_YUV, U8, YUV_TO_BGR, Planes, upsample_chroma

GAINS = (0.5, 2.0)
OFFSETS = (-40.0, 40.0)
_LEAST_PIXELS = 400
_MOST_PIXELS = 40_000
_ROUNDS = 12
# Black levels of one lamp's cameras differ by a few codes; a fit to mid tones alone makes up for its errors with more,
# and white gauze turns cyan. 3 codes, and a quarter of what the gain leaves unexplained.
_BLACK = 3.0
_DOUBT = 0.25


def match_colours(source_bgr: U8, target_bgr: U8, mask: U8) -> Colour | None:
    """Fits the map of one camera's colours to another's.

    Parameters
    ----------
    source_bgr, target_bgr : (H, W, 3) uint8 array
        Aligned pictures of both, BGR, possibly stacked from several frames.
    mask : (H, W) uint8 array
        Where it is not 0 the two are compared.

    Returns
    -------
    Colour or None
        The affine map of the source's codes to the target's: gains in 0.5..2, offsets in -40..40. None with fewer
        than 400 useful pixels, and where both have texture and in no colour the same: they show different things.

    Raises
    ------
    ValueError
        Where the sizes differ.

    Notes
    -----
    Robust: parallax and things that only one of them sees may fill up to about a third of the mask.
    """
    if source_bgr.shape != target_bgr.shape or mask.shape != source_bgr.shape[:2]:
        raise ValueError(f"pictures and mask differ in size: {source_bgr.shape}, {target_bgr.shape}, {mask.shape}")
    inside = np.flatnonzero(cv2.erode((mask != 0).astype(np.uint8), np.ones((5, 5), np.uint8)))
    # Averaging over 5 pixels takes out noise and the last pixel of misalignment, which would flatten the fitted gain.
    a, b = (cv2.blur(picture, (5, 5)).reshape(-1, 3)[inside] for picture in (source_bgr, target_bgr))
    clear = (np.minimum(a, b).min(axis=1) > 6) & (np.maximum(a, b).max(axis=1) < 249)  # clipped codes say nothing
    chosen = np.flatnonzero(clear)
    if len(chosen) < _LEAST_PIXELS:
        return None
    chosen = chosen[:: max(1, len(chosen) // _MOST_PIXELS)]
    fits = _fit(a[chosen].astype(np.float64), b[chosen].astype(np.float64))
    return None if fits is None else as_matrix(fits[:, 0], fits[:, 1])


def as_matrix(gains: NDArray[np.float64], offsets: NDArray[np.float64]) -> Colour:
    """The Y'CbCr matrix of a gain and an offset for each colour.

    Parameters
    ----------
    gains, offsets : (3,) float array
        In the order B, G, R, of full-range codes 0..255.

    Returns
    -------
    Colour
        3x4, on BT.709 limited 8-bit codes.
    """
    bgr = np.hstack([np.diag(gains), np.reshape(offsets, (3, 1))])
    matrix = (_square(BGR_TO_YUV) @ _square(bgr) @ _square(YUV_TO_BGR))[:3]
    return Colour(tuple(tuple(float(v) for v in row) for row in matrix))  # pyright: ignore[reportArgumentType]


def colour_at(pose: Pose, camera: str, frames: Sequence[int]) -> Colour | None:
    """What makes a camera's colours the programme's.

    Parameters
    ----------
    pose : Pose
        Of the frames.
    camera : str
        Its name.
    frames : sequence of int
        Programme frames: one, or those whose median the picture is.

    Returns
    -------
    Colour or None
        The drift taken out, then the match; None where its colours stay as they are.
    """
    match, drift = pose.colour.get(camera), drift_at(pose, camera, frames)
    if drift is None or match is None:
        return match or drift
    matrix = np.array(match.matrix) @ _square(np.array(drift.matrix))
    return Colour(tuple(tuple(float(v) for v in row) for row in matrix))  # pyright: ignore[reportArgumentType]


def drift_at(pose: Pose, camera: str, frames: Sequence[int]) -> Colour | None:
    """What brings a camera to its usual exposure and white balance; None where it does not drift. See `colour_at`."""
    keys: Sequence[ColourKey] = pose.colour_keys.get(camera, ())
    if not keys:
        return None
    gains = np.median([gains_at(keys, frame) for frame in frames], axis=0)
    return as_matrix(gains[::-1], np.zeros(3))


def apply_colour(planes: Planes, colour: Colour) -> Planes:
    """Applies a match to a picture.

    Parameters
    ----------
    planes : Planes
        The picture.
    colour : Colour
        Of `match_colours`.

    Returns
    -------
    Planes
        Exact to a code at every pixel: chroma where it lies, Y' with chroma's share.

    Notes
    -----
    One `cv2.transform` of three channels to three, which alone of its kind is vectorised (0.3 ms for the half-size
    planes at 1080p; to two channels 2.3), makes the new chroma and that share. The share fills its 8 bits, so that
    rounding and interpolating it cost a fraction of a code.
    """
    y, u, v = planes
    luma, chroma = np.array(colour.matrix[0]), np.array(colour.matrix[1:])
    fill = min(16.0, 127 / max(128 * float(np.abs(luma[1:3]).sum()), 1e-9))
    share = fill * luma[1:3]
    rows = np.array([[0.0, *share, 128 - 128 * share.sum()], *chroma])
    share_of_y, new_u, new_v = cv2.split(cv2.transform(cv2.merge([_at_chroma(y), u, v]), rows))
    rest = luma[3] + 128 * float(luma[1:3].sum()) - 128 / fill
    new_y = cv2.addWeighted(y, float(luma[0]), upsample_chroma(np.asarray(share_of_y, np.uint8)), 1 / fill, rest)
    return Planes(new_y, new_u, new_v)  # pyright: ignore[reportArgumentType]


def _fit(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """(3, 2) gain and offset of each colour; a pixel that fits badly in one is left out of all. None: see above."""
    gains, offsets = _start(a, b)
    unlike = False
    for _ in range(_ROUNDS):
        textured = likened = 0
        residual = np.abs(b - (a * gains + offsets)).max(axis=1)
        keep = residual <= max(3.0, 2.5 * float(np.median(residual)))
        new_gains, new_offsets = np.empty(3), np.empty(3)
        for channel in range(3):
            x, y = a[keep, channel], b[keep, channel]
            spread_x, spread_y = x.std(), y.std()
            # Both have noise, so neither regression is right; the ratio of spreads is, where the two go together.
            has_texture = spread_x > 2 and spread_y > 2
            alike = float(np.corrcoef(x, y)[0, 1]) if has_texture else 0.0
            together = alike > 0.5
            textured, likened = textured + has_texture, likened + together
            gain = np.clip(spread_y / spread_x if together else 1.0, *GAINS)
            offset = np.clip(y.mean() - gain * x.mean(), *OFFSETS)
            if together:  # what the two share little of says little of black: then the gain alone has to explain more
                doubt = _DOUBT * np.sqrt(1 - alike**2) * gain * x.mean()
                offset *= _BLACK**2 / (_BLACK**2 + doubt**2)
                gain = np.clip((y.mean() - offset) / x.mean(), *GAINS)
            new_gains[channel], new_offsets[channel] = gain, offset
        unlike = textured == 3 and not likened
        if np.allclose(new_gains, gains, atol=1e-4) and np.allclose(new_offsets, offsets, atol=1e-2):
            break
        gains, offsets = new_gains, new_offsets
    return None if unlike else np.stack([gains, offsets], axis=1)


def _start(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Median colour and inter-quartile spread: a start that a third of foreign pixels cannot throw."""
    low_a, mid_a, high_a = np.percentile(a, [25, 50, 75], axis=0)
    low_b, mid_b, high_b = np.percentile(b, [25, 50, 75], axis=0)
    gains = np.clip((high_b - low_b + 1) / (high_a - low_a + 1), *GAINS)
    return gains, np.clip(mid_b - gains * mid_a, *OFFSETS)


def _square(affine: NDArray[np.float64]) -> NDArray[np.float64]:
    """A 3x4 matrix as one of 4x4."""
    return np.vstack([affine, [0, 0, 0, 1]])


def _at_chroma(y: U8) -> U8:
    """(H / 2, W / 2): luma where the chroma samples lie, [1 2 1] / 4 of the columns around them."""
    height, width = y.shape[0] // 2, y.shape[1] // 2
    small = cv2.resize(y, (width, height), interpolation=cv2.INTER_AREA)
    if width > 1:
        left = cv2.resize(y[:, 1:-1], (width - 1, height), interpolation=cv2.INTER_AREA)
        cv2.addWeighted(small[:, 1:], 0.5, left, 0.5, 0, dst=small[:, 1:])
    return small  # pyright: ignore[reportReturnType]
