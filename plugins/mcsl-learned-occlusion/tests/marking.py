"""A little operation made by hand, and somebody who marks its frames: every pixel's truth is known."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from mcsl_learned_occlusion.labelling import PAINT, read_png, save_png, write_frames

from mcsl_core.hooks import AlignedPose, AlignedView

SIZE = (480, 270)
CAMERAS = ("cam1", "cam2", "cam3")


def cloth(rng: np.random.Generator, colour: tuple[int, int, int], strength: float = 0.25) -> np.ndarray:
    """A (270, 480, 3) picture of one colour with folds and threads."""
    width, height = SIZE
    folds = np.zeros((height, width))
    for k, w in ((3, 0.3), (12, 0.5), (50, 0.6)):
        folds += w * cv2.resize(rng.normal(0, 1, (height // k + 2, width // k + 2)).astype(np.float32), SIZE)
    return np.clip(np.array(colour, np.float32) * (1 + strength * folds[..., None]), 0, 255).astype(np.uint8)


class Operation:
    """A reddish field on drapes, and things that pass over it, each before one camera.

    cam2 is turned by half a turn, cam3 is 10 % darker than the others.
    """

    def __init__(self, seed: int, drape: tuple[int, int, int] = (70, 120, 40)) -> None:
        self._rng = rng = np.random.default_rng(seed)
        self.field = np.zeros((SIZE[1], SIZE[0]), np.uint8)
        cv2.ellipse(self.field, (240, 135), (100, 65), 10, 0, 360, 1, -1)
        self.still = cloth(rng, drape)
        flesh = cloth(rng, (90, 100, 190), 0.4)
        self.still[self.field > 0] = flesh[self.field > 0]
        turn = np.array([[-1.0, 0, SIZE[0] - 1], [0, -1, SIZE[1] - 1], [0, 0, 1]])
        homographies = {"cam1": np.eye(3), "cam2": turn, "cam3": np.eye(3)}
        self.scene = AlignedPose(SIZE, "cam1", homographies, dict.fromkeys(CAMERAS, SIZE), self.field > 0)

    def moment(self) -> tuple[tuple[AlignedView, ...], dict[str, np.ndarray]]:
        """The views, and camera -> (H, W) bool in scene pixels, what something hides from it."""
        pictures, hidden = {}, {}
        for camera in CAMERAS:
            shown, mask = self.still.copy(), np.zeros(self.field.shape, np.uint8)
            if self._rng.random() < 0.6:
                middle = self._rng.uniform((100, 60), (380, 210)).astype(int).tolist()
                axes = self._rng.uniform(30, 90, 2).astype(int).tolist()
                cv2.ellipse(mask, middle, axes, float(self._rng.uniform(0, 180)), 0, 360, 1, -1)
                thing = cloth(self._rng, tuple(self._rng.uniform(20, 230, 3)), 0.15)
                shown[mask > 0] = thing[mask > 0]
            if camera == "cam2":
                shown = cv2.rotate(shown, cv2.ROTATE_180)
            if camera == "cam3":
                shown = (shown * 0.9).astype(np.uint8)
            noise = self._rng.normal(0, 1.5, shown.shape)
            pictures[camera], hidden[camera] = np.clip(shown + noise, 0, 255).astype(np.uint8), mask > 0
        return self.scene.views(pictures), hidden


def mark(
    operation: Operation, folder: Path, *, count: int = 9, moments: int = 24, elsewhere: bool = True
) -> list[Path]:
    """Exports frames of an operation and paints them, with a rim left out as by hand; the masks written."""
    filmed = [operation.moment() for _ in range(moments)]
    numbers = [25 * n for n in range(moments)]
    painted = []
    for picture in write_frames(folder, operation.scene, [views for views, _ in filmed], numbers, count=count):
        number, camera = picture.stem.split("_")
        hidden = filmed[numbers.index(int(number))][1][camera]
        kinds = np.where(hidden, 2, np.where(operation.field > 0, 1, 3 if elsewhere else 0)).astype(np.uint8)
        around = np.ones((5, 5), np.uint8)
        kinds[cv2.erode(kinds, around) != cv2.dilate(kinds, around)] = 0
        if camera == "cam2":
            kinds = cv2.rotate(kinds, cv2.ROTATE_180)
        mask = read_png(picture)  # painted over the picture, as by hand
        for kind, name in enumerate(("field", "in the way", "elsewhere"), 1):
            mask[kinds == kind] = PAINT[name]
        save_png(picture.with_suffix(".mask.png"), mask)
        painted.append(picture.with_suffix(".mask.png"))
    return painted
