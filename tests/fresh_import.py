"""Modules that a test writes: imported from their source as it is now, and gone after the test."""

from __future__ import annotations

import importlib
import sys
from types import ModuleType

import pytest


def fresh_import(name: str, patch: pytest.MonkeyPatch) -> ModuleType:
    """The module ``name`` as it is found now, whatever module of that name was imported before.

    No bytecode is written: it would be taken for that of another source of the same length, written in the same second.
    After the test the name means what it meant before it, so that another test's module of that name is not taken
    for its own.
    """
    patch.setitem(sys.modules, name, sys)  # who undoes this brings back what stood there, or nothing
    del sys.modules[name]
    patch.setattr(sys, "dont_write_bytecode", True)
    importlib.invalidate_caches()
    return importlib.import_module(name)
