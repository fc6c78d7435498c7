"""Residual parallax: how far off each camera shows what does not lie on the plane it is aligned by.

A homography aligns one plane, the surgical field. Drapes, instruments and towels lie above or below it, and each
camera sees them from its own side, so that what one camera shows beyond another's edge does not continue it (13 pixels
at 960 on simulated drapes; plane plus parallax, Irani and Anandan 1996). The perspective is the reference camera's in
its first pose: dense optical flow (DIS, Kroeger et al. 2016) from its picture to another camera's, both medians without
whoever moved, says where that camera has what belongs at a pixel. It is kept where the pictures agree, and smoothed
over 1/96 of the width; beyond their overlap it goes on as near it.

References
----------
M. Irani, P. Anandan: Parallax geometry of pairs of points for 3D scene analysis. ECCV 1996.
T. Kroeger, R. Timofte, D. Dai, L. Van Gool: Fast optical flow using dense inverse search. ECCV 2016.
H. Knutsson, C.-F. Westin: Normalized and differential convolution. CVPR 1993.
"""

from __future__ import annotations

from collections.abc import Mapping
from threading import Lock
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Edl
from mcsl_core.edl.placement import first_of_perspective, placement_matrix, still_range
from mcsl_core.filling.median_grid import first_grid_frames, grid_step
from mcsl_core.imaging.geometry import Homography, scaling, translation
from mcsl_core.imaging.planes import U8
from mcsl_core.imaging.warp import WarpField
from mcsl_core.lru_cache import LruCache
from mcsl_core.parallel import by_threads

from .picture_source import PictureSource
from .placement import programme_matrix, surface_of

_WIDTH = 640  # of the programme as compared; 480 to 960 differ by 0.5 dB
_MARGIN = 0.25  # of the programme's size, on each side: what centering may bring in
_SMOOTH = 1 / 96  # sigma, of the programme's width; at 1/24 what is filled is 1 to 2 dB worse
_FURTHER = ((4, 0.05), (16, 0.0025))  # times that, and weight, of wider surroundings where the near ones tell nothing
_MOST = 0.04  # of the compared pictures' width: what flow finds further off is something else
_MISSED = 5.0  # compared pixels by which the flow back may miss
_LEAST_AGREEMENT = 0.23  # mean; pictures of one field: 0.27 to 0.7, unrelated ones: to 0.2
_CONTRAST = 40.0  # what surroundings are normalised to
_UNLIKE = 0.67 * _CONTRAST  # mean difference after warping; pictures of one field: 0.28 to 0.64, unrelated: 0.7 on
_NODE = 4  # compared pixels between nodes
_LOCAL = 12.0  # sigma of the surroundings whose brightness and contrast are taken out, compared pixels
_KEPT_BYTES = 5_000_000  # of warp fields, 80 kB each
_SURFACES_BYTES = 10_000_000  # of those that reliefs make, 500 kB each

Values = NDArray[np.float32]


class Parallax:
    """Which `WarpField` takes a camera's picture into the perspective, by pose; found when first asked. Thread-safe.

    By the pose's relief where it has one (`by_relief`), by the flow between the pictures where it has none (`of`).
    Shared by compositors that work side by side or one after another: either takes up to a third of a second.

    Parameters
    ----------
    edl : Edl
        The programme.
    pictures : PictureSource
        Whose medians are compared.
    """

    def __init__(self, edl: Edl, pictures: PictureSource) -> None:
        self._edl, self._pictures = edl, pictures
        self._scale = min(1.0, _WIDTH / edl.size[0])
        self._lock = Lock()
        self._fields: LruCache[Mapping[str, WarpField | None]] = LruCache(_KEPT_BYTES)
        self._surfaces: LruCache[WarpField | None] = LruCache(_SURFACES_BYTES)

    def of(self, pose_index: int, camera: str) -> WarpField | None:
        """The warp field of a camera's picture in a pose.

        Parameters
        ----------
        pose_index : int
            Index of the pose in the EDL.
        camera : str
            The camera's name.

        Returns
        -------
        WarpField or None
            None where the picture lies right already, or the pictures do not agree on how it lies.
        """
        with self._lock:  # one pose at a time: others would wait for the same pictures
            return self._fields.get(pose_index, lambda: self._of_pose(pose_index)).get(camera)

    def by_relief(self, pose_index: int, camera: str) -> WarpField | None:
        """What the pose's relief adds to where a camera's plane lies; None where it has none or adds nothing."""
        pose = self._edl.poses[pose_index]
        return self._surfaces.get((pose_index, camera), lambda: surface_of(self._edl, pose, camera))

    def _of_pose(self, pose_index: int) -> Mapping[str, WarpField | None]:
        """Of all cameras whose position is known, in parallel: whoever asks for one asks for most."""
        pose = self._edl.poses[pose_index]
        names = [
            camera.name for camera in self._edl.cameras if placement_matrix(self._edl, pose, camera.name) is not None
        ]
        found = by_threads(lambda name: self._warp_field(pose_index, name), names)
        return dict(zip(names, found, strict=True))

    def _warp_field(self, pose_index: int, camera: str) -> WarpField | None:
        base = first_of_perspective(self._edl, pose_index)
        if (base, self._edl.reference) == (pose_index, camera):
            return None
        guide, picture = self._on_canvas(base, self._edl.reference), self._on_canvas(pose_index, camera)
        if guide is None or picture is None:
            return None
        flow = residual_parallax(*guide, *picture, _SMOOTH * self._scale * self._edl.size[0])
        if flow is None:
            return None
        nodes = np.ascontiguousarray(flow[::_NODE, ::_NODE]) / np.float32(self._scale)
        width, height = self._edl.size
        return WarpField(nodes, (-_MARGIN * width, -_MARGIN * height), _NODE / self._scale)

    def _on_canvas(self, pose_index: int, camera: str) -> tuple[U8, U8] | None:
        """Luma of a camera's median near the start of a pose, warped to the canvas, and 255 inside its picture."""
        edl = self._edl
        pose = edl.poses[pose_index]
        still = still_range(edl, pose)
        planes = self._pictures.median(camera, first_grid_frames(still, grid_step(still, float(edl.rate))), still)
        if planes is None:
            return None
        luma = planes.y
        to_canvas = self._canvas() @ programme_matrix(edl, pose, camera)
        if self._scale < 1:  # area average first: a warp alone would alias
            size = (max(2, round(luma.shape[1] * self._scale)), max(2, round(luma.shape[0] * self._scale)))
            to_canvas = to_canvas @ scaling(size, (luma.shape[1], luma.shape[0]))
            luma = np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), np.uint8)
        wide = self._scale * (1 + 2 * _MARGIN)
        size = (round(edl.size[0] * wide), round(edl.size[1] * wide))
        inside = cv2.warpPerspective(np.full_like(luma, 255), to_canvas, size, flags=cv2.INTER_NEAREST)
        return np.asarray(cv2.warpPerspective(luma, to_canvas, size), np.uint8), np.asarray(inside, np.uint8)

    def _canvas(self) -> Homography:
        """Programme pixel -> pixel of the pictures compared, which reach beyond the programme."""
        width, height = self._edl.size
        return np.diag([self._scale, self._scale, 1.0]) @ translation(_MARGIN * width, _MARGIN * height)


def residual_parallax(guide: U8, guide_mask: U8, picture: U8, picture_mask: U8, sigma_px: float) -> Values | None:
    """Where one picture has what another has at a pixel: dense flow checked forward and backward, then smoothed.

    Parameters
    ----------
    guide, picture : (h, w) uint8
        Luma in one coordinate system; brightness and contrast may differ.
    guide_mask, picture_mask : (h, w) uint8
        0 outside the pictures.
    sigma_px : float
        How smooth, in pixels. Where the pictures agree too little the flow is that of wider surroundings.

    Returns
    -------
    (h, w, 2) float32 or None
        From a pixel of ``guide`` to the same thing in ``picture``, in pixels; None where the pictures overlap too
        little or the flow makes them no more alike.

    Notes
    -----
    Smoothing is normalised convolution (Knutsson and Westin 1993), weighted by how far a pixel's flow is to be trusted.
    """
    shared = cv2.min(guide_mask, picture_mask)
    both = np.asarray(cv2.erode(shared, np.ones((9, 9), np.uint8), borderType=cv2.BORDER_CONSTANT), np.uint8)
    if np.count_nonzero(both) < 32 * 32:
        return None
    a, b = _normalised(guide, guide_mask), _normalised(picture, picture_mask)
    forward, backward = _flow(a, b, both, finest=0), _flow(b, a, both, finest=1)
    weight = _agreement(a, b, both, forward, backward)
    if weight[both > 0].mean() < _LEAST_AGREEMENT:
        return None
    smooth = _smoothed(forward, np.square(weight), sigma_px)  # where somebody stood, what lies around decides
    return smooth if _difference(a, b, both, smooth) < min(_difference(a, b, both, None), _UNLIKE) else None


def _flow(a: U8, b: U8, both: U8, finest: int) -> Values:
    """(h, w, 2) by DIS, its patches larger than the preset's: those lose a tube 20 pixels away on plain cloth."""
    dis = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    dis.setFinestScale(finest)  # 0 gains 1.6 dB where little is to be seen, for 0.4 s; a check is content with 1
    dis.setPatchSize(12)
    dis.setPatchStride(4)
    return dis.calc(a, np.where(both > 0, b, a), None)  # pyright: ignore


def _normalised(luma: U8, mask: U8) -> U8:
    """Local brightness and contrast taken out."""
    inside: Values = mask.astype(np.float32) / np.float32(255)
    share: Values = _blurred(inside, _LOCAL) + np.float32(1e-6)
    above = luma.astype(np.float32) - _blurred(luma * inside, _LOCAL) / share
    spread: Values = np.sqrt(_blurred(np.square(above) * inside, _LOCAL) / share + 16)
    return np.where(mask > 0, np.clip(128 + _CONTRAST * above / spread, 0, 255), 128).astype(np.uint8)


def _agreement(a: U8, b: U8, both: U8, forward: Values, backward: Values) -> Values:
    """0..1: how far a pixel's flow is to be trusted: there is texture, it fits, and it leads there and back."""
    texture = cv2.blur(cv2.magnitude(cv2.Sobel(a, cv2.CV_32F, 1, 0), cv2.Sobel(a, cv2.CV_32F, 0, 1)), (9, 9))
    found, inside = _sampled(b, forward), (both > 0) & (_sampled(both, forward, cv2.INTER_NEAREST) > 0)
    error = cv2.blur(cv2.absdiff(a, found).astype(np.float32), (9, 9))
    missed = np.square(forward + _sampled(backward, forward)).sum(axis=2)
    near = np.square(forward).sum(axis=2) < (_MOST * a.shape[1]) ** 2
    fits = np.minimum(texture / 20, 1) * np.exp(-((error / 20) ** 2) - missed / _MISSED**2)
    return np.asarray(inside * near * fits, np.float32)


def _sampled(picture: NDArray[Any], flow: Values, flags: int = cv2.INTER_LINEAR) -> NDArray[Any]:
    """``picture`` at the end of each pixel's flow."""
    y, x = np.mgrid[0 : picture.shape[0], 0 : picture.shape[1]].astype(np.float32)
    return cv2.remap(picture, x + flow[..., 0], y + flow[..., 1], flags)  # pyright: ignore[reportReturnType]


def _difference(a: U8, b: U8, both: U8, flow: Values | None) -> float:
    found = b if flow is None else _sampled(b, flow)
    return float(cv2.absdiff(a, found)[both > 0].mean())


def _smoothed(flow: Values, weight: Values, sigma_px: float) -> Values:
    """Normalised convolution (Knutsson and Westin 1993), wider ones where the weights are next to nothing."""
    total, share = np.zeros_like(flow), np.full(weight.shape, 1e-12, np.float32)
    for times, part in ((1, 1.0), *_FURTHER):
        total += part * np.stack([_blurred(flow[..., i] * weight, times * sigma_px) for i in (0, 1)], axis=-1)
        share += part * _blurred(weight, times * sigma_px)
    return total / share[..., None]


def _blurred(values: Values, sigma: float) -> Values:
    """A Gaussian, nothing beyond the edge; wide ones on a coarser grid."""
    factor = 2 ** max(0, int(np.log2(max(sigma / 4, 1))))
    if factor == 1:
        return np.asarray(cv2.GaussianBlur(values, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT), np.float32)
    height, width = values.shape
    small = cv2.resize(values, (-(-width // factor), -(-height // factor)), interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), sigma / factor, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
