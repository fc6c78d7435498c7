"""The surgical field between document and stages: what was drawn goes in, what was taken comes out and is told."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from mcsl_core import edl
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.edl.edits import check_drawn
from mcsl_core.edl.field import HAND, MIDDLE, Polygons, awaits_analysis, drawn_over, has_area
from mcsl_core.imaging.geometry import scaling, transform_points
from mcsl_core.imaging.masks import Mask, outlines
from mcsl_core.progress import Progress


def drawn_before(before: edl.Edl | None, reference: str, frames: int) -> tuple[edl.DrawnField, ...]:
    """The fields drawn by hand in the EDL that lay there before, as far as a programme of ``frames`` has them.

    Raises
    ------
    DocumentError
        Where they are of another camera's perspective than ``reference``'s.
    """
    if before is None:
        return ()
    check_drawn(before, reference)
    return tuple(drawn for drawn in before.drawn_fields if drawn.range.stop <= frames)


def field_stretches(solved: Sequence[SolvedPose], drawn: Sequence[edl.DrawnField]) -> tuple[edl.FieldStretch, ...]:
    """Where the field was taken to lie, for the EDL: what is drawn as it is drawn, all else by its outlines."""
    found = []
    for pose in solved:
        for piece, mask, by in pose.fields():
            polygons = next((p for _, p in drawn_over(drawn, piece)), None) if by == HAND else _polygons(mask, pose)
            if polygons:
                found.append(edl.FieldStretch(piece, by, polygons))
    return tuple(found)


def without_claims(shots: Sequence[edl.Shot], fields: Sequence[edl.FieldStretch]) -> tuple[edl.Shot, ...]:
    """The shots, their reasons without a share of the field where nothing shows one."""
    unknown = [stretch.range for stretch in fields if stretch.by == MIDDLE]
    told = []
    for shot in shots:
        parts = (shot.range.intersection(piece) for piece in unknown)
        if 2 * sum(len(part) for part in parts if part is not None) > len(shot.range):
            shot = attrs.evolve(shot, why=shot.why.replace("of the field", "of the middle of the picture"))
        told.append(shot)
    return tuple(told)


def tell_of_fields(made: edl.Edl, progress: Progress) -> None:
    """Where no field was found, and where one was drawn that was not used."""
    for stretch in made.fields:
        if stretch.by == MIDDLE:
            progress.note(
                f"frames {stretch.range}: nothing shows where the surgical field lies, so the middle of the picture is "
                "taken; to draw it: mcsl field"
            )
    if awaits_analysis(made):
        progress.note("a field that is drawn was not used: it was drawn meanwhile, or lies outside of the picture")


def _polygons(mask: Mask, pose: SolvedPose) -> Polygons:
    """The outlines of a mask of aligned pixels, in programme pixels to a tenth."""
    aligned = pose.aligned
    full = aligned.camera_sizes[aligned.reference]
    to_programme = np.array(pose.pose.anchor) @ scaling(aligned.size, full)
    moved = (np.round(transform_points(to_programme, outline), 1) + 0.0 for outline in outlines(mask)[:20])
    polygons = (tuple((float(x), float(y)) for x, y in outline) for outline in moved)
    return tuple(polygon for polygon in polygons if has_area(polygon))
