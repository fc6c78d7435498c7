"""A tie that the pictures contradict is refuted; true ones are not: small overlaps, relief, heads, plain drapes."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.photo_consistency import Agreement, LaidView, agreement, refuted
from tests.core.alignment.test_steady import cloth

SIZE = (640, 360)
REACH = 15


def laid(picture: np.ndarray, inside: slice | None = None, *, by: tuple[float, float] = (0, 0)) -> LaidView:
    """A picture laid off by some pixels, seen only in some columns."""
    big = cv2.resize(picture, SIZE)
    moved = cv2.warpAffine(big, np.array([[1.0, 0, by[0]], [0, 1, by[1]]]), SIZE, borderMode=cv2.BORDER_REFLECT)
    steady = np.zeros(SIZE[::-1], bool)
    steady[:, slice(None) if inside is None else inside] = True
    return LaidView(np.asarray(cv2.cvtColor(moved, cv2.COLOR_BGR2GRAY), np.uint8), steady)


def test_views_that_show_the_same_agree_and_others_by_chance_only() -> None:
    scene = cloth(1)
    assert agreement(laid(scene), laid(scene, by=(6, -5)), REACH).over_chance > 20
    assert agreement(laid(scene), laid(scene, by=(60, 45)), REACH).over_chance < 4
    assert agreement(laid(scene), laid(cloth(2)), REACH).over_chance < 4


def test_exposure_and_colour_do_not_matter() -> None:
    scene = cloth(1)
    darker = cv2.convertScaleAbs(scene, alpha=0.5, beta=30)
    assert agreement(laid(scene), laid(darker, by=(4, 3)), REACH).over_chance > 20


@pytest.mark.parametrize("share", [0.1, 0.2, 0.35])
def test_a_true_tie_by_a_small_overlap_stands(share: float) -> None:
    scene = cloth(1)
    overlap = slice(0, round((share + 0.1) * SIZE[0]))
    views = {"a": laid(scene), "b": laid(scene, overlap, by=(5, 5))}
    assert not refuted(views, "a", REACH)


def test_a_false_tie_is_refuted_and_what_hangs_on_the_reference_by_others_is_not() -> None:
    """c is tied to a by way of b, where a head hides it from a; d shows something else."""
    scene, head = cloth(1), cloth(7)
    behind = scene.copy()
    behind[:, :160] = head[:, :160]
    views = {
        "a": laid(behind),
        "b": laid(scene),
        "c": laid(scene, slice(0, 320), by=(3, 3)),
        "d": laid(cloth(9)),
    }
    assert set(refuted(views, "a", REACH)) == {"d"}


def test_nothing_is_refuted_where_nothing_can_be_tried() -> None:
    plain = np.full((180, 320, 3), 120, np.uint8)
    assert agreement(laid(plain), laid(plain), REACH) == Agreement(0, 0)
    assert not refuted({"a": laid(plain), "b": laid(plain)}, "a", REACH)
    hidden = laid(cloth(1), slice(0, 0))
    assert not refuted({"a": hidden, "b": laid(cloth(2))}, "a", REACH)


def test_a_published_homography_stands_and_a_wrong_one_does_not(shared_data: Path) -> None:
    folder = shared_data / "planar"
    one, three = (cv2.imread(str(next(folder.rglob(f"graf{n}.png")))) for n in (1, 3))
    stored = cv2.FileStorage(str(next(folder.rglob("*.xml"))), cv2.FILE_STORAGE_READ)
    true = stored.getFirstTopLevelNode().mat()
    size = (640, round(640 * one.shape[0] / one.shape[1]))
    small = np.diag([640 / one.shape[1], 640 / one.shape[1], 1.0])

    def view(picture: np.ndarray, homography: np.ndarray) -> LaidView:
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        laid_grey = cv2.warpPerspective(grey, small @ homography, size)
        inside = cv2.warpPerspective(np.full_like(grey, 255), small @ homography, size, flags=cv2.INTER_NEAREST) > 0
        return LaidView(np.asarray(laid_grey, np.uint8), inside)

    wrong = np.array([[1, 0, 90], [0, 1, 70], [0, 0, 1.0]])
    assert not refuted({"a": view(one, np.eye(3)), "b": view(three, np.linalg.inv(true))}, "a", REACH)
    assert set(refuted({"a": view(one, np.eye(3)), "b": view(three, wrong @ np.linalg.inv(true))}, "a", REACH)) == {"b"}
