"""What the contract suite needs to run this plugin: a model, of frames marked in another operation than it is shown."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import marking
from mcsl_learned_occlusion.labelling import read_marked
from mcsl_learned_occlusion.training import Training, train

from mcsl_core.hooks import Silent


def prepare(folder: Path) -> Mapping[str, str]:
    """The environment variables it is run with."""
    marked = []
    for seed, drape in ((1, (70, 120, 40)), (2, (120, 80, 40)), (3, (150, 150, 150))):
        marking.mark(marking.Operation(seed, drape), folder / str(seed))
        marked += read_marked(folder / str(seed))
    model, _ = train(marked, Silent(), Training(folds=2))
    model.save(folder / "model.npz")
    return {"MCSL_LEARNED_MODEL": str(folder / "model.npz")}
