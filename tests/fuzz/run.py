"""Fuzzing by hand: ``python -m tests.fuzz.run KIND --runs N`` (all: every kind), from the project's folder.

With ``--atheris`` coverage leads the way: it needs atheris, which no other part of the project does. An input that
brings out anything but our own errors is kept in the folder ``build/fuzz``, and its traceback is shown.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

FOUND = Path("build/fuzz")


def loop(kind: str, runs: int, seed: int) -> int:
    """Valid inputs changed by chance; returns how many brought out something else than our errors."""
    from .harnesses import HARNESSES
    from .mutation import mutated

    harness, random = HARNESSES[kind], Random(seed)
    taken, faults = 0, {}
    with tempfile.TemporaryDirectory(prefix="mcsl-fuzz-") as folder:
        for _ in range(runs):
            data = mutated(random.choice(harness.seeds), random)
            try:
                taken += harness.run(Path(folder), data)
            except Exception as error:
                frame = traceback.extract_tb(error.__traceback__)[-1]
                faults.setdefault((type(error).__name__, frame.filename, frame.lineno), (data, error))
    for data, error in faults.values():
        keep(kind, data)
        traceback.print_exception(error)
    print(f"{kind}: {runs} inputs, {taken} taken, {runs - taken} refused, {len(faults)} faults", flush=True)
    return len(faults)


def led(kind: str, runs: int, seed: int) -> None:
    """atheris: inputs that reach new code are changed further; ends the process."""
    import atheris

    with atheris.instrument_imports(include=["mcsl_core", "mcsl_onnx_occlusion", "mcsl_switching_style"]):
        from .harnesses import HARNESSES
        from .mutation import mutated
    harness = HARNESSES[kind]
    with tempfile.TemporaryDirectory(prefix="mcsl-fuzz-") as name:
        corpus, folder = Path(name) / "corpus", Path(name) / "files"
        for made in (corpus, folder, FOUND):
            made.mkdir(parents=True, exist_ok=True)
        for number, data in enumerate(harness.seeds):
            (corpus / str(number)).write_bytes(data)

        def change(data: bytes, most: int, number: int) -> bytes:
            return mutated(data, Random(number))[:most]

        change_any: Callable[..., Any] = change
        options = [f"-runs={runs}", f"-seed={seed}", "-max_len=200000", f"-artifact_prefix={FOUND}/{kind}-"]
        atheris.Setup(
            [sys.argv[0], *options, "-print_final_stats=1", str(corpus)],
            lambda data: harness.run(folder, data) and None,
            custom_mutator=change_any,
        )
        atheris.Fuzz()


def keep(kind: str, data: bytes) -> None:
    FOUND.mkdir(parents=True, exist_ok=True)
    (FOUND / f"{kind}-{hashlib.sha256(data).hexdigest()[:12]}").write_bytes(data)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind")
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--atheris", action="store_true")
    given = parser.parse_args()
    if given.atheris:
        led(given.kind, given.runs, given.seed)
        return 0
    from .harnesses import HARNESSES

    kinds = list(HARNESSES) if given.kind == "all" else [given.kind]
    return 1 if sum(loop(kind, given.runs, given.seed) for kind in kinds) else 0


if __name__ == "__main__":
    sys.exit(main())
