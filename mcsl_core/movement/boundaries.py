"""One boundary of a movement to the frame: its start or, backwards in time, its end.

Every camera's common displacement against a template at rest, over all cameras together: they sit on one lamp, so each
has gone the same share of its way. On simulated recordings the pooled curve is known to 0.02 px, and a turn of 20 s is
seen within a third of a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.parallel import by_threads
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SAMPLE_HEIGHT

from .displacement import Grey, Template, common_sizes, texture
from .onset import onset

Array = NDArray[np.float64]

REST_FRAMES = 5  # frames whose median is the template at rest: a hand that passes is not in it
REST_STRIDE = 3  # of the first frames every third is taken for it
LEAST_SHARE = 0.1  # of patches found again for a camera to count; once it has moved on, 0.00 to 0.05 are found
LEAST_BACKGROUND_SHARE = 0.2  # the same of background patches, of which heads occlude some and chance finds up to 0.15
LOST_FRAMES = 6
LOST_SAMPLES = 3
AT_REST_PX = 0.1  # the median over all cameras up to which none has moved: between samples the error is 0.05
STEADY_PX = 0.3  # patches that lie this still in the frames at rest are background
NOISE_PX = 0.02
RISEN = 0.7
ABRUPT_PX = 0.3  # a curve that ends below it shows no growth: the lamp was gone from one frame to the next
MAX_FITTED_PX = 1.3  # the curve is fitted up to here: beyond, patches are lost and the linear step falls behind


@frozen(eq=False)
class CloseSampling:
    """Close sampling in time about one boundary of a movement.

    Attributes
    ----------
    footage
        The cameras on the programme clock.
    cameras
        Their names.
    step_s
        Seconds from one frame to the next.
    lead_frames
        How many of its frames lie before the sample at rest.
    """

    footage: Footage
    cameras: Sequence[str]
    step_s: float
    lead_frames: int = field(default=25)

    def textures(self, camera: str, frames: Sequence[int]) -> dict[int, Grey]:
        """Programme frame -> texture of ``camera``, of those with a picture."""
        pictures = self.footage.pictures(camera, sorted(frames), height=SAMPLE_HEIGHT)
        return {frame: texture(picture) for frame, picture in pictures if picture is not None}


@frozen(eq=False)
class DisplacementCurve:
    """One camera's displacement against its template at rest, over N frames; NaN where there is no data.

    Attributes
    ----------
    share
        (N,): share of the background patches found again, 0..1.
    common
        (N, 4): as `Displacement.common`.
    """

    share: Array
    common: Array


def bracket_boundary(samples: Iterable[Mapping[str, Grey]]) -> tuple[int, int]:
    """The two samples between which the lamp leaves its position.

    Parameters
    ----------
    samples
        Camera -> texture, in order away from rest; the first is at rest. Read no farther than needed.

    Returns
    -------
    rest, gone
        Positions of the last sample at rest and of the first after it that is not.
    """
    templates: dict[str, Template] = {}
    rest, gone, last = 0, 0, 0
    for last, textures in enumerate(samples):
        if not templates:
            templates = {camera: Template.of([one]) for camera, one in textures.items()}
            continue
        displacements = [templates[c].displacement(one) for c, one in textures.items() if c in templates]
        usable = [d for d in displacements if d is not None]
        sizes = common_sizes(usable, least_share=LEAST_SHARE)
        found = len(sizes) >= max(1, min(2, len(usable)))
        if found and np.median(sizes) < AT_REST_PX:
            rest, gone = last, 0
        elif not gone and (not found or np.median(sizes) > MAX_FITTED_PX):
            gone = last
        if gone and last - gone >= LOST_SAMPLES:  # for good, not behind a head that passes
            break
    return rest, gone or last


def boundary_time(sampling: CloseSampling, rest: int, moving: int, bound: int) -> float | None:
    """The instant, in frames, at which the lamp begins to move (``rest`` < ``moving``) or comes to rest.

    Parameters
    ----------
    sampling
        How to sample.
    rest
        A programme frame at which the lamp stands, perhaps a second off.
    moving
        One by which it surely moves.
    bound
        How far beyond ``rest`` may be read.

    Returns
    -------
    float or None
        None where no camera shows it.

    Notes
    -----
    Where the curve is not flat at its beginning, sampling begins earlier, up to four times.
    """
    rate = float(sampling.footage.rate)
    step = max(1, round(sampling.step_s * rate))
    forward = 1 if moving >= rest else -1
    margin = sampling.lead_frames * step
    moving = min(max(moving, 0), sampling.footage.frames - 1)
    begin, found = rest, None
    for _ in range(4):
        begin = rest - forward * margin
        begin = max(begin, bound) if forward > 0 else min(begin, bound)
        order = list(range(begin, moving + forward, forward * step))
        if len(order) < REST_FRAMES + 2:
            return None
        found = _onset_position(_curves(sampling, order))
        if found is not None and found > REST_FRAMES * REST_STRIDE:
            return begin + forward * step * found
        if begin == bound:
            break
        margin *= 2
    return None if found is None else begin + forward * step * found


def _curves(sampling: CloseSampling, order: Sequence[int]) -> list[DisplacementCurve]:
    """Every camera's curve along the frames of ``order``, whose first are at rest; of those with a picture there."""
    found = by_threads(lambda camera: _curve(sampling.textures(camera, order), order), sampling.cameras)
    return [curve for curve in found if curve is not None]


def _curve(textures: Mapping[int, Grey], order: Sequence[int]) -> DisplacementCurve | None:
    at_rest = [textures[frame] for frame in order if frame in textures][: REST_FRAMES * REST_STRIDE]
    if len(at_rest) < 2:
        return None
    template = Template.of(at_rest[::REST_STRIDE]).background_only(at_rest, STEADY_PX)
    share, common = np.full(len(order), np.nan), np.full((len(order), 4), np.nan)
    for i, frame in enumerate(order):
        displacement = template.displacement(textures[frame]) if frame in textures else None
        if displacement is not None:
            share[i] = displacement.share()
            together = displacement.common()
            if together is not None:
                common[i] = together
    return DisplacementCurve(share, common)


def _onset_position(curves: Sequence[DisplacementCurve]) -> float | None:
    """The position along the curves at which the lamp begins to move; None where no camera shows it."""
    live = [c for c in curves if (c.share[: REST_FRAMES * REST_STRIDE] > LEAST_BACKGROUND_SHARE).mean() > 0.5]
    if not live:
        return None
    visible = np.array([c.share > LEAST_BACKGROUND_SHARE for c in live])  # (C, N); NaN is not visible
    way = np.array([np.where(n[:, None], c.common, np.nan) for n, c in zip(visible, live, strict=True)])
    size = _median(np.linalg.norm(way, axis=2), axis=0)
    gone = _lost_for_good((visible.sum(axis=0) >= min(2, len(live))) & (size <= MAX_FITTED_PX))
    top = gone - 1
    # The curve is judged along the direction of its end: noise across it does not count, and that along it has no bias.
    toward = way[:, top]
    length = np.linalg.norm(toward, axis=1)
    if not float(_median(length, axis=0)) > ABRUPT_PX:
        return top + 0.5
    share = np.einsum("cnk,ck->cn", way[:, :gone], toward) / length[:, None] ** 2
    curve = _median(share, axis=0) * float(np.nanmedian(length))
    # A knock of a pixel ends where it can still be seen: beyond its rise the curve says nothing about its start.
    risen = np.flatnonzero(curve > RISEN * np.nanmax(curve))
    curve = curve[: int(risen.min(initial=top)) + 1]
    rest = curve[: max(len(curve) // 2, 2)]
    noise = max(NOISE_PX, 1.48 * float(_median(np.abs(rest - _median(rest, axis=0)), axis=0)))
    return onset(np.arange(float(len(curve))), curve, noise=noise)


def _lost_for_good(enough: NDArray[np.bool_]) -> int:
    """The first position at which the template is lost and stays so, not for a hand that passes."""
    for i in range(1, len(enough)):
        if not enough[i : i + LOST_FRAMES].any():
            return i
    return len(enough)


def _median(values: Array, *, axis: int) -> Array:
    """`numpy.nanmedian` without its warning where there is no data."""
    return np.ma.filled(np.ma.median(np.ma.masked_invalid(values), axis=axis), np.nan)  # pyright: ignore[reportReturnType]
