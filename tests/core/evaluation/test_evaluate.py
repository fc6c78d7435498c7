"""ITF and AvSpeed against the formulas written out, the variants, and the pairs that count."""

from __future__ import annotations

import csv
import io
import math
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from hypothesis import given
from pictures import programme_frames, psnr
from strategies import edls

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.coverage import Coverage
from mcsl_core.compositing.proxy import proxy_edl
from mcsl_core.edl import IDENTITY, Camera, Colour, Edl, Look, Media, Override, Pose, Shot
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import InputError, UsageError
from mcsl_core.evaluation.evaluate import Variant, evaluate, standard_variants, without_alignment
from mcsl_core.evaluation.metrics import CEILING_DB, Tracker, Tracks, fidelity_db, grey, speed_px
from mcsl_core.evaluation.results import load_evaluation, to_csv, to_json
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

SIZE = (320, 180)
RATE = Fraction(25)
FRAMES = 24


def moved(dx: float, dy: float = 0.0, degrees: float = 0.0):
    """A matrix that turns about the middle of the picture and then moves."""
    turn = np.vstack([cv2.getRotationMatrix2D(((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2), degrees, 1), [0, 0, 1]])
    turn[:2, 2] += dx, dy
    return tuple(tuple(float(v) for v in row) for row in turn)


def texture(seed: int = 3) -> np.ndarray:
    """A still picture with corners to follow, larger than the cameras' pictures on all sides."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(40, 216, (60, 80, 3)).astype(np.uint8)
    return cv2.resize(coarse, (640, 480), interpolation=cv2.INTER_CUBIC)


TO_REFERENCE = {"a": IDENTITY, "b": moved(12, -6, 20), "c": moved(-20, 4, -35)}


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three cameras that see one still texture, turned and shifted: what aligned views show is the same."""
    folder = tmp_path_factory.mktemp("still")
    shift = np.array([[1, 0, -160], [0, 1, -150], [0, 0, 1.0]])
    for name, matrix in TO_REFERENCE.items():
        view = cv2.warpPerspective(texture(), np.linalg.inv(np.array(matrix)) @ shift, SIZE, flags=cv2.INTER_CUBIC)
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=RATE) as writer:
            for _ in range(FRAMES):
                writer.write(bgr_to_planes(view))
    return folder


def programme(*shots: tuple[int, str], **more) -> Edl:
    """Shots as (first frame, camera) over `FRAMES`, all aligned as the cameras were laid."""
    starts = [*(start for start, _ in shots), FRAMES]
    return Edl(
        rate=RATE,
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", FRAMES),), SIZE, RATE) for n in TO_REFERENCE),
        poses=(Pose(FrameRange(0, FRAMES), TO_REFERENCE),),
        shots=tuple(Shot(FrameRange(s, starts[i + 1]), camera) for i, (s, camera) in enumerate(shots)),
        **more,
    )


THREE = ((0, "a"), (8, "b"), (16, "c"))


# ------------------------------------------------------------------------------------------------------- formulas


def test_itf_is_the_mean_psnr_between_neighbours() -> None:
    rng = np.random.default_rng(1)
    pictures = rng.integers(0, 256, (6, 20, 30)).astype(np.uint8)
    errors = np.mean((pictures[1:].astype(float) - pictures[:-1]) ** 2, axis=(1, 2))
    expected = np.mean(10 * np.log10(255**2 / errors))
    each = [fidelity_db(a, b) for a, b in zip(pictures, pictures[1:], strict=False)]
    assert np.mean(each) == pytest.approx(expected)


def test_equal_neighbours_count_as_the_ceiling() -> None:
    assert fidelity_db(np.zeros((4, 4), np.uint8), np.zeros((4, 4), np.uint8)) == CEILING_DB


def test_only_the_pixels_of_the_mask_count() -> None:
    a, b = np.zeros((10, 10), np.uint8), np.zeros((10, 10), np.uint8)
    b[:5], b[5:] = 10, 200
    mask = np.zeros((10, 10), np.uint8)
    mask[:5] = 255
    assert fidelity_db(a, b, mask) == pytest.approx(20 * math.log10(25.5))
    assert math.isnan(fidelity_db(a, b, np.zeros((10, 10), np.uint8)))


def test_grey_is_full_range() -> None:
    planes = bgr_to_planes(np.repeat(np.array([0, 128, 255], np.uint8), 4).reshape(2, 6, 1).repeat(3, axis=2))
    assert np.abs(grey(planes).astype(int) - np.repeat([0, 128, 255], 4).reshape(2, 6)).max() <= 1


def test_speed_is_the_mean_distance_of_points_that_both_frames_show() -> None:
    points = np.array([[x, y] for x in (10, 50, 90) for y in (10, 30, 50)], float)
    tracks = Tracks(points, points)
    there = np.array([[1, 0, 3.0], [0, 1, 4], [0, 0, 1]])
    assert speed_px(tracks, np.eye(3), there, (100, 60)) == pytest.approx(5)
    far = np.array([[1, 0, 12.0], [0, 1, 0], [0, 0, 1]])  # the column at 90 leaves: six points are too few
    assert math.isnan(speed_px(tracks, np.eye(3), far, (100, 60)))
    assert speed_px(tracks, np.eye(3), far, (103, 60)) == pytest.approx(12)


def test_corners_are_followed_and_points_found_again() -> None:
    picture = cv2.cvtColor(texture(), cv2.COLOR_BGR2GRAY)
    shift = np.array([[1, 0, 2.5], [0, 1, -1.5]])
    followed = Tracker().follow(picture, cv2.warpAffine(picture, shift, (640, 480)))
    inside = (followed.before > 20).all(axis=1) & (followed.before < [620, 460]).all(axis=1)
    assert inside.sum() > 50
    assert np.abs((followed.after - followed.before)[inside] - [2.5, -1.5]).max() < 0.3
    hidden = picture.copy()
    hidden[:, 320:] = cv2.cvtColor(texture(9), cv2.COLOR_BGR2GRAY)[:, 320:]
    kept = Tracker().follow(picture, hidden).before[:, 0]
    assert (kept < 310).sum() > 50
    assert (kept > 330).sum() < 0.1 * (kept < 310).sum(), "what something came before is not followed"
    turn = cv2.getRotationMatrix2D((320, 240), 72, 1)
    found = Tracker().match(picture, cv2.warpAffine(picture, turn, (640, 480)))
    assert len(found) > 50
    assert np.median(np.linalg.norm(found.before @ turn[:, :2].T + turn[:, 2] - found.after, axis=1)) < 0.5


def test_where_there_is_nothing_to_follow_there_are_no_tracks() -> None:
    flat, noise = np.full((90, 160), 99, np.uint8), np.random.default_rng(0).integers(0, 255, (2, 180, 320))
    assert len(Tracker().follow(flat, flat)) == 0
    assert len(Tracker().match(flat, flat)) == 0
    picture = cv2.cvtColor(texture(), cv2.COLOR_BGR2GRAY)
    scattered = np.hstack([np.roll(picture[:, i : i + 128], 90 * i // 128, axis=0) for i in range(0, 640, 128)])
    assert len(Tracker().match(picture, scattered)) == 0, "five ways at once are no common plane"
    a, b = noise.astype(np.uint8)
    assert len(Tracker().match(a, b)) == 0, "chance matches lie on no plane"


# ------------------------------------------------------------------------------------------------------- variants


@given(edls())
def test_without_alignment_has_the_same_shots_and_no_look(edl: Edl) -> None:
    plain = without_alignment(edl)
    assert plain.shots == edl.shots
    assert all({p.anchor, *p.homographies.values()} == {IDENTITY} for p in plain.poses)
    asked = [o for o in plain.overrides if o.centering or o.fill or o.colour]
    for piece, decision in resolve(plain):
        if not any(piece.intersection(o.range) for o in asked):
            assert not any((decision.centering, decision.fill, decision.colour))


def test_the_papers_variants_come_in_its_order() -> None:
    edl = programme(*THREE)
    names = [v.name for v in standard_variants(edl, manual={0: TO_REFERENCE})]
    assert names == ["no", "manual", "plane", "auto", "centered", "filled", "delivered"]
    assert "manual" not in [v.name for v in standard_variants(edl)]
    with pytest.raises(InputError, match=r"camera c is shown at frames .* and was not aligned by hand"):
        standard_variants(edl, manual={0: {"b": IDENTITY}})


def test_every_variant_is_made_by_the_same_compositor(still: Path, monkeypatch) -> None:
    """No-alignment and Manual-alignment too: what is measured against each other differs in the EDL alone."""
    made = []

    class Watched(Compositor):
        def frames(self, piece):
            for planes in super().frames(piece):
                made.append((self.edl.poses[0].homographies["b"], self.edl.poses[0].homographies["c"]))
                yield planes

    monkeypatch.setattr("mcsl_core.evaluation.observer.Compositor", Watched)
    edl = programme(*THREE)
    variants = standard_variants(edl, manual={0: {"b": moved(14, -6, 20), "c": moved(-20, 6, -35)}})
    evaluate(edl, still, variants)
    assert len(made) == (len(variants) - 1) * FRAMES, "without a relief Auto is by planes: the two are made once"
    for variant in variants:
        placed = variant.edl.poses[0].homographies
        same = [m for m in made if np.allclose(m[0], placed["b"]) and np.allclose(m[1], placed["c"])]
        assert len(same) >= FRAMES, variant.name
    assert len({tuple(np.ravel(m)) for m in made}) == 3  # none, by hand, found


# ------------------------------------------------------------------------------------------------------ measuring


def test_alignment_shows_in_every_figure(still: Path) -> None:
    """A still texture: aligned, its points stay where they are; unaligned, they move as the cameras lie."""
    edl = programme(*THREE)
    done = evaluate(edl, still, standard_variants(edl, manual={0: {"b": moved(14, -6, 20), "c": moved(-20, 6, -35)}}))
    no, manual, auto, filled = (done.row(name) for name in ("no", "manual", "auto", "filled"))
    assert [(s.frame, s.before, s.camera) for s in done.switches] == [(8, "a", "b"), (16, "b", "c")]
    for row in done.measured:
        assert row.whole is not None
        assert (row.whole.pairs, row.whole.tracked) == (FRAMES - 1, FRAMES - 1)
        assert (row.switches.pairs, row.switches.tracked) == (2, 2)
    assert auto.switches.av_speed_px < 0.5  # SIFT places a point to about a third of a pixel
    assert manual.switches.av_speed_px == pytest.approx((2 + 2 * math.sqrt(2)) / 2, abs=0.5)
    assert no.switches.av_speed_px > 20
    assert auto.switches.itf_valid_db > manual.switches.itf_valid_db + 3 > no.switches.itf_valid_db + 3
    assert filled.switches.itf_db > auto.switches.itf_db + 3, "black edges move, filled ones do not"
    assert done.gains()["switches_av_speed"] > 80, "less speed is a gain"
    assert auto.switches.av_speed_field_px is None, "no centering: it is not known where the field is"
    assert done.gains(over="no")["switches_itf_valid"] > 50


def test_what_centering_moves_is_motion_too(still: Path) -> None:
    edl = programme((0, "b"), centering=((0, 0.0, 0.0), (FRAMES - 1, 2.0 * (FRAMES - 1), 0.0)))
    done = evaluate(edl, still)
    auto, centered = (done.row(name).whole for name in ("auto", "centered"))
    assert auto is not None
    assert centered is not None
    assert auto.av_speed_px < 0.1
    assert centered.av_speed_px == pytest.approx(2, abs=0.1)
    assert centered.itf_valid_db < auto.itf_valid_db - 10


def test_results_about_the_field_leave_the_rest_out(still: Path) -> None:
    """A turn about the field's middle moves what is there less than the rest, and spoils its picture less."""
    middle = np.array([(SIZE[0] - 1) / 2 + 40, (SIZE[1] - 1) / 2])
    turn = np.vstack([cv2.getRotationMatrix2D(tuple(middle), 4, 1), [0, 0, 1]])
    turned = tuple(tuple(float(v) for v in row) for row in turn @ np.array(TO_REFERENCE["b"]))
    edl = programme((0, "a"), (8, "b"), centering=((0, -40.0, 0.0),))
    done = evaluate(edl, still, standard_variants(edl, manual={0: {"b": turned}}), every=0)
    manual, auto, centered = (done.row(name).switches for name in ("manual", "auto", "centered"))
    assert manual.av_speed_field_px < 0.6 * manual.av_speed_px
    within = 0.2 * SIZE[0] * 2 / 3 * math.radians(4)  # the mean of a disc's radii is two thirds of its own
    assert manual.av_speed_field_px == pytest.approx(within, rel=0.3)
    assert manual.itf_field_db > manual.itf_valid_db + 1
    assert auto.av_speed_field_px == pytest.approx(auto.av_speed_px, abs=0.2)
    assert centered.itf_field_db == pytest.approx(auto.itf_field_db, abs=1.5), "its circle moves along"


def test_the_speed_agrees_with_points_found_in_the_finished_pictures(still: Path) -> None:
    """The carried points against an independent measure: features of the composed frames on either side of a switch."""
    edl = programme((0, "a"), (8, "b"))
    variants = standard_variants(edl, manual={0: {"b": moved(20, 0, 14)}})
    done = evaluate(edl, still, variants, every=0)
    for variant in variants[:3]:
        before, after = programme_frames(
            attrs.evolve(variant.edl, look=variant.look or edl.look), still, FrameRange(7, 9)
        )
        sift = cv2.SIFT_create()
        (ka, da), (kb, db) = (sift.detectAndCompute(grey(p), None) for p in (before, after))
        good = [m for m, n in cv2.BFMatcher().knnMatch(da, db, k=2) if m.distance < 0.7 * n.distance]
        seen = [np.linalg.norm(np.subtract(kb[m.trainIdx].pt, ka[m.queryIdx].pt)) for m in good]
        # Other points, and edges of the black among them: medians and means of one rigid motion differ by their place.
        assert done.row(variant.name).switches.av_speed_px == pytest.approx(np.mean(seen), rel=0.15, abs=0.3)


def test_itf_is_that_of_the_programme_as_it_is_made(still: Path) -> None:
    """At full size against the frames that conform would write, with the EDL's own look."""
    edl = programme(*THREE)
    done = evaluate(edl, still, [Variant("delivered", "", edl)], width=SIZE[0])
    pictures = [grey(p) for p in programme_frames(edl, still)]
    expected = np.mean([min(psnr(a, b), CEILING_DB) for a, b in pairwise(pictures)])
    whole = done.row("delivered").whole
    assert whole is not None
    assert whole.itf_db == pytest.approx(expected, abs=0.01)


def test_sampling_counts_every_switch_and_weighs_the_rest(still: Path) -> None:
    edl = programme(*THREE)
    variants = [Variant("auto", "", edl, Look(False, False, False))]
    all_pairs, some, none = (evaluate(edl, still, variants, every=n).measured[0] for n in (1, 5, 0))
    assert all_pairs.at_switches == some.at_switches == none.at_switches
    assert none.whole is None
    assert all_pairs.switches == some.switches == none.switches
    assert some.whole is not None
    assert all_pairs.whole is not None
    assert some.whole.pairs == all_pairs.whole.pairs
    assert some.whole.itf_db == pytest.approx(all_pairs.whole.itf_db, rel=0.02)


def test_of_many_switches_some_spread_evenly_may_stand_for_all(still: Path) -> None:
    edl = programme((0, "a"), (4, "b"), (8, "c"), (12, "b"), (16, "a"))
    done = evaluate(edl, still, [Variant("auto", "", edl, Look(False, False, False))], every=4, most_switches=2)
    assert [s.frame for s in done.switches] == [4, 12]
    assert done.conditions.switches == 4
    row = done.measured[0]
    assert (row.switches.pairs, row.switches.tracked, len(row.at_switches)) == (4, 2, 2)
    assert row.whole is not None
    assert row.whole.pairs == FRAMES - 1


def test_where_the_cameras_behind_have_a_gap_the_fill_goes_on_with_other_moments(still: Path) -> None:
    """The cameras that fill have no picture for a while: nothing turns black, and every pixel stays valid."""
    edl = programme((0, "c"))
    gap = (FrameRange(10, 12),)
    edl = attrs.evolve(edl, cameras=tuple(attrs.evolve(c, gaps=gap if c.name != "c" else ()) for c in edl.cameras))
    whole = evaluate(edl, still, [Variant("filled", "", edl, Look(False, True, False))]).measured[0].whole
    assert whole is not None
    assert whole.itf_valid_db == pytest.approx(whole.itf_db, abs=0.5)
    assert whole.itf_db > 40


def test_a_variant_with_other_shots_is_refused(still: Path) -> None:
    edl = programme(*THREE)
    other = attrs.evolve(edl, overrides=(Override(FrameRange(0, 4), camera="c"),))
    with pytest.raises(UsageError, match="'other' does not show the same shots"):
        evaluate(edl, still, [Variant("other", "", other)])


def test_where_no_camera_has_a_picture_there_is_no_data(still: Path) -> None:
    edl = programme((0, "b"))
    gap = (FrameRange(10, 12),)
    edl = attrs.evolve(edl, cameras=tuple(attrs.evolve(c, gaps=gap) for c in edl.cameras))
    row = evaluate(edl, still, [Variant("auto", "", edl, Look(False, False, False))]).measured[0]
    assert row.whole is not None
    assert row.whole.tracked == row.whole.pairs - 3, "into the gap, within it, out of it"
    assert row.switches.itf_db is None


# ------------------------------------------------------------------------------------------------ proxy, coverage


def test_a_proxy_is_the_programme_at_a_smaller_size(still: Path) -> None:
    edl = programme((0, "b"), centering=((0, 8.0, -6.0),), look=Look(centering=True, fill=False, colour=False))
    full = grey(next(iter(programme_frames(edl, still, FrameRange(3, 4)))))
    small = proxy_edl(edl, (160, 90))
    footage = Footage(small.cameras, rate=RATE, frames=FRAMES, base=still)
    made = grey(next(iter(Compositor(small, footage).frames(FrameRange(3, 4)))))
    expected = cv2.resize(full, (160, 90), interpolation=cv2.INTER_AREA)
    inner = np.s_[20:-20, 30:-30]
    assert fidelity_db(made[inner].copy(), expected[inner].copy()) > 28
    off = cv2.warpAffine(expected, np.array([[1, 0, 1.0], [0, 1, 0]]), (160, 90))
    assert fidelity_db(made[inner].copy(), expected[inner].copy()) > fidelity_db(made[inner].copy(), off[inner].copy())


@pytest.mark.parametrize("filler", [FootprintFiller, PaperFiller])
def test_coverage_tells_which_camera_every_pixel_is_from(still: Path, filler) -> None:
    edl = programme((0, "c"), look=Look(centering=False, fill=True, colour=False))
    footage = Footage(edl.cameras, rate=RATE, frames=FRAMES, base=still)
    coverage = Coverage(edl, footage, filler=filler())
    shares = coverage.shares(2)
    covered = coverage.covered(2)
    total = sum(shares.values())
    assert total[covered > 0].min() > 0.4  # an edge pixel is half black
    assert total.max() < 1.02
    deep = cv2.warpPerspective(np.full(SIZE[::-1], 255, np.uint8), np.array(TO_REFERENCE["c"]), SIZE) > 0
    deep = cv2.erode(deep.astype(np.uint8), np.ones((81, 81), np.uint8), borderValue=0) > 0
    assert shares["c"][deep].min() > 0.98
    assert shares["a"][~deep].max() > 0.98, "the reference camera stands behind"
    dimmed = Colour(((0.3, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
    coloured = attrs.evolve(
        edl,
        look=attrs.evolve(edl.look, colour=True),
        poses=(attrs.evolve(edl.poses[0], colour={"c": dimmed}),),
        overrides=(Override(FrameRange(0, 5), colour=True),),
    )
    again = Coverage(coloured, footage, filler=filler()).shares(2)
    assert all((again[name] == shares[name]).all() for name in shares), "colours do not tell where a pixel is from"
    plain = Coverage(edl, footage, look=Look(False, False, False)).covered(2)
    assert np.count_nonzero(plain) < np.count_nonzero(covered)


# --------------------------------------------------------------------------------------------------- written down


def test_results_come_back_as_they_were_written(still: Path, tmp_path: Path) -> None:
    edl = programme(*THREE)
    done = evaluate(edl, still, standard_variants(edl, manual={0: TO_REFERENCE}), every=4, width=160)
    text = to_json(done)
    (tmp_path / "f.json").write_text(text, "utf-8")
    again = load_evaluation(tmp_path / "f.json")
    assert to_json(again) == text
    assert again.row("auto").switches.itf_db == pytest.approx(done.row("auto").switches.itf_db, abs=1e-3)
    rows = list(csv.DictReader(io.StringIO(to_csv(done))))
    assert [(r["variant"], r["scope"]) for r in rows][:2] == [("no", "whole"), ("no", "switches")]
    assert float(rows[1]["itf_db"]) == pytest.approx(done.row("no").switches.itf_db, abs=1e-3)
    (tmp_path / "f.json").write_text("{}", "utf-8")
    with pytest.raises(InputError, match="not the results of an evaluation"):
        load_evaluation(tmp_path / "f.json")
