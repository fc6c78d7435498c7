# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's buttons, in the order of the work. What they decide stands in the plain modules."""

import bpy  # pyright: ignore[reportMissingImports]

from . import (
    analysis,
    angles,
    decisions,
    delivery,
    field,
    interchange,
    look,
    microphone,
    preview,
    proxies,
    recording,
    removal,
    timeline,
)

_PARTS = (
    recording,
    analysis,
    timeline,
    angles,
    proxies,
    decisions,
    removal,
    look,
    field,
    microphone,
    delivery,
    interchange,
)
CLASSES = tuple(kind for part in _PARTS for kind in part.CLASSES)


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    preview.remove_lines()
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
