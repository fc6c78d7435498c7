"""Independent pieces of work by as many threads as there are cores; numpy and OpenCV let go of the interpreter."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def by_threads(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """``function`` of each item, in the order of the items; the first error is raised."""
    with ThreadPoolExecutor(os.cpu_count()) as workers:
        return list(workers.map(function, items))
