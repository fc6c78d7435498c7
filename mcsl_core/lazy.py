"""Names of a package that are imported when they are first asked for (PEP 562): what nobody uses costs nothing."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, names: Mapping[str, Sequence[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` for the package of that name.

    names: module -> what comes from it. Type checkers do not follow it: write the same imports under
    ``if TYPE_CHECKING`` as well.
    """
    homes = {name: module for module, its in names.items() for name in its}

    def get(name: str) -> Any:
        if name not in homes:  # AttributeError: ``from package import module`` then looks for a module of that name
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(homes[name]), name)
        setattr(sys.modules[package], name, value)  # from now on it is found without asking here
        return value

    def known() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes})

    return get, known
