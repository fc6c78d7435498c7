"""Gains that follow a camera's drift: linear between keys, held outside, and refused where they make no sense."""

from __future__ import annotations

import attrs
import pytest
from builders import R, small_edl

from mcsl_core.edl import dumps, from_json, loads, to_json
from mcsl_core.edl.colour import gains_at, keys_over
from mcsl_core.errors import DocumentError

KEYS = ((10, 1.0, 1.0, 1.0), (20, 1.2, 1.0, 0.8), (40, 1.2, 1.1, 0.8))


def with_keys(keys):
    edl = small_edl()
    return attrs.evolve(edl, poses=(attrs.evolve(edl.poses[0], colour_keys={"cam2": keys}),))


def test_gains_are_linear_between_keys_and_held_outside() -> None:
    assert gains_at(KEYS, 0) == (1.0, 1.0, 1.0)
    assert gains_at(KEYS, 15) == pytest.approx((1.1, 1.0, 0.9))
    assert gains_at(KEYS, 30) == pytest.approx((1.2, 1.05, 0.8))
    assert gains_at(KEYS, 99) == (1.2, 1.1, 0.8)


def test_what_a_stretch_depends_on_are_its_ends_and_the_keys_between() -> None:
    assert keys_over(KEYS, R(12, 31)) == [
        (12, *gains_at(KEYS, 12)),
        KEYS[1],
        (30, *gains_at(KEYS, 30)),
    ]
    assert keys_over(KEYS, R(50, 60)) == [(50, 1.2, 1.1, 0.8), (59, 1.2, 1.1, 0.8)]


def test_a_document_keeps_them_and_has_none_where_nothing_drifts() -> None:
    edl = with_keys(KEYS)
    assert loads(dumps(edl)) == edl
    assert to_json(edl)["poses"][0]["colour_keys"] == {"cam2": [list(key) for key in KEYS]}
    assert "colour_keys" not in to_json(small_edl())["poses"][0]


@pytest.mark.parametrize(
    ("keys", "where"),
    [
        ({"cam2": [[300, 1.0, 1.0, 1.0]]}, ".colour_keys.cam2[0][0]"),
        ({"cam2": [[5, 1.0, 1.0, 1.0], [5, 1.0, 1.0, 1.0]]}, ".colour_keys.cam2[1][0]"),
        ({"cam2": [[5, 1.0, 0.0, 1.0]]}, ".colour_keys.cam2[0][2]"),
        ({"cam2": [[5, 1.0, 1.0]]}, ".colour_keys.cam2[0]"),
        ({"cam9": [[5, 1.0, 1.0, 1.0]]}, ".colour_keys.cam9"),
    ],
)
def test_wrong_keys_are_refused_where_they_stand(keys, where) -> None:
    value = to_json(small_edl())
    value["poses"][0]["colour_keys"] = keys
    with pytest.raises(DocumentError) as refused:
        from_json(value)
    assert refused.value.where.endswith("$.poses[0]" + where), refused.value
