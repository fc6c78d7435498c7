"""The ideal programme: what a camera would film that hung still where the reference camera stands in the first pose.

With the hands at work and at rest and their instruments; without heads, shoulders, arms that reach for the lamp, and
grain. Exposure and white balance are the reference camera's own, so that in the first pose the two differ by nothing
else. Where the field lies in it never changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path

import attrs
import cv2

from mcsl_core.imaging.planes import Planes
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Progress

from .clocks import Clock
from .field_truth import true_field
from .ground import Ground
from .optics import Optics
from .render import CameraPictures
from .scene import Scene
from .schedule import LampPath
from .truth import Truth

FOLDER = "ideal"
FILM, FIELD = "ideal.mp4", "field.png"  # by both `recording.discovery` tells this folder from a camera's
# A yardstick: 51 dB and more of what was drawn; the number of threads decides on what x264 writes.
_ENCODING = Encoding(options={"preset": "superfast", "crf": "6", "threads": "2"})


def ideal_pictures(scene: Scene, ground: Ground, frames: Iterable[int] | None = None) -> Iterator[Planes]:
    """The ideal programme's frames, one after another.

    Parameters
    ----------
    scene, ground
        What is filmed.
    frames
        Which; all without. Rising order is quick.
    """
    scenario = scene.scenario
    still = attrs.evolve(
        scene,
        scenario=attrs.evolve(scenario, noise=0.0),
        path=LampPath(scene.path.poses[:1], ()),
        persons=(),
    )
    pictures = CameraPictures(still, ground, 0, Clock(), Optics(scenario, scene.path, 0))
    for frame in range(scenario.frames) if frames is None else frames:
        yield pictures.frame(frame)[0]


def film_ideal(scene: Scene, ground: Ground, truth: Truth, folder: Path, progress: Progress) -> None:
    """Writes the ideal programme and its field.

    Parameters
    ----------
    scene, ground
        What is filmed.
    truth
        About the same scene.
    folder
        Where `FILM` goes, and `FIELD`: 255 where the picture shows the surgical field, whoever is in the way.
    progress
        Told of the frames.
    """
    scenario = scene.scenario
    progress.stage("ideal", scenario.frames, "frames")
    interval = max(1, round(Fraction(scenario.keyframe_s) * scenario.rate))
    with VideoWriter(
        folder / FILM, size=scenario.size, rate=scenario.rate, encoding=_ENCODING, keyframe_interval=interval
    ) as writer:
        for done, planes in enumerate(ideal_pictures(scene, ground), 1):
            writer.write(planes)
            progress.advance(done)
    _, png = cv2.imencode(".png", true_field(truth, 0, 0, scenario.size).astype("uint8") * 255)
    (folder / FIELD).write_bytes(png.tobytes())
