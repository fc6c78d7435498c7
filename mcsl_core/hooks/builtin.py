"""The stages that come with mcsl, offered through the same hooks as everybody's."""

from __future__ import annotations

from mcsl_core.alignment.features import RootSift
from mcsl_core.alignment.joint import JointPlane
from mcsl_core.alignment.relief.protocol import PlaneRelief
from mcsl_core.alignment.relief.sweep import PlaneSweep
from mcsl_core.alignment.tracking.following import BackgroundTracker
from mcsl_core.centering.field import FieldCenterer
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.movement.paper import DegreeOfMisalignment
from mcsl_core.movement.stillness import Stillness
from mcsl_core.occlusion.consensus import Consensus
from mcsl_core.occlusion.hue_area import HueArea
from mcsl_core.selection.selectors import Fixed, LeastOccluded, ShortestPath, ThroughHeads

from .specs import hookimpl


@hookimpl
def register_movement_detectors():
    return [Stillness(), DegreeOfMisalignment()]


@hookimpl
def register_matchers():
    return [RootSift()]


@hookimpl
def register_aligners():
    return [JointPlane()]


@hookimpl
def register_reliefs():
    return [PlaneSweep(), PlaneRelief()]


@hookimpl
def register_trackers():
    return [BackgroundTracker()]


@hookimpl
def register_occlusion_detectors():
    return [Consensus(), HueArea()]


@hookimpl
def register_selectors():
    return [ShortestPath(), ThroughHeads(), LeastOccluded(), Fixed()]


@hookimpl
def register_centerers():
    return [FieldCenterer()]


@hookimpl
def register_fillers():
    return [FootprintFiller(), PaperFiller()]
