"""What is to be simulated: one frozen value, checked when it is made. Lengths in mm, times in seconds.

Everything drawn from chance comes from ``Scenario.stream(name)``, so a change in one part of the simulator
leaves the others as they were, and the same scenario always gives the same recording.
"""

from __future__ import annotations

import zlib
from fractions import Fraction
from typing import Any

import attrs
import numpy as np

from mcsl_core.timing import parse_rate

from .families import Traits, check_families, settings_of, traits_of

DRAPES = ("green", "blue", "white", "skin", "brown", "blown")
SKINS = ("light", "medium", "dark", "near-black")
GLOVES = ("white", "blue", "skin", "green", "tan", "bare")


def _within(low: float, high: float):
    def check(_: object, attribute: attrs.Attribute, value: float) -> None:
        if not low <= value <= high:
            raise ValueError(f"{attribute.name} must lie between {low} and {high}, got {value}")

    return check


def _one_of(choices: tuple[str, ...]):
    def check(_: object, attribute: attrs.Attribute, value: str) -> None:
        if value not in choices:
            raise ValueError(f"{attribute.name} must be one of {', '.join(choices)}, got {value!r}")

    return check


def _chosen(name: str, usual: object) -> Any:
    """What the scenario's families choose for a value that is not given, or the usual one."""
    return attrs.Factory(lambda self: settings_of(self.families).get(name, usual), takes_self=True)


def _relief(self: Scenario) -> float:
    """What its families choose, or 35 mm; a smaller field has less."""
    return settings_of(self.families).get("relief_mm", 35.0) * self.traits.narrow


def _even_size(_: object, attribute: attrs.Attribute, value: tuple[int, int]) -> None:
    if len(value) != 2 or any(v % 2 or not 64 <= v <= 4096 for v in value):
        raise ValueError(f"{attribute.name} must be (width, height), both even and 64 to 4096, got {value}")


def _movements(value: int | tuple) -> int | tuple[tuple[float, float], ...]:
    if isinstance(value, int):
        return value
    return tuple((float(start), float(length)) for start, length in value)


def _size(value: tuple[int, int]) -> tuple[int, int]:
    return value[0], value[1]


def _rate(value: Fraction | int | str) -> Fraction:
    rate = parse_rate(value) if isinstance(value, str) else Fraction(value)
    if not 1 <= rate <= 240:
        raise ValueError(f"rate must lie between 1 and 240 frames a second, got {value}")
    return rate


@attrs.frozen(kw_only=True)
class Scenario:
    """A simulated operation: what is filmed, for how long, and by which cameras.

    Parameters
    ----------
    families
        Names of `FAMILIES`: what is unlike the plain scene. They choose ``drape``, ``skin``, ``gloves``, ``heads``,
        ``relief_mm`` and ``crf`` where these are not given.
    seed
        Of everything drawn from chance.
    duration_s
        Of the programme, 0.5 s to a day.
    size
        (width, height) of the pictures, even.
    rate
        Frames per second, 1 to 240.
    cameras
        1 to 9.
    movements
        How many lamp movements (placed by chance), or each one's (start_s, length_s) in programme time.
    keyframe_s
        From one keyframe to the next.
    clock_offset_s, drift_ppm
        Largest absolute clock offset and drift of the cameras other than the reference.
    relief_mm
        Height span of the surgical field (1st to 99th percentile); 0 makes it flat.
    drape, skin, gloves
        Colours: one of `DRAPES`, `SKINS`, `GLOVES`.
    heads
        People whose heads lean into the pictures, 0 to 8.
    hands
        Gloved hands that work in the field, 0 to 4.
    noise
        Sensor noise, standard deviation in luma levels of 255.
    crf
        Of x264, 0 (lossless) to 51.
    audio
        Whether the files have audio.

    Raises
    ------
    ValueError
        Where a value is out of range, movements overlap or do not fit into the duration, or families are unknown or
        contradict each other.

    Examples
    --------
    >>> Scenario(seed=1, duration_s=10, movements=((4.0, 1.5),)).camera_names
    ('cam1', 'cam2', 'cam3', 'cam4', 'cam5')
    """

    families: tuple[str, ...] = attrs.field(default=(), converter=check_families)  # first: others ask for it
    seed: int = attrs.field(default=0, validator=_within(0, 2**32 - 1))
    duration_s: float = attrs.field(default=60.0, converter=float, validator=_within(0.5, 24 * 3600))
    size: tuple[int, int] = attrs.field(default=(960, 540), converter=_size, validator=_even_size)
    rate: Fraction = attrs.field(default=Fraction(30000, 1001), converter=_rate)
    cameras: int = attrs.field(default=5, validator=_within(1, 9))
    movements: int | tuple[tuple[float, float], ...] = attrs.field(default=1, converter=_movements)
    keyframe_s: float = attrs.field(default=1.0, converter=float, validator=_within(0.02, 60))
    clock_offset_s: float = attrs.field(default=0.3, converter=float, validator=_within(0, 30))
    drift_ppm: float = attrs.field(default=20.0, converter=float, validator=_within(0, 1000))
    relief_mm: float = attrs.field(
        default=attrs.Factory(_relief, takes_self=True), converter=float, validator=_within(0, 80)
    )
    drape: str = attrs.field(default=_chosen("drape", "green"), validator=_one_of(DRAPES))
    skin: str = attrs.field(default=_chosen("skin", "light"), validator=_one_of(SKINS))
    gloves: str = attrs.field(default=_chosen("gloves", "white"), validator=_one_of(GLOVES))
    heads: int = attrs.field(default=_chosen("heads", 3), validator=_within(0, 8))
    hands: int = attrs.field(default=3, validator=_within(0, 4))
    noise: float = attrs.field(default=1.2, converter=float, validator=_within(0, 10))
    crf: int = attrs.field(default=_chosen("crf", 20), validator=_within(0, 51))
    audio: bool = True

    def __attrs_post_init__(self) -> None:
        if isinstance(self.movements, int):
            if self.movements < 0:
                raise ValueError(f"movements must not be negative, got {self.movements}")
            if self.movements * 8.0 > self.duration_s:
                raise ValueError(
                    f"a movement needs 8 s, so {self.movements} need {self.movements * 8} s at least; "
                    f"the recording has {self.duration_s:g} s: make it longer or give their times yourself"
                )
            return
        last = 0.0
        for start, length in sorted(self.movements):
            if length < 0.2 or start <= last or start + length >= self.duration_s:
                raise ValueError(
                    f"movement (start_s={start:g}, length_s={length:g}) must last 0.2 s or more, lie within the "
                    f"recording's {self.duration_s:g} s and begin after the one before it has ended"
                )
            last = start + length

    @property
    def traits(self) -> Traits:
        """What its families add to the scene."""
        return traits_of(self.families)

    @property
    def frames(self) -> int:
        """Frames of the programme, which are those of the reference camera."""
        return max(1, int(self.duration_s * self.rate))

    @property
    def camera_names(self) -> tuple[str, ...]:
        """cam1, cam2, ...; the first is the reference."""
        return tuple(f"cam{n + 1}" for n in range(self.cameras))

    def stream(self, *name: object) -> np.random.Generator:
        """The random generator of one named part of this scenario."""
        words = [zlib.crc32(str(part).encode()) for part in name]
        return np.random.default_rng([self.seed, *words])
