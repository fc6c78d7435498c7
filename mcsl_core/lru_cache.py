"""What was worked out and may be asked for again: the one cache in memory, with one rule of eviction.

The least recently used goes first, as soon as all together are larger than a bound in bytes: pictures, tables for
warping and plans grow with the programme's size, so a count of them would say nothing about memory. By `cachetools`.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import wraps
from threading import Lock
from typing import Any, Generic, TypeVar, TypeVarTuple

import attrs
import numpy as np
from cachetools import LRUCache

T = TypeVar("T")
Arguments = TypeVarTuple("Arguments")

_LEAST_BYTES = 64  # of anything, so that values without arrays are bounded too


class LruCache(Generic[T]):
    """Values by key, together at most ``most_bytes``. Safe from several threads.

    A value that is larger than the bound is kept alone: it is what the next frame asks for again.
    """

    def __init__(self, most_bytes: int) -> None:
        self._values: LRUCache[Hashable, T] = LRUCache(
            most_bytes, lambda value: min(max(_LEAST_BYTES, bytes_of(value)), most_bytes)
        )
        self._lock = Lock()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """The value of ``key``, made now where it is not there. Two threads may make it at once: one is kept."""
        with self._lock:
            if key in self._values:
                return self._values[key]
        made = make()
        with self._lock:
            return self._values.setdefault(key, made)

    @property
    def bytes(self) -> int:
        """How much lies here now."""
        return int(self._values.currsize)


def bytes_of(value: Any) -> int:
    """Bytes of the arrays in a value: itself, its items or fields, however deep."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, Mapping):
        return sum(bytes_of(item) for item in value.values())
    if isinstance(value, tuple | list):
        return sum(bytes_of(item) for item in value)
    if attrs.has(type(value)):
        return sum(bytes_of(getattr(value, field.name)) for field in attrs.fields(type(value)))
    return 0


def kept(method: Callable[[Any, *Arguments], T]) -> Callable[[Any, *Arguments], T]:
    """A method that works out each answer once. The answers are kept in its object, none is evicted.

    Notes
    -----
    `functools.cache` of a bound method holds the object that holds it: the two, and the pictures they refer to, then
    wait for the garbage collector, which seldom comes to a program that makes few objects and large ones.
    """
    name = f"_kept_{method.__name__}"

    @wraps(method)
    def found(self: Any, *arguments: *Arguments) -> T:
        answers = self.__dict__.setdefault(name, {})
        if arguments not in answers:
            answers[arguments] = method(self, *arguments)
        return answers[arguments]

    return found
