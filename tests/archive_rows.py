"""Rows of an archive's table as a hospital's might be, for tests and benchmarks of what many operations take."""

from __future__ import annotations

import random
from collections.abc import Iterator

from mcsl_core.archive.figures import Figures


def rows(count: int, seed: int = 1) -> Iterator[Figures]:
    """Operations of one to four hours; one in fifty could not be made."""
    chance = random.Random(seed)
    for number in range(count):
        name, length = f"2026-{number:05d}", chance.uniform(3600, 14400)
        known = {"operation": name, "results": name, "step": "", "work_s": 2 * length, "cameras": 5, "files": 20}
        known |= {"recorded_bytes": 10**10, "seconds": length, "width": 1920, "height": 1080, "rate": 29.97003}
        if number % 50 == 7:
            why = "cam3.mp4: ends before it should. Copy it again from the recorder"
            yield Figures(**{**known, "state": "refused", "step": "analyse", "why": why})
            continue
        weak = chance.choice([0, 0, 0, 1, 2])
        seen = chance.betavariate(6, 3)
        yield Figures(
            **known,
            state="done",
            why="",
            shots=900,
            switches=chance.randrange(1200),
            movements=chance.randrange(30),
            poses=12,
            perspectives=1,
            overrides=5,
            overridden_s=60.0,
            overrides_without_picture=int(chance.random() < 0.05),
            weak_cameras=weak,
            weak_share=weak * chance.uniform(0, 0.2),
            visible=seen,
            visible_best=min(1.0, seen * 1.04),
            field_unknown_share=0.2 if chance.random() < 0.05 else 0.0,
            clock_confidence=chance.random(),
            unsure_clocks=int(chance.random() < 0.1),
            gap_share=chance.expovariate(1000),
            movement_s=200.0,
            longest_movement_s=chance.uniform(2, 25),
            residual_px=1.1,
            itf_db=31.0,
            av_speed_px=0.4,
            switches_itf_db=25.0,
            switches_av_speed_px=1.4,
        )
