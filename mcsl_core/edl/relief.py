"""The scene as a relief over one plane, as every camera of a pose sees it: plane + parallax.

A scene point is a programme pixel before centering, (x, y), and its height over the plane, gamma. A camera sees it at
``projection @ [x, y, 1, gamma]`` (homogeneous). How that becomes places in pictures stands in `imaging.relief`.

References
----------
Irani, Anandan, "Parallax geometry of pairs of points for 3D scene analysis", ECCV 1996.
"""

from __future__ import annotations

from collections.abc import Mapping

from attrs import field, frozen

from mcsl_core.documents import Bounds, NotEmpty, doc, key_path

from .checks import NUMBERS, check_matrix, require
from .colour import Matrix34

MOST_NODES = 1024  # of a row or a column
PERCENT = Bounds(0, 100)


@frozen
class Relief:
    """How high the scene stands over the plane, and how the cameras see that."""

    projections: Mapping[str, Matrix34] = field(
        validator=[NotEmpty(), NUMBERS],
        metadata=doc(
            "camera -> [x, y, 1, gamma], programme pixel before centering, to camera pixel (homogeneous), scaled so "
            "that the third number of the third row is 1; a camera that is not in it keeps its plane"
        ),
    )
    gamma: tuple[tuple[float, ...], ...] = field(
        validator=NUMBERS,
        metadata=doc(
            "height over the plane at rows of nodes spread evenly over the programme's picture, from its first pixel's "
            "centre to its last one's; one moves the camera moved most by about a pixel"
        ),
    )
    confidence: tuple[tuple[int, ...], ...] = field(
        validator=PERCENT, metadata=doc("0 to 100 at each node; at 0 the camera's plane holds, from 50 on the relief")
    )

    def __attrs_post_init__(self) -> None:
        for name, (a, b, c) in self.projections.items():
            check_matrix((a[:3], b[:3], c[:3]), f".projections{key_path(name)}")
        rows, most = len(self.gamma), f"2 to {MOST_NODES} are taken"
        require(2 <= rows <= MOST_NODES, f"has {rows} rows, {most}", ".gamma")
        columns = len(self.gamma[0])
        require(2 <= columns <= MOST_NODES, f"has {columns} nodes, {most}", ".gamma[0]")
        found = len(self.confidence)
        require(found == rows, f"has {found} rows, gamma has {rows}", ".confidence")
        for part in ("gamma", "confidence"):
            for index, row in enumerate(getattr(self, part)):
                require(len(row) == columns, f"has {len(row)} nodes, gamma[0] has {columns}", f".{part}[{index}]")
