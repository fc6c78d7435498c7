"""Tables as text (CSV): separated by commas, semicolons or tabs, in UTF-8 or UTF-16, as spreadsheets write them.

What cannot be read is refused by its line. Cells hold no line breaks: a quotation mark that is left open would else
swallow all the lines after it.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from attrs import frozen

from mcsl_core.errors import DocumentError
from mcsl_core.input_files import read_text

MOST_BYTES = 1 << 30  # eye trackers write some 600 bytes a sample, a million samples in two hours
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d{1,4})?", re.ASCII)
_GROUPED = re.compile(r"[1-9]\d{0,2}[.,]\d{3}", re.ASCII)


@frozen
class Row:
    """A line of a table.

    Attributes
    ----------
    line : int
        Its number in the file, from 1.
    cells : mapping of str to str
        By column, without the blanks around them; "" where the line is shorter than the head.
    """

    line: int
    cells: Mapping[str, str]


@frozen
class Table:
    """A table with a head.

    Attributes
    ----------
    path : Path
        Its file.
    columns : tuple of str
        The names in its head, without the blanks around them.
    """

    path: Path
    columns: tuple[str, ...]
    _cells: Iterator[tuple[int, list[str]]]

    def __iter__(self) -> Iterator[Row]:
        """The lines that hold anything, once; DocumentError names a line that cannot be read."""
        for line, cells in self._cells:
            if len(cells) > len(self.columns) and any(cells[len(self.columns) :]):
                raise DocumentError(
                    f"has {len(cells)} cells, the first line names {len(self.columns)} columns",
                    where=f"{self.path}, line {line}",
                    remedy="Put text that holds the separator in quotation marks, and write a decimal point",
                )
            padded = [*cells, *[""] * (len(self.columns) - len(cells))]
            yield Row(line, dict(zip(self.columns, padded, strict=False)))


def read_table(path: Path, *, wanted: str, remedy: str = "") -> Table:
    """Opens a table.

    Parameters
    ----------
    path : Path
        The file.
    wanted, remedy : str
        What it should be, "a file of ratings", and what its first line should hold; for messages.

    Raises
    ------
    InputError, DocumentError
        Where it cannot be read, holds no line, or names two columns alike.
    """
    text = read_text(path, wanted=wanted, remedy=remedy, most=MOST_BYTES)
    first, separator = _separator(text)
    cells = _split(text, path, separator, skipped=first)
    _, head = next(cells, (0, []))
    if not head:
        raise DocumentError("is empty", where=str(path), remedy=remedy)
    while head and not head[-1]:  # a spreadsheet's trailing separators
        head.pop()
    twice = sorted({name for name in head if name and head.count(name) > 1})
    if twice:
        raise DocumentError(f"names the column {twice[0]!r} twice", where=str(path), remedy="Rename one of the two")
    return Table(path, tuple(head), cells)


def number(text: str, *, comma: bool = True) -> float:
    """The number in a cell; ValueError where it is none. With ``comma`` 3,5 is 3.5 as well."""
    if not _NUMBER.fullmatch(text) or (not comma and "," in text):
        raise ValueError(f"{text[:40]!r} is no number")
    if math.isinf(value := float(text.replace(",", "."))):
        raise ValueError(f"{text[:40]!r} is too large a number")
    return value


class Grouping:
    """Watches numbers that were written alike: whether commas or points in them stand for thousands.

    "1,100" beside "980" is eleven hundred from a spreadsheet; beside "980.5" it could be 1.1.
    """

    def __init__(self, most: float = math.inf) -> None:
        self._most = most  # what is larger as a whole number is none
        self._decimals = self._whole = False
        self._first: tuple[int, str] | None = None

    def see(self, text: str, line: int) -> None:
        """A number that `number` takes, and the line it stands in."""
        digits = re.sub("[,.]", "", text)
        if digits == text:
            self._whole = True
        elif not _GROUPED.fullmatch(text) or int(digits) > self._most:
            self._decimals = True
        elif self._first is None:
            self._first = line, text

    def check(self, path: Path) -> None:
        """DocumentError where the numbers can be read in two ways."""
        if self._first is not None and self._whole and not self._decimals:
            line, text = self._first
            whole = re.sub("[,.]", "", text)
            raise DocumentError(
                f"{text!r} may be {whole} or {number(text):g}",
                where=f"{path}, line {line}",
                remedy=f"Write {whole} for thousands, {text.replace(',', '.')}0 for a fraction",
            )


def _separator(text: str) -> tuple[int, str]:
    """How many lines to leave out before the head, and what separates its cells."""
    for number_of_lines, line in enumerate(io.StringIO(text, newline=None)):
        said = re.fullmatch(r"\s*\"?sep=(.)\"?\s*", line)  # Excel's own line
        if said:
            return number_of_lines + 1, said[1]
        if line.strip():
            return number_of_lines, max(",;\t", key=re.sub(r'"[^"]*"', "", line).count)
    return 0, ","


def _split(text: str, path: Path, separator: str, *, skipped: int) -> Iterator[tuple[int, list[str]]]:
    """(line number, cells) of the lines that hold anything."""
    lines = io.StringIO(text, newline=None)
    for _ in range(skipped):
        lines.readline()
    rows = csv.reader(lines, delimiter=separator, strict=True)
    while True:
        line = skipped + rows.line_num + 1
        try:
            cells = next(rows)
        except StopIteration:
            return
        except csv.Error as error:
            said = str(error) if skipped + rows.line_num == line or "larger" in str(error) else _OPEN
            raise DocumentError(_fault(said), where=f"{path}, line {line}", remedy=_REMEDY) from error
        if skipped + rows.line_num > line:
            raise DocumentError(_fault(_OPEN), where=f"{path}, line {line}", remedy=_REMEDY)
        cells = [cell.strip() for cell in cells]
        if any(cells):
            yield line, cells


_OPEN = "unexpected end of data"
_REMEDY = "Correct or delete the line"


def _fault(said: str) -> str:
    if said == _OPEN:
        return "a quotation mark is opened and not closed"
    if "field larger" in said:  # by a quotation mark left open, most of the time
        return f"a cell has more than {csv.field_size_limit():,} characters, or a quotation mark is not closed"
    return f"cannot be read ({said})"
