"""ITF against the formula written out, and the programme it is held against."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from strategies import edls

from mcsl_core.edl import IDENTITY, Edl, resolve
from mcsl_core.evaluation import interframe_fidelity, without_alignment


def test_itf_is_the_mean_psnr_between_neighbours() -> None:
    rng = np.random.default_rng(1)
    pictures = rng.integers(0, 256, (6, 20, 30)).astype(np.uint8)
    errors = np.mean((pictures[1:].astype(float) - pictures[:-1]) ** 2, axis=(1, 2))
    assert interframe_fidelity(pictures) == pytest.approx(np.mean(10 * np.log10(255**2 / errors)))


def test_equal_neighbours_count_as_the_ceiling() -> None:
    assert interframe_fidelity(np.zeros((3, 4, 4), np.uint8)) == 60
    with pytest.raises(ValueError, match="two pictures"):
        interframe_fidelity(np.zeros((1, 4, 4), np.uint8))


@given(edls())
def test_without_alignment_has_the_same_shots_and_no_look(edl: Edl) -> None:
    plain = without_alignment(edl)
    assert plain.shots == edl.shots
    assert all({p.anchor, *p.homographies.values()} == {IDENTITY} for p in plain.poses)
    asked = [o for o in plain.overrides if o.centering or o.fill or o.colour]
    for piece, decision in resolve(plain):
        if not any(piece.intersection(o.range) for o in asked):
            assert not any((decision.centering, decision.fill, decision.colour))
