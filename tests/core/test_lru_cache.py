"""The cache in memory: bounded by bytes, the least recently used goes first; and what objects keep for themselves."""

from __future__ import annotations

import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from attrs import frozen
from cycles import left_in_cycles
from hypothesis import given
from hypothesis import strategies as st

from mcsl_core.imaging.planes import black
from mcsl_core.lru_cache import LruCache, bytes_of, kept


def array(size: int) -> np.ndarray:
    return np.zeros(size, np.uint8)


def test_the_least_recently_used_goes_when_the_bytes_are_full() -> None:
    cache, made = LruCache(3000), []

    def get(key: str) -> np.ndarray:
        return cache.get(key, lambda: made.append(key) or array(1000))

    for key in "abcada":  # d takes the place of b, which was used before c and a
        get(key)
    assert made == ["a", "b", "c", "d"]
    get("c")
    assert made == ["a", "b", "c", "d"]
    get("b")
    assert made == ["a", "b", "c", "d", "b"]
    get("d")
    assert made == ["a", "b", "c", "d", "b", "d"], "d was used before a and c"


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 500)), max_size=60))
def test_never_more_than_the_bound_and_always_the_value_of_the_key(asked: list[tuple[int, int]]) -> None:
    cache, sizes = LruCache(600), {}
    for key, size in asked:
        found = cache.get(key, lambda k=key, n=size: sizes.update({k: n}) or array(n))
        assert len(found) == sizes[key]
        assert cache.bytes <= 600


def test_what_is_larger_than_the_bound_is_kept_alone() -> None:
    cache = LruCache(1000)
    cache.get("small", lambda: array(10))
    large = cache.get("large", lambda: array(5000))
    assert cache.get("large", lambda: array(0)) is large
    assert len(cache.get("small", lambda: array(11))) == 11


def test_nothing_is_a_value_too() -> None:
    cache: LruCache[int | None] = LruCache(1000)
    assert cache.get("gap", lambda: None) is None
    assert cache.get("gap", lambda: 3) is None
    for key in range(1000):
        cache.get(key, lambda: None)
    assert cache.get("gap", lambda: 3) == 3, "values without arrays are bounded too"


def test_threads_get_one_object() -> None:
    cache = LruCache(10_000)
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda n: (n % 5, id(cache.get(n % 5, lambda: array(10)))), range(400)))
    assert len(set(found)) == 5


def test_bytes_are_those_of_the_arrays_however_deep() -> None:
    @frozen(eq=False)
    class Plan:
        name: str
        weights: tuple[np.ndarray, ...]
        more: dict[str, list[np.ndarray]]

    assert bytes_of(Plan("x", (array(3), array(4)), {"y": [array(5)]})) == 12
    assert bytes_of(black((8, 6))) == 72
    assert bytes_of("text") == bytes_of(None) == 0


class Sums:
    def __init__(self) -> None:
        self.made: list[tuple[int, int]] = []

    @kept
    def of(self, a: int, b: int) -> int:
        self.made.append((a, b))
        return a + b

    @kept
    def next(self, a: int, b: int) -> int:
        return self.of(a, b) + 1


def test_what_is_kept_is_worked_out_once_an_object() -> None:
    one, other = Sums(), Sums()
    assert [one.of(1, 2), one.of(2, 1), one.of(1, 2), one.next(1, 2), one.next(1, 2)] == [3, 3, 3, 4, 4]
    assert (one.made, other.made) == ([(1, 2), (2, 1)], [])


def test_what_is_kept_goes_with_its_object() -> None:
    gone: list[weakref.ref[Sums]] = []

    def use() -> None:
        sums = Sums()
        sums.next(1, 2)
        gone.append(weakref.ref(sums))
        del sums
        assert gone[0]() is None

    left_in_cycles(use)  # in which the collector rests
    assert gone
