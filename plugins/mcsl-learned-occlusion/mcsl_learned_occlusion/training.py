"""From marked frames to a model, with an honest figure: every frame judged by a model that saw none of its moment."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core import __version__
from mcsl_core.hooks import InputError, Progress

from .features import AT, COLOURS, FROM_OTHERS, FROM_PAST, MOVED, NAMES, Float, features, usual_of, without
from .labelling import Marked
from .model import CLASSES, Model


@frozen
class Training:
    """pixels: taken from a frame and class. hidden: sizes of the layers. rounds: over all pixels.

    alone, new: share of the pixels that are shown without the other views, as a scorer between samples is asked, and
    without a past. tint: deviation of the white balance they are shown in, log ratio: lamps and cameras differ.

    strange: share of the pixels that are shown in any colour at all, with a tint of strange_tint, so that what changed
    counts for more than what colour it has. Judged on each of six simulated operations by a model of the other five,
    with drapes, gloves and skins of their own, IoU of the field, what is in the way, elsewhere: without it 0.70, 0.80,
    0.73, with it 0.72, 0.89, 0.86.
    """

    pixels: int = field(default=1200)
    hidden: tuple[int, ...] = field(default=(24, 12))
    rounds: int = field(default=16)
    alone: float = field(default=0.2)
    new: float = field(default=0.05)
    tint: float = field(default=0.1)
    strange: float = field(default=0.5)
    strange_tint: float = field(default=0.5)
    folds: int = field(default=4)
    seed: int = field(default=0)


@frozen
class Judged:
    """iou: class -> intersection over union over all pixels held out. frames: how many were held out, in turn."""

    iou: dict[str, float]
    frames: int


@frozen(eq=False)
class _Frame:
    """values: (N, features) of all painted pixels. labels: (N,)."""

    moment: str
    values: Float
    labels: NDArray[np.int8]


def train(marked: Sequence[Marked], progress: Progress, settings: Training = Training()) -> tuple[Model, Judged]:
    """A model of all marked frames, and how models of the others did on each.

    InputError where field or what is in the way was painted nowhere, or all frames are of one moment.
    """
    painted = {name: sum(int((m.labels == i).sum()) for m in marked) for i, name in enumerate(CLASSES)}
    lacking = [name for name in CLASSES[:2] if painted[name] < 50]
    if lacking:
        raise InputError(
            f"{lacking[0]!r} is painted nowhere, or on less than 50 pixels",
            remedy="Paint both the field and what is in the way, on several frames",
        )
    classes = tuple(name for name in CLASSES if painted[name] >= 50)
    moments = sorted({m.moment for m in marked})
    if len(moments) < 2:
        raise InputError("all painted frames are of one moment", remedy="Paint frames of several moments")
    folds = min(settings.folds, len(moments))
    progress.stage("Training", folds + 2, "rounds")
    frames = [_frame(m, len(classes)) for m in marked]
    progress.advance(1)
    order = np.random.default_rng(settings.seed).permutation(len(moments))
    fold_of = {moments[at]: number % folds for number, at in enumerate(order)}
    confusion = np.zeros((len(classes), len(classes)), np.int64)
    for fold in range(folds):
        model = _fitted([f for f in frames if fold_of[f.moment] != fold], classes, settings)
        for frame in frames:
            if model is not None and fold_of[frame.moment] == fold:
                said = model.probabilities(frame.values).argmax(axis=1)
                np.add.at(confusion, (frame.labels, said), 1)
        progress.advance(fold + 2)
    model = _fitted(frames, classes, settings)
    assert model is not None, "all classes are painted"
    judged = Judged(_iou(confusion, classes), len(frames))
    about = {
        "mcsl": __version__,
        "frames": len(frames),
        "moments": len(moments),
        "iou": {name: round(value, 4) for name, value in judged.iou.items()},
    }
    progress.advance(folds + 2)
    return Model(model.mean, model.deviation, model.weights, classes, about), judged


def _frame(marked: Marked, classes: int) -> _Frame:
    values = features(marked.seen, usual_of(marked.behind), [marked.camera])[marked.camera]
    known = (marked.labels >= 0) & (marked.labels < classes) & marked.seen[marked.camera].inside
    return _Frame(marked.moment, values[known], marked.labels[known])


def _fitted(frames: Sequence[_Frame], classes: tuple[str, ...], settings: Training) -> Model | None:
    """None where the frames lack a class, as a fold may."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPClassifier

    rng = np.random.default_rng(settings.seed)
    values, labels, weight = [], [], []
    for frame in frames:
        for index in range(len(classes)):
            at = np.flatnonzero(frame.labels == index)
            if len(at):
                at = rng.choice(at, min(len(at), settings.pixels), replace=False)
                values.append(frame.values[at])
                labels.append(frame.labels[at])
    if not labels or len(set(np.concatenate(labels).tolist())) < len(classes):
        return None
    # Doubles, since the last bit of a sum depends on where an array lies in memory and training makes it grow: in
    # floats the same frames once gave weights that differed.
    x, y = _varied(np.concatenate(values), rng, settings).astype(np.float64), np.concatenate(labels)
    mean, deviation = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-3)
    how: dict[str, Any] = {"batch_size": min(512, len(x)), "max_iter": settings.rounds, "random_state": settings.seed}
    learner = MLPClassifier(settings.hidden, alpha=1e-3, learning_rate_init=3e-3, **how)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # so many rounds, no more: it must not take minutes
        learner.fit(np.clip((x - mean) / deviation, -6, 6), y)
    layers = [
        (w.astype(np.float32), b.astype(np.float32)) for w, b in zip(learner.coefs_, learner.intercepts_, strict=True)
    ]
    if len(classes) == 2:  # scikit-learn keeps one column of a sigmoid then: the softmax of 0 and it
        (weight, bias) = layers.pop()
        layers.append((np.hstack([np.zeros_like(weight), weight]), np.concatenate([np.zeros_like(bias), bias])))
    return Model(mean.astype(np.float32), deviation.astype(np.float32), tuple(layers), classes, {})


def _varied(values: Float, rng: np.random.Generator, settings: Training) -> Float:
    """The same pixels in other white balances, some without the other views, some without a past."""
    varied = values.copy()
    strange = rng.random((len(values), 1)) < settings.strange
    for colour in COLOURS[:2]:
        tint = np.where(strange, settings.strange_tint, settings.tint)
        varied[:, list(MOVED[colour])] += (tint * rng.normal(0, 1, (len(values), 1))).astype(np.float32)
    varied[:, AT["usually in the middle"]] += rng.normal(0, 0.1, len(values)).astype(np.float32)
    alone = rng.random(len(values)) < settings.alone
    varied[alone] = without(varied[alone], FROM_OTHERS, ["no others"])
    new = rng.random(len(values)) < settings.new
    varied[new] = without(varied[new], sorted({*FROM_OTHERS, *FROM_PAST}), ["no others", "no past"])
    assert varied.shape[1] == len(NAMES)
    return varied


def _iou(confusion: NDArray[np.int64], classes: Sequence[str]) -> dict[str, float]:
    """confusion: painted by said."""
    both = np.diag(confusion)
    either = confusion.sum(axis=0) + confusion.sum(axis=1) - both
    return {name: float(both[i] / max(either[i], 1)) for i, name in enumerate(classes)}
