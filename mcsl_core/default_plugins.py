"""The stages that come with mcsl, offered through the same hooks as everybody's."""

from __future__ import annotations

from .alignment import JointPlane
from .centering import FieldCenterer
from .consensus import Consensus
from .features import RootSift
from .filling import FootprintFiller, ReferenceFiller
from .hookspecs import hookimpl
from .misalignment import DegreeOfMisalignment
from .movement import Stillness
from .occlusion import HueArea
from .selection import Fixed, LeastOccluded, ShortestPath


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
def register_occlusion_detectors():
    return [Consensus(), HueArea()]


@hookimpl
def register_selectors():
    return [ShortestPath(), LeastOccluded(), Fixed()]


@hookimpl
def register_centerers():
    return [FieldCenterer()]


@hookimpl
def register_fillers():
    return [FootprintFiller(), ReferenceFiller()]
