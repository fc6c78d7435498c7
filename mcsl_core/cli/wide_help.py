"""Help in Japanese: the texts told, and lines broken by the cells that letters take at a terminal."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import click
from rich.cells import cell_len

from .language import told, word

_COLUMN, _SPACING = 30, 2  # as click lays definitions out
_CLOSING = "、。，．,.:;!?！？）)]」』】〉》〜ー・ぁぃぅぇぉっゃゅょァィゥェォッャュョ"
_OPENING = "（([「『【〈《"
_PIECE = re.compile(rf"[{re.escape(_OPENING)}]*(?:[!-~]+|[^\s])[{re.escape(_CLOSING)}]*|\s+")
"""What no line ends inside of: a word in Latin letters, a letter in others, with its punctuation."""


def wrapped(text: str, width: int) -> list[str]:
    """The lines of a paragraph, none wider than ``width`` cells where it can be broken."""
    lines, line = [], ""
    for piece in _PIECE.findall(" ".join(text.split())):
        if line and cell_len((line + piece).rstrip()) > width:
            lines.append(line.rstrip())
            line = piece.lstrip()
        else:
            line += piece
    return [*lines, line.rstrip()]


class WideHelp(click.HelpFormatter):
    """click's pages of help, in Japanese."""

    def write_usage(self, prog: str, args: str = "", prefix: str | None = None) -> None:
        words = " ".join(word(one) for one in args.split())
        super().write_usage(prog, words, prefix or f"{word('Usage:')} ")

    def write_heading(self, heading: str) -> None:
        super().write_heading(word(heading))

    def write_text(self, text: str) -> None:
        paragraphs = []
        for paragraph in told(text).split("\n\n"):
            if not paragraph.startswith("\b"):  # which says that its lines are as they shall be
                paragraph = _kept(wrapped(paragraph, self.width - self.current_indent))
            paragraphs.append(paragraph)
        super().write_text("\n\n".join(paragraphs))

    def write_dl(self, rows: Iterable[tuple[str, str]], col_max: int = _COLUMN, col_spacing: int = _SPACING) -> None:
        rows = list(rows)
        first = min(max((cell_len(term) for term, _ in rows), default=0), col_max) + col_spacing
        width = max(self.width - first - self.current_indent, 10)
        told_rows = [(term, _kept(wrapped(_definition(text), width)) if text else "") for term, text in rows]
        super().write_dl(told_rows, col_max, col_spacing)


def _kept(lines: Sequence[str]) -> str:
    """A paragraph whose lines click leaves as they are."""
    return "\n".join(["\b", *lines])


def _definition(text: str) -> str:
    """What an option is for, and in brackets its default, or that it must be given."""
    parts = re.fullmatch(r"(.*?)(?:\s*\[([^\]]*)\])?", text, re.DOTALL)
    assert parts is not None
    about, extra = told(parts[1]), parts[2]
    if extra is None:
        return about
    return f"{about}  [{'; '.join(word(one) for one in extra.split('; '))}]".strip()
