"""The edit-decision list: the one document between analysis, editor and renderer. Written out in docs/reference/edl.md.

The document's classes and its reading and writing, under one name: ``from mcsl_core.edl import Edl, load``. What
follows from a document stands beside: `resolve` (what holds after the editor's decisions), `placement` (where
pictures lie), `edits` (changes to a whole document).
"""

from .camera import Camera, Clock, Media
from .checks import IDENTITY, NO_SOUND, Matrix
from .colour import Colour, ColourKey, Matrix34
from .field import DrawnField, FieldStretch
from .look import Look
from .movement import Movement, MovementView
from .outside import allowed_outside, remember
from .relief import Relief
from .schema import (
    CenteringKey,
    Correction,
    Edl,
    MadeBy,
    Override,
    Pose,
    Shot,
    Weak,
)
from .serialization import SCHEMA, dumps, from_json, load, loads, read, save, to_json

__all__ = [
    "IDENTITY",
    "NO_SOUND",
    "SCHEMA",
    "Camera",
    "CenteringKey",
    "Clock",
    "Colour",
    "ColourKey",
    "Correction",
    "DrawnField",
    "Edl",
    "FieldStretch",
    "Look",
    "MadeBy",
    "Matrix",
    "Matrix34",
    "Media",
    "Movement",
    "MovementView",
    "Override",
    "Pose",
    "Relief",
    "Shot",
    "Weak",
    "allowed_outside",
    "dumps",
    "from_json",
    "load",
    "loads",
    "read",
    "remember",
    "save",
    "to_json",
]
