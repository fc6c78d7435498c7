"""The report's pictures and what it measures where a pose has a relief: films of a scene whose heights are known."""

from __future__ import annotations

import base64
import re
from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
import relief_scene as scene
from click.testing import CliRunner
from numpy.typing import NDArray

from mcsl_core.cli.main import cli
from mcsl_core.edl import Camera, Edl, FieldStretch, Look, Media, Shot, load, save
from mcsl_core.imaging.geometry import inverse, transform_points
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import footage_of
from mcsl_core.report.field_picture import laid_picture
from mcsl_core.report.pictures import pose_pictures
from mcsl_core.report.residuals import residuals
from mcsl_core.timing import FrameRange

SIZE, RATE, FRAMES, HEIGHT = (480, 320), Fraction(25), 12, 14.0
LOSSLESS = Encoding(options={"preset": "ultrafast", "qp": "0"})


@pytest.fixture(scope="module")
def edl_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two cameras before a hill that moves the second one's picture by 14 pixels, which is shown."""
    folder = tmp_path_factory.mktemp("hill")
    noise = cv2.GaussianBlur(np.random.default_rng(7).uniform(0, 255, (SIZE[1], SIZE[0], 3)), (0, 0), 2.5)
    seen = {"a": np.clip(128 + 4 * (noise - 128), 0, 255).astype(np.uint8)}
    seen["b"] = scene.picture_of(seen["a"], HEIGHT)
    for name, picture in seen.items():
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=RATE, encoding=LOSSLESS) as writer:
            for _ in range(FRAMES):
                writer.write(picture)
    whole = FrameRange(0, FRAMES)
    square = ((120.0, 80.0), (360.0, 80.0), (360.0, 240.0), (120.0, 240.0))
    edl = Edl(
        rate=RATE,
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=tuple(Camera(name, (Media(f"{name}.mp4", FRAMES),), SIZE, RATE) for name in seen),
        poses=(scene.pose_of(FRAMES, SIZE, height=HEIGHT, solved_from=(0, 3, 6, 9, 11)),),
        shots=(Shot(whole, "b"),),
        look=Look(centering=False, fill=False, colour=False),
        fields=(FieldStretch(whole, "pictures", (square,)),),
    )
    path = folder / "edl.json"
    save(edl, path)
    return path


def with_surface(edl_path: Path, surface: bool) -> Edl:
    edl = load(edl_path)
    return attrs.evolve(edl, look=attrs.evolve(edl.look, surface=surface))


def middle(picture: NDArray) -> NDArray:
    """Of the hill, in grey."""
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)[100:220, 160:320].astype(float)


@pytest.mark.parametrize("surface", [True, False])
def test_views_over_each_other_are_sharp_by_the_relief_and_blurred_by_planes(edl_path: Path, surface: bool) -> None:
    pictures = pose_pictures(with_surface(edl_path, surface), edl_path.parent, None, Silent())[0]
    assert pictures is not None
    after, shown = (
        cv2.imdecode(np.frombuffer(base64.b64decode(url.partition(",")[2]), np.uint8), cv2.IMREAD_COLOR)
        for url in (pictures.after, pictures.programme)
    )
    contrast = middle(after).std() / middle(shown).std()  # pyright: ignore[reportArgumentType]
    assert contrast > 0.9 if surface else contrast < 0.85


@pytest.mark.parametrize("surface", [True, False])
def test_a_field_is_outlined_on_the_picture_as_the_look_lays_it(edl_path: Path, surface: bool) -> None:
    """Of another camera, where the reference camera has no picture."""
    edl = with_surface(edl_path, surface)
    a = laid_picture(edl, footage_of(edl, edl_path.parent), 5)
    gap = attrs.evolve(edl.cameras[0], gaps=(FrameRange(4, 7),))
    edl = attrs.evolve(edl, cameras=(gap, edl.cameras[1]))
    b = laid_picture(edl, footage_of(edl, edl_path.parent), 5)
    off = np.abs(middle(a) - middle(b)).mean()
    assert off < 6 if surface else off > 20


def test_what_plane_and_surface_leave_is_what_the_heights_say(edl_path: Path) -> None:
    """By a plane as far as the hill moves the field's places; by the relief a fraction of a pixel."""
    found = residuals(load(edl_path), edl_path.parent, Silent())[0]
    assert found.keys() == {"a", "b"}
    assert found["a"] == found["b"], "there is one pair"
    x, y = np.meshgrid(np.arange(120.0, 360), np.arange(80.0, 240))
    places = np.column_stack([x.ravel(), y.ravel()])
    laid = transform_points(inverse(scene.PROJECTION[:, :3]), scene.seen(places, SIZE, HEIGHT))
    apart = np.hypot(*(laid - places).T)
    assert found["b"].plane.median == pytest.approx(np.median(apart), abs=0.5)
    assert found["b"].plane.most == pytest.approx(np.percentile(apart, 95), abs=0.7)
    assert found["b"].surface.median < 0.3
    assert found["b"].surface.most < 0.8


def test_nothing_is_measured_of_a_plane(edl_path: Path) -> None:
    edl = load(edl_path)
    plane = attrs.evolve(edl, poses=tuple(attrs.evolve(pose, relief=None) for pose in edl.poses))
    assert residuals(plane, edl_path.parent, Silent()) == [{}]


def report(edl_path: Path, out: Path, *options: str) -> str:
    done = CliRunner().invoke(cli, ["report", str(edl_path), "-o", str(out), *options])
    assert done.exit_code == 0, done.output
    return out.read_text("utf-8")


def test_the_page_shows_the_relief_and_what_remains(edl_path: Path, tmp_path: Path) -> None:
    text = report(edl_path, tmp_path / "r.html")
    assert "The scene&#39;s relief, from a and b, is known in 100% of the picture." in text
    assert "moves a camera's picture by up to" in text
    assert "surface leaves, px" in text
    assert text.count("base64,") == 5
    assert len(re.findall(r'<td class="n">\d+\.\d / \d+\.\d</td>', text)) == 4
    assert "There is no switch to measure it at." in text


def test_the_relief_is_a_picture(edl_path: Path, tmp_path: Path) -> None:
    """Left out with the others; what it leaves is a number, and stays."""
    bare = report(edl_path, tmp_path / "r.html", "--no-pictures")
    assert "base64," not in bare
    assert "moves a camera's picture" not in bare
    assert "surface leaves, px" in bare
    hidden = report(edl_path, tmp_path / "h.html", "--anonymous")
    assert "from cam A and cam B, is known" in hidden
    assert "moves a camera's picture" in hidden


def test_a_relief_without_its_media(edl_path: Path, tmp_path: Path) -> None:
    """Is shown all the same; what it leaves cannot be measured."""
    save(load(edl_path), tmp_path / "edl.json")
    text = report(tmp_path / "edl.json", tmp_path / "r.html")
    assert text.count("base64,") == 1
    assert "The pictures cannot be shown" in text
    assert "surface leaves, px" not in text
