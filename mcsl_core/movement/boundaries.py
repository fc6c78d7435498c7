"""One side of a movement to the frame: its start, or looking backwards in time its end.

Every camera's common displacement from the view at rest, over all cameras together: they sit on one lamp, so each has
gone the same share of its way. On simulated recordings the pooled curve is known to 0.02 px, and a turn of 20 s is seen
within a third of a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT

from .displacement import Grey, Standing, texture
from .onset import onset

Array = NDArray[np.float64]

REST_LOOKS = 5  # looks whose median is the view at rest, every third of them taken: a hand that passes is not in it
REST_STRIDE = 3
FOUND = 0.1  # share of patches found again with which a view counts; of one that has moved on 0.00 to 0.05 are
FOUND_STEADY = 0.2  # the same of patches that are background, of which heads cover fewer and chance finds up to 0.15
LOST_LOOKS = 6
LOST_SAMPLES = 3
AT_REST_PX = 0.1  # a view this near to its place, over all cameras, has not moved: between samples the error is 0.05
STEADY_PX = 0.3  # patches that lie this still in the looks at rest are background
NOISE_PX = 0.02
RISEN = 0.7
AT_ONCE_PX = 0.3  # a curve that ends below it shows no course: the lamp was gone from one look to the next
FITTED_PX = 1.3  # the curve is fitted up to here: beyond, patches are lost and the linear step falls behind


def bracket(looks: Iterable[Mapping[str, Grey]]) -> tuple[int, int]:
    """(the last of ``looks`` that shows the view at rest, which the first does; the first after it that does not).

    looks: camera -> texture, in order away from rest; read no farther than needed.
    """
    standing: dict[str, Standing] = {}
    rest, gone, last = 0, 0, 0
    for last, look in enumerate(looks):
        if not standing:
            standing = {camera: Standing.of([one]) for camera, one in look.items()}
            continue
        shifts = [s for c, one in look.items() if c in standing and (s := standing[c].shift(one)) is not None]
        sizes = [float(np.linalg.norm(c)) for s in shifts if s.share() > FOUND and (c := s.common()) is not None]
        found = len(sizes) >= max(1, min(2, len(shifts)))
        if found and np.median(sizes) < AT_REST_PX:
            rest, gone = last, 0
        elif not gone and (not found or np.median(sizes) > FITTED_PX):
            gone = last
        if gone and last - gone >= LOST_SAMPLES:  # for good, not behind a head that passes
            break
    return rest, gone or last


@frozen(eq=False)
class CloseLook:
    """How to look closely: at all ``cameras``, ``step_s`` apart, beginning ``looks`` before the sample at rest."""

    footage: Footage
    cameras: Sequence[str]
    step_s: float
    looks: int = field(default=25)

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
    margin = look.looks * step
    moving = min(max(moving, 0), look.footage.frames - 1)
    begin, found = rest, None
    for _ in range(4):
        begin = rest - forward * margin
        begin = max(begin, bound) if forward > 0 else min(begin, bound)
        order = list(range(begin, moving + forward, forward * step))
        if len(order) < REST_LOOKS + 2:
            return None
        found = _leaving(_courses(look, order))
        if found is not None and found > REST_LOOKS * REST_STRIDE:
            return begin + forward * step * found
        if begin == bound:
            break
        margin *= 2
    return None if found is None else begin + forward * step * found


def _courses(look: CloseLook, order: Sequence[int]) -> list[Course]:
    """Every camera's way along the frames of ``order``, whose first are at rest."""

    def course(camera: str) -> Course | None:
        textures = look.textures(camera, order)
        first = [textures[frame] for frame in order if frame in textures][: REST_LOOKS * REST_STRIDE]
        if len(first) < 2:
            return None
        standing = Standing.of(first[::REST_STRIDE]).at_rest(first, STEADY_PX)
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
    live = [c for c in courses if (c.share[: REST_LOOKS * REST_STRIDE] > FOUND_STEADY).mean() > 0.5]
    if not live:
        return None
    near = np.array([c.share > FOUND_STEADY for c in live])  # (C, N); NaN is not near
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
    # A knock of a pixel ends where it can still be seen: beyond its rise the curve says nothing about its start.
    risen = np.flatnonzero(curve > RISEN * np.nanmax(curve))
    curve = curve[: int(risen.min(initial=top)) + 1]
    rest = curve[: max(len(curve) // 2, 2)]
    noise = max(NOISE_PX, 1.48 * float(_median(np.abs(rest - _median(rest, axis=0)), axis=0)))
    return onset(np.arange(float(len(curve))), curve, noise=noise)


def _gone_for_good(enough: NDArray[np.bool_]) -> int:
    """The first look at which the view at rest is lost and stays so, not for a hand that passes."""
    for i in range(1, len(enough)):
        if not enough[i : i + LOST_LOOKS].any():
            return i
    return len(enough)


def _median(values: Array, *, axis: int) -> Array:
    """`numpy.nanmedian` without its warning where there is no data."""
    return np.ma.filled(np.ma.median(np.ma.masked_invalid(values), axis=axis), np.nan)  # pyright: ignore[reportReturnType]
