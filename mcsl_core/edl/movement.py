"""A movement of the lamp, and how its cameras lie meanwhile where that is known."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import attrs
from attrs import field, frozen

from mcsl_core.documents import AtMost, doc, key_path
from mcsl_core.timing import FrameRange

from .checks import NOT_NEGATIVE, NUMBERS, UNIT, Matrix, check_matrix
from .colour import Matrix34

MOST_VIEWS = 100_000  # of a movement


@frozen
class MovementView:
    """How the cameras lie at one instant while the lamp moves; linear between one and the next."""

    frame: int = field(
        validator=NOT_NEGATIVE,
        metadata=doc("programme frame; a camera's picture counts at the instant that it was taken"),
    )
    homographies: Mapping[str, Matrix] = field(
        metadata=doc("camera pixel -> programme pixel before centering; a camera that lacks is not known then")
    )
    projections: Mapping[str, Matrix34] = field(
        factory=dict,
        validator=NUMBERS,
        metadata=doc("camera -> [x, y, 1, gamma] to camera pixel, as in a pose's relief", optional=True),
    )

    def __attrs_post_init__(self) -> None:
        for name, matrix in self.homographies.items():
            check_matrix(matrix, f".homographies{key_path(name)}")
        for name, (a, b, c) in self.projections.items():
            check_matrix((a[:3], b[:3], c[:3]), f".projections{key_path(name)}")

    def names(self) -> Iterator[tuple[str, str]]:
        """(part of the document, camera) of all that is said of cameras."""
        yield from (("homographies", name) for name in self.homographies)
        yield from (("projections", name) for name in self.projections)


@frozen
class Movement:
    """A stretch in which the lamp moves."""

    range: FrameRange = field(metadata=doc("first moving frame to first frame standing still again"))
    confidence: float = field(default=1.0, validator=UNIT, metadata=doc("how sure the detector is"))
    views: tuple[MovementView, ...] = field(
        default=(),
        validator=AtMost(MOST_VIEWS),
        metadata=doc(
            "how the cameras lie from the first to the last of them, so that the programme stands still; without, it "
            "holds its camera and the picture glides off",
            optional=True,
        ),
    )

    @property
    def middle(self) -> int:
        """The frame at which one pose ends and the next begins, unless the recording begins or ends in the movement."""
        return (self.range.start + self.range.stop) // 2


def unfollowed(movements: Iterable[Movement]) -> tuple[Movement, ...]:
    """The movements without views: the programme holds its camera in them."""
    return tuple(attrs.evolve(movement, views=()) for movement in movements)
