"""Any segmentation network in ONNX as mcsl's occlusion detector: `--occlusion onnx`, the network by MCSL_ONNX_MODEL.

The network is shown every camera's own picture, upright as the camera sees it; what it says is then laid into the
aligned. It may know the surgical field, or what is in the way of it, or both.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from attrs import field, frozen

from mcsl_core.hooks import AlignedPose, AlignedView, Mask, UsageError, hookimpl, main_region

from .network import Map, Network

VARIABLE = "MCSL_ONNX_MODEL"


@frozen(repr=False)
class OnnxOcclusion:
    """The visible field by a segmentation network in ONNX. Named by the environment variable MCSL_ONNX_MODEL.

    looks: so many samples of a stretch are shown to the network to find where its field lies. share: a place is the
    field when so many of the views that reach it show the field there; hands hide it from some, most of the time.
    """

    looks: int = field(default=16)
    share: float = field(default=0.35)
    name = "onnx"

    def prepare(self) -> None:
        """Loads the network, so that one that is missing or wrong is refused before any work is done."""
        chosen_network()

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> OnnxScorer:
        """A scorer for a stretch of a pose; of a network that knows the field, the field is where it says."""
        network = chosen_network()
        scorer = OnnxScorer(network, aligned, aligned.field)
        if not network.description.output.field or not len(samples):
            return scorer
        shown = np.zeros(aligned.field.shape, np.float32)
        reached = np.zeros(aligned.field.shape, np.float32)
        for position in np.unique(np.linspace(0, len(samples) - 1, min(self.looks, len(samples))).astype(int)):
            for view in samples[position]:
                shown += scorer.field(view)
                reached += view.inside
        place = main_region((shown > self.share * reached) & (reached > 0))
        return OnnxScorer(network, aligned, place if place.any() else aligned.field)

    def __repr__(self) -> str:
        """With the network's fingerprint: results in the cache are those of this network."""
        path = os.environ.get(VARIABLE)
        return f"OnnxOcclusion(looks={self.looks}, share={self.share}, network={path and fingerprint(Path(path))})"


@frozen(eq=False)
class OnnxScorer:
    """Scores samples of one stretch of a pose. place: (H, W), the field in scene pixels."""

    network: Network
    aligned: AlignedPose
    place: Mask

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """camera -> visible share of the field, 0..1."""
        area = max(int(self.place.sum()), 1)
        return {view.camera: float(np.count_nonzero(self.place & self.visible(view))) / area for view in views}

    def visible(self, view: AlignedView) -> Mask:
        """(H, W) bool in scene pixels: where nothing is in the way, by what the network knows of that.

        One that knows both is asked what is in the way: a wound's depth or a swab need not look like the field.
        """
        maps = self.network.maps(view.picture)
        if maps.occluder is not None:
            return view.inside & ~self._laid(maps.occluder, view)
        assert maps.field is not None, "a description names one of them at least"
        return view.inside & self._laid(maps.field, view)

    def field(self, view: AlignedView) -> Mask:
        """(H, W) bool in scene pixels: where the view shows the field."""
        probability = self.network.maps(view.picture).field
        assert probability is not None, "asked of networks that know the field only"
        return view.inside & self._laid(probability, view)

    def _laid(self, probability: Map, view: AlignedView) -> Mask:
        warp = self.aligned.warp_of(view.camera, (probability.shape[1], probability.shape[0]))
        laid = cv2.warpPerspective(probability, warp, self.aligned.size, flags=cv2.INTER_LINEAR)
        return laid >= self.network.description.output.threshold


def chosen_network() -> Network:
    """The network that MCSL_ONNX_MODEL names; UsageError where it names none."""
    path = os.environ.get(VARIABLE)
    if not path:
        raise UsageError(
            "no network is named",
            where="--occlusion onnx",
            remedy=f"Set the environment variable {VARIABLE} to an .onnx file that has its .toml beside it",
        )
    return _loaded(Path(path).absolute(), fingerprint(Path(path)))


@lru_cache(maxsize=2)
def _loaded(path: Path, fingerprint: str) -> Network:
    return Network.load(path)


def fingerprint(path: Path) -> str:
    """Of the network, its description and all files beside it that hold weights: by its stem or named in it."""
    digest = hashlib.sha256()
    beside = list(path.parent.iterdir()) if path.parent.is_dir() else []
    named = _weights_named(path) if path.is_file() else set()
    for file in sorted(beside):  # the stem is compared, not globbed: it may hold brackets
        if (file.name.startswith(f"{path.stem}.") or file.name in named) and file.is_file():
            digest.update(os.fsencode(file.name) + b"\0")
            with file.open("rb") as stream:
                digest.update(hashlib.file_digest(stream, "sha256").digest())
    return digest.hexdigest()[:24]


def _weights_named(path: Path) -> set[str]:
    """The files that a network says its weights lie in: the key "location", then a name of at most 127 bytes."""
    data = path.read_bytes()
    found = re.finditer(rb"\n\x08location\x12([\x01-\x7f])", data)
    return {os.fsdecode(data[m.end() : m.end() + m[1][0]]).removeprefix("./") for m in found}


@hookimpl
def register_occlusion_detectors():
    return [OnnxOcclusion()]
