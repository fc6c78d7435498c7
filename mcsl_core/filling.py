"""Filling the programme pixels that the chosen camera, warped, does not cover. Nothing is ever invented.

A filler gets one `View` a programme frame: the chosen camera's warped picture and the means to look at the other
cameras through the same eye, piece by piece. Everything is in programme pixels; alphas are uint8, 255 for "all of it".
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Protocol

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from .images import BLACK, U8, Planes, feathered


@frozen
class Rect:
    """Part of a picture: left, top, width, height, all even, so that it has chroma of its own."""

    x: int
    y: int
    width: int
    height: int

    def of(self, planes: Planes) -> Planes:
        """That part of ``planes``, as views."""
        y, u, v = planes
        half = (slice(self.y // 2, (self.y + self.height) // 2), slice(self.x // 2, (self.x + self.width) // 2))
        return Planes(y[self.y : self.y + self.height, self.x : self.x + self.width], u[half], v[half])


_SLIVER = 1 / 200  # least share of the frame for which one more camera is decoded: 100 x 100 pixels at 1080p


class View(Protocol):
    """One programme frame before filling."""

    @property
    def frame(self) -> int: ...

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the programme."""
        ...

    @property
    def camera(self) -> str:
        """The chosen camera."""
        ...

    @property
    def front(self) -> Planes:
        """The chosen camera's picture, warped and coloured; black where it does not reach."""
        ...

    @property
    def others(self) -> Sequence[str]:
        """Cameras that may stand in, the closest first; the reference camera leads."""
        ...

    @property
    def geometry(self) -> Hashable:
        """Equal values mean equal footprints: what is worked out from them may be kept."""
        ...

    @property
    def previous(self) -> Planes | None:
        """The finished programme frame before this one, where the filler asked for a memory."""
        ...

    def footprint(self, camera: str) -> U8:
        """(height / 2, width / 2): 255 where that camera sees the programme, on the grid of the chroma samples."""
        ...

    def look(self, camera: str, rect: Rect) -> Planes | None:
        """What that camera has in ``rect``, warped and coloured; None where it has no picture at this frame."""
        ...


class Filler(Protocol):
    """Fills what the chosen camera leaves empty. May keep what depends on geometry alone, nothing else."""

    @property
    def name(self) -> str: ...

    @property
    def version(self) -> int:
        """Rises when the same frames come out differently: conformed chunks are then made again."""
        ...

    @property
    def memory_frames(self) -> int:
        """How many frames before a stretch must be made for `View.previous` to be as good as from the start; or 0."""
        ...

    def fill(self, view: View) -> Planes:
        """The finished frame; ``view.front`` itself where there is nothing to fill."""
        ...


Stack = tuple[tuple[str, NDArray[np.float32]], ...]  # cameras from front to back, their alphas (H/2, W/2) in 0..1


@frozen(eq=False)
class _Patch:
    """A piece to fill: how much of the camera in front stays, and of each behind it, the nearest first."""

    rect: Rect
    front: NDArray[np.float32]  # (height / 2, width / 2), 0..1
    behind: Stack


class FootprintFiller:
    """Fills outside the camera's geometric footprint, softly over its edge, with what other cameras see there.

    The footprint follows from the warp alone, so dark pixels are no holes and nothing flickers. Cameras stand behind
    each other, each faded over its own edge where another goes on behind it; where none sees anything it stays black.
    Only strips in which something is missing are touched.
    """

    name = "footprint"
    version = 1
    memory_frames = 0

    def __init__(self, feather_px: float = 24.0) -> None:
        self.feather_px = feather_px
        self._plans: dict[Hashable, tuple[_Patch, ...]] = {}

    def fill(self, view: View) -> Planes:
        plan = self._plans.get(view.geometry)
        if plan is None:
            if len(self._plans) >= 64:
                self._plans.clear()
            plan = self._plans[view.geometry] = self._plan(view)
        if not plan:
            return view.front
        out = Planes(*(plane.copy() for plane in view.front))
        for patch in plan:
            _blend_into(out, view, patch)
        return out

    def _plan(self, view: View) -> tuple[_Patch, ...]:
        feather = self.feather_px / 2  # the footprints are half size
        front = feathered(view.footprint(view.camera), feather)
        if front.min() == 255:
            return ()
        alphas = {camera: feathered(view.footprint(camera), feather) for camera in view.others}
        layers = _layers(front, alphas, view.others)
        patches = []
        for rect in strips(front < 255):
            part = (slice(rect.y // 2, (rect.y + rect.height) // 2), slice(rect.x // 2, (rect.x + rect.width) // 2))
            seen = tuple((camera, _weights(alphas[camera][part])) for camera in layers)
            stack = _settled(((view.camera, _weights(front[part])), *seen))
            if len(stack) > 1:
                patches.append(_Patch(rect, stack[0][1], stack[1:]))
        return tuple(patches)


def _settled(stack: Stack) -> Stack:
    """Alphas for blending over each other so that the last one to see a pixel fades into nothing but itself.

    Only those that show anywhere are kept; the first always is.
    """
    shares, open_ = [], np.float32(1)
    for _, alpha in stack:
        shares.append(open_ * alpha)
        open_ = open_ * (1 - alpha)
    settled, behind = [], np.zeros_like(shares[0])
    for (camera, _), share in reversed(list(zip(stack, shares, strict=True))):
        behind = behind + share
        if share.max() > 1 / 512 or camera == stack[0][0]:
            settled.append((camera, np.where(behind > 1e-4, share / np.maximum(behind, 1e-4), 0).astype(np.float32)))
    return tuple(reversed(settled))


def _layers(front: U8, alphas: Mapping[str, U8], others: Sequence[str]) -> tuple[str, ...]:
    """Who stands behind: the reference, then whoever adds most. Each camera costs its whole decoding."""
    open_ = 1 - _weights(front[::4, ::4])
    weights = {camera: _weights(alpha[::4, ::4]) for camera, alpha in alphas.items()}
    chosen: list[str] = []
    left = list(others)
    while left:
        gains = {camera: float((open_ * weights[camera]).mean()) for camera in left}
        best = left[0] if not chosen and gains[left[0]] >= _SLIVER else max(left, key=lambda c: gains[c])
        if gains[best] < _SLIVER:
            break
        chosen.append(best)
        left.remove(best)
        open_ = open_ * (1 - weights[best])
    return tuple(chosen)


def _weights(alpha: U8) -> NDArray[np.float32]:
    return alpha.astype(np.float32) / np.float32(255)


def strips(missing: NDArray[np.bool_], rows: int = 32) -> tuple[Rect, ...]:
    """Rectangles (in pixels twice as fine as ``missing``) that together cover where it is true, and not much more.

    Bands of ``rows`` half-size rows, cut where more than 32 columns in a row have nothing missing.
    """
    height = missing.shape[0]
    found: list[Rect] = []
    for top in range(0, height, rows):
        band = missing[top : top + rows]
        columns = np.flatnonzero(band.any(axis=0))
        if not len(columns):
            continue
        for run in np.split(columns, np.flatnonzero(np.diff(columns) > 32) + 1):
            rect = Rect(2 * int(run[0]), 2 * top, 2 * int(run[-1] - run[0] + 1), 2 * len(band))
            above = found[-1] if found else None
            if above and (above.x, above.width) == (rect.x, rect.width) and above.y + above.height == rect.y:
                found[-1] = Rect(rect.x, above.y, rect.width, above.height + rect.height)
            else:
                found.append(rect)
    return tuple(found)


def _blend_into(out: Planes, view: View, patch: _Patch) -> None:
    target = patch.rect.of(out)
    layers = [(view.look(camera, patch.rect), alpha) for camera, alpha in patch.behind]
    stack = [(target, patch.front), *((planes, alpha) for planes, alpha in layers if planes is not None)]
    for index, plane in enumerate(target):
        result: NDArray = np.full(plane.shape, BLACK[index], np.uint8)
        for planes, alpha in reversed(stack):
            weight = alpha if index else _full_size(alpha)
            result = cv2.blendLinear(tuple(planes)[index], result, weight, 1 - weight)
        plane[:] = result


def _full_size(alpha: NDArray[np.float32]) -> NDArray[np.float32]:
    return cv2.resize(alpha, (2 * alpha.shape[1], 2 * alpha.shape[0]), interpolation=cv2.INTER_LINEAR)  # pyright: ignore


class ReferenceFiller:
    """The paper's: pixels above 10 are the front, blurred by 49 as alpha, over the reference camera's picture.

    What then is missing comes from the frame before, blurred, so that it is the more blurred the older it is.
    """

    name = "reference"
    version = 1
    memory_frames = 30

    def fill(self, view: View) -> Planes:
        reference = view.others[0] if view.others else None
        behind = view.look(reference, Rect(0, 0, *view.size)) if reference is not None else None
        mask = _bright(view.front)
        missing = cv2.bitwise_not(mask)
        out = Planes(*(plane.copy() for plane in view.front))
        if behind is not None:
            missing = cv2.bitwise_and(missing, cv2.bitwise_not(_bright(behind)))
            alpha = cv2.GaussianBlur(mask, (49, 49), 0)
            small = cv2.resize(alpha, (alpha.shape[1] // 2, alpha.shape[0] // 2), interpolation=cv2.INTER_AREA)
            weights = [_weights(np.asarray(a, np.uint8)) for a in (alpha, small, small)]
            for plane, other, weight in zip(out, behind, weights, strict=True):
                plane[:] = cv2.blendLinear(plane, other, weight, 1 - weight)
        if view.previous is not None:
            for plane, before in zip(out, view.previous, strict=True):
                hole = missing if plane.shape == missing.shape else missing[::2, ::2]
                _keep(plane, before, np.asarray(hole, np.uint8))
        return out


def _bright(planes: Planes) -> U8:
    """255 where the picture exceeds 10 of 255: luma 25 in limited range."""
    return cv2.threshold(planes.y, 25, 255, cv2.THRESH_BINARY)[1]  # pyright: ignore[reportReturnType]


def _keep(plane: U8, before: U8, hole: U8) -> None:
    """Blurred pixels of the frame before into ``hole``, in place; only its surroundings are blurred."""
    x, y, width, height = cv2.boundingRect(hole)
    if not width:
        return
    part = (slice(max(0, y - 8), y + height + 8), slice(max(0, x - 8), x + width + 8))
    cv2.copyTo(cv2.GaussianBlur(before[part], (9, 9), 0), hole[part], plane[part])
