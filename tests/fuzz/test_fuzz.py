"""A share of the fuzzing for every run of the tests; `run` does it at length, by hand."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
from fuzz.harnesses import HARNESSES
from fuzz.mutation import mutated
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st


@pytest.mark.parametrize("kind", HARNESSES)
def test_what_the_fuzzing_begins_with_is_taken(tmp_path: Path, kind: str) -> None:
    assert all(HARNESSES[kind].run(tmp_path, seed) for seed in HARNESSES[kind].seeds)


@pytest.mark.parametrize("kind", HARNESSES)
@settings(
    max_examples=100, derandomize=True, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(number=st.integers(0, 2**32))
def test_nothing_but_our_own_errors_comes_out(tmp_path: Path, kind: str, number: int) -> None:
    random = Random(number)
    HARNESSES[kind].run(tmp_path, mutated(random.choice(HARNESSES[kind].seeds), random))
