"""Rectangles of a picture whose chroma is subsampled by two."""

from __future__ import annotations

from attrs import frozen

from .planes import Planes


@frozen
class Rect:
    """Part of a picture. All numbers are even, so that it has chroma of its own; it may reach beyond the picture.

    Attributes
    ----------
    x, y
        Left and top edge, pixels.
    width, height
        Its size, pixels.
    """

    x: int
    y: int
    width: int
    height: int

    def of(self, planes: Planes) -> Planes:
        """That part of ``planes``; shares their memory."""
        y, u, v = planes
        half = (slice(self.y // 2, (self.y + self.height) // 2), slice(self.x // 2, (self.x + self.width) // 2))
        return Planes(y[self.y : self.y + self.height, self.x : self.x + self.width], u[half], v[half])

    def grown(self, by: int) -> Rect:
        """With a border of ``by`` (even) pixels around it."""
        return Rect(self.x - by, self.y - by, self.width + 2 * by, self.height + 2 * by)
