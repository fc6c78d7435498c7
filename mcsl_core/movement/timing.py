"""One side of a movement to the frame: its start, or looking backwards in time its end.

Every camera's common displacement from the view at rest, over all cameras together: they sit on one lamp, so each has
gone the same share of its way. On simulated recordings the pooled curve is known to 0.02 px, and a turn of 20 s is seen
within a third of a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from ..footage import Footage
from ..samples import SAMPLE_HEIGHT
from .displacement import Grey, Standing, texture
from .onset import onset

Array = NDArray[np.float64]

REST_LOOKS = 5  # looks whose median is the view at rest, every third of them taken: a hand that passes is not in it
REST_STRIDE = 3
FOUND = 0.1  # share of patches found again with which a view counts; of a view that has moved on 0.00 to 0.05 are
LOST_LOOKS = 6
AT_ONCE_PX = 0.3  # a curve that ends below it shows no course: the lamp was gone from one look to the next
FITTED_PX = 1.3  # the curve is fitted up to here: beyond, patches are lost and the linear step falls behind


@frozen(eq=False)
class CloseLook:
    """How to look closely: at all ``cameras``, ``step_s`` apart, ``margin_s`` beyond the sample at rest."""

    footage: Footage
    cameras: Sequence[str]
    step_s: float
    margin_s: float

    def textures(self, camera: str, frames: Sequence[int]) -> dict[int, Grey]:
        pictures = self.footage.pictures(camera, sorted(frames), height=SAMPLE_HEIGHT)
        return {frame: texture(picture) for frame, picture in pictures if picture is not None}


@frozen(eq=False)
class Course:
    """One camera's way from its view at rest. share: (N,) patches found again; common: (N, 4) as `Shift.common`; both
    NaN where there is no data."""

    share: Array
    common: Array


def time_side(look: CloseLook, rest: int, moving: int, bound: int) -> float | None:
    """The instant, in frames, at which the lamp leaves (``rest`` < ``moving``) or reaches its place.

    rest: a frame at which it stands, perhaps a second off; moving: one by which it surely moves; bound: as far as may
    be looked beyond rest. None where no camera shows it. Where the curve is not flat at its beginning, the look begins
    earlier.
    """
    rate = float(look.footage.rate)
    step = max(1, round(look.step_s * rate))
    forward = 1 if moving >= rest else -1
    margin = look.margin_s * rate
    moving = min(max(moving, 0), look.footage.frames - 1)
    for _ in range(4):
        begin = rest - forward * round(margin)
        begin = max(begin, bound) if forward > 0 else min(begin, bound)
        order = list(range(begin, moving + forward, forward * step))
        if len(order) < REST_LOOKS + 2:
            return None
        found = _leaving(_courses(look, order))
        if found is None:
            return None
        if begin == bound or found > REST_LOOKS * REST_STRIDE:
            break
        margin *= 2
    return order[0] + forward * step * found


def _courses(look: CloseLook, order: Sequence[int]) -> list[Course]:
    """Every camera's way along the frames of ``order``, whose first are at rest."""

    def course(camera: str) -> Course | None:
        textures = look.textures(camera, order)
        first = [frame for frame in order if frame in textures][: REST_LOOKS * REST_STRIDE : REST_STRIDE]
        if len(first) < 2:
            return None
        standing = Standing.of([textures[frame] for frame in first])
        share, common = np.full(len(order), np.nan), np.full((len(order), 4), np.nan)
        for i, frame in enumerate(order):
            shift = standing.shift(textures[frame]) if frame in textures else None
            if shift is not None:
                share[i] = shift.share()
                together = shift.common()
                if together is not None:
                    common[i] = together
        return Course(share, common)

    with ThreadPoolExecutor(max_workers=2) as workers:
        return [c for c in workers.map(course, look.cameras) if c is not None]


def _leaving(courses: Sequence[Course]) -> float | None:
    """The position, in looks, at which the lamp leaves its place; None where no camera shows it."""
    live = [c for c in courses if float(np.nanmedian(c.share[: 2 * REST_LOOKS])) > FOUND]
    if not live:
        return None
    near = np.array([c.share > FOUND for c in live])  # (C, N); NaN is not near
    way = np.array([np.where(n[:, None], c.common, np.nan) for n, c in zip(near, live, strict=True)])
    size = _median(np.linalg.norm(way, axis=2), axis=0)
    gone = _gone_for_good((near.sum(axis=0) >= min(2, len(live))) & (size <= FITTED_PX))
    top = gone - 1
    # The curve is judged along the direction of its end: noise across it does not count, and that along it has no bias.
    toward = way[:, top]
    length = np.linalg.norm(toward, axis=1)
    if not float(_median(length, axis=0)) > AT_ONCE_PX:
        return top + 0.5
    share = np.einsum("cnk,ck->cn", way[:, :gone], toward) / length[:, None] ** 2
    curve = _median(share, axis=0) * float(np.nanmedian(length))
    return onset(np.arange(float(gone)), curve)


def _gone_for_good(enough: NDArray[np.bool_]) -> int:
    """The first look at which the view at rest is lost and stays so, not for a hand that passes."""
    for i in range(1, len(enough)):
        if not enough[i : i + LOST_LOOKS].any():
            return i
    return len(enough)


def _median(values: Array, *, axis: int) -> Array:
    """`numpy.nanmedian` without its warning where there is no data."""
    return np.ma.filled(np.ma.median(np.ma.masked_invalid(values), axis=axis), np.nan)  # pyright: ignore[reportReturnType]
