"""Plugins behind checks: what goes in cannot be changed, what comes out is what the protocol promises, time is told.

The pipeline calls every plugin, the built-ins too, through the guard of its stage (`registry.Offer.checked`, one of
`stage_guards`). Whatever a plugin does wrong is a `PluginError` of one line that names stage, plugin, package and
version, and says what to do.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeVar

import attrs
import numpy as np
from attrs import field, frozen

from mcsl_core.errors import Cancelled, McslError, PluginError

from .stages import STAGES
from .watch import Watch

T = TypeVar("T")


def read_only(value: T) -> T:
    """The same value, none of whose arrays and mappings can be written to; no array is copied."""
    if isinstance(value, np.ndarray):
        locked = value.view()
        locked.flags.writeable = False
        return locked  # pyright: ignore[reportReturnType]
    if isinstance(value, Mapping):
        return MappingProxyType({key: read_only(item) for key, item in value.items()})  # pyright: ignore
    if isinstance(value, tuple):
        return tuple(read_only(item) for item in value)  # pyright: ignore[reportReturnType]
    if attrs.has(type(value)):
        changed = {f.alias: read_only(getattr(value, f.name)) for f in attrs.fields(type(value)) if f.init}
        return attrs.evolve(value, **changed)  # pyright: ignore[reportArgumentType]
    return value


@frozen(eq=False)
class Guard:
    """One plugin's object behind its stage's checks.

    Attributes
    ----------
    implementation : object
        What the plugin registered.
    stage : str
        The stage it does; see `STAGES`.
    label : str
        "name (package version)".
    package : str
        Where it comes from.
    watch : Watch, optional
        Who is told how long it takes.
    """

    implementation: Any
    stage: str
    label: str
    package: str
    watch: Watch | None = field(default=None)

    @property
    def name(self) -> str:
        return self.implementation.name

    @property
    def who(self) -> str:
        """What the plugin is called in errors and notes."""
        return f"{STAGES[self.stage].noun} {self.label}"

    def call(self, method: str, *given: Any, on: Any = None, **named: Any) -> Any:
        """Call a method of the plugin's object and take its time.

        Parameters
        ----------
        method : str
            The method's name.
        *given, **named
            Its arguments.
        on : object, optional
            Another object of the plugin's, in place of ``implementation``.

        Returns
        -------
        object
            What the method returns.

        Raises
        ------
        PluginError
            In place of whatever the method raises, in the plugin's name; `Cancelled` stays what it is.
        McslError
            As the method raised it, with the plugin's name added: it is said for people already.
        """
        began = time.monotonic()
        try:
            return getattr(self.implementation if on is None else on, method)(*given, **named)
        except Cancelled:
            raise
        except McslError as error:
            if self.package != "mcsl" and self.label not in error.where:
                error.where = f"{self.who}: {error.where}" if error.where else self.who
            raise
        except Exception as error:
            raise self.fault(f"{method} raised {type(error).__name__}: {' '.join(str(error).split())}") from error
        finally:
            if self.watch is not None and self.package != "mcsl":
                self.watch.spent(self.who, time.monotonic() - began)

    def fault(self, what: str) -> PluginError:
        """The error that says ``what`` the plugin did wrong."""
        remedy = f"Report it to the author of {self.package}, or choose another with --{self.stage}"
        return PluginError(what.rstrip("."), where=self.who, remedy=remedy)

    def need(self, holds: bool, what: str) -> None:
        """Raise the `fault` ``what`` unless it ``holds``."""
        if not holds:
            raise self.fault(what)

    def need_kind(self, method: str, value: object, kind: type) -> None:
        """Raise a `fault` unless what ``method`` returned is of the type ``kind``."""
        self.need(isinstance(value, kind), f"{method} gave {described(value)}, expected {kind.__name__}")


def described(value: object) -> str:
    """What a plugin gave, in a few words for an error."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} and shape {value.shape}"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def is_number(value: object) -> bool:
    """Whether it is one, and finite."""
    return isinstance(value, (int, float, np.integer, np.floating)) and bool(np.isfinite(value))
