"""What a network wants to see and what its numbers mean: the TOML file beside the .onnx file.

Everything is checked when it is read; a wrong value is refused with the file and the key.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from mcsl_core.hooks import DocumentError, Fault, make_converter, read_toml, structure_document

LAYOUTS = ("NCHW", "NHWC")
COLOURS = ("RGB", "BGR")
MEANINGS = ("softmax", "sigmoid", "probabilities", "labels")
_REMEDY = "See the README of mcsl-onnx-occlusion"


def _one_of(*allowed: str):
    def check(_: Any, attribute: attrs.Attribute, value: str) -> None:
        if value not in allowed:
            raise Fault(f"must be one of {', '.join(allowed)}, got {value!r}", f".{attribute.name}")

    return check


def _classes(_: Any, attribute: attrs.Attribute, value: tuple[int, ...]) -> None:
    if any(number < 0 for number in value) or len(set(value)) != len(value):
        raise Fault(f"must be different class numbers from 0 on, got {list(value)}", f".{attribute.name}")


def _size(_: Any, attribute: attrs.Attribute, value: tuple[int, int] | None) -> None:
    if value is not None and not all(8 <= side <= 4096 for side in value):
        raise Fault(f"must be [width, height], 8 to 4096 pixels each, got {list(value)}", f".{attribute.name}")


def _above_0(_: Any, attribute: attrs.Attribute, value: float | tuple[float, ...]) -> None:
    if any(number <= 0 for number in (value if isinstance(value, tuple) else (value,))):
        raise Fault(f"must be above 0, got {value}", f".{attribute.name}")


@frozen
class Input:
    """size: [width, height] that a picture is brought to; without it the network's own. layout: order of its axes.

    colour: order of the three channels. A value of the picture, 0 to 255, is handed over as
    (value * scale - mean) / deviation, mean and deviation in the order of ``colour``.
    """

    size: tuple[int, int] | None = field(default=None, validator=_size)
    layout: str = field(default="NCHW", validator=_one_of(*LAYOUTS))
    colour: str = field(default="RGB", validator=_one_of(*COLOURS))
    scale: float = field(default=1 / 255, validator=_above_0)
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    deviation: tuple[float, float, float] = field(default=(1.0, 1.0, 1.0), validator=_above_0)


@frozen
class Output:
    """meaning: what the numbers are. name: which output, the first without. layout: order of its axes.

    softmax: one channel a class, before softmax. sigmoid: one channel a class, before sigmoid, each for itself.
    probabilities: one channel a class, already 0 to 1. labels: no channels, the class's number at each pixel.
    field, occluder: the classes that are the surgical field, and those that are in the way of it; one of them may be
    missing. threshold: from this probability on a pixel is of them.
    """

    meaning: str = field(validator=_one_of(*MEANINGS))
    name: str | None = None
    layout: str = field(default="NCHW", validator=_one_of(*LAYOUTS))
    field: tuple[int, ...] = attrs.field(default=(), validator=_classes)
    occluder: tuple[int, ...] = attrs.field(default=(), validator=_classes)
    threshold: float = attrs.field(default=0.5)

    def __attrs_post_init__(self) -> None:
        if not self.field and not self.occluder:
            raise Fault("must name at least one class, or occluder must", ".field")
        if both := sorted({*self.field} & {*self.occluder}):
            raise Fault(f"class {both[0]} is the field as well", ".occluder")
        if not 0 < self.threshold < 1:
            raise Fault(f"must lie between 0 and 1, got {self.threshold}", ".threshold")


@frozen
class Description:
    """All that must be known about a network to use it."""

    output: Output
    input: Input = attrs.field(factory=Input)


def read_description(path: Path) -> Description:
    """The description in ``path``; InputError where there is none, DocumentError with the key where one is wrong."""
    value = read_toml(path, wanted="a network's description", remedy=_REMEDY)
    try:
        return structure_document(value, Description, make_converter(), where=str(path), name="")
    except DocumentError as error:
        raise DocumentError(
            error.what, where=error.where.replace("$.", "").replace("$", "top"), remedy=_REMEDY
        ) from error
