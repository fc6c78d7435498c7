"""What the contract suite needs to run this plugin: a network that knows red from green and blue."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import networks


def prepare(folder: Path) -> Mapping[str, str]:
    """The environment variables it is run with."""
    network = networks.reddish(folder / "reddish.onnx", size=(240, 136))
    network.with_suffix(".toml").write_text('[output]\nmeaning = "sigmoid"\nfield = [0]\n')
    return {"MCSL_ONNX_MODEL": str(network)}
