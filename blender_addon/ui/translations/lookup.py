# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in the user's language, through Blender's own mechanism. English is the text itself."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from .japanese import JAPANESE

CONTEXTS = ("*", "Operator")  # buttons look their text up in a context of their own


def told(text: str) -> str:
    """``text`` of a message in the user's language; with {fields} still to be filled in."""
    return bpy.app.translations.pgettext_rpt(text)


def shown(text: str) -> str:
    """``text`` of a label in the user's language; with {fields} still to be filled in."""
    return bpy.app.translations.pgettext_iface(text)


def language() -> str:
    """The language of Blender's interface, such as ja_JP; empty where Blender does not say."""
    return bpy.app.translations.locale


def register() -> None:
    table = {(context, english): japanese for english, japanese in JAPANESE.items() for context in CONTEXTS}
    bpy.app.translations.register(__name__, {"ja_JP": table})


def unregister() -> None:
    bpy.app.translations.unregister(__name__)
