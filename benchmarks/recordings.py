"""The simulated recordings of the final tables: seeds that no stage was tuned on.

    python -m benchmarks.recordings FOLDER        makes those that are missing (half an hour on two cores)

Tuning used seeds 1 to 399; scenes unlike the plain one have seeds of their own in families.py, and what is held against
the ideal programme has in ideal.py. Whoever tunes on one of
these replaces it by a new one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

R = TypeVar("R")
TEN_MINUTES = 600.0

# Movements, drapes, skins, gloves, sizes and rates all differ; 404 has a slow turn of 20 s, a knock and a quick move.
RECORDINGS: Mapping[str, Scenario] = {
    "401": Scenario(seed=401, duration_s=TEN_MINUTES, size=(640, 360), rate=8, movements=4),
    "402": Scenario(
        seed=402, duration_s=TEN_MINUTES, size=(480, 270), rate=8, movements=3,
        drape="blue", skin="dark", gloves="blue", heads=4,
    ),
    "403": Scenario(
        seed=403, duration_s=TEN_MINUTES, size=(640, 360), rate=8, movements=2,
        drape="white", skin="medium", gloves="skin",
    ),
    "404": Scenario(
        seed=404, duration_s=300, size=(640, 360), rate="25/2", movements=((60, 20), (150, 0.6), (220, 4)),
        drape="blue", gloves="skin", heads=4,
    ),
    "405": Scenario(seed=405, duration_s=90, rate=15, skin="dark", gloves="green"),
    "406": Scenario(seed=406, duration_s=90, rate=15, drape="white", heads=4),
    "407": Scenario(seed=407, duration_s=90, rate=15, drape="blue", skin="medium", gloves="skin", clock_offset_s=2.0),
    "408": Scenario(seed=408, duration_s=120, size=(1280, 720), rate="25/2", movements=2, drift_ppm=60),
}  # fmt: skip


def make(folder: Path, name: str) -> Path:
    """The recording's folder, made when it is not there yet."""
    target = folder / name
    if not (target / "truth.json").exists():
        simulate(RECORDINGS[name], target, Silent())
    return target


def elsewhere(work: Callable[..., R], *given: object) -> R:
    """Runs in a process of its own: one that is started later has the memory of who starts it as its own most."""
    with ProcessPoolExecutor(1, get_context("spawn")) as other:
        return other.submit(work, *given).result()


def main() -> None:
    folder = Path(sys.argv[1])
    with ProcessPoolExecutor(2) as workers:
        for made in workers.map(make, [folder] * len(RECORDINGS), RECORDINGS):
            print(made, flush=True)


if __name__ == "__main__":
    main()
