"""Finding plugins and choosing stages by name. Two of one name is an error that names both packages."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from functools import cache, cached_property
from importlib import metadata
from threading import Timer
from typing import Any

import attrs
import pluggy
from attrs import field, frozen

from mcsl_core import __version__
from mcsl_core.edl import Edl
from mcsl_core.errors import PluginError, UsageError
from mcsl_core.filling.protocol import Filler
from mcsl_core.progress import Progress

from . import builtin
from .specs import PROJECT, Hooks
from .stage_guards import GUARDS
from .stages import STAGES, Stage
from .watch import Watch

log = logging.getLogger(__name__)
_SLOW_S = 30  # torch takes ten seconds on a cold disk


@frozen(eq=False)
class Offer:
    """One named object of one package.

    Attributes
    ----------
    stage : str
        The stage it does; see `STAGES`.
    name : str
        By which it is chosen.
    package, version : str
        Where it comes from.
    implementation : object
        What the package registered.
    watch : Watch, optional
        Who is told how long it takes.
    """

    stage: str
    name: str
    package: str
    version: str
    implementation: Any
    watch: Watch | None = field(default=None)

    @cached_property
    def checked(self) -> Any:
        """The object as the pipeline calls it, behind its stage's checks; see `stage_guards`."""
        return GUARDS[self.stage](self.implementation, self.stage, str(self), self.package, self.watch)

    def prepare(self) -> None:
        """Have the object load what it needs, where it can: what is missing is told before long work begins."""
        if callable(getattr(self.implementation, "prepare", None)):
            self.checked.call("prepare")

    def __str__(self) -> str:
        return f"{self.name} ({self.package} {self.version})"

    @property
    def summary(self) -> str:
        """The first sentence of its description."""
        text = " ".join((type(self.implementation).__doc__ or "").split())
        return text.split(". ")[0].rstrip(".")


@frozen(eq=False)
class Plugins:
    """Everything on offer, by stage and name.

    Attributes
    ----------
    offers : tuple of Offer
        In order.
    left_out : tuple of PluginError
        What is wrong with each installed plugin that cannot be used.
    """

    offers: tuple[Offer, ...]
    left_out: tuple[PluginError, ...] = ()

    def choose(self, stage: str, name: str | None = None) -> Offer:
        """Choose the object for a stage.

        Parameters
        ----------
        stage : str
            See `STAGES`.
        name : str, optional
            The object's; the stage's default without.

        Returns
        -------
        Offer

        Raises
        ------
        UsageError
            Where nothing has that name; lists what there is.
        """
        name = name or STAGES[stage].default
        for offer in self.offers:
            if (offer.stage, offer.name) == (stage, name):
                return offer
        known = ", ".join(o.name for o in self.offers if o.stage == stage)
        if self.left_out:  # it may be the one that brings it
            told = "; ".join(f"{error.where} {error.what}" for error in self.left_out)
            raise PluginError(
                f"there is no {STAGES[stage].noun} named {name!r}, but {told}",
                remedy=f"Repair that plugin, or choose one of {known}",
            )
        raise UsageError(
            f"there is no {STAGES[stage].noun} named {name!r}",
            remedy=f"Choose one of {known}, or install the plugin that brings it (`mcsl plugins` lists all)",
        )


def filler_of(edl: Edl, progress: Progress | None = None) -> Filler:
    """The filler that an EDL was made with, the default where it does not say.

    Parameters
    ----------
    edl : Edl
        The programme.
    progress : Progress, optional
        Where it is told that the filler is slow.

    Returns
    -------
    Filler

    Raises
    ------
    PluginError
        Names the package to install where the filler is not here.
    """
    offer = filler_offer(edl)
    if progress is not None:
        offer = attrs.evolve(offer, watch=Watch(float(edl.frames / edl.rate), progress.note))
    return offer.checked


def filler_offer(edl: Edl) -> Offer:
    """As `filler_of`, the offer itself."""
    made = edl.made_by.plugins.get("filler", "") if edl.made_by else ""
    name, _, package = made.partition(" (")
    try:
        return discover().choose("filler", name or None)
    except UsageError as error:  # a PluginError names the one that cannot be used
        raise PluginError(
            f"was made with the filler {made}, which is not installed",
            where="the EDL",
            remedy=f"Install {package.rstrip(')') or 'it'}, or analyse again with another --filler",
        ) from error


def discover(extra: Sequence[tuple[object, str, str]] = (), *, entry_points: bool = True) -> Plugins:
    """Everything on offer: the built-ins, the plugins installed under the entry-point group ``mcsl``, and extra ones.

    Parameters
    ----------
    extra : sequence of (object, str, str)
        Module or object with hook functions, its package and version.
    entry_points : bool
        Whether installed plugins are found.

    Returns
    -------
    Plugins

    Raises
    ------
    PluginError
        Names what is wrong with whom: two objects of one name, or one of ``extra`` that cannot be used. What is
        installed and cannot be used is left out with a warning.
    """
    found = [offer for source in [(builtin, "mcsl", __version__), *extra] for offer in _offers(*source)]
    left_out: list[PluginError] = []
    for point in sorted(metadata.entry_points(group=PROJECT), key=lambda p: p.name) if entry_points else ():
        try:
            found += _offers(*_loaded(point))
        except PluginError as error:
            left_out.append(error)
            _warn(f"{error.where} {error.what}: it is left out. {error.remedy}")
    offers: dict[tuple[str, str], Offer] = {}
    for offer in found:
        key = (offer.stage, offer.name)
        if key in offers:
            raise PluginError(
                f"two {offer.stage} plugins are named {offer.name!r}",
                where=f"{offers[key].package} and {offer.package}",
                remedy="Uninstall one of them, or have its author rename it",
            )
        offers[key] = offer
    return Plugins(tuple(offers.values()), tuple(left_out))


@cache
def _warn(text: str) -> None:
    """Once, however often plugins are looked for."""
    log.warning("%s", text)


def _loaded(point: metadata.EntryPoint) -> tuple[object, str, str]:
    package = point.dist.name if point.dist else point.value
    version = point.dist.version if point.dist else "?"
    where = f"plugin {package} {version} ({point.value})"
    # What hangs cannot be ended, but named.
    slow = Timer(_SLOW_S, _warn, [f"{where} has been importing for {_SLOW_S} s. If that is wrong, uninstall {package}"])
    slow.daemon = True
    slow.start()
    try:
        return point.load(), package, version
    except (Exception, SystemExit) as error:  # a plugin that ends the program is no reason to end
        raise PluginError(
            f"cannot be imported: {type(error).__name__}: {error}",
            where=where,
            remedy=f"Repair or uninstall it: pip uninstall {package}",
        ) from error
    finally:
        slow.cancel()


def _offers(source: object, package: str, version: str) -> list[Offer]:
    """What one plugin registers, checked."""
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(Hooks)
    who = f"plugin {package} {version}"
    try:
        manager.register(source)
        manager.check_pending()
    except pluggy.PluginValidationError as error:
        raise PluginError(str(error), where=who, remedy="Its hooks must be those of docs/hooks.md") from error
    return [
        Offer(stage, _name(implementation, kind, who), package, version, implementation)
        for stage, kind in STAGES.items()
        for implementation in _registered(manager, kind, who)
    ]


def _registered(manager: pluggy.PluginManager, kind: Stage, who: str) -> Iterator[object]:
    """The objects that a plugin's hook for one stage returns."""
    try:
        results = getattr(manager.hook, kind.hook)()
    except (Exception, SystemExit) as error:
        raise PluginError(
            f"{kind.hook} failed: {type(error).__name__}: {error}", where=who, remedy="Repair or uninstall it"
        ) from error
    for result in results:
        if not isinstance(result, Sequence):
            raise PluginError(f"{kind.hook} returned {result!r}", where=who, remedy="It must return a list")
    for result in results:
        yield from result


def _name(implementation: object, kind: Stage, who: str) -> str:
    """The object's name; it must be an object, and have one and all else that its stage needs."""
    if isinstance(implementation, type):
        raise PluginError(
            f"{kind.hook} offers the class {implementation.__qualname__}",
            where=who,
            remedy=f"It must offer objects: {implementation.__qualname__}()",
        )
    name = getattr(implementation, "name", None)
    lacking = [method for method in kind.methods if not callable(getattr(implementation, method, None))]
    lacking += [number for number in kind.numbers if not isinstance(getattr(implementation, number, None), int)]
    if not isinstance(name, str) or not name or lacking:
        raise PluginError(
            f"{kind.hook} offers {implementation!r}, which lacks {', '.join(lacking) or 'a name'}",
            where=who,
            remedy="See the protocol in docs/hooks.md",
        )
    return name
