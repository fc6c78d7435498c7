"""A small segmentation network in ONNX, made of painted frames: the `onnx` detector of benchmarks/detectors.py.

It sees one picture, as most networks do: the colours at a pixel and averaged over 5, 15 and 45 pixels around it, and
how much they vary there; then two layers of 24 and 12 over the pixel. It knows nothing of other views or of the past.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import onnx
from mcsl_learned_occlusion.labelling import labels_of, read_png
from mcsl_learned_occlusion.model import CLASSES
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

SIZE = (320, 180)
SIDES = (5, 15, 45)
LAYERS = (24, 12)
PIXELS = 1500  # of a frame and class
DESCRIPTION = f"""\
[input]
size = [{SIZE[0]}, {SIZE[1]}]

[output]
meaning = "softmax"
field = [{CLASSES.index("field")}]
occluder = [{CLASSES.index("in the way")}]
"""


def write_network(folders: Sequence[Path], out: Path) -> dict[str, Any]:
    """Trains it on all painted frames and writes it with its description; what it is, for people."""
    from sklearn.neural_network import MLPClassifier

    values, labels = _pixels(folders)
    mean, deviation = values.mean(axis=0), values.std(axis=0)
    how: dict[str, Any] = {"batch_size": 512, "learning_rate_init": 3e-3, "max_iter": 20, "random_state": 0}
    learner = MLPClassifier(LAYERS, alpha=1e-3, **how)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        learner.fit((values - mean) / deviation, labels)
    first = learner.coefs_[0] / deviation[:, None]  # the normalisation goes into the first layer
    biases = [learner.intercepts_[0] - mean @ first, *learner.intercepts_[1:]]
    _save([first, *learner.coefs_[1:]], biases, out)
    out.with_suffix(".toml").write_text(DESCRIPTION, "utf-8")
    count = sum(w.size for w in learner.coefs_) + sum(b.size for b in biases)
    return {
        "network": f"{SIZE[0]}x{SIZE[1]}, one picture at a time, {count} weights, {out.stat().st_size / 1000:.0f} kB"
    }


def _seen(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(H, W, planes): what the network's pooling layers make of a BGR picture."""
    rgb = cv2.resize(picture, SIZE, interpolation=cv2.INTER_AREA)[..., ::-1].astype(np.float32) / 255
    planes = [rgb]
    for side in SIDES:
        # As the network pools: over what lies in the picture.
        count = cv2.blur(np.ones(rgb.shape[:2], np.float32), (side, side), borderType=cv2.BORDER_CONSTANT)[..., None]
        mean = cv2.blur(rgb, (side, side), borderType=cv2.BORDER_CONSTANT) / count
        square = cv2.blur(rgb * rgb, (side, side), borderType=cv2.BORDER_CONSTANT) / count
        planes += [mean, np.sqrt(np.maximum(square - mean * mean, 0) + 1e-6)]
    return np.concatenate(planes, axis=2).astype(np.float32)


def _pixels(folders: Sequence[Path]) -> tuple[NDArray[np.float32], NDArray[np.int8]]:
    rng = np.random.default_rng(0)
    values, labels = [], []
    for painted in sorted(path for folder in folders for path in folder.glob("*.mask.png")):
        picture = read_png(painted.with_name(painted.name.replace(".mask.png", ".png")))
        label = cv2.resize(labels_of(read_png(painted)) + 1, SIZE, interpolation=cv2.INTER_NEAREST).ravel() - 1
        seen = _seen(picture).reshape(len(label), -1)
        for index in range(len(CLASSES)):
            at = np.flatnonzero(label == index)
            if len(at):
                at = rng.choice(at, min(len(at), PIXELS), replace=False)
                values.append(seen[at])
                labels.append(label[at])
    return np.concatenate(values), np.concatenate(labels)


def _save(weights: Sequence[NDArray], biases: Sequence[NDArray], out: Path) -> None:
    nodes, parts, arrays = [], ["picture"], {"little": np.array(1e-6, np.float32)}
    nodes.append(helper.make_node("Mul", ["picture", "picture"], ["squares"]))
    for side in SIDES:
        mean, square = f"mean{side}", f"square{side}"
        for source, pooled in (("picture", mean), ("squares", square)):  # columns, then rows: 45 x 45 at once is slow
            half = side // 2
            down = {"kernel_shape": [side, 1], "pads": [half, 0, half, 0], "count_include_pad": 0}
            across = {"kernel_shape": [1, side], "pads": [0, half, 0, half], "count_include_pad": 0}
            nodes.append(helper.make_node("AveragePool", [source], [f"{pooled}_down"], **down))
            nodes.append(helper.make_node("AveragePool", [f"{pooled}_down"], [pooled], **across))
        nodes += [
            helper.make_node("Mul", [mean, mean], [f"{mean}2"]),
            helper.make_node("Sub", [square, f"{mean}2"], [f"variance{side}"]),
            helper.make_node("Relu", [f"variance{side}"], [f"positive{side}"]),
            helper.make_node("Add", [f"positive{side}", "little"], [f"some{side}"]),
            helper.make_node("Sqrt", [f"some{side}"], [f"deviation{side}"]),
        ]
        parts += [mean, f"deviation{side}"]
    nodes.append(helper.make_node("Concat", parts, ["layer0"], axis=1))
    for number, (weight, bias) in enumerate(zip(weights, biases, strict=True)):
        arrays[f"w{number}"] = weight.T.astype(np.float32)[..., None, None]
        arrays[f"b{number}"] = bias.astype(np.float32)
        last = number == len(weights) - 1
        made = "scores" if last else f"sum{number}"
        nodes.append(helper.make_node("Conv", [f"layer{number}", f"w{number}", f"b{number}"], [made]))
        if not last:
            nodes.append(helper.make_node("Relu", [made], [f"layer{number + 1}"]))
    graph = helper.make_graph(
        nodes,
        "small",
        [helper.make_tensor_value_info("picture", TensorProto.FLOAT, [1, 3, SIZE[1], SIZE[0]])],
        [helper.make_tensor_value_info("scores", TensorProto.FLOAT, [1, len(CLASSES), SIZE[1], SIZE[0]])],
        [numpy_helper.from_array(np.ascontiguousarray(array), name) for name, array in arrays.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model)
    out.write_bytes(model.SerializeToString())
