"""A camera strip's transform shows the picture where the homography puts it. The oracle projects points and finds
their spots in the rendered picture; it knows nothing of Blender's conventions.
"""

from __future__ import annotations

import av
import cv2
import numpy as np
import pytest
from blender_recording import R, an_edl
from spots import SPOTS, middles, projected, spots

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.timeline import build_timeline
from mcsl_core.delivery import presets
from mcsl_core.edl import IDENTITY, Camera, Media, Pose, Shot


def rendered(tmp_path, blender, homography, anchor, size, programme):
    """The first programme frame, luma, of a camera with that homography."""
    spots(tmp_path / "a.mp4", size, SPOTS * size[0] / 320)
    spots(tmp_path / "ref.mp4", (320, 180), SPOTS)
    edl = an_edl(
        frames=4,
        size=programme,
        cameras=(
            Camera("cam1", (Media("ref.mp4", 4),), (320, 180), an_edl().rate),
            Camera("cam2", (Media("a.mp4", 4),), size, an_edl().rate),
        ),
        movements=(),
        poses=(Pose(R(0, 4), {"cam1": IDENTITY, "cam2": homography}, anchor=anchor),),
        shots=(Shot(R(0, 4), "cam2"),),
        overrides=(),
    )
    edls.save(edl, tmp_path / "edl.json")
    build_timeline(tmp_path / "edl.json", tmp_path / "edit.blend", blender=blender)
    out = tmp_path / "out.mkv"
    preset = presets.load_preset("archive").for_blender()
    run_task(blender, {"task": "render", "blend": str(tmp_path / "edit.blend"), "preset": preset, "output": str(out)})
    with av.open(str(out)) as container:
        return next(container.decode(video=0)).to_ndarray(format="gray")


def similarity(degrees, scale, tx, ty):
    a = np.deg2rad(degrees)
    c, s = scale * np.cos(a), scale * np.sin(a)
    return ((c, -s, tx), (s, c, ty), (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("degrees", "scale", "tx", "ty", "size"),
    [
        (0, 1, 17, -9, (320, 180)),
        (20, 0.8, 70, 10, (320, 180)),
        (-72, 0.7, 60, 200, (320, 180)),
        (8, 0.45, 20, 0, (640, 360)),
    ],
)
def test_a_similarity_is_shown_exactly(tmp_path, blender, degrees, scale, tx, ty, size):
    homography = similarity(degrees, scale, tx, ty)
    luma = rendered(tmp_path, blender, homography, IDENTITY, size, (320, 180))
    expected = projected(homography, SPOTS * size[0] / 320)
    inside = expected[(expected > 8).all(1) & (expected[:, 0] < 311) & (expected[:, 1] < 171)]
    found = middles(luma)
    assert len(inside) >= 3
    for point in inside:
        # H.264 at CRF 4 and bilinear resampling move a disc of 80 pixels by under a twentieth; thrice that is allowed
        assert np.hypot(*(found - point).T).min() < 0.15, (point, found)


def test_a_homography_is_shown_as_the_similarity_nearest_round_the_field(tmp_path, blender):
    homography = ((0.9, 0.12, -4.0), (-0.08, 1.02, 12.0), (2e-4, -1.5e-4, 1.0))
    anchor = similarity(4, 1.05, -5, 2)
    luma = rendered(tmp_path, blender, homography, anchor, (320, 180), (320, 180))
    expected = projected(np.array(anchor) @ np.array(homography), SPOTS)
    found = middles(luma)
    errors = np.array([np.hypot(*(found - p).T).min() for p in expected])
    # the best similarity of these six points themselves, by OpenCV, is the yardstick
    best, _ = cv2.estimateAffinePartial2D(SPOTS, expected, method=cv2.LMEDS, refineIters=100)
    bound = np.hypot(*(SPOTS @ best[:, :2].T + best[:, 2] - expected).T)
    assert np.sqrt((errors**2).mean()) < 1.5 * np.sqrt((bound**2).mean())
    assert errors[4] < 3  # the spot in the middle


def test_the_oracle_would_notice_a_turned_sign(tmp_path, blender):
    luma = rendered(tmp_path, blender, similarity(20, 0.8, 70, 10), IDENTITY, (320, 180), (320, 180))
    wrong = projected(similarity(-20, 0.8, 70, 10), SPOTS)
    assert max(np.hypot(*(middles(luma) - p).T).min() for p in wrong) > 5
