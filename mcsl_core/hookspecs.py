"""The hooks through which stages come in, the built-ins by the same door, and what each stage must be able to do.

A plugin is a module (or object) with functions of the names below, marked with ``mcsl_core.hookspecs.hookimpl`` and
announced under the entry-point group ``mcsl``. Each function returns the objects it offers; each object has a
``name`` by which it is chosen. What plugins are handed is not theirs to change.

One that needs something of the user's, such as a model, may have a method ``prepare()`` without arguments: it is called
before an analysis begins, and what is missing is told then (as a `McslError` that says what to do) and not hours later.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Protocol

import numpy as np
import pluggy
from numpy.typing import NDArray

from .alignment import Alignment, Correspondences
from .centering import FieldPlace
from .edl import CenteringKey, Shot
from .features import Features
from .filling import Filler
from .footage import Footage
from .progress import Progress
from .samples import Samples
from .scene import Scene, View
from .scores import Detection, ScoreTable

PROJECT = "mcsl"
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


class MovementDetector(Protocol):
    """Finds the stretches in which the lamp moves."""

    @property
    def name(self) -> str: ...

    def detect(self, samples: Samples, footage: Footage, progress: Progress) -> Detection:
        """Movements in order, not overlapping, inside [0, footage.frames), and the curve they were judged by.

        samples: the recording about once a second, reduced; iterate it. footage: for a closer look at full rate.
        """
        ...


class Matcher(Protocol):
    """Finds the same places in two pictures."""

    @property
    def name(self) -> str: ...

    def features(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> Features:
        """Distinctive points of a (H, W, 3) BGR picture, only where ``mask`` (H, W) is not 0."""
        ...

    def match(self, a: Features, b: Features) -> NDArray[np.intp]:
        """(M, 2) indices: point [i, 0] of ``a`` is point [i, 1] of ``b``; each point at most once."""
        ...


class Aligner(Protocol):
    """Ties every camera of a pose to the reference camera."""

    @property
    def name(self) -> str: ...

    def align(
        self,
        pairs: Mapping[tuple[str, str], Correspondences],
        sizes: Mapping[str, tuple[int, int]],
        reference: str,
    ) -> Alignment:
        """One homography per camera that can be tied in, the others as weak with a reason.

        pairs: matches of cameras (a, b), pooled over clear moments: first of distinctive points, of which those in the
        surgical field weigh 1, those outside about 0.01; then of every spot of the field, which weigh 0.3 to 1. sizes:
        every camera's (width, height).
        """
        ...


class OcclusionScorer(Protocol):
    """Scores the moments of one stretch, in any order."""

    def score(self, views: Sequence[View]) -> Mapping[str, float]:
        """camera -> visible share of the surgical field, 0 (hidden) to 1 (clear), for every view handed in."""
        ...


class OcclusionDetector(Protocol):
    """Says how much of the surgical field each camera sees."""

    @property
    def name(self) -> str: ...

    def scorer(self, scene: Scene, moments: Sequence[Sequence[View]]) -> OcclusionScorer:
        """A scorer for a stretch of a pose, a few minutes at most.

        moments: the views of its samples in order of time, about one a second; each access reads them anew. The scorer
        is then asked about these moments, and about others of the stretch with only some of the cameras.
        """
        ...


class Selector(Protocol):
    """Chooses the camera of every moment."""

    @property
    def name(self) -> str: ...

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> Sequence[Shot]:
        """Shots that tile [0, frames) without gap or overlap; ``rate`` in frames per second."""
        ...


class Centerer(Protocol):
    """Shifts the programme so that what matters is in the middle."""

    @property
    def name(self) -> str: ...

    def centre(self, places: Sequence[FieldPlace], *, size: tuple[int, int], rate: float) -> Sequence[CenteringKey]:
        """(frame, dx, dy) with rising frames, in programme pixels; ``size`` is the programme's (width, height)."""
        ...


class Hooks:
    """The hook specifications."""

    @hookspec
    def register_movement_detectors(self) -> Sequence[MovementDetector]:  # pyright: ignore[reportReturnType]
        """Movement detectors, chosen by ``--movement NAME``."""

    @hookspec
    def register_matchers(self) -> Sequence[Matcher]:  # pyright: ignore[reportReturnType]
        """Matchers, chosen by ``--matcher NAME``."""

    @hookspec
    def register_aligners(self) -> Sequence[Aligner]:  # pyright: ignore[reportReturnType]
        """Aligners, chosen by ``--aligner NAME``."""

    @hookspec
    def register_occlusion_detectors(self) -> Sequence[OcclusionDetector]:  # pyright: ignore[reportReturnType]
        """Occlusion detectors, chosen by ``--occlusion NAME``."""

    @hookspec
    def register_selectors(self) -> Sequence[Selector]:  # pyright: ignore[reportReturnType]
        """Selectors, chosen by ``--selector NAME``."""

    @hookspec
    def register_centerers(self) -> Sequence[Centerer]:  # pyright: ignore[reportReturnType]
        """Centerers, chosen by ``--centerer NAME``."""

    @hookspec
    def register_fillers(self) -> Sequence[Filler]:  # pyright: ignore[reportReturnType]
        """Fillers, chosen by ``--filler NAME``."""
