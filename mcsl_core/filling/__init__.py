"""Filling the programme pixels that the chosen camera, warped, does not cover. Nothing is ever invented.

A filler gets one `View` a programme frame: the chosen camera's warped picture and the means to look at the other
cameras through the same eye, piece by piece, now and at other moments. Everything is in programme pixels.
"""

from .closeness import viewpoint_difference
from .footprint import FootprintFiller
from .moments import first_looks, grid_step
from .origin import ShowOrigin
from .reference import ReferenceFiller
from .view import CELL, Filler, Rect, View

__all__ = [
    "CELL",
    "Filler",
    "FootprintFiller",
    "Rect",
    "ReferenceFiller",
    "ShowOrigin",
    "View",
    "first_looks",
    "grid_step",
    "viewpoint_difference",
]
