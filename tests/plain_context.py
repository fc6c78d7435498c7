"""A filler's context whose cameras have one brightness each: the same small interface that plugins get."""

from __future__ import annotations

import numpy as np
from attrs import field, frozen

from mcsl_core.imaging.planes import Planes, blurred
from mcsl_core.imaging.rect import Rect
from mcsl_core.timing import FrameRange

SIZE = (320, 192)
RATE = 10


def grey(value, size=SIZE):
    half = (size[1] // 2, size[0] // 2)
    return Planes(np.full(size[::-1], value, np.uint8), np.full(half, 128, np.uint8), np.full(half, 128, np.uint8))


@frozen(eq=False)
class PlainContext:
    """Cameras of one brightness each (a number, None, or by frame), which show columns [left, right) of the programme.

    poses: where the lamp stands still, and columns of cameras that show something else there. asked: every picture.
    """

    columns: dict
    values: dict
    camera: str
    previous: Planes | None = None
    frame: int = 0
    rate: float = RATE
    size: tuple[int, int] = SIZE
    poses: tuple = ((FrameRange(0, 3000), {}),)
    asked: list = field(factory=list)

    def pose(self, frame):
        return next(pose for pose in self.poses if frame in pose[0])

    @property
    def still(self):
        return self.pose(self.frame)[0]

    @property
    def followed(self):
        return False

    @property
    def elsewhere(self):
        others = [still for still, _ in self.poses if still != self.still]
        earlier = [s for s in others if s.start < self.still.start]
        return earlier[::-1] + [s for s in others if s not in earlier]

    @property
    def others(self):
        return [c for c in self.columns if c != self.camera]

    @property
    def geometry(self):
        return (self.camera, tuple(self.columns.items()), self.still)

    @property
    def front(self):
        return self.picture(self.camera, Rect(0, 0, *SIZE))

    def columns_of(self, camera, frame):
        return self.pose(self.frame if frame is None else frame)[1].get(camera, self.columns[camera])

    def change(self, camera, median_of):
        return np.zeros((-(-SIZE[1] // 16), -(-SIZE[0] // 16)), np.float32)

    def footprint(self, camera, frame=None, *, parallax_corrected=False):
        left, right = self.columns_of(camera, frame)
        mask = np.zeros((SIZE[1] // 2, SIZE[0] // 2), np.uint8)
        mask[:, left // 2 : right // 2] = 255
        return mask

    def picture(self, camera, rect, median_of=(), blur_px=0.0, *, parallax_corrected=False):
        self.asked.append((camera, tuple(median_of), blur_px))
        value = self.values[camera]
        shown = [value(f) if callable(value) else value for f in median_of or (self.frame,)]
        shown = sorted(v for v in shown if v is not None)
        if not shown:
            return None
        planes = grey(16)
        left, right = self.columns_of(camera, median_of[0] if median_of else None)
        planes.y[:, left:right] = shown[(len(shown) - 1) // 2]
        planes = blurred(planes, blur_px) if blur_px else planes
        return rect.of(planes)
