"""Contact sheets, read back as pictures."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from peopled_scene import HEAD, Filmed, Thing, above, programme, write_films
from pictures import psnr

from mcsl_core.report.contact_sheet import GAP, head_sheet, save_picture

FRAME, CAMERA, CAP = 50, "cam2", (150, 90, 40)


def test_a_head_is_seen_through_in_the_last_column_alone(tmp_path: Path) -> None:
    at = above(CAMERA, (0.0, 0.0), HEAD)
    (tmp_path / "with").mkdir()
    (tmp_path / "without").mkdir()
    sheets = []
    for name, things in (("with", [Thing(HEAD, lambda frame: at, 50, CAP)]), ("without", [])):
        base = write_films(Filmed(things), tmp_path / name)
        edl = programme("cam1", see_through=False)
        save_picture(head_sheet(edl, base, [(FRAME, CAMERA)], width=960 + 4 * GAP), tmp_path / f"{name}.png")
        sheets.append(cv2.imread(str(tmp_path / f"{name}.png")))
    assert sheets[0].shape == (180 + 2 * GAP, 960 + 4 * GAP, 3)
    near = []
    for column in range(3):
        left = GAP + column * (320 + GAP)
        cells = [sheet[GAP : GAP + 180, left : left + 320] for sheet in sheets]
        y, x = np.mgrid[:180, :320]
        near.append(psnr(*cells, np.hypot(x - 160, y - 90) < 40))
    raw, plain, seen = near
    assert raw < 22
    assert plain < 22
    assert seen > 28
