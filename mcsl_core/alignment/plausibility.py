"""Whether a lamp's camera can lie so: a test of an alignment that knows nothing of matches or pictures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mcsl_core.edl import Weak
from mcsl_core.imaging.geometry import Array, Homography

from .protocol import Alignment

_MARGIN, _PLACES = 0.25, 9  # of the picture's width and height left out on each side; places tried a side
# In the middle of their pictures 136 right views of 22 recordings, one of them real, were stretched by 1.6 at most,
# their scale changed by 2.5 at most from place to place (a limb) and was 0.63 to 1.6. Eight ties by heads: a scale of
# 0.07 and less, three of them mirrored or stretched 190 times and more.
_SQUEEZED = 5.0
_UNEVEN = 4.0
_SCALED = 6.0


def plausible(alignment: Alignment, sizes: Mapping[str, tuple[int, int]], reference: str) -> Alignment:
    """The alignment without cameras that no lamp holds so, which are weak.

    Parameters
    ----------
    alignment : Alignment
        Camera -> its homography, full-size camera pixel -> reference pixel.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    reference : str
        The reference camera, which stays.

    Returns
    -------
    Alignment
        A camera is left out whose picture would be mirrored, or in its middle stretched more than five times as much
        one way as another, four times as large in one place as in another, or six times as large or small as the
        reference's. All cameras look at one place from about one distance: few matches, of a head that hides
        the field, say such things.
    """
    wrong = sorted(implausible(alignment.homographies, sizes, reference))
    reason = "where its matches lay it, its picture would be mirrored, squeezed or shrunk as no view of a lamp is"
    return alignment.without(Weak(name, reason) for name in wrong)


def implausible(
    homographies: Mapping[str, Homography], sizes: Mapping[str, tuple[int, int]], reference: str
) -> set[str]:
    """The cameras that no lamp holds so; see `plausible`."""
    return {
        name
        for name, homography in homographies.items()
        if name != reference and not _is_possible(homography, sizes[name], sizes[reference])
    }


def _is_possible(homography: Homography, size: tuple[int, int], reference: tuple[int, int]) -> bool:
    x, y = (np.linspace(_MARGIN * n, (1 - _MARGIN) * n, _PLACES) for n in size)
    slopes = _slopes(homography, np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    if slopes is None or np.linalg.det(slopes).min() <= 0:
        return False
    along, across = np.linalg.svd(slopes, compute_uv=False).T
    scale = np.sqrt(along * across) * size[1] / reference[1]
    even = scale.max() < _UNEVEN * scale.min() and (along < _SQUEEZED * across).all()
    return bool(even and scale.min() > 1 / _SCALED and scale.max() < _SCALED)


def _slopes(homography: Homography, points: Array) -> Array | None:
    """(N, 2, 2): how a homography stretches the plane at points; None where its horizon passes between them."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    depth = mapped[:, 2]
    if depth.min() * depth.max() <= 0:
        return None
    at = mapped[:, :2] / depth[:, None]
    return (homography[None, :2, :2] - at[:, :, None] * homography[None, 2:, :2]) / depth[:, None, None]
