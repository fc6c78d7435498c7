"""Writing a picture of BT.709 as HLG or PQ carry it: ten bits in BT.2020's primaries, diffuse white at 203 cd/m2."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np

from mcsl_core.imaging.planes import Planes, planes_to_bgr

from .writing import VideoWriter

_BT2020, _TRANSFER = 9, {"pq": 16, "hlg": 18}
_TO_BT2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])  # ITU-R BT.2087
_STEPS = 4096  # of light's square root, in which the curves are tabled


class HdrWriter(VideoWriter):
    """A `VideoWriter` of HDR files.

    Parameters
    ----------
    path, settings
        As `VideoWriter` takes them; the encoding's pixel format has ten bits.
    light
        "hlg" or "pq".
    """

    def __init__(self, path: Path, *, light: str, **settings: Any) -> None:
        super().__init__(path, **settings)
        self._tags = _BT2020, _TRANSFER[light], _BT2020
        steps = (np.arange(_STEPS) / (_STEPS - 1)) ** 2
        self._codes = np.round(65535 * (_pq_codes(steps) if light == "pq" else _hlg_codes(steps))).astype(np.uint16)
        codes = np.arange(256) / 255
        self._light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4).astype(np.float32)

    def _frame(self, planes: Planes) -> Any:
        light = cv2.transform(self._light[planes_to_bgr(planes)[..., ::-1]], _TO_BT2020)
        steps = np.sqrt(np.clip(light, 0, 1)) * (_STEPS - 1) + 0.5
        frame = av.VideoFrame.from_ndarray(self._codes[steps.astype(np.intp)], format="rgb48le")
        return frame.reformat(
            format=self.encoding.pixel_format, dst_colorspace=_BT2020, src_color_range="JPEG", dst_color_range="MPEG"
        )


def _pq_codes(light: np.ndarray) -> np.ndarray:
    power = (light * 203 / 10_000) ** (1305 / 8192)
    return ((107 / 128 + 2413 / 128 * power) / (1 + 2392 / 128 * power)) ** (2523 / 32)


def _hlg_codes(light: np.ndarray) -> np.ndarray:
    scene = light ** (1 / 1.2) * 0.26496  # a system gamma of 1.2 on each channel, white at 75 %
    upper = 0.17883277 * np.log(np.maximum(12 * scene - 0.28466892, 1e-6)) + 0.55991073
    return np.where(scene <= 1 / 12, np.sqrt(3 * scene), upper)
