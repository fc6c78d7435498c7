"""The classifier as plain arrays in an .npz file: nothing in it is code, so a model from elsewhere does no harm.

A small network with two hidden layers, one softmax over the classes. Trained by scikit-learn, run by numpy.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.hooks import InputError, read_arrays, write_atomic

from .features import NAMES, Float

SCHEMA = "mcsl.learned-occlusion/1"
CLASSES = ("field", "in the way", "elsewhere")
_REMEDY = "Train it again with `mcsl-label train`"
_MOST_BYTES = 16 << 20  # unpacked; a model takes some 50 kB


@frozen(eq=False)
class Model:
    """mean, deviation: (F,) of the features. weights: per layer (in, out) and (out,). classes: of `CLASSES`, in order.

    about: what it was trained on and how well it did, for people.
    """

    mean: Float
    deviation: Float
    weights: tuple[tuple[Float, Float], ...]
    classes: tuple[str, ...]
    about: dict[str, Any]

    def probabilities(self, values: Float) -> Float:
        """(..., classes) of (..., F) features."""
        layer = (values.reshape(-1, values.shape[-1]) - self.mean) / self.deviation
        layer = np.clip(layer, -6, 6)  # what was never seen in training must not run away
        for number, (weight, bias) in enumerate(self.weights):
            layer = layer @ weight + bias
            if number < len(self.weights) - 1:
                layer = np.maximum(layer, 0)
        layer = np.exp(layer - layer.max(axis=1, keepdims=True))
        layer /= layer.sum(axis=1, keepdims=True)
        return layer.reshape(*values.shape[:-1], len(self.classes))

    def save(self, path: Path) -> None:
        """Writes it atomically; the same model gives the same bytes."""
        arrays: dict[str, NDArray] = {"mean": self.mean, "deviation": self.deviation}
        for number, (weight, bias) in enumerate(self.weights):
            arrays |= {f"weight{number}": weight, f"bias{number}": bias}
        head = {"schema": SCHEMA, "features": list(NAMES), "classes": list(self.classes), "about": self.about}
        stream = io.BytesIO()
        np.savez_compressed(stream, head=np.array(json.dumps(head)), **arrays)  # pyright: ignore[reportArgumentType]
        write_atomic(path, stream.getvalue())

    @classmethod
    def load(cls, path: Path) -> Model:
        """The model in ``path``; InputError says what is wrong with a file that holds none."""
        if not path.is_file():
            raise InputError("is not there", where=str(path), remedy="MCSL_LEARNED_MODEL must name a model's .npz file")
        arrays = read_arrays(path, wanted="a model of mcsl-label", remedy=_REMEDY, most=_MOST_BYTES)
        try:
            head = json.loads(str(arrays.pop("head")[()]))
            layers = sum(name.startswith("weight") for name in arrays)
            weights = tuple((arrays[f"weight{n}"], arrays[f"bias{n}"]) for n in range(layers))
            model = cls(arrays["mean"], arrays["deviation"], weights, tuple(head["classes"]), dict(head["about"]))
            fault = _fault(model, head)
        except Exception as error:  # a missing array, JSON that is none, arrays and lists of any other form
            why = f"{type(error).__name__}: {' '.join(str(error).split())}"
            raise InputError(f"is not a model of mcsl-label ({why})", where=str(path), remedy=_REMEDY) from error
        if fault:
            raise InputError(fault, where=str(path), remedy=_REMEDY)
        return model


def _fault(model: Model, head: dict[str, Any]) -> str:
    """What is wrong with a model that was read; empty where nothing is."""
    if head.get("schema") != SCHEMA:
        return f"its schema is {head.get('schema')!r}, expected {SCHEMA!r}"
    if tuple(head.get("features", ())) != NAMES:
        return "it was trained on other features than this version has"
    if model.classes[:2] != CLASSES[:2] or not set(model.classes) <= set(CLASSES):
        return f"its classes are {', '.join(model.classes)}, expected {', '.join(CLASSES)}"
    sizes = [len(NAMES), *(weight.shape[-1] for weight, _ in model.weights)]
    shapes = [(a, b) for a, b in zip(sizes, sizes[1:], strict=False)]
    whole = [
        weight.shape == shape and bias.shape == shape[1:]
        for (weight, bias), shape in zip(model.weights, shapes, strict=True)
    ]
    if not model.weights or not all(whole) or sizes[-1] != len(model.classes):
        return "its layers do not fit each other"
    everything = [model.mean, model.deviation, *(part for layer in model.weights for part in layer)]
    if model.mean.shape != (len(NAMES),) or model.deviation.shape != (len(NAMES),):
        return f"mean and deviation must be {len(NAMES)} numbers each"
    if any(part.dtype.kind != "f" or not np.isfinite(part).all() for part in everything):
        return "it holds values that are no numbers"
    return "" if (model.deviation > 0).all() else "a deviation must be above 0"
