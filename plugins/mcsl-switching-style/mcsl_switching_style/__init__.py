"""Selectors that cut as an editor would: what a viewer gains by seeing more, less what every cut costs him.

A style says what cuts cost (`style.Style`); of all ways to cut the recording the one worth most is taken, exactly
(`planning.best_path`). Three styles have names of their own; one more is read from the file that MCSL_STYLE names.
"""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import attrs
from attrs import field, frozen

from mcsl_core.hooks import InputError, ScoreTable, Shot, hookimpl, read_toml, sample_borders, shots_from

from .planning import best_path
from .style import CALM, CLOSE, TEACHING, Style, costs_of

__all__ = ["CALM", "CLOSE", "TEACHING", "Style", "StyleSelector", "load_style"]

VARIABLE = "MCSL_STYLE"


@frozen
class StyleSelector:
    """Cuts as an editor would in this style; see the package's README."""

    name: str
    style: Style

    @property
    def min_shot_s(self) -> float:
        """What the style promises; mcsl keeps it when it moves the cuts to the frame."""
        return self.style.min_shot_s

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> tuple[Shot, ...]:
        """Shots that tile [0, frames), the best of all in this style."""
        borders = sample_borders(table, frames)
        choice = best_path(costs_of(self.style, table, borders, float(rate)))
        return shots_from(choice, table, borders, f"{self.name}: {{visible}}{{next}}")


@frozen
class CalmStyle(StyleSelector):
    """Long shots: cuts away only where the field is lost for a while."""

    name: str = field(default="style-calm", init=False)
    style: Style = field(default=CALM, init=False)


@frozen
class CloseStyle(StyleSelector):
    """Close on the field: whoever sees it best, in shots of at least a second and a half."""

    name: str = field(default="style-close", init=False)
    style: Style = field(default=CLOSE, init=False)


@frozen
class TeachingStyle(StyleSelector):
    """One camera that learners know their way in, the first; another only while that one is blocked, then back."""

    name: str = field(default="style-teaching", init=False)
    style: Style = field(default=TEACHING, init=False)


@frozen
class OwnStyle:
    """The style in the TOML file that MCSL_STYLE names."""

    path: Path
    name = "style-own"

    @property
    def min_shot_s(self) -> float:
        """See `StyleSelector.min_shot_s`; InputError names what is wrong with the file."""
        return load_style(self.path).min_shot_s

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> tuple[Shot, ...]:
        """Shots that tile [0, frames); InputError names what is wrong with the file."""
        return StyleSelector(self.name, load_style(self.path)).select(table, frames=frames, rate=rate)


def load_style(path: Path) -> Style:
    """The style in a TOML file: `base`, the name of the style it starts from (calm), and what it does otherwise."""
    remedy = f"See the table in the README of mcsl-switching-style, or unset {VARIABLE}"
    values = read_toml(path, wanted="a style", remedy=remedy)
    try:
        bases = {"calm": CALM, "close": CLOSE, "teaching": TEACHING}
        base = values.pop("base", "calm")
        if not isinstance(base, str) or base not in bases:
            raise ValueError(f"base is {base!r}, expected one of {', '.join(bases)}")
        kinds = {f.name: type(f.default) for f in attrs.fields(Style)}
        for name, value in values.items():
            if name not in kinds:
                raise ValueError(f"there is no {name!r}, expected one of {', '.join(kinds)}")
            if not isinstance(value, kinds[name]) and (type(value), kinds[name]) != (int, float):
                raise ValueError(f"{name} is {value!r}, expected a {'text' if kinds[name] is str else 'number'}")
        return attrs.evolve(bases[base], **{n: v if kinds[n] is str else float(v) for n, v in values.items()})
    except (ValueError, OverflowError) as error:
        raise InputError(str(error.args[0]), where=str(path), remedy=remedy) from error  # a validator says more


@hookimpl
def register_selectors():
    own = os.environ.get(VARIABLE)
    return [CalmStyle(), CloseStyle(), TeachingStyle(), *([OwnStyle(Path(own))] if own else [])]
