"""Stillness on films whose truth is known, made without the simulator: what moves and what only seems to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from lamp_video import write_lamp

from mcsl_core.movement.protocol import Detection
from mcsl_core.movement.stillness import Stillness
from mcsl_core.progress import Silent
from mcsl_core.recording.sample_store import SampleStore


def detected(tmp_path: Path, way, **settings) -> tuple[Detection, float]:
    footage = write_lamp(tmp_path, way, **settings)
    samples = SampleStore.record(footage, tmp_path / "samples", Silent())
    found = Stillness().detect(samples, footage, Silent())
    samples.close()
    return found, float(footage.rate)


def eased(start_s: float, length_s: float):
    def way(t: float) -> float:
        u = min(max((t - start_s) / length_s, 0.0), 1.0)
        return u * u * (3 - 2 * u)

    return way


def check(found: Detection, rate: float, truth: list[tuple[float, float]], within_s: float = 0.5) -> None:
    seconds = [(m.range.start / rate, m.range.stop / rate) for m in found.movements]
    assert len(seconds) == len(truth), seconds
    for (start, stop), (true_start, true_stop) in zip(seconds, truth, strict=True):
        assert start == pytest.approx(true_start, abs=within_s)
        assert stop == pytest.approx(true_stop, abs=within_s)


@pytest.mark.slow
@pytest.mark.parametrize("length_s", [0.5, 3.0, 12.0])
def test_a_movement_is_timed_within_half_a_second(tmp_path, length_s) -> None:
    found, rate = detected(tmp_path, eased(9.2, length_s), seconds=18 + length_s, heads=0.3)
    check(found, rate, [(9.2, 9.2 + length_s)])
    assert found.movements[0].confidence > 0.8


@pytest.mark.slow
def test_two_movements_some_seconds_apart_are_two(tmp_path) -> None:
    first, second = eased(6, 1.5), eased(12, 2)
    found, rate = detected(tmp_path, lambda t: 0.5 * first(t) + 0.5 * second(t), seconds=20)
    check(found, rate, [(6, 7.5), (12, 14)])


@pytest.mark.slow
def test_a_knock_of_three_pixels_is_found(tmp_path) -> None:
    found, rate = detected(tmp_path, eased(10.4, 0.4), seconds=20, far_px=3, heads=0.25)
    check(found, rate, [(10.4, 10.8)])


@pytest.mark.slow
def test_a_drift_too_slow_for_one_second_is_found(tmp_path) -> None:
    """0.3 px a second: neighbouring samples lie within their noise."""
    found, rate = detected(tmp_path, lambda t: min(max((t - 12) / 20, 0), 1), seconds=44, far_px=6)
    check(found, rate, [(12, 32)], within_s=1.5)


@pytest.mark.slow
def test_heads_over_most_of_every_picture_are_no_movement(tmp_path) -> None:
    found, _ = detected(tmp_path, lambda t: 0.0, seconds=40, heads=0.48)
    assert not found.movements


@pytest.mark.slow
def test_a_shake_that_comes_back_between_two_samples_is_not_seen(tmp_path) -> None:
    """Looks are a second apart: what is over before the next one leaves no trace. Told, not hidden."""
    found, _ = detected(tmp_path, lambda t: np.sin(40 * t) if 8.2 < t < 8.8 else 0.0, seconds=16, far_px=8)
    assert not found.movements


@pytest.mark.slow
def test_one_frozen_camera_does_not_hide_a_movement(tmp_path) -> None:
    found, rate = detected(tmp_path, eased(8, 2), seconds=18, frozen_cameras=[1])
    check(found, rate, [(8, 10)])


@pytest.mark.slow
def test_a_movement_while_one_camera_has_no_picture_is_found_once(tmp_path) -> None:
    found, rate = detected(tmp_path, eased(8, 2), seconds=18, blind_cameras=[2])
    check(found, rate, [(8, 10)])


@pytest.mark.slow
def test_a_movement_while_no_camera_has_a_picture_is_found(tmp_path) -> None:
    found, rate = detected(tmp_path, eased(8, 2), seconds=18, blind_cameras=[0, 1, 2])
    assert len(found.movements) == 1
    (movement,) = found.movements
    assert movement.range.start / rate < 10
    assert movement.range.stop / rate > 8


@pytest.mark.parametrize("seconds", [0.4, 1.2, 2.2])
def test_recordings_of_few_samples_are_taken(tmp_path, seconds) -> None:
    found, _ = detected(tmp_path, lambda t: 0.0, seconds=seconds)
    assert not found.movements
    assert len(found.curve.frames) == max(0, int(np.ceil(seconds)) - 1)


@pytest.mark.slow
def test_movements_at_either_end_stay_inside(tmp_path) -> None:
    out, back = eased(-1, 3), eased(13, 4)
    found, rate = detected(tmp_path, lambda t: 0.5 * out(t) + 0.5 * back(t), seconds=15)
    assert len(found.movements) == 2
    first, last = found.movements
    assert first.range.start / rate <= 1
    assert first.range.stop / rate == pytest.approx(2, abs=0.5)
    assert last.range.start / rate == pytest.approx(13, abs=0.5)
    assert 14 <= last.range.stop / rate <= 15
