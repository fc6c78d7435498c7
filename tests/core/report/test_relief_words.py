"""What is said of a pose's relief."""

from __future__ import annotations

from fractions import Fraction

import attrs
import pytest
from relief_scene import pose_of

from mcsl_core.edl import IDENTITY, Camera, Edl, MadeBy, Media, Override, Pose, Shot, Weak
from mcsl_core.report.relief_words import relief_words
from mcsl_core.timing import FrameRange


def programme(pose: Pose, **changes) -> Edl:
    pose = attrs.evolve(pose, weak=tuple(Weak(name, "seldom seen") for name in "abc" if name not in pose.homographies))
    cameras = tuple(Camera(name, (Media(f"{name}.mp4", 100),), (320, 180), Fraction(25)) for name in "abc")
    values = {"poses": (pose,), "shots": (Shot(FrameRange(0, 100), "a"),), **changes}
    return Edl(rate=Fraction(25), size=(320, 180), frames=100, reference="a", cameras=cameras, **values)


def test_the_cameras_are_told_and_how_much_is_known() -> None:
    pose = pose_of(100, (320, 180))
    assert pose.relief is not None
    told = "The scene's relief, from a and b, is known in 100% of the picture"
    assert relief_words(programme(pose), pose) == f"{told}."
    third = attrs.evolve(pose, homographies={**pose.homographies, "c": IDENTITY})
    assert relief_words(programme(third), third) == f"{told}; c keeps the plane."
    half = tuple((100,) * 48 + (20,) * 48 for _ in range(54))
    unsure = attrs.evolve(pose, relief=attrs.evolve(pose.relief, confidence=half))
    assert "50% of the picture" in relief_words(programme(unsure), unsure)


def test_a_look_without_surface_is_told() -> None:
    pose = pose_of(100, (320, 180))
    edl = programme(pose)
    off = attrs.evolve(edl, look=attrs.evolve(edl.look, surface=False))
    partly = attrs.evolve(edl, overrides=(Override(FrameRange(0, 10), surface=False),))
    assert relief_words(off, pose).endswith("The look has surface off: pictures go by the plane.")
    assert relief_words(partly, pose).endswith("The look has surface off in a part of it.")


@pytest.mark.parametrize(
    ("plugins", "why"),
    [
        ({"relief": "plane-sweep (mcsl 0.2.0)"}, ": the cameras show no relief that they agree on"),
        ({"relief": "plane (mcsl 0.2.0)"}, ": the analysis was told to (--relief plane)"),
        ({"filler": "footprint (mcsl 0.1.0)"}, ": the analysis did not look for a relief"),
        ({}, ""),
    ],
)
def test_a_plane_is_told_and_why(plugins: dict[str, str], why: str) -> None:
    pose = attrs.evolve(pose_of(100, (320, 180)), relief=None)
    made_by = MadeBy("0.2.0", {}, plugins)
    assert relief_words(programme(pose, made_by=made_by), pose) == f"The scene is taken as a plane{why}."
    assert relief_words(programme(pose), pose) == "The scene is taken as a plane."
    alone = attrs.evolve(pose, homographies={"a": IDENTITY})
    assert relief_words(programme(alone), alone).endswith(": fewer than two cameras are aligned.")
