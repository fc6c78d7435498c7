"""The simulator against roads that share no code with it: decoded pictures, template matching, sound correlation."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest

from mcsl_core.errors import Cancelled, DocumentError
from mcsl_core.imaging.masks import hue_mask
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.audio import read_audio
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, Truth, alignment_error, best_plane, best_plane_error, load_truth, simulate

QUIET = Scenario(
    seed=5, duration_s=2.6, size=(640, 360), cameras=3, movements=((1.0, 0.6),), heads=0, hands=0, clock_offset_s=0.2
)
BUSY = Scenario(seed=8, duration_s=3.0, size=(320, 180), movements=0, heads=3, hands=2, clock_offset_s=0.25)


def luma(file: Path) -> list[np.ndarray]:
    """All of a file's pictures, luma only."""
    facts = probe(file)
    reader = VideoReader(facts)
    try:
        return [to_planes(frame, facts).y for _, frame in reader.read(Fraction(0))]
    finally:
        reader.close()


def sound(file: Path) -> np.ndarray:
    facts = probe(file)
    blocks = [block.ravel() for _, block in read_audio(facts, facts.audio_tracks[0], Fraction(0), 48000)]
    return np.concatenate(blocks)


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Truth]:
    """Nobody about; the lamp moves once."""
    out = tmp_path_factory.mktemp("quiet")
    return out, simulate(QUIET, out, Silent())


@pytest.fixture(scope="module")
def busy(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Truth]:
    out = tmp_path_factory.mktemp("busy")
    return out, simulate(BUSY, out, Silent())


def test_the_files_are_as_promised(busy):
    out, truth = busy
    assert truth.frames == BUSY.frames == 89
    for name, file, count in zip(truth.cameras, truth.files, truth.camera_frames, strict=True):
        assert file == f"{name}.mp4"
        facts = probe(out / file)
        assert (facts.size, facts.rate, facts.frames) == (BUSY.size, BUSY.rate, count)
        assert [track.rate for track in facts.audio_tracks] == [48000]
        assert facts.keyframe_interval_s == pytest.approx(1.0, abs=0.35)  # a mean over a short file's three
    assert truth.camera_frames[0] == truth.frames


def test_it_stands_still_but_for_the_movement(quiet):
    out, truth = quiet
    pictures = [p.astype(np.float32) for p in luma(out / "cam1.mp4")]
    assert len(pictures) == truth.frames
    (start, stop) = truth.movements[0]
    window = cv2.createHanningWindow(pictures[0].shape[::-1], cv2.CV_32F)

    def shift(a: int, b: int) -> float:
        (dx, dy), _ = cv2.phaseCorrelate(pictures[a], pictures[b], window)
        return float(np.hypot(dx, dy))

    # The eased start moves by less than a pixel at first; its middle is where the lamp is quickest.
    assert max(shift(n, n + 1) for n in (*range(start - 1), *range(stop, truth.frames - 1))) < 0.1
    assert shift(0, start - 1) < 0.1
    assert shift(stop, truth.frames - 1) < 0.1
    middle = (start + stop) // 2
    assert shift(middle, middle + 1) > 1.0
    grey = np.abs(pictures[start - 1] - pictures[stop]).mean()
    assert grey > 5 * np.abs(pictures[0] - pictures[start - 1]).mean()
    # The very first and last frame of the range belong to it: there, the picture has left its place.
    still = np.abs(pictures[start - 1] - pictures[start - 2]).mean()
    assert np.abs(pictures[start + 1] - pictures[start - 1]).mean() > 1.3 * still


def _shown(truth: Truth, out: Path, camera: str, frames: range) -> np.ndarray:
    """The mean picture of a camera over some programme frames: less noise."""
    pictures = luma(out / truth.files[truth.camera_index(camera)])
    own = [k for n in frames if (k := truth.own_frame(camera, n)) is not None]
    return np.mean([pictures[k] for k in own], axis=0).astype(np.float32)


def vertex(scores: np.ndarray) -> float:
    """Where, in -0.5..0.5 about the middle, the parabola through three scores is highest."""
    left, middle, right = scores.astype(float)
    return 0.5 * (left - right) / (left - 2 * middle + right)


@pytest.mark.parametrize("pose_index", [0, 1])
def test_the_projections_agree_with_what_is_drawn(quiet, pose_index):
    """Where the best plane leaves an error, matching patches of the two pictures finds that very error."""
    out, truth = quiet
    pose = truth.poses[pose_index]
    frames = range(pose.range[0] + 8, min(pose.range[1] - 2, pose.range[0] + 16))
    reference = _shown(truth, out, "cam1", frames)
    found, true = [], []
    for camera in ("cam2", "cam3"):
        H = best_plane(truth, pose_index, camera)
        warped = cv2.warpPerspective(_shown(truth, out, camera, frames), H, reference.shape[::-1])
        index = truth.camera_index(camera)
        in_reference = pose.field_points_px[0]
        planar = cv2.perspectiveTransform(pose.field_points_px[index][None], H)[0]
        for at, moved in zip(in_reference, planar, strict=True):
            x, y = np.rint(at).astype(int)
            half, reach = 9, 7
            if not (half + reach < x < 640 - half - reach and half + reach < y < 360 - half - reach):
                continue
            patch = reference[y - half : y + half + 1, x - half : x + half + 1]
            area = warped[y - half - reach : y + half + reach + 1, x - half - reach : x + half + reach + 1]
            score = cv2.matchTemplate(area, patch, cv2.TM_CCOEFF_NORMED)
            _, best, _, (bx, by) = cv2.minMaxLoc(score)
            if best > 0.8 and 0 < bx < 2 * reach and 0 < by < 2 * reach:
                found.append((bx + vertex(score[by, bx - 1 : bx + 2]), by + vertex(score[by - 1 : by + 2, bx])))
                true.append(moved - at + reach)
    error = np.linalg.norm(np.array(found) - true, axis=1)
    # Within a patch the relief slants and wet places glisten otherwise to each camera: a single match errs by 0.7 px,
    # all of them together do not. test_simulation_geometry.py holds the drawing itself to a hundredth of that.
    assert len(error) > 150
    assert np.median(error) < 0.9
    assert np.abs(np.median(np.array(found) - true, axis=0)).max() < 0.25
    planar_error = np.median(np.linalg.norm(np.array(true) - reach, axis=1))
    assert np.median(error) < 0.45 * planar_error


def test_no_plane_is_better_than_the_best(quiet):
    _, truth = quiet
    rng = np.random.default_rng(0)
    for camera in ("cam2", "cam3"):
        H = best_plane(truth, 0, camera)
        least = best_plane_error(truth, 0, camera)
        assert least == pytest.approx(truth.best_plane_error_px[0][camera])
        assert least > 0.5
        for _ in range(60):
            other = H * (1 + rng.normal(0, 1e-4, (3, 3)))
            assert alignment_error(truth, 0, camera, other) >= least - 1e-9
    assert best_plane_error(truth, 0, "cam1") < 1e-6


def test_a_flat_field_is_a_plane(tmp_path):
    truth = simulate(
        attrs.evolve(QUIET, relief_mm=0, duration_s=0.5, movements=0, cameras=2, size=(160, 90), audio=False),
        tmp_path,
        Silent(),
    )
    assert best_plane_error(truth, 0, "cam2") < 1e-3
    assert np.ptp(truth.field_points_mm[:, 2]) < 1e-3


def test_the_field_has_the_relief_that_was_asked_for(quiet):
    _, truth = quiet
    heights = truth.field_points_mm[:, 2]
    assert np.percentile(heights, 99) - np.percentile(heights, 1) == pytest.approx(QUIET.relief_mm, rel=0.1)
    assert 200 < len(heights) < 500


def test_neighbours_are_turned_against_each_other(busy):
    _, truth = busy
    pose = truth.poses[0]
    headings = [np.rad2deg(np.arctan2(R[0, 1], R[0, 0])) for R in pose.R]
    turns = np.diff([*headings, headings[0]])
    assert np.allclose(np.abs((turns + 180) % 360 - 180), 72, atol=6)


def test_the_cameras_hear_the_same_room_by_their_own_clocks(busy):
    out, truth = busy
    reference = sound(out / "cam1.mp4")
    for camera in range(1, 5):
        heard = sound(out / truth.files[camera])
        size = 2 ** int(np.ceil(np.log2(len(reference) + len(heard))))
        spectrum = np.fft.rfft(reference, size) * np.conj(np.fft.rfft(heard, size))
        correlation = np.fft.irfft(spectrum, size)
        lag = int(np.argmax(correlation))
        lag = lag - size if lag > size // 2 else lag
        assert lag / 48000 == pytest.approx(truth.clocks[camera].offset_s, abs=0.004)
        assert 0.002 < abs(truth.clocks[camera].offset_s) <= BUSY.clock_offset_s


def test_clocks_go_both_ways(busy):
    _, truth = busy
    for clock in truth.clocks:
        assert clock.programme(clock.own(7200.0)) == pytest.approx(7200.0, abs=1e-9)
        assert abs(clock.drift_ppm) <= BUSY.drift_ppm
    assert truth.clocks[0].own(3.0) == 3.0


def test_the_same_seed_makes_the_same_pictures(tmp_path):
    tiny = Scenario(seed=3, duration_s=0.6, size=(160, 90), cameras=2, movements=0)
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        simulate(attrs.evolve(tiny, seed=seed), tmp_path / name, Silent())
    a, b, c = (np.stack(luma(tmp_path / name / "cam2.mp4")[:10]) for name in "abc")
    assert (a == b).all()
    assert np.abs(a.astype(float) - c).mean() > 10
    assert (tmp_path / "a/truth.json").read_bytes() == (tmp_path / "b/truth.json").read_bytes()


def test_the_visible_field_is_what_no_head_hides(busy, tmp_path):
    """The same operation without anybody: where the two pictures differ at a field point, something hides it."""
    out, truth = busy
    simulate(attrs.evolve(BUSY, heads=0, hands=0), tmp_path, Silent())
    assert truth.visible_field.shape == (truth.frames, 5)
    assert (truth.visible_field <= truth.visible_field_without_hands + 1e-9).all()
    seen, counted = [], []
    for camera, name in enumerate(truth.cameras):
        bare, full = luma(tmp_path / f"{name}.mp4"), luma(out / f"{name}.mp4")
        x, y = np.rint(truth.poses[0].field_points_px[camera]).astype(int).T
        inside = (x >= 0) & (x < BUSY.size[0]) & (y >= 0) & (y < BUSY.size[1])
        for n in range(5, truth.frames, 6):
            k = truth.own_frame(name, n)
            if k is None or k >= len(bare):
                continue
            alike = np.abs(bare[k].astype(float) - full[k])[y[inside], x[inside]] < 14
            counted.append(alike.sum() / len(x))
            seen.append(truth.visible_field[n, camera])
    error = np.abs(np.array(counted) - seen)
    # Shade darkens open skin near a hand, and a cap may by chance be as bright as the skin below it.
    assert np.median(error) < 0.1
    assert np.corrcoef(counted, seen)[0, 1] > 0.9
    assert np.ptp(seen) > 0.5


def test_somebody_sees_the_field(busy):
    _, truth = busy
    assert (truth.visible_field_without_hands.max(1) > 0.6).mean() > 0.9
    assert truth.visible_field.min() < 0.4


def test_the_truth_comes_back(quiet):
    out, truth = quiet
    loaded = load_truth(out / "truth.json")
    for name in ("scenario", "rate", "frames", "size", "cameras", "files", "camera_frames", "clocks", "movements"):
        assert getattr(loaded, name) == getattr(truth, name), name
    assert loaded.best_plane_error_px == truth.best_plane_error_px
    assert [p.range for p in loaded.poses] == [p.range for p in truth.poses]
    pinhole = loaded.poses[1].pinhole(2)
    assert np.allclose(pinhole.project(loaded.field_points_mm), truth.poses[1].field_points_px[2])
    assert np.array_equal(loaded.visible_field, truth.visible_field)
    assert load_truth(out).frames == truth.frames


def test_a_file_that_is_no_truth_is_refused(tmp_path):
    (tmp_path / "truth.json").write_text('{"schema": "something else"}')
    with pytest.raises(DocumentError, match="schema"):
        load_truth(tmp_path)


def test_stopping_leaves_nothing(tmp_path):
    progress = Silent()

    class StopSoon(Silent):
        def advance(self, done: int) -> None:
            progress.token.cancel()
            progress.advance(done)

    with pytest.raises(Cancelled):
        simulate(attrs.evolve(BUSY, duration_s=60), tmp_path, StopSoon())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": (321, 180)}, "even"),
        ({"drape": "pink"}, "green, blue, white"),
        ({"movements": ((50.0, 20.0),)}, "movement"),
        ({"movements": 30}, "longer"),
        ({"cameras": 0}, "cameras"),
        ({"rate": 0}, "rate"),
        ({"relief_mm": -1}, "relief_mm"),
    ],
)
def test_an_impossible_scenario_is_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        Scenario(**settings)


def test_movements_by_chance_keep_apart():
    from mcsl_core.simulation.schedule import movement_frames

    for seed in range(30):
        ranges = movement_frames(Scenario(seed=seed, duration_s=90, movements=4))
        assert len(ranges) == 4
        edges = [edge for piece in ranges for edge in piece]
        assert edges == sorted(edges)
        assert edges[0] > 30
        assert edges[-1] < 89 * 30
        assert all(b - a > 30 for a, b in zip(edges[1::2], edges[2::2], strict=False))


@pytest.mark.parametrize(("drape", "least", "most"), [("skin", 0.8, 1.0), ("green", 0.0, 0.5)])
def test_by_hue_a_drape_of_the_skins_colour_cannot_be_told_from_the_field(tmp_path, drape, least, most):
    scenario = Scenario(
        seed=6, duration_s=0.5, size=(320, 180), cameras=1, movements=0, heads=0, hands=0, drape=drape, audio=False
    )
    simulate(scenario, tmp_path, Silent())
    facts = probe(tmp_path / "cam1.mp4")
    reader = VideoReader(facts)
    try:
        _, frame = next(iter(reader.read(Fraction(0))))
        picture = planes_to_bgr(to_planes(frame, facts))
    finally:
        reader.close()
    assert least <= (hue_mask(picture) > 0).mean() <= most
