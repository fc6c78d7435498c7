"""Families of scenes: what operations have that the plain scene lacks, by name.

A family chooses some of a scenario's values, where its maker does not give them, and traits that nothing else sets.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import attrs


@attrs.frozen(kw_only=True)
class Traits:
    """What families add to a scene. As they stand here, they add nothing.

    Attributes
    ----------
    resting : int
        Hands that rest over one place at one height for minutes, every other one holding a retractor. Each hides what
        lies below it, from every camera alike.
    quick : bool
        Whether heads come and go within a second or two.
    limb : bool
        Whether the field is a limb with steep sides and a sutured incision.
    narrow : float
        Size of the field, as a share of the usual one.
    straps : bool
        Whether red straps lie about the field.
    plain : bool
        Whether the drapes are of one colour without folds, threads or things upon them.
    smooth : float
        How much of the skin's and the cloth's fine texture is missing, 0..1.
    floor : bool
        Whether the table is narrow and the floor, 0.85 m below, is seen beside it.
    glare : float
        Strength of the highlights that wander over what is wet, 0..1.
    exposure : float
        By how much exposure is off, in natural logarithms, when a camera begins or the lamp has moved; it settles, and
        pumps by a third of that.
    white_balance : float
        By how much a camera's blue and red drift, in natural logarithms.
    defocus : float
        Standard deviation of one camera's blur, as a share of the picture's width.
    k1 : float
        Largest radial distortion, negative: barrels.
    photograph : bool
        Whether skin, tissue and cloth have the detail of photographs; needs scikit-image.
    """

    resting: int = 0
    quick: bool = False
    limb: bool = False
    narrow: float = 1.0
    straps: bool = False
    plain: bool = False
    smooth: float = 0.0
    floor: bool = False
    glare: float = 0.0
    exposure: float = 0.0
    white_balance: float = 0.0
    defocus: float = 0.0
    k1: float = 0.0
    photograph: bool = False


@attrs.frozen
class Family:
    """A kind of scene.

    Attributes
    ----------
    says
        What it is, for people.
    traits
        Of `Traits`, those that it sets.
    settings
        Of `Scenario`, those that it chooses where they are not given.
    """

    says: str
    traits: Mapping[str, Any] = attrs.field(factory=dict)
    settings: Mapping[str, Any] = attrs.field(factory=dict)


FAMILIES: Mapping[str, Family] = {
    "resting-hand": Family("a hand and a retractor that rest over the field for minutes", {"resting": 2}),
    "bare-hands": Family("hands without gloves", settings={"gloves": "bare"}),
    "limb": Family("a limb with steep sides and a sutured incision", {"limb": True}, {"relief_mm": 48.0}),
    "narrow-field": Family("a field of half the size in a large drape", {"narrow": 0.5}),
    "red-straps": Family("red straps and tan gloves, in the skin's hue", {"straps": True}, {"gloves": "tan"}),
    "smooth-skin": Family("skin and cloth with little texture to match", {"smooth": 0.85}),
    "blown-drape": Family("white drapes blown out", settings={"drape": "blown"}),
    "brown-drape": Family("brown drapes, in the skin's hue", settings={"drape": "brown"}),
    "near-black-skin": Family("skin nearly black", settings={"skin": "near-black"}),
    "monotone-drape": Family("drapes of one colour without folds or things on them", {"plain": True}),
    "floor": Family("a narrow table, the floor in view", {"floor": True}),
    "glare": Family("highlights that wander", {"glare": 0.9}),
    "exposure": Family("exposure that settles and pumps, camera by camera", {"exposure": 0.45}),
    "white-balance": Family("white balance that drifts, camera by camera", {"white_balance": 0.14}),
    "defocus": Family("one camera out of focus, never the reference", {"defocus": 0.0032}),
    "lens": Family("lenses that distort", {"k1": -0.45}),
    "low-bitrate": Family("files of a low bitrate", settings={"crf": 38}),
    "photographic": Family("the detail of photographs (needs scikit-image)", {"photograph": True}),
    "quick-heads": Family("six people whose heads come and go within a second or two", {"quick": True}, {"heads": 6}),
}


def traits_of(names: Iterable[str]) -> Traits:
    """All that these families add."""
    return Traits(**_merged({name: FAMILIES[name].traits for name in names}))


def settings_of(names: Iterable[str]) -> dict[str, Any]:
    """What these families choose of a scenario's values."""
    return _merged({name: FAMILIES[name].settings for name in names})


def check_families(names: Iterable[str]) -> tuple[str, ...]:
    """The names, if all are known, none is there twice and they can be combined; ValueError if not."""
    chosen = tuple(names)
    for name in chosen:
        if name not in FAMILIES:
            raise ValueError(f"there is no family {name!r}; there are {', '.join(FAMILIES)}")
        if chosen.count(name) > 1:
            raise ValueError(f"family {name} is named twice")
    settings_of(chosen)
    traits_of(chosen)
    return chosen


def _merged(chosen: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    by: dict[str, str] = {}
    for name, values in chosen.items():
        for key, value in values.items():
            if found.get(key, value) != value:
                raise ValueError(f"families {by[key]} and {name} want different things of {key}")
            found[key], by[key] = value, name
    return found
