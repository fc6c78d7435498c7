"""A network in ONNX, run by onnxruntime on the processor.

onnxruntime is imported where it is used, not with the package: every `mcsl` process imports its plugins.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.hooks import InputError

from .description import Description, read_description

TYPES = {"tensor(float)": np.float32, "tensor(float16)": np.float16, "tensor(uint8)": np.uint8}
_REMEDY = "Correct the description or choose another network; see the README of mcsl-onnx-occlusion"

Map = NDArray[np.float32]


@frozen(eq=False)
class Maps:
    """What a network says about one picture, (h, w) float32 each, 0 to 1; None of classes it does not know."""

    field: Map | None
    occluder: Map | None


@frozen(eq=False)
class Network:
    """A network with its description. size: (width, height) of what it is shown."""

    path: Path
    description: Description
    session: Any
    size: tuple[int, int]
    kind: Any

    @classmethod
    def load(cls, path: Path) -> Network:
        """The network ``path`` by the .toml beside it; InputError names the file, and the key where it is that.

        It is run once on a grey picture: a network that does not fit is refused before hours are spent on it.
        """
        described = path.with_suffix(".toml")
        description = read_description(described)
        session = _session(path)
        inputs = session.get_inputs()
        if len(inputs) != 1:
            names = ", ".join(i.name for i in inputs)
            raise InputError(f"wants {len(inputs)} inputs ({names}), expected one", where=str(path), remedy=_REMEDY)
        kind = TYPES.get(inputs[0].type)
        if kind is None:
            raise InputError(
                f"wants {inputs[0].type}, expected one of {', '.join(TYPES)}", where=str(path), remedy=_REMEDY
            )
        size = _input_size(inputs[0].shape, description, path, described)
        names = [o.name for o in session.get_outputs()]
        if description.output.name not in (None, *names):
            raise InputError(
                f"there is no output {description.output.name!r} but {', '.join(names)}",
                where=f"{described} at output.name",
                remedy=_REMEDY,
            )
        network = cls(path, description, session, size, kind)
        network.maps(np.full((size[1], size[0], 3), 128, np.uint8))
        return network

    def maps(self, picture: NDArray[np.uint8]) -> Maps:
        """Field and what is in the way in a (h, w, 3) BGR picture of any size, in the network's own output pixels."""
        output = self.description.output
        try:
            (raw,) = self.session.run(
                [output.name or self.session.get_outputs()[0].name],
                {self.session.get_inputs()[0].name: self._input(picture)},
            )
        except Exception as error:  # onnxruntime's own errors have no common base but Exception
            raise InputError(
                f"fails on a picture of {self.size[0]}x{self.size[1]}: {_first_line(error)}",
                where=str(self.path),
                remedy=_REMEDY,
            ) from error
        classes = self._classes(np.asarray(raw))
        self._check_shape(classes.shape[-2:], np.shape(raw))
        return Maps(self._map(classes, output.field), self._map(classes, output.occluder))

    def _input(self, picture: NDArray[np.uint8]) -> NDArray:
        wanted = self.description.input
        shrinks = self.size[0] < picture.shape[1]
        shown = cv2.resize(picture, self.size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
        if wanted.colour == "RGB":
            shown = shown[..., ::-1]
        if self.kind is np.uint8:
            values = shown
        else:
            mean, deviation = (np.array(v, np.float32) for v in (wanted.mean, wanted.deviation))
            values = (shown * np.float32(wanted.scale) - mean) / deviation
        if wanted.layout == "NCHW":
            values = values.transpose(2, 0, 1)
        return np.ascontiguousarray(values[None], self.kind)

    def _classes(self, raw: NDArray) -> NDArray:
        """(h, w) class numbers, or (C, h, w) probabilities; InputError where ``raw`` is neither."""
        output = self.description.output
        shape = "x".join(map(str, raw.shape))
        if output.meaning == "labels":
            if raw.ndim == 4 and 1 in (raw.shape[1], raw.shape[3]):
                raw = raw[:, 0] if raw.shape[1] == 1 else raw[..., 0]
            if raw.ndim != 3 or raw.shape[0] != 1:
                raise self._fault(f"labels must be one number a pixel, the network gives {shape}", "output.meaning")
            return raw[0]
        if raw.ndim != 4 or raw.shape[0] != 1 or raw.dtype.kind != "f":
            raise self._fault(
                f"{output.meaning} must be fractions of shape 1x{'CxHxW' if output.layout == 'NCHW' else 'HxWxC'}, "
                f"the network gives {raw.dtype} of {shape}",
                "output.meaning",
            )
        scores = raw[0].astype(np.float32)
        if output.layout == "NHWC":
            scores = scores.transpose(2, 0, 1)
        unknown = [c for c in (*output.field, *output.occluder) if c >= len(scores)]
        if unknown:
            key = "output.field" if unknown[0] in output.field else "output.occluder"
            raise self._fault(f"there is no class {unknown[0]}: the network gives {shape}, {output.layout}", key)
        if not np.isfinite(scores).all():
            raise InputError("gives values that are no numbers (NaN or infinite)", where=str(self.path), remedy=_REMEDY)
        if output.meaning == "softmax":
            if len(scores) < 2:
                raise self._fault("softmax of one class says nothing; sigmoid may be meant", "output.meaning")
            scores = np.exp(scores - scores.max(axis=0))
            return scores / scores.sum(axis=0)
        if output.meaning == "sigmoid":
            return 1 / (1 + np.exp(-np.clip(scores, -60, 60)))
        if scores.min() < -0.01 or scores.max() > 1.01:
            raise self._fault(
                f"probabilities lie in 0..1, the network gives {scores.min():.3g} to {scores.max():.3g}",
                "output.meaning",
            )
        return scores

    def _check_shape(self, found: tuple[int, ...], raw: tuple[int, ...]) -> None:
        """InputError where a map has not the shape of the picture, smaller by whatever the network's strides are."""
        (width, height), (rows, columns) = self.size, found
        # rows = height / stride, columns = width / stride, each rounded by up to one.
        if min(found) > 1 and abs(rows * width - columns * height) <= width + height:
            return
        layout = "NHWC" if self.description.output.layout == "NCHW" else "NCHW"
        raise InputError(
            f"the network gives {'x'.join(map(str, raw))}, by {self.description.output.layout} maps of "
            f"{columns}x{rows} pixels, which is no picture of {width}x{height}",
            where=f"{self.path.with_suffix('.toml')} at output.layout",
            remedy=f'Write layout = "{layout}" under [output] if that is its order of axes. {_REMEDY}',
        )

    def _map(self, classes: NDArray, wanted: tuple[int, ...]) -> Map | None:
        if not wanted:
            return None
        output = self.description.output
        if output.meaning == "labels":
            return np.isin(np.rint(classes), wanted).astype(np.float32)
        part = classes[list(wanted)]
        return part.max(axis=0) if output.meaning == "sigmoid" else np.clip(part.sum(axis=0), 0, 1)

    def _fault(self, what: str, key: str) -> InputError:
        return InputError(what, where=f"{self.path.with_suffix('.toml')} at {key}", remedy=_REMEDY)


def _session(path: Path) -> Any:
    import onnxruntime

    if not path.is_file():
        raise InputError("is not there", where=str(path), remedy="MCSL_ONNX_MODEL must name an .onnx file")
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4  # what is wrong is said below, once
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:
        raise InputError(
            f"cannot be used as an ONNX network: {_first_line(error)}",
            where=str(path),
            remedy="Export it again, or update onnxruntime",
        ) from error


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _input_size(shape: list[Any], description: Description, path: Path, described: Path) -> tuple[int, int]:
    """(width, height) that the network is shown; names of free axes are texts in ``shape``."""
    wanted = description.input
    text = "x".join(map(str, shape))
    if len(shape) != 4:
        raise InputError(f"wants an input of shape {text}, expected four axes", where=str(path), remedy=_REMEDY)
    order = (1, 2, 3) if wanted.layout == "NCHW" else (3, 1, 2)
    channels, height, width = (shape[axis] if isinstance(shape[axis], int) else None for axis in order)
    if channels not in (None, 3):
        raise InputError(
            f"wants {channels} channels by {wanted.layout} (its input is {text}), expected 3",
            where=f"{described} at input.layout",
            remedy=_REMEDY,
        )
    if isinstance(shape[0], int) and shape[0] != 1:
        raise InputError(f"wants {shape[0]} pictures at once, expected 1", where=str(path), remedy=_REMEDY)
    size = wanted.size or (None if width is None or height is None else (width, height))
    if size is None:
        raise InputError(
            f"is missing: the network takes pictures of any size ({text})",
            where=f"{described} at input.size",
            remedy=_REMEDY,
        )
    if width not in (None, size[0]) or height not in (None, size[1]):
        raise InputError(
            f"is {size[0]}x{size[1]}, but the network wants {width or 'any'}x{height or 'any'}",
            where=f"{described} at input.size",
            remedy=_REMEDY,
        )
    return size
