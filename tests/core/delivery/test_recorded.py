"""Pictures and sound come out as recorded, or the number that stands for them in the keys has risen.

Nobody must remember it: whoever changes what comes out is told here.
"""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
import recorded_programme
from numpy.typing import NDArray
from recorded_programme import KINDS, RECORD, made, numbers, write_media

from mcsl_core.compositing import parallax
from mcsl_core.filling.footprint import FootprintFiller

AGAIN = "PYTHONPATH=. python tests/recorded_programme.py"
WHERE = {
    "bare": "PICTURES in mcsl_core/code_keys.py",
    "lanczos": "PICTURES in mcsl_core/code_keys.py",
    "footprint": "FootprintFiller.version, or PICTURES in mcsl_core/code_keys.py",
    "reference": "PaperFiller.version, or PICTURES in mcsl_core/code_keys.py",
    "sound": "SOUND in mcsl_core/code_keys.py",
}


def same(kind: str, now: NDArray, then: NDArray) -> bool:
    """Whether nobody sees or hears a difference: processors and libraries round in their own ways."""
    if now.shape != then.shape:
        return False
    off = np.abs(now.astype(int) - then)
    if kind == "sound":
        return bool(off.max() <= 2)
    return bool(off.mean() < 0.05 and (off > 2).mean() < 0.005)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded")
    write_media(path)
    return path


@pytest.fixture(scope="module")
def now(folder: Path) -> dict[str, NDArray]:
    return made(folder)


@pytest.fixture(scope="module")
def then() -> dict[str, NDArray]:
    with np.load(RECORD) as stored:
        return dict(stored)


@pytest.mark.parametrize("kind", [*KINDS, "sound"])
def test_what_comes_out_is_what_the_number_stands_for(kind: str, now: dict, then: dict) -> None:
    number = int(then[f"number of {kind}"])
    if numbers()[kind] != number:
        pytest.fail(f"{WHERE[kind]} is {numbers()[kind]}, the record is of {number}: make it anew, {AGAIN}")
    if not same(kind, now[kind], then[kind]):
        pytest.fail(f"{kind} comes out differently, and conformed media would stay as they are: raise {WHERE[kind]}")


def test_the_record_holds_all_that_a_picture_is_made_of(then: dict) -> None:
    """No picture is black or like the next, and the fill leaves less empty than there is without it."""
    for kind in KINDS:
        assert all(picture.std() > 5 for picture in then[kind])
        assert not any(same(kind, a, b) for a, b in zip(then[kind], then[kind][1:], strict=False))
    empty = {kind: (then[kind][:, :96] <= 16).mean() for kind in KINDS}
    assert empty["footprint"] < empty["bare"] / 2
    assert not same("bare", then["bare"], then["lanczos"])


FILLED = KINDS["footprint"][0]


@pytest.mark.parametrize(
    ("module", "name", "value"),
    [
        (parallax, "_LEAST_AGREEMENT", 2),  # so that no flow is good enough
        (recorded_programme, "KINDS", {"footprint": (FILLED, FootprintFiller(18), "linear")}),
        (recorded_programme, "KINDS", {"footprint": (attrs.evolve(FILLED, colour=False), FootprintFiller(), "linear")}),
    ],
    ids=["parallax", "feather", "colour"],
)
def test_a_change_is_seen(module, name, value, folder, now, monkeypatch) -> None:
    monkeypatch.setattr(module, name, value)
    assert not same("footprint", made(folder)["footprint"], now["footprint"])
