"""Finding plugins: what a wrong one is told, and that two of one name are refused by both names."""

from __future__ import annotations

import types

import pytest

from mcsl_core.alignment.relief.protocol import ReliefScene
from mcsl_core.errors import PluginError, UsageError
from mcsl_core.hooks.registry import discover
from mcsl_core.hooks.specs import hookimpl
from mcsl_core.selection.selectors import Fixed


def plugin(hook: str, result) -> types.ModuleType:
    module = types.ModuleType("theirs")

    def function():
        if isinstance(result, Exception):
            raise result
        return result

    function.__name__ = hook
    setattr(module, hook, hookimpl(function))
    return module


class Mine:
    """Takes the last camera. Always."""

    name = "mine"

    def select(self, table, *, frames, rate):
        return Fixed(table.cameras[-1]).select(table, frames=frames, rate=rate)


def found(module):
    return discover([(module, "their-package", "1.2")], entry_points=False)


def test_a_plugins_object_is_chosen_by_name() -> None:
    plugins = found(plugin("register_selectors", [Mine()]))
    offer = plugins.choose("selector", "mine")
    assert str(offer) == "mine (their-package 1.2)"
    assert offer.summary == "Takes the last camera"
    assert plugins.choose("selector").name == "shortest-path"


def test_an_unknown_name_lists_what_there_is() -> None:
    with pytest.raises(UsageError, match=r"'nosuch'.*shortest-path, through-heads, least-occluded, fixed"):
        discover(entry_points=False).choose("selector", "nosuch")


def test_two_of_one_name_are_refused_with_both_packages() -> None:
    with pytest.raises(PluginError, match=r"mcsl and their-package.*two selector plugins are named 'fixed'"):
        found(plugin("register_selectors", [Fixed()]))


@pytest.mark.parametrize(
    ("module", "message"),
    [
        (plugin("register_selectors", [object()]), "lacks select"),
        (plugin("register_selectors", [Mine]), "offers the class Mine"),
        (plugin("register_selectors", Mine()), "register_selectors returned <"),
        (plugin("register_fillers", [types.SimpleNamespace(name="f", fill=len, version=1)]), "lacks remembers"),
        (plugin("register_selectors", RuntimeError("no licence")), "RuntimeError: no licence"),
        (plugin("register_sellectors", [Mine()]), "register_sellectors"),
    ],
)
def test_a_wrong_plugin_is_named_with_package_and_version(module, message: str) -> None:
    with pytest.raises(PluginError) as caught:
        found(module)
    assert "their-package 1.2" in str(caught.value)
    assert message in str(caught.value)


def test_a_relief_of_their_own_stands_beside_the_built_in_ones() -> None:
    flat = types.SimpleNamespace(name="flat", estimate=lambda scene: None)
    plugins = found(plugin("register_reliefs", [flat]))
    assert plugins.choose("relief", "flat").checked.estimate(ReliefScene((8, 8), {})) is None
    assert {o.name for o in plugins.offers if o.stage == "relief"} == {"plane-sweep", "plane", "flat"}


def test_a_tracker_of_their_own_stands_beside_the_built_in_one() -> None:
    blind = types.SimpleNamespace(name="blind", follow=lambda lamp, before, after, instants: [None] * len(instants))
    plugins = found(plugin("register_trackers", [blind]))
    assert str(plugins.choose("tracker", "blind")) == "blind (their-package 1.2)"
    assert plugins.choose("tracker").name == "background"
    with pytest.raises(PluginError, match=r"register_trackers offers .* which lacks follow"):
        found(plugin("register_trackers", [types.SimpleNamespace(name="lazy")]))
