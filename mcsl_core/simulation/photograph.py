"""The detail of photographs: retina for skin and tissue, fibres for cloth. Both come with scikit-image, under CC0."""

from __future__ import annotations

import importlib.util
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.errors import UsageError

from .scenario import Scenario

TISSUE, CLOTH = "retina.jpg", "grass.png"
PX_PER_MM = {TISSUE: 3.4, CLOTH: 3.0}
STRENGTH = {TISSUE: 1.6, CLOTH: 0.45}


def tissue_detail(scenario: Scenario, pitch_mm: float, shape: tuple[int, ...]) -> NDArray:
    """(h, w, 3) factors of colour for the field's cut-out."""
    photograph = _photograph(TISSUE)
    side = photograph.shape[0]
    # Its middle: the disc itself is a bright spot, and the picture is round.
    return _laid(scenario, photograph[side // 5 : -side // 5, side // 5 : -side // 5], TISSUE, pitch_mm, shape)


def cloth_detail(scenario: Scenario, pitch_mm: float, shape: tuple[int, ...]) -> NDArray:
    """(h, w, 3) factors of colour for the whole table."""
    return _laid(scenario, _photograph(CLOTH), CLOTH, pitch_mm, shape)


def _laid(scenario: Scenario, photograph: NDArray, name: str, pitch_mm: float, shape: tuple[int, ...]) -> NDArray:
    """A photograph's detail, turned by chance, mirrored where it ends."""
    rng = scenario.stream("photograph", name)
    picture = photograph.astype(np.float32) + 8
    mean = cv2.GaussianBlur(picture, (0, 0), 14 * PX_PER_MM[name], borderType=cv2.BORDER_REFLECT)
    detail = np.clip(1 + STRENGTH[name] * (picture / mean - 1), 0.3, 1.8)
    turn, scale = rng.uniform(0, 2 * np.pi), pitch_mm * PX_PER_MM[name]
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    middle = np.array([shape[1], shape[0]]) / 2
    linear = np.array([[c, -s], [s, c]])
    offset = np.array([picture.shape[1], picture.shape[0]]) / 2 - linear @ middle
    if scale > 1:
        detail = cv2.GaussianBlur(detail, (0, 0), 0.45 * scale)
    matrix = np.column_stack([linear, offset])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(detail, matrix, (shape[1], shape[0]), flags=flags, borderMode=cv2.BORDER_REFLECT)


@lru_cache(maxsize=2)
def _photograph(name: str) -> NDArray:
    """(h, w, 3) uint8, BGR; UsageError where scikit-image is not installed."""
    spec = importlib.util.find_spec("skimage")
    file = Path(spec.origin or "").parent / "data" / name if spec else None
    if file is None or not file.is_file():
        raise UsageError(
            "the family photographic needs the photographs of scikit-image", remedy="Run: pip install scikit-image"
        )
    picture = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None, f"{file} is a picture"
    return picture
