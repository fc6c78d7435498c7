"""A part of a programme's chunks, so that several jobs on several machines share one: the K-th of N by time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Self, TypeVar

from attrs import frozen

from mcsl_core.errors import UsageError

T = TypeVar("T")


@frozen
class Part:
    """One of ``of`` neighbouring stretches of nearly equal length.

    Parameters
    ----------
    number : int
        Which, from 1.
    of : int
        How many there are.

    Raises
    ------
    UsageError
        Where there is no such part.
    """

    number: int
    of: int

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.number <= self.of:
            raise UsageError(f"there is no part {self.number} of {self.of}", remedy="Count from 1/N to N/N")

    @classmethod
    def read(cls, text: str) -> Self:
        """The part that ``2/8`` means; UsageError where it means none."""
        found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text, re.ASCII)
        if found is None:
            raise UsageError(f"{text!r} is no part", remedy="Write it as 2/8, the second of eight")
        return cls(int(found[1]), int(found[2]))

    @property
    def first(self) -> bool:
        return self.number == 1

    def taken(self, all_of_them: Sequence[T]) -> tuple[T, ...]:
        """This part of a sequence. All parts together are the sequence; with many parts some are empty."""
        count = len(all_of_them)
        return tuple(all_of_them[(self.number - 1) * count // self.of : self.number * count // self.of])


WHOLE = Part(1, 1)
