"""A timeline's file is an editor's work: built anew over it only where nobody has worked in it, or by force."""

import pytest
from blender_recording import in_blender

from mcsl_core.blender.timeline import build_timeline
from mcsl_core.errors import InputError


def test_an_edited_timeline_is_replaced_by_force_alone_and_kept(built, blender):
    edl = built.parent / "edl.json"
    build_timeline(edl, built, blender=blender)  # nobody has worked in it
    in_blender(blender, built, "scene.timeline_markers.new('mine', frame=3)")
    edited = built.read_bytes()
    with pytest.raises(InputError, match="is there already, and not as mcsl wrote it"):
        build_timeline(edl, built, blender=blender)
    assert built.read_bytes() == edited
    build_timeline(edl, built, blender=blender, force=True)
    kept = [path.read_bytes() for path in built.parent.glob("edit.blend?")]  # one is the editor's Blender's own
    assert edited in kept
    build_timeline(edl, built, blender=blender)
    assert len(list(built.parent.glob("edit.blend?"))) == len(kept)
