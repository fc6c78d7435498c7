"""The hook specifications, and the marker by which a plugin's functions are known."""

from __future__ import annotations

from collections.abc import Sequence

import pluggy

from mcsl_core.alignment.protocol import Aligner, Matcher
from mcsl_core.alignment.relief.protocol import ReliefEstimator
from mcsl_core.alignment.tracking.protocol import Tracker
from mcsl_core.centering.protocol import Centerer
from mcsl_core.filling.protocol import Filler
from mcsl_core.movement.protocol import MovementDetector
from mcsl_core.occlusion.protocol import OcclusionDetector
from mcsl_core.selection.protocol import Selector

PROJECT = "mcsl"
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


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
    def register_reliefs(self) -> Sequence[ReliefEstimator]:  # pyright: ignore[reportReturnType]
        """Relief estimators, chosen by ``--relief NAME``."""

    @hookspec
    def register_trackers(self) -> Sequence[Tracker]:  # pyright: ignore[reportReturnType]
        """Lamp trackers, chosen by ``--tracker NAME``."""

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
