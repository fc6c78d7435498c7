"""Errors: one sentence for people, an exit code for programs, and a way back from a child process."""

from __future__ import annotations

import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

from mcsl_core import errors
from mcsl_core.errors import BusyError, Cancelled, DocumentError, Fault, InputError, McslError, UsageError

KINDS = [k for k in vars(errors).values() if isinstance(k, type) and issubclass(k, McslError)]


def refuse() -> None:
    raise DocumentError("is empty", where="edl.json at $.cameras", remedy="Hand in another")


def test_the_sentence_says_where_what_and_what_to_do():
    assert str(McslError("is silent", where="cam1.mp4", remedy="Use --sync motion")) == (
        "cam1.mp4: is silent. Use --sync motion"
    )
    assert str(McslError("is silent")) == "is silent"


def test_a_fault_says_the_path_below_its_object():
    assert str(Fault("must be 1 or more, got 0", ".size[1]")) == "size[1]: must be 1 or more, got 0"
    assert str(Fault("no")) == "no"


@pytest.mark.parametrize("kind", KINDS)
def test_exit_codes_are_those_of_the_design(kind):
    expected = {UsageError: 2, BusyError: 4, InputError: 3, Cancelled: 130}
    code = next((c for base, c in expected.items() if issubclass(kind, base)), 4)
    assert kind.exit_code == code


@pytest.mark.parametrize("kind", KINDS)
def test_every_error_survives_pickling(kind):
    error = kind() if kind is Cancelled else kind("broke", where="here", remedy="mend it")
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is kind
    assert (back.what, back.where, back.remedy, str(back)) == (error.what, error.where, error.remedy, str(error))


def test_an_error_comes_back_from_a_process_pool():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool, pytest.raises(DocumentError) as raised:
        pool.submit(refuse).result(timeout=60)
    assert raised.value.where == "edl.json at $.cameras"
