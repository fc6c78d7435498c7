"""The look `see_through`: what heads hide from the chosen camera, as other cameras show it at the same instant.

What is above the field (`filling.see_through`) is decided on a fixed grid of frames, twelve a second, and goes over
from one to the next by a cubic B-spline in time: whatever is decided, the weight of a mask never changes by more than
`STEADY` from one frame of the grid to the next, and a frame depends on its number alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import floor

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.filling.protocol import FillContext
from mcsl_core.filling.see_through import Moment
from mcsl_core.filling.viewpoint import viewpoint_difference
from mcsl_core.filling.visual_hull import COLUMNS, Cells, taken
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.lru_cache import LruCache
from mcsl_core.timing import FrameRange

from .camera_warper import CameraWarper
from .frame_context import FrameContext
from .moments import Moments
from .placement import programme_matrix
from .read_ahead import ReadAhead

GRID_S = 1 / 12  # from one decision to the next
STEADY = 2 / 3  # of a mask's weight: most that it changes from one decision to the next
_FADE_S = 0.3  # towards the ends of a pose, where the lamp begins to move
_SOFT = 1.0  # sigma of a mask's edge, in cells
_RING = 6.0  # sigma of the difference in colour about a mask, in cells
_MOST_CODES = 24.0  # of that difference
_LITTLE = 1 / 500  # of the picture: who hides less of a mask from another camera does not matter
_TRACE = 1 / 256  # of weight: less is nothing
_DECIDED_BYTES = 60_000_000  # of decisions on cells, 230 kB for each other camera


def decided_within(rate: float) -> int:
    """Frames on either side of one, at so many a second, whose decisions its masks go over between."""
    return 2 * _step(rate)


def _step(rate: float) -> int:
    return max(1, round(GRID_S * rate))


@frozen(eq=False)
class Patch:
    """What one other camera shows in place of the chosen one, by cell of the programme before centering.

    Attributes
    ----------
    weight : (rows, columns) float32
        0..1.
    colour : (rows, columns, 3) float32
        Codes added to its picture, so that it meets the chosen one's about the mask.
    """

    weight: Cells
    colour: Cells


class SeeThrough:
    """Sees through heads for one compositor.

    Parameters
    ----------
    warper : CameraWarper
        Of the compositor.
    pictures : ReadAhead
        What the warper's pictures come from.
    """

    def __init__(self, warper: CameraWarper, pictures: ReadAhead) -> None:
        self._warper = warper
        self._moments = Moments(warper, pictures)
        self.forget()

    def forget(self) -> None:
        """Let go of what was kept."""
        self._moments.forget()
        self._decided: LruCache[Mapping[str, Patch]] = LruCache(_DECIDED_BYTES)

    def through(self, context: FrameContext, shown: FillContext, planes: Planes) -> Planes:
        """A finished frame with what other cameras show under heads.

        Parameters
        ----------
        context : FrameContext
            The frame.
        shown : FillContext
            Where other cameras' pictures come from: the same, or one that tints them.
        planes : Planes
            The frame so far.

        Returns
        -------
        Planes
            ``planes`` itself where nothing is seen through.
        """
        patches = self._at(context)
        if not patches:
            return planes
        rect = _around(np.sum([patch.weight for patch in patches.values()], axis=0), context)
        if rect is None:
            return planes
        pictures = {name: shown.picture(name, rect, parallax_corrected=True) for name in patches}
        found = Planes(*(plane.copy() for plane in planes))
        for index, target in enumerate(rect.of(found)):
            total, result = np.zeros(target.shape, np.float32), np.zeros(target.shape, np.float32)
            for name, patch in patches.items():
                picture = pictures[name]
                if picture is None:
                    continue
                weight = _spread(patch.weight, rect, 2 if index else 1, context)
                level = _spread(np.ascontiguousarray(patch.colour[..., index]), rect, 2 if index else 1, context)
                result += weight * (tuple(picture)[index] + level)
                total += weight
            target[:] = np.clip(np.rint(result + (1 - total) * target), 0, 255)
        return found

    def weights(self, context: FrameContext) -> Mapping[str, Cells]:
        """By other camera, 0..1 by cell of the programme before centering: how much of it a frame shows."""
        return {name: patch.weight for name, patch in self._at(context).items()}

    def _at(self, context: FrameContext) -> Mapping[str, Patch]:
        """The patches of a frame, between those of the grid."""
        frame = context.frame
        stretch = next((piece for piece in self._moments.stretches if frame in piece), None)
        if stretch is None or not self._warper.has_relief(context.laid_by, context.camera):
            return {}
        step = _step(context.rate)
        first, part = floor(frame / step), (frame % step) / step
        spline = [(first + n, weight) for n, weight in zip((-1, 0, 1, 2), _b_spline(part), strict=True) if weight > 0]
        near = [(max(stretch.start, min(n * step, stretch.stop - 1)), weight) for n, weight in spline]
        fade = self._fade(context, stretch)
        decided = [(self._patches(context, at), weight * fade) for at, weight in near]
        names = dict.fromkeys(name for patches, _ in decided for name in patches)
        lost: Cells | None = None
        found = {}
        for name in names:
            own = [(patches[name], weight) for patches, weight in decided if name in patches]
            weight = sum(w * patch.weight for patch, w in own)
            if not self._warper.has_relief(context.laid_by, name):  # decided where it was known how it lies
                lost = np.asarray(weight if lost is None else lost + weight, np.float32)
                continue
            total = sum(w for _, w in own)
            colour = sum(w * patch.colour for patch, w in own) / np.float32(max(total, 1e-6))
            found[name] = Patch(np.asarray(weight, np.float32), np.asarray(colour, np.float32))
        return found if lost is None else _with_more(found, lost)

    def _fade(self, context: FrameContext, stretch: FrameRange) -> float:
        """0..1: less near where the lamp begins to move or comes to rest, and is not followed."""
        frames = self._warper.edl.frames
        begins = context.frame - stretch.start + 1 if stretch.start > 0 else frames
        ends = stretch.stop - context.frame if stretch.stop < frames else frames
        return min(1.0, min(begins, ends) / max(1.0, _FADE_S * context.rate))

    # ----------------------------------------------------------------------------------------- a frame of the grid

    def _patches(self, context: FrameContext, frame: int) -> Mapping[str, Patch]:
        return self._decided.get((context.camera, frame), lambda: self._decide(context.camera, frame, context.frame))

    def _decide(self, camera: str, frame: int, now: int) -> Mapping[str, Patch]:
        moment = self._moments.at(frame, now)
        if moment is None or camera not in moment.live or len(moment.live) < 3:
            return {}
        above = moment.above(camera)
        if not above.any():
            return {}
        left = _blurred(above, _SOFT)
        found = {}
        for other in self._order(frame, camera, moment):
            if left.max() < _TRACE:
                break
            clear = self._clear(moment, other, left)
            weight = left * clear
            if weight.max() < 0.02:
                continue
            found[other] = Patch(weight, _meeting(moment, camera, other, above, clear))
            left = np.asarray(left - weight, np.float32)
        return found

    @staticmethod
    def _clear(moment: Moment, camera: str, left: Cells) -> Cells:
        """0..1 by cell of the programme: where the camera shows the field, or hands at work on it."""
        seen = moment.clear(camera) > 0.5
        if ((left > _TRACE) & ~seen).mean() > _LITTLE:
            seen = moment.clear_or_hands(camera) > 0.5
        if ((left > _TRACE) & (moment.changed_in_programme(camera) > 0.5)).mean() > _LITTLE:
            seen &= moment.above(camera) < 0.5
        return _blurred(np.asarray(cv2.erode(seen.astype(np.float32), np.ones((5, 5), np.uint8)), np.float32), _SOFT)

    def _order(self, frame: int, camera: str, moment: Moment) -> list[str]:
        """The other cameras of the moment, the nearest viewpoint first."""
        edl, pose = self._warper.edl, self._warper.pose(self._warper.pose_at(frame))
        front, size = programme_matrix(edl, pose, camera), edl.camera(camera).size
        others = (name for name in moment.live if name != camera)
        return sorted(others, key=lambda name: viewpoint_difference(front, programme_matrix(edl, pose, name), size))


def _with_more(patches: Mapping[str, Patch], more: Cells) -> dict[str, Patch]:
    """With more weight for those that have at least a quarter of it: so no head comes back by halves."""
    total = sum((patch.weight for patch in patches.values()), np.zeros_like(more))
    times = np.where(4 * total >= more, 1 + more / np.maximum(total, _TRACE), 1).astype(np.float32)
    return {name: Patch(patch.weight * times, patch.colour) for name, patch in patches.items()}


def _meeting(moment: Moment, camera: str, other: str, above: Cells, clear: Cells) -> Cells:
    """Codes by which the camera's picture differs from another's, from where both show the field into the mask."""
    own, theirs = moment.rays[camera].own, moment.rays[other].own
    both = clear * (1 - np.asarray(cv2.dilate(above, np.ones((3, 3), np.uint8)), np.float32))
    for name, cells in ((camera, own), (other, theirs)):
        both = both * taken(moment.behind[name].verified, cells) * (1 - moment.changed_in_programme(name))
    apart = taken(moment.live[camera], own) - taken(moment.live[other], theirs)
    share = _blurred(both, _RING)[..., None]
    codes = _blurred(np.asarray(apart * both[..., None], np.float32), _RING) / (share + 0.02)
    return np.clip(codes, -_MOST_CODES, _MOST_CODES).astype(np.float32)


def _b_spline(part: float) -> tuple[float, float, float, float]:
    """Weights of the grid's frames before, at, after and after that, ``part`` of the way to the third."""
    t = part
    return (1 - t) ** 3 / 6, (3 * t**3 - 6 * t**2 + 4) / 6, (-3 * t**3 + 3 * t**2 + 3 * t + 1) / 6, t**3 / 6


def _blurred(cells: Cells, sigma: float) -> Cells:
    return np.asarray(cv2.GaussianBlur(cells, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE), np.float32)


def _around(weight: Cells, context: FrameContext) -> Rect | None:
    """The part of the programme in which there is any weight, of even sides; None without any."""
    x, y, width, height = cv2.boundingRect((weight > _TRACE).astype(np.uint8))
    if not width:
        return None
    cell = context.size[0] / COLUMNS
    left, top = (max(0, floor((n - 1) * cell + by)) for n, by in zip((x, y), context.offset, strict=True))
    right = min(context.size[0], floor((x + width + 1) * cell + context.offset[0]) + 2)
    bottom = min(context.size[1], floor((y + height + 1) * cell + context.offset[1]) + 2)
    left, top, right, bottom = left // 2 * 2, top // 2 * 2, right // 2 * 2, bottom // 2 * 2
    return Rect(left, top, right - left, bottom - top) if left < right and top < bottom else None


def _spread(cells: Cells, rect: Rect, step: int, context: FrameContext) -> NDArray[np.float32]:
    """Cells at a rectangle's samples, ``step`` pixels apart, linear between their middles."""
    rows, columns = cells.shape
    x, y = columns / context.size[0], rows / context.size[1]
    matrix = np.array(
        [
            [x * step, 0, (rect.x - context.offset[0] + 0.5) * x - 0.5],
            [0, y * step, (rect.y - context.offset[1] + 0.5) * y - 0.5],
        ]
    )
    size = (rect.width // step, rect.height // step)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(cells, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE), np.float32)
