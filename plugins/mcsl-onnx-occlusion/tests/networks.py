"""Small networks made by hand, so that what they must say is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

KINDS = {"float": TensorProto.FLOAT, "half": TensorProto.FLOAT16, "uint8": TensorProto.UINT8}


def save(
    path: Path,
    nodes: list,
    *,
    size: tuple[object, object] = (96, 64),
    layout: str = "NCHW",
    kind: str = "float",
    weights: dict[str, np.ndarray] | None = None,
    inputs: tuple[str, ...] = ("picture",),
) -> Path:
    """Nodes from "picture" to "out" as an .onnx file; size: (width, height), numbers or names of free axes."""
    width, height = size
    numbers = TensorProto.FLOAT16 if kind == "half" else TensorProto.FLOAT
    out = TensorProto.INT64 if nodes[-1].op_type == "ArgMax" else numbers
    shape = [1, 3, height, width] if layout == "NCHW" else [1, height, width, 3]
    graph = helper.make_graph(
        nodes,
        "made by hand",
        [helper.make_tensor_value_info(name, KINDS[kind], shape) for name in inputs],
        [helper.make_tensor_value_info("out", out, ["n", "c", "h", "w"])],
        [numpy_helper.from_array(value, name) for name, value in (weights or {}).items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model)
    path.write_bytes(model.SerializeToString())
    return path


def reddish(path: Path, *, logits: bool = True, **how) -> Path:
    """Class 0: what is redder than green, by the share of (red - green) in red + green + blue; RGB, 0 to 1.

    Skin and tissue have 0.1 and more, white gloves about 0.02, steel 0, green and blue cloth less.
    """
    weights = {
        "difference": np.array([1, -1, 0], np.float32).reshape(1, 3, 1, 1),
        "sum": np.ones((1, 3, 1, 1), np.float32),
        "dark": np.array(0.15, np.float32),
        "steep": np.array(60, np.float32),
        "from": np.array(-4.0, np.float32),
    }
    nodes = [
        helper.make_node("AveragePool", ["picture"], ["soft"], kernel_shape=[3, 3], pads=[1, 1, 1, 1]),
        helper.make_node("Conv", ["soft", "difference"], ["red"]),
        helper.make_node("Conv", ["soft", "sum"], ["light"]),
        helper.make_node("Add", ["light", "dark"], ["enough"]),
        helper.make_node("Div", ["red", "enough"], ["share"]),
        helper.make_node("Mul", ["share", "steep"], ["steeper"]),
        helper.make_node("Add", ["steeper", "from"], ["out" if logits else "logits"]),
    ]
    if not logits:
        nodes.append(helper.make_node("Sigmoid", ["logits"], ["out"]))
    return save(path, nodes, weights=weights, **how)


def channels(path: Path, **how) -> Path:
    """Three classes: how red, green and blue a pixel is; what the network is shown comes out as it is."""
    return save(path, [helper.make_node("Identity", ["picture"], ["out"])], **how)


def labels(path: Path, **how) -> Path:
    """The number of the strongest channel, 0 red, 1 green, 2 blue, as a map of labels (1, 1, H, W)."""
    node = helper.make_node("ArgMax", ["picture"], ["out"], axis=1, keepdims=1)
    return save(path, [node], **how)


def not_a_number(path: Path, **how) -> Path:
    """0 / 0 everywhere a picture is black."""
    return save(path, [helper.make_node("Div", ["picture", "picture"], ["out"])], **how)
