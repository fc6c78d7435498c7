"""Plugins that need something of the user's to run, such as a model, bring it themselves.

One that does has a `tests/contract_setup.py` with ``prepare(folder) -> environment variables``.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

import pytest

PLUGINS = Path(__file__).resolve().parents[2] / "plugins"


@pytest.fixture(scope="session", autouse=True)
def prepared_plugins(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Every installed plugin of ours as a user has it who did what its README says."""
    with pytest.MonkeyPatch.context() as patch:
        for script in sorted(PLUGINS.glob("*/tests/contract_setup.py")):
            name = script.parents[1].name
            try:
                metadata.distribution(name)
            except metadata.PackageNotFoundError:
                continue
            patch.syspath_prepend(script.parent)
            spec = importlib.util.spec_from_file_location(f"contract_setup_of_{name.replace('-', '_')}", script)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            sys.modules[spec.name] = module
            spec.loader.exec_module(module)
            for variable, value in module.prepare(tmp_path_factory.mktemp(name)).items():
                patch.setenv(variable, value)
        yield
