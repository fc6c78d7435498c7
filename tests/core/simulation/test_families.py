"""Families of scenes: what they show is what their truth says, by roads that share no code with the simulator's own."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from mcsl_core.cli.main import cli
from mcsl_core.errors import UsageError
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.progress import Silent
from mcsl_core.simulation import FAMILIES, Scenario, load_truth, photograph, simulate, true_field
from mcsl_core.simulation.backdrop import Backdrop
from mcsl_core.simulation.clocks import clocks
from mcsl_core.simulation.floor import DEPTH_MM, Floor
from mcsl_core.simulation.ground import FIELD_HALF_MM, Ground
from mcsl_core.simulation.layers import Picture
from mcsl_core.simulation.optics import Optics, defocused
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.resting import resting_hands
from mcsl_core.simulation.rig import PinholeCamera, Rig
from mcsl_core.simulation.scene import Scene
from mcsl_core.simulation.schedule import lamp_path, people
from mcsl_core.simulation.surface import HALF_MM, Site, Surface

SMALL = Scenario(seed=11, duration_s=20, size=(320, 180), rate=8, movements=0, heads=0, hands=0, audio=False)


def staged(**changes) -> tuple[Scene, Ground]:
    scene = Scene.of(attrs.evolve(SMALL, **changes))
    return scene, Ground.of(scene.scenario, scene.surface, scene.rig)


def pictures_of(scene: Scene, ground: Ground, camera: int) -> CameraPictures:
    return CameraPictures(scene, ground, camera, clocks(scene.scenario)[camera])


def luma(pictures: CameraPictures, frame: int) -> np.ndarray:
    return pictures.frame(frame)[0].y.astype(float)


def test_families_choose_what_is_not_given():
    assert (Scenario(families=("quick-heads",)).heads, Scenario().heads) == (6, 3)
    assert Scenario(families=("quick-heads",), heads=2).heads == 2
    both = Scenario(families=("brown-drape", "red-straps"))
    assert (both.drape, both.gloves) == ("brown", "tan")
    assert Scenario(families=("limb", "narrow-field")).relief_mm == Scenario(families=("limb",)).relief_mm / 2


@pytest.mark.parametrize(
    ("families", "told"),
    [(("ghost",), "limb"), (("limb", "limb"), "twice"), (("brown-drape", "blown-drape"), "drape")],
)
def test_what_cannot_be_combined_is_refused(families, told, tmp_path):
    with pytest.raises(ValueError, match=told):
        Scenario(families=families)
    chosen = [word for name in families for word in ("--family", name)]
    result = CliRunner().invoke(cli, ["simulate", str(tmp_path / "out"), *chosen])
    assert isinstance(result.exception, UsageError)
    assert not (tmp_path / "out").exists()


def test_the_command_line_combines_them_and_what_is_given_wins(tmp_path):
    def made(*chosen: str) -> dict:
        size = ["--size", "160x90", "--duration", "0.5", "--rate", "8", "--cameras", "2", "--movements", "0"]
        result = CliRunner().invoke(cli, ["simulate", str(tmp_path), *size, *chosen])
        assert result.exit_code == 0, result.output
        return json.loads((tmp_path / "truth.json").read_text())["scenario"]

    assert "families" not in made()
    several = made("--family", "limb", "--family", "brown-drape", "--family", "red-straps", "--drape", "blue")
    assert several["families"] == ["limb", "brown-drape", "red-straps"]
    assert (several["drape"], several["gloves"], several["relief_mm"]) == ("blue", "tan", 48.0)
    assert load_truth(tmp_path).scenario.families == ("limb", "brown-drape", "red-straps")


ALL_AT_ONCE = tuple(name for name in FAMILIES if name not in ("blown-drape", "bare-hands", "photographic"))


@pytest.mark.parametrize(
    "families", [ALL_AT_ONCE, *(pytest.param((name,), id=name, marks=pytest.mark.slow) for name in FAMILIES)]
)
def test_each_family_is_filmed(families, tmp_path):
    if "photographic" in families:
        pytest.importorskip("skimage", reason="scikit-image is not installed; it has the photographs")
    scenario = Scenario(seed=7, duration_s=0.5, size=(160, 90), rate=8, movements=0, families=families, audio=False)
    truth = simulate(scenario, tmp_path, Silent())
    assert truth.visible_field.max() > 0.2
    assert 60 < len(truth.field_points_mm) < 500
    loaded = load_truth(tmp_path)
    assert loaded.scenario == scenario
    for camera in range(5):
        projected = loaded.poses[0].pinhole(camera).project(loaded.field_points_mm)
        assert np.allclose(projected, loaded.poses[0].field_points_px[camera])


@pytest.mark.parametrize("families", [("limb",), ("narrow-field",), ("limb", "narrow-field")])
def test_every_point_of_a_steep_field_is_seen_by_every_camera(families):
    """A ray sent through each point's pixel meets the surface there, not on a slope before it."""
    for seed in range(6):
        scene = Scene.of(
            attrs.evolve(SMALL, seed=seed, families=families, relief_mm=Scenario(families=families).relief_mm)
        )
        points = scene.surface.visibility_points_mm
        for camera in range(5):
            pinhole = scene.rig.pinhole(camera, scene.path.poses[0])
            rays = points - pinhole.centre_mm
            for share in np.linspace(0.95, 0.998, 25):  # on its way down the last 50 mm
                along = pinhole.centre_mm + share * rays
                below = scene.surface.height_at(along[:, :1], along[:, 1:2])[:, 0] - along[:, 2]
                assert np.percentile(below, 99.5) < 1.0


@pytest.mark.parametrize("families", [("limb",), ("limb", "narrow-field")])
def test_a_steep_field_is_drawn_where_its_points_project(families):
    scene, ground = staged(families=families, size=(640, 360), relief_mm=Scenario(families=families).relief_mm)
    points = scene.surface.field_points_mm
    for camera in range(5):
        pinhole = scene.rig.pinhole(camera, scene.path.poses[0])
        px = pinhole.project(points)
        px = px[((px > 1) & (px < (638, 358))).all(1)].astype(np.float32)
        maps = Backdrop(scene, ground, camera, np.ones(3))._maps(pinhole)
        x, y = (cv2.remap(m, px[:, :1], px[:, 1:], cv2.INTER_LINEAR) * ground.pitch_mm - HALF_MM for m in maps)
        drawn = pinhole.project(np.concatenate([x, y, scene.surface.height_at(x, y)], 1))
        error = np.linalg.norm(drawn - px, axis=1)
        assert np.median(error) < 0.05
        assert error.max() < 0.5


def test_a_limb_has_steep_sides_within_its_field():
    for seed in range(4):
        surface = Surface.of(attrs.evolve(SMALL, seed=seed, families=("limb",), relief_mm=48))
        points = surface.field_points_mm
        x, y = points[:, :1], points[:, 1:2]
        slopes = [
            np.abs(surface.height_at(x + dx, y + dy) - surface.height_at(x - dx, y - dy)) / 4
            for dx, dy in ((2, 0), (0, 2))
        ]
        steep = np.rad2deg(np.arctan(np.hypot(*slopes)))
        assert np.percentile(steep, 90) > 42
        assert np.ptp(points[:, 2]) > 40


def test_what_rests_stays_where_it_is_and_hides_what_lies_below():
    resting, bare = staged(families=("resting-hand",)), staged()
    places = [[p.origin for p in resting[0].placements(t)] for t in np.linspace(1, 9, 9)]
    assert len(places[0]) == 4  # two hands and their sleeves
    assert np.ptp(np.array(places), axis=0).max() < 0.5
    covered = []
    for camera in range(5):
        shown, empty = pictures_of(*resting, camera), pictures_of(*bare, camera)
        planes, (visible, without_hands) = shown.frame(20)
        px = resting[0].rig.pinhole(camera, resting[0].path.poses[0]).project(resting[0].surface.field_points_mm)
        x, y = np.rint(px).astype(int).T
        inside = (x >= 0) & (x < 320) & (y >= 0) & (y < 180)
        alike = np.abs(planes_to_bgr(planes).astype(float) - planes_to_bgr(empty.frame(20)[0])).max(2) < 30
        assert without_hands > 0.95
        assert alike[y[inside], x[inside]].sum() / len(x) == pytest.approx(visible, abs=0.1)
        covered.append(1 - visible)
    # Near the field, one hand hides much the same from all cameras.
    assert min(covered) > 0.05
    assert np.ptp(covered) < 0.3


def test_resting_hands_come_and_go_within_minutes():
    scenario = attrs.evolve(SMALL, families=("resting-hand",), duration_s=900)
    for hand in resting_hands(scenario, Site.of(scenario)):
        away = np.array([np.hypot(*hand.tip_at(t)[:2]) > 200 for t in np.arange(0, 900, 0.5)])
        assert 0.005 < away.mean() < 0.2
        turns = np.flatnonzero(np.diff(away.astype(int)))
        assert 4 <= len(turns) <= 30


def test_quick_heads_come_and_go_within_seconds():
    def stays(families: tuple[str, ...]) -> np.ndarray:
        scenario = attrs.evolve(SMALL, families=families, duration_s=120, heads=6)
        found = []
        for person in people(scenario, Rig.of(scenario), lamp_path(scenario)):
            over = np.array([np.hypot(*person.head_at(t)[:2]) < 250 for t in np.arange(0, 120, 0.05)])
            edges = np.flatnonzero(np.diff(over.astype(int)))
            found += [0.05 * (b - a) for a, b in zip(edges, edges[1:], strict=False) if over[a + 1]]
        return np.array(found)

    quick, usual = stays(("quick-heads",)), stays(())
    assert np.median(quick) < 2 < 4 < np.median(usual)
    assert np.percentile(quick, 90) < 3.5


def test_exposure_begins_off_settles_and_begins_anew_when_the_lamp_has_moved():
    scene = Scene.of(attrs.evolve(SMALL, families=("exposure",), movements=((9.0, 1.0),)))
    grey = np.full((180, 320, 4), (100, 128, 128, 255), np.uint8)
    for camera in range(5):
        optics, pinhole = Optics(scene.scenario, scene.path, camera), scene.rig.pinhole(camera, scene.path.poses[0])

        def light(t: float, optics=optics, pinhole=pinhole) -> float:
            return float(np.mean(optics.seen(Picture.of(grey), pinhole, pinhole, t).y)) - 16

        assert abs(light(0) / 84 - 1) > 0.15
        assert abs(light(10.05) / 84 - 1) > 0.1
        settled = [light(t) / 84 for t in (7.5, 8.0, 8.5, 17.0, 18.0, 19.0)]
        assert abs(np.median(settled) - 1) < 0.07


def test_white_balance_drifts_slowly_and_leaves_green():
    scene = Scene.of(attrs.evolve(SMALL, families=("white-balance",)))
    grey = np.full((180, 320, 4), (125, 128, 128, 255), np.uint8)
    pinhole = scene.rig.pinhole(1, scene.path.poses[0])
    optics = Optics(scene.scenario, scene.path, 1)
    seen = [optics.seen(Picture.of(grey), pinhole, pinhole, t).planes() for t in np.arange(0, 100, 1.0)]
    means = np.array([planes_to_bgr(planes).mean((0, 1)) for planes in seen])
    assert np.ptp(means[:, 1]) < 4
    assert np.ptp(means[:, 0]) > 10
    assert np.ptp(means[:, 2]) > 10
    assert np.abs(np.diff(means, axis=0)).max() < 7  # chroma of eight bits steps by two levels


def test_one_camera_is_out_of_focus_and_it_is_not_the_reference():
    scene, ground = staged(families=("defocus",))
    sharp = [cv2.Laplacian(luma(pictures_of(scene, ground, c), 3), cv2.CV_64F).std() for c in range(5)]
    blurred = defocused(scene.scenario)
    assert blurred == int(np.argmin(sharp)) != 0
    assert sharp[blurred] < 0.6 * np.median(sharp)
    assert {defocused(attrs.evolve(scene.scenario, seed=seed)) for seed in range(40)} == {1, 2, 3, 4}


def test_a_lens_moves_what_is_drawn_to_where_the_truth_has_it():
    """White dots at undistorted pixels, found again where the distorting camera projects them."""
    scene = Scene.of(attrs.evolve(SMALL, families=("lens",), size=(640, 360)))
    drawn = scene.rig.pinhole(3, scene.path.poses[0])
    true = scene.rig.camera(3, scene.path.poses[0])
    assert true.k1 < -0.2
    where = np.array([(60, 40), (320, 180), (500, 60), (600, 330), (150, 300), (40, 180)], float)
    layer = np.zeros((360, 640, 4), np.uint8)
    for x, y in where:
        cv2.circle(layer, (int(x), int(y)), 4, (235, 128, 128, 255), -1)
    seen = Optics(scene.scenario, scene.path, 3).seen(Picture.of(layer), drawn, true, 0.0).y
    depths = 900 * np.linalg.solve(drawn.K, np.column_stack([where, np.ones(len(where))]).T).T
    expected = true.project((depths - drawn.t) @ drawn.R)
    assert np.abs(expected - where).max() > 2
    for x, y in expected:
        column, row = round(x), round(y)
        window = seen[row - 8 : row + 9, column - 8 : column + 9].astype(float)
        rows, columns = np.mgrid[-8:9, -8:9]
        found = np.array([(window * columns).sum(), (window * rows).sum()]) / window.sum() + (column, row)
        assert np.linalg.norm(found - (x, y)) < 0.15


def test_a_camera_with_distortion_goes_there_and_back():
    K = np.array([[1184.0, 0, 319.5], [0, 1184, 179.5], [0, 0, 1]])
    camera = PinholeCamera(K, np.eye(3), np.zeros(3)).through_lens(-0.4)
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-150, 150, (50, 2)), rng.uniform(800, 1200, 50)])
    px = camera.project(points)
    rays = camera.rays(px)
    assert np.allclose(rays[:, :2] / rays[:, 2:], points[:, :2] / points[:, 2:], atol=1e-9)
    corner = PinholeCamera(K, np.eye(3), np.zeros(3)).rays(np.array([[0.0, 0.0]]))
    assert np.allclose(camera.project(corner), [[0, 0]], atol=1e-9)


def test_the_floor_lies_far_below_and_beside_the_table_alone():
    scene, ground = staged(families=("floor",), size=(640, 360))
    bare = staged(size=(640, 360))
    x, y = np.meshgrid(np.arange(640.0), np.arange(360.0))
    floor, shown, cameras = Floor.of(scene.scenario), {}, {}
    for camera in (1, 3):  # both look past the same edge
        pinhole = cameras[camera] = scene.rig.pinhole(camera, scene.path.poses[0])
        shown[camera] = luma(pictures_of(scene, ground, camera), 100)  # the field has changed since the beginning
        coloured = [
            planes_to_bgr(pictures_of(*staging, camera).frame(100)[0]).astype(int)
            for staging in ((scene, ground), bare)
        ]
        differs = np.abs(coloured[0] - coloured[1]).max(2) > 12
        rays = pinhole.rays(np.stack([x, y], -1))
        table = pinhole.centre_mm + rays * (-pinhole.centre_mm[2] / rays[..., 2:])  # where they meet z = 0
        beyond = floor.outside(table[..., 0], table[..., 1])
        assert (beyond > 20).mean() > 0.05
        assert differs[beyond > 30].mean() > 0.85  # the drapes lie below z = 0 there: their edge is seen further out
        assert differs[beyond < -50].mean() < 0.001
    # What both cameras see of it agrees at its depth, by the plane's homography.
    on_floor = np.array([[1, 0, 0], [0, 1, 0], [0, 0, -DEPTH_MM], [0, 0, 1.0]])
    first, second = (cameras[c].K @ np.column_stack([cameras[c].R, cameras[c].t]) @ on_floor for c in (1, 3))
    warp = first @ np.linalg.inv(second)
    laid = cv2.warpPerspective(shown[3].astype(np.float32), warp, (640, 360))
    both = cv2.warpPerspective((beyond > 30).astype(np.float32), warp, (640, 360)) > 0.99
    rays = cameras[1].rays(np.stack([x, y], -1))
    table = cameras[1].centre_mm + rays * (-cameras[1].centre_mm[2] / rays[..., 2:])
    both &= floor.outside(table[..., 0], table[..., 1]) > 30
    assert both.sum() > 1000
    assert np.corrcoef(laid[both], shown[1][both])[0, 1] > 0.85


def test_glare_wanders_over_the_field_and_is_each_cameras_own():
    shining, dull = staged(families=("glare",), size=(640, 360)), staged(size=(640, 360))
    places = []
    for camera in (0, 2):
        bright, plain = pictures_of(*shining, camera), pictures_of(*dull, camera)
        pinhole = shining[0].rig.pinhole(camera, shining[0].path.poses[0])
        field = np.rint(pinhole.project(shining[0].surface.visibility_points_mm)).astype(int)
        added = {}
        for frame in (16, 20, 60, 90, 120, 150):
            gain = luma(bright, frame) - luma(plain, frame)
            assert np.abs(gain[:20]).max() < 12  # far from the field nothing shines but grain
            added[frame] = gain[field[:, 1].clip(0, 359), field[:, 0].clip(0, 639)]
            assert added[frame].max() > 50
        alike = [np.corrcoef(added[16], added[frame])[0, 1] for frame in added]
        assert alike[1] > 0.8  # half a second later
        assert min(alike) < 0.75
        places.append(added[16])
    assert np.corrcoef(*places)[0, 1] < 0.7


def test_straps_are_red_and_lie_about_the_field():
    scene, ground = staged(families=("red-straps",), size=(640, 360))
    planes, _ = pictures_of(scene, ground, 0).frame(8)
    plain, _ = pictures_of(*staged(size=(640, 360)), 0).frame(8)
    differs = np.abs(planes_to_bgr(planes).astype(int) - planes_to_bgr(plain)).max(2) > 60
    assert differs.mean() > 0.002
    blue, green, red = planes_to_bgr(planes)[differs].mean(0)
    assert red > 2 * max(blue, green)


def test_a_monotone_drape_has_nothing_to_match():
    def detail(**changes) -> float:
        scene, ground = staged(size=(640, 360), noise=0, **changes)
        field = scene.surface.site.opening(*np.meshgrid(*2 * [np.linspace(-432, 432, ground.base.shape[0])])) > -8
        grey = cv2.cvtColor(ground.base, cv2.COLOR_BGR2GRAY).astype(float)
        return float(np.abs(cv2.Laplacian(grey, cv2.CV_64F))[~field].mean())

    assert detail(families=("monotone-drape",)) < 0.1 * detail()


def test_photographs_give_detail_that_paint_has_not():
    pytest.importorskip("skimage", reason="scikit-image is not installed; it has the photographs")
    painted, detailed = staged()[1], staged(families=("photographic",))[1]
    ratio = detailed.tissue.colour.mean((0, 1)) / painted.tissue.colour.mean((0, 1))
    assert np.abs(ratio - 1).max() < 0.1  # of the same colour
    change = np.abs(detailed.tissue.colour - painted.tissue.colour).mean() / painted.tissue.colour.mean()
    assert change > 0.02


def test_without_the_photographs_it_says_what_to_install(monkeypatch, tmp_path):
    photograph._photograph.cache_clear()
    monkeypatch.setitem(sys.modules, "skimage", None)
    with pytest.raises(UsageError, match="scikit-image") as told:
        simulate(Scenario(duration_s=0.5, movements=0, size=(160, 90), families=("photographic",)), tmp_path, Silent())
    assert "pip install" in str(told.value)
    assert not list(tmp_path.glob("*.mp4"))


@pytest.mark.parametrize("families", [(), ("limb", "lens"), ("narrow-field",)])
def test_the_true_field_is_where_its_points_are_seen(families, tmp_path):
    scenario = attrs.evolve(SMALL, duration_s=0.5, cameras=3, families=families)
    truth = simulate(scenario, tmp_path, Silent())
    for camera in range(3):
        mask = true_field(truth, 0, camera, (320, 180))
        px = np.rint(truth.poses[0].field_points_px[camera]).astype(int)
        inside = ((px >= 0) & (px < (320, 180))).all(1)
        assert mask[px[inside, 1], px[inside, 0]].mean() > 0.97
        hull = np.zeros((180, 320), np.uint8)
        cv2.fillConvexPoly(hull, cv2.convexHull(px.astype(np.int32)), 1)
        union = (mask | (hull > 0)).sum()
        assert (mask & (hull > 0)).sum() / union > 0.85  # the points keep two millimetres off the drapes
        small = true_field(truth, 0, camera, (160, 90))
        assert (small == mask[::2, ::2]).mean() > 0.97


def test_the_page_about_them_names_each():
    page = (Path(__file__).parents[3] / "docs/how-to/simulate.md").read_text("utf-8")
    rows = [line.split("|")[1].strip(" `") for line in page.splitlines() if line.startswith("| `")]
    assert rows == list(FAMILIES)


def test_smooth_skin_has_little_texture_and_the_wound_keeps_its_own():
    (scene, painted), (_, smooth) = staged(size=(640, 360)), staged(families=("smooth-skin",), size=(640, 360))
    side = painted.tissue.wet.shape[0]
    line = np.linspace(-FIELD_HALF_MM, FIELD_HALF_MM, side)
    x, y = np.meshgrid(line, line)
    depth, bare = scene.surface.site.wound(x, y), scene.surface.site.opening(x, y) > 4

    def detail(ground: Ground, where: np.ndarray) -> float:
        grey = cv2.cvtColor(ground.tissue.colour.astype(np.float32), cv2.COLOR_BGR2GRAY)
        return float(np.abs(cv2.Laplacian(grey, cv2.CV_32F))[where].mean())

    skin, wound = (depth < -0.4) & bare, depth > 0.3
    assert detail(smooth, skin) < 0.35 * detail(painted, skin)
    assert detail(smooth, wound) > 0.8 * detail(painted, wound)
