"""The command line's texts in Japanese, by their English, which is the key. tests/cli/test_japanese.py keeps it so.

A template's fields are named by what fills them in the source; the Japanese has the same.
"""

from . import (
    analysis,
    blender,
    commands,
    delivery,
    documents,
    editors,
    help,
    measuring,
    others,
    plugins,
    recordings,
    timelines,
    words,
)

OURS: dict[str, str] = {}
for area in (
    documents,
    recordings,
    analysis,
    plugins,
    delivery,
    measuring,
    editors,
    blender,
    timelines,
    commands,
    help,
):
    OURS |= area.TEXTS

COMPOSED = others.COMPOSED
OTHERS = others.TEXTS
TEXTS = OURS | COMPOSED | OTHERS
WORDS = words.WORDS
