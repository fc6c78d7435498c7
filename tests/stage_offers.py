"""Every installed implementation of a stage, and those that docs/hooks.md shows, as parameters of a test."""

from __future__ import annotations

import pytest
from hooks_page import shown_plugins

from mcsl_core.hooks.registry import Offer, discover

ALL = discover(shown_plugins()).offers


def offers(stage: str):
    """One test for each plugin of a stage; skipped where it says that libraries it needs are not installed."""
    return pytest.mark.parametrize(
        "offer", [pytest.param(o, id=o.name, marks=lacking(o)) for o in ALL if o.stage == stage]
    )


def lacking(offer: Offer) -> list[pytest.MarkDecorator]:
    missing = getattr(offer.implementation, "missing", list)()
    return [pytest.mark.skip(reason=f"{offer} needs {', '.join(missing)}")] if missing else []
