"""Independent pieces of work by as many threads as there are cores; numpy and OpenCV let go of the interpreter."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import cv2

T = TypeVar("T")
R = TypeVar("R")


def by_threads(function: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """``function`` of each item, in the order of the items; the first error is raised."""
    with ThreadPoolExecutor(os.cpu_count()) as workers:
        return list(workers.map(function, items))


@contextlib.contextmanager
def opencv_in_one_thread() -> Iterator[None]:
    """OpenCV starts no threads of its own: for work that keeps all cores busy by itself, which they would wait for."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)
