# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels in the sequencer's sidebar, tab mcsl, in the order of the work. They only show; operators do."""

import bpy  # pyright: ignore[reportMissingImports]

from . import analyse, conform, look, recording, render, shots

CLASSES = tuple(kind for part in (recording, analyse, shots, look, conform, render) for kind in part.CLASSES)


def register() -> None:
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
