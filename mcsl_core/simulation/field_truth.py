"""Which pixels of a camera show the surgical field, by truth: what a mask of the field is held against."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .scenario import Scenario
from .surface import Surface
from .truth import Truth


def true_field(truth: Truth, pose_index: int, camera: int | str, size: tuple[int, int]) -> NDArray[np.bool_]:
    """The surgical field in a camera's picture, whoever is in the way.

    Parameters
    ----------
    truth
        Of the recording.
    pose_index, camera
        Where and in whose picture; the camera by index or name.
    size
        (width, height) that the picture is reduced to.

    Returns
    -------
    NDArray
        (height, width) bool: where the ray through a pixel's middle meets bare skin or the wound.
    """
    surface = _surface(truth.scenario)
    width, height = size
    x = (np.arange(width) + 0.5) * truth.size[0] / width - 0.5
    y = (np.arange(height) + 0.5) * truth.size[1] / height - 0.5
    pinhole = truth.poses[pose_index].pinhole(truth.camera_index(camera))
    return surface.site.opening(*surface.intersect(pinhole, np.stack(np.meshgrid(x, y), -1))) > 0


@lru_cache(maxsize=4)
def _surface(scenario: Scenario) -> Surface:
    return Surface.of(scenario)
