# SPDX-License-Identifier: GPL-3.0-or-later
"""Where camera strips stand, and the keys of those over movements of the lamp that is followed."""

from __future__ import annotations

import hashlib
from array import array
from collections.abc import Mapping, Sequence
from typing import Any

from ..core.moving import TransformKey
from ..core.strip_plan import CameraTrack, MoviePiece
from .compat import ends, strips_of
from .curves import curves_of_transforms, keys_in, make_curve, path_of, remove_curve, set_keys
from .scene_properties import CAMERA, FOLLOWS, PLANNED_TRANSFORM, role_of
from .transforms import NUMBERS, set_transform, transform_numbers


def place_camera(scene: Any, strip: Any, piece: MoviePiece) -> None:
    """A camera strip stands as its piece of the plan says, or moves as the piece's keys say.

    Keys of the editor's own on a strip that stands stay. A strip with our keys keeps no planned transform: it says
    nothing about alignment, whatever is done to it.
    """
    set_transform(strip, piece.transform)
    if piece.keys:
        strip.pop(PLANNED_TRANSFORM, None)
        _set_keys(scene, strip, piece.keys)
        return
    if strip.pop(FOLLOWS, None) is not None:
        for name in NUMBERS:
            remove_curve(scene, path_of(strip, name))
    assert piece.planned is not None
    strip[PLANNED_TRANSFORM] = transform_numbers(piece.planned)


def _set_keys(scene: Any, strip: Any, keys: Sequence[TransformKey]) -> None:
    numbers = [transform_numbers(key.transform) for key in keys]
    curves = {}
    for name, values in zip(NUMBERS, zip(*numbers, strict=True), strict=True):
        path = path_of(strip, name)
        curves[path] = make_curve(scene, path)
        set_keys(curves[path], [key.frame for key in keys], values, [key.hold for key in keys])
    strip[FOLLOWS] = _keys_hash(curves, strip)


def follow_movements(scene: Any, tracks: Sequence[CameraTrack]) -> None:
    """The strips over movements get the keys of the plan anew: corrections may be others, keys changed by hand go."""
    pieces = {t.camera: [piece for file in t.files for piece in file.pieces if piece.keys] for t in tracks}
    for strip in scene.sequence_editor.strips:
        if role_of(strip) != "camera" or FOLLOWS not in strip:
            continue
        start, stop = ends(strip)
        for piece in pieces.get(strip[CAMERA], ()):
            if piece.range.start < stop and start < piece.range.stop:
                place_camera(scene, strip, piece)
                break


def moved_by_hand(scene: Any) -> tuple[Any, ...]:
    """The strips over movements whose keys are others than those they were given."""
    curves = curves_of_transforms(scene)
    found = (s for s in strips_of(scene, "MOVIE") if role_of(s) == "camera" and FOLLOWS in s)
    return tuple(strip for strip in found if strip[FOLLOWS] != _keys_hash(curves, strip))


def _keys_hash(curves: Mapping[str, Any], strip: Any) -> str:
    values = array("f")
    for name in NUMBERS:
        if (curve := curves.get(path_of(strip, name))) is not None:
            values.extend(keys_in(curve))
    return hashlib.sha256(values.tobytes()).hexdigest()[:16]
