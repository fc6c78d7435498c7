"""`benchmarks.ideal` by programmes whose distance to the ideal one is known."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from pictures import psnr

from benchmarks.ideal import FINAL, TUNING, Variant, is_tuning, pictures, scenario, scene_of, variants
from benchmarks.ideal_distance import CEILING_DB, Distance, distance, means, occasions
from benchmarks.ideal_geometry import (
    AROUND,
    DRILL_S,
    Cut,
    Lamp,
    TrueGeometry,
    best_planes,
    displacements,
    drilled,
    in_movements,
    inverse,
    jumps,
    shown_frame,
    switches,
)
from benchmarks.ideal_hands import Hands
from benchmarks.ideal_page import markdown
from mcsl_core import edl
from mcsl_core.edl import IDENTITY, Camera, Clock, Edl, Media, Movement, Pose, Shot
from mcsl_core.imaging.geometry import to_edl_matrix
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, Truth, best_plane, simulate
from mcsl_core.timing import FrameRange

FLAT = Scenario(
    seed=4, duration_s=4, size=(320, 180), rate=5, cameras=2, movements=((2.0, 0.8),), heads=0, hands=1,
    relief_mm=0, audio=False, noise=0, crf=10, clock_offset_s=0,
)  # fmt: skip


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory):
    out = tmp_path_factory.mktemp("flat")
    return out, simulate(FLAT, out, Silent(), ideal=True)


def programme(truth: Truth, *, cam2_off: tuple[float, float] = (0.0, 0.0)) -> Edl:
    """cam1, then cam2, then cam1, laid by the truth's planes; cam2 is put off by so many programme pixels."""
    move = np.array([[1, 0, cam2_off[0]], [0, 1, cam2_off[1]], [0, 0, 1.0]])
    start, stop = truth.movements[0]
    middle = (start + stop) // 2
    home = truth.poses[0].field_points_px[0]
    poses = []
    for n, within in enumerate((FrameRange(0, middle), FrameRange(middle, truth.frames))):
        anchor = np.eye(3) if n == 0 else np.array(homography(truth.poses[n].field_points_px[0], home))
        H = np.linalg.inv(anchor) @ move @ anchor @ best_plane(truth, n, 1)
        poses.append(Pose(within, {"cam1": IDENTITY, "cam2": to_edl_matrix(H)}, to_edl_matrix(anchor)))
    cameras = tuple(Camera(c, (Media(f"{c}.mp4", truth.frames),), truth.size, truth.rate) for c in ("cam1", "cam2"))
    ends = (0, 4, start + 1, truth.frames)
    shots = tuple(Shot(FrameRange(ends[n], ends[n + 1]), c) for n, c in enumerate(("cam1", "cam2", "cam1")))
    return Edl(
        rate=truth.rate, size=truth.size, frames=truth.frames, reference="cam1", cameras=cameras,
        movements=(Movement(FrameRange(start, stop)),), poses=tuple(poses), shots=shots,
    )  # fmt: skip


def homography(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    from mcsl_core.simulation.truth import fit_homography

    return fit_homography(source, target)


# ------------------------------------------------------------------------------------------------------- distances


def test_distances_of_known_pictures() -> None:
    rng = np.random.default_rng(2)
    ideal = np.clip(rng.normal(110, 25, (90, 160)), 30, 200).astype(np.uint8)
    mask = np.zeros(ideal.shape, bool)
    mask[20:70, 30:130] = True
    same = distance(ideal, ideal, mask)
    assert same is not None
    assert same.psnr_db == CEILING_DB
    assert same.ssim == pytest.approx(1)
    darker = distance((0.8 * ideal + 5).astype(np.uint8), ideal, mask)
    assert darker is not None
    assert darker.psnr_db < 25
    assert darker.ssim > 0.99
    elsewhere = ideal.copy()
    elsewhere[~mask] = 0
    assert distance(elsewhere, ideal, mask).psnr_db == CEILING_DB  # pyright: ignore
    assert distance(ideal, ideal, np.zeros_like(mask)) is None


def test_the_further_it_is_shifted_the_further_it_is_from_the_ideal(flat) -> None:
    out, _ = flat
    ideal = pictures(out / "ideal" / "ideal.mp4")[0].y
    mask = np.zeros(ideal.shape, bool)
    mask[50:130, 90:230] = True
    found = [distance(np.roll(ideal, shift, 1), ideal, mask) for shift in (0, 1, 2, 4)]
    for measure in ("psnr_db", "ssim"):
        values = [getattr(d, measure) for d in found]
        assert values == sorted(values, reverse=True)
    assert found[0].psnr_db == CEILING_DB  # pyright: ignore


def test_means_are_of_the_frames_that_have_a_distance() -> None:
    row = [Distance(20, 0.5), None, Distance(30, 0.7), Distance(40, 0.9)]
    assert means(row, np.array([True, True, True, False])) == (25, 0.6)
    assert means(row, np.array([False, True, False, False])) is None


# -------------------------------------------------------------------------------------------------------- geometry


def test_what_leads_back_leads_back() -> None:
    def there(at: np.ndarray) -> np.ndarray:
        x, y = at.T
        return np.stack([1.1 * x + 6 * np.sin(y / 30), 0.9 * y - 5 * np.cos(x / 25) + 0.1 * x], -1)

    rng = np.random.default_rng(3)
    at = rng.uniform(0, 300, (200, 2))
    assert np.abs(inverse(there, there(at), at + rng.normal(0, 8, at.shape)) - at).max() < 1e-5


def test_a_plane_that_is_right_displaces_nothing_and_one_that_is_off_by_so_much(flat) -> None:
    _, truth = flat
    for off in ((0.0, 0.0), (3.0, -4.0)):
        made = programme(truth, cam2_off=off)
        found = displacements(made, truth, surface=False)
        assert set(found) == {(0, "cam2"), (1, "cam1"), (1, "cam2")}
        for (_, camera), values in found.items():
            expected = 3 * np.hypot(*off) if camera == "cam2" else 0.0  # 960 over 320 px
            assert values == pytest.approx(np.full(len(values), expected), abs=0.05)
        assert max(values.max() for values in best_planes(made, truth).values()) < 0.05


def with_relief(made: Edl, truth: Truth) -> Edl:
    """``made`` with a relief that lays cam2 where it belongs, whatever the planes say."""
    right, poses = programme(truth), []
    for there, pose in zip(right.poses, made.poses, strict=True):
        seen = {}
        for camera, homography in there.homographies.items():
            P = np.column_stack([np.linalg.inv(np.array(there.anchor) @ np.array(homography)), np.zeros(3)])
            seen[camera] = tuple(tuple(float(v) for v in row) for row in P / P[2, 2])
        relief = edl.Relief(seen, gamma=((0.0,) * 9,) * 6, confidence=((100,) * 9,) * 6)
        poses.append(attrs.evolve(pose, relief=relief))
    return attrs.evolve(made, poses=tuple(poses))


def test_a_relief_that_is_right_where_planes_are_off(flat) -> None:
    _, truth = flat
    made = with_relief(programme(truth, cam2_off=(6.0, 0.0)), truth)
    assert [v.name for v in variants(made, truth)][4:5] == ["surface"]
    plane, surface = (displacements(made, truth, surface=by) for by in (False, True))
    assert np.median(plane[0, "cam2"]) == pytest.approx(18, abs=0.1)
    assert max(np.median(values) for values in surface.values()) < 0.2
    cut = Cut(4, "cam1", "cam2")
    assert (jumps(made, truth, cut, surface=True) or (9,))[0] < 0.15
    assert (jumps(made, truth, cut, surface=False) or (9,))[0] == pytest.approx(12, abs=0.1)


def test_what_a_movement_displaces(flat) -> None:
    """The programme holds its picture to the middle of a movement: near its ends little is displaced."""
    _, truth = flat
    found = in_movements(programme(truth), truth, surface=False).reshape(-1, len(truth.field_points_mm))
    assert len(found) == len(truth.in_movements[0].frames)
    way = np.median(np.hypot(*(truth.poses[1].field_points_px[1] - truth.poses[0].field_points_px[1]).T)) * 3
    assert 1 < np.median(found[0]) < way
    assert in_movements(programme(truth), attrs.evolve(truth, in_movements=()), surface=False).size == 0


def test_jumps_at_switches(flat) -> None:
    _, truth = flat
    made = programme(truth, cam2_off=(6.0, 0.0))
    cuts = switches(made, truth)
    assert cuts == [Cut(4, "cam1", "cam2")]  # the other falls into the movement
    at, above = jumps(made, truth, cuts[0], surface=False) or (0, 0)
    assert at == pytest.approx(12, abs=0.05)  # 640 over 320 px
    assert abs(above - at) > 2  # parallax: 40 mm up, seen from 0.35 m apart
    at, above = jumps(programme(truth), truth, cuts[0], surface=False) or (9, 0)
    assert at < 0.05
    assert above > 4


def test_the_floor_lays_every_camera_where_the_ideal_has_it_in_movements_too(flat) -> None:
    out, truth = flat
    ideal, seen = pictures(out / "ideal" / "ideal.mp4"), {c: pictures(out / f"{c}.mp4") for c in truth.cameras}
    geometry, hands = TrueGeometry(programme(truth), truth), Hands(programme(truth), truth)
    in_ideal = hands.in_ideal(range(truth.frames))
    start, _ = truth.movements[0]
    mask = np.zeros(ideal[0].y.shape, bool)
    mask[40:140, 80:240] = True
    for camera in truth.cameras:
        for frame in (2, start + 2, truth.frames - 2):
            own = truth.own_frame(camera, frame)
            assert own is not None
            laid, inside = geometry.picture(seen[camera][own], camera, frame, colour=False)  # pyright: ignore
            here = hands.in_camera(camera, frame)
            assert here is not None
            bare = mask & inside & ~in_ideal[frame] & ~geometry.mask(here.all, camera, frame)
            assert bare.sum() > 2000
            plain = distance(seen[camera][own].y, ideal[frame].y, bare)
            right = distance(laid.y, ideal[frame].y, bare)
            assert right is not None
            assert plain is not None
            assert right.ssim > 0.8
            assert right.ssim > plain.ssim + 0.15 or camera == "cam1"
            # Colours, too, come from where the luma comes from.
            assert psnr(laid.u, ideal[frame].u, inside[::2, ::2] & bare[::2, ::2]) > 28
    still, inside = geometry.picture(seen["cam1"][2], "cam1", 2, colour=False)  # pyright: ignore
    assert inside[1:-1, 1:-1].all()
    assert psnr(still.y, seen["cam1"][2].y) > 40
    assert Lamp(programme(truth), truth).pinhole("cam1", 10_000) is None


def test_what_is_shown_goes_by_the_clock_that_the_camera_was_given(flat) -> None:
    _, truth = flat
    made = programme(truth)
    late = attrs.evolve(made.cameras[1], clock=Clock(offset_s=0.4))
    wrong = attrs.evolve(made, cameras=(made.cameras[0], late))
    assert shown_frame(made, truth, "cam2", 7) == 7
    assert shown_frame(wrong, truth, "cam2", 7) == 5
    assert shown_frame(wrong, truth, "cam2", 1) is None
    frame = truth.movements[0][0] + 2
    centres = [Lamp(p, truth).pinhole("cam2", frame).centre_mm for p in (made, wrong)]  # pyright: ignore
    assert np.linalg.norm(centres[1] - centres[0]) > 1


def test_frames_are_told_apart(flat) -> None:
    _, truth = flat
    shown = ["cam1"] * 4 + ["cam2"] * (truth.frames - 4)
    hidden = np.ones_like(truth.visible_field_without_hands)
    hidden[7, 1] = hidden[2, 1] = hidden[truth.movements[0][0], 1] = 0.5  # in frame 2 cam1 is shown
    which = occasions(attrs.evolve(truth, visible_field_without_hands=hidden), shown)
    start, stop = truth.movements[0]
    assert np.flatnonzero(which["moving"]).tolist() == list(range(start, stop))
    assert np.flatnonzero(which["heads"]).tolist() == [7]
    assert (which["standing"] ^ which["moving"]).all()
    assert which["all"].sum() == truth.frames


def test_a_drilled_cut_goes_to_cameras_that_see_the_field(flat) -> None:
    _, truth = flat
    long = attrs.evolve(truth.poses[0], range=(0, 40))
    seen = np.ones((60, 2))
    seen[15:30, 1] = 0.5
    slow = attrs.evolve(truth, poses=(long,), visible_field_without_hands=seen, frames=60, movements=())
    short, within = programme(truth), FrameRange(0, 60)
    poses, shots = (attrs.evolve(short.poses[0], range=within),), (Shot(within, "cam1"),)
    made = attrs.evolve(short, frames=60, movements=(), poses=poses, shots=shots)
    cut = drilled(made, slow)
    step = round(DRILL_S * 5)
    starts = [(shot.range.start, shot.camera) for shot in cut.shots]
    # Every step to the other camera, but not while that sees little; what stands still ends three frames early.
    free = [frame for frame in range(step, 40 - AROUND, step) if not 15 - AROUND < frame < 30 + AROUND]
    assert next(frame for frame, camera in starts if camera == "cam2") == free[0]
    assert {frame for frame, _ in starts[1:]} <= set(range(step, 40 - AROUND, step))
    assert not [f for f, camera in starts if camera == "cam2" and 15 - AROUND < f < 30 + AROUND]
    assert len(starts) >= 3


# -------------------------------------------------------------------------------------------------------- the rest


def test_recordings_to_tune_on_are_kept_apart() -> None:
    assert not set(TUNING) & set(FINAL)
    reliefs = {scenario(str(seed)).relief_mm for seed in FINAL}
    assert min(reliefs) == 10
    assert max(reliefs) == 60
    assert len({scenario(str(seed)).drape for seed in FINAL}) == 6
    assert scenario("suturing:601").families
    assert is_tuning({"name": "501"})
    assert not is_tuning({"name": "suturing:601"})
    assert not is_tuning({"name": "701"})


def test_variants_are_those_that_the_programme_has(flat) -> None:
    _, truth = flat
    found = variants(programme(truth), truth)
    assert [v.name for v in found] == ["no", "manual", "best plane", "plane"]
    assert not any(v.look.centering or v.surface for v in found)
    assert isinstance(found[0], Variant)
    assert found[0].edl.poses[0].homographies["cam2"] == IDENTITY
    assert isinstance(found[3].edl, edl.Edl)


@pytest.mark.parametrize("surface", [False, True])
def test_the_page_has_what_was_measured(flat, surface: bool) -> None:
    _, truth = flat
    names = ["plane", "floor", *(["surface"] if surface else [])]
    occasions_of = {"all": [20.0, 0.5], "standing": [21.0, 0.6], "moving": None, "switches": [22.0, 0.7], "heads": None}
    spread = {name: [1.0, 2.0, 3.0] for name in ("plane", "best plane", *(["surface"] if surface else []))}
    spread |= {"surface": [2.0, 3.0, 4.0]} if surface else {}
    figures = {
        "name": "701", "scene": scene_of(truth), "perspectives": 1, "weak": 0,
        "views": [{"pose": 0, "camera": "cam2", **spread}], "pooled": spread,
        "moving": {name: [4.0, 5.0, 6.0] for name in names},
        "jumps": {name: [(1.5, 9.0), (2.5, 11.0)] for name in names},
        "distance": {
            "surface": dict.fromkeys(names, occasions_of), "bare": dict.fromkeys(names, occasions_of),
            "field": dict.fromkeys(names, occasions_of),
            "frames": {"switches": 12},
        },
    }  # fmt: skip
    page = markdown([figures])
    assert "| plane | 20.0 / 0.500 | 21.0 / 0.600 | – | 22.0 / 0.700 | – |" in page
    assert "| plane | 2 | 2.00 | 2.50 | 10.00 |" in page
    assert "1.00 / 2.00 / 3.00" in page
    assert "| 701 | 4.0 / 5.0 / 6.0 |" in page
    assert ("cam2 in pose 0" in page) == surface
    assert ("| surface |" in page) == surface
