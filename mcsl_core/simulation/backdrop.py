"""The backdrop: one camera's picture of all that lies still, the ground's map resampled over the relief."""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from .floor import SHADED_MM, Floor
from .glare import Glare
from .ground import Ground
from .layers import Picture, layer_of
from .rig import PinholeCamera
from .scene import Scene
from .surface import HALF_MM

COARSE, COARSE_MOVING = 4, 8
"""Where rays meet the surface is worked out on every fourth pixel and interpolated between: the surface is smooth.
While the lamp moves, every eighth does."""
STEPS = 64
"""Steps from one state of the field to the next: finer ones change no pixel by a whole level."""
STEPS_OF_GLARE = 192
"""The same where glare wanders over it: eight a second."""
SHUTTER_S = 1 / 60


@attrs.frozen(eq=False)
class _PosePicture:
    """The picture of a pose, and where in it the field's cut-out shows.

    Attributes
    ----------
    pose, step
        Index of the pose, and step of the field's progression.
    whole
        The picture as a layer.
    picture
        The same in planes.
    window
        Rows and columns that show the cut-out; None where nothing of it shows.
    mask
        (h, w), where in the window.
    map_x, map_y
        (h, w), the positions in the cut-out that the window shows.
    """

    pose: int
    step: int
    whole: NDArray
    picture: Picture
    window: tuple[slice, slice] | None
    mask: NDArray
    map_x: NDArray
    map_y: NDArray


class Backdrop:
    """Pictures of the ground for one camera, in its own colours; quick when time rises.

    Parameters
    ----------
    scene, ground
        What is filmed.
    camera
        Its index.
    gains
        (3,), the sensor's gains of B, G, R.
    """

    def __init__(self, scene: Scene, ground: Ground, camera: int, gains: NDArray) -> None:
        self._scene, self._ground, self._camera, self._gains = scene, ground, camera, gains
        self._base = layer_of(ground.base, gains)
        traits = scene.scenario.traits
        self._floor = Floor.of(scene.scenario) if traits.floor else None
        self._floor_layer = layer_of(self._floor.picture, gains) if self._floor else None
        self._glare = Glare(ground, camera, scene.rig.azimuth_deg[camera]) if traits.glare else None
        self._steps = STEPS_OF_GLARE if traits.glare else STEPS
        self._states: dict[int, NDArray] = {}
        self._still: _PosePicture | None = None
        self._moving: tuple[int, NDArray] | None = None

    def at(self, t: float) -> tuple[Picture, PinholeCamera]:
        """The picture at programme time ``t``, not to be drawn upon, and the camera then."""
        pose, still = self._scene.path.pose(t)
        pinhole = self._scene.rig.pinhole(self._camera, pose)
        step = round(self._scene.progression.at(t) * self._steps)
        if still is None:
            if self._moving is None or self._moving[0] != step:
                self._moving = (step, self._texture(step))
            return Picture.of(self._blurred(self._moving[1], t)), pinhole
        self._moving = None
        if self._still is None or self._still.pose != still:
            self._still = self._fresh(still, step, pinhole)
        elif self._still.step != step:
            self._still = self._refreshed(self._still, step)
        return self._still.picture, pinhole

    def picture_from(self, t: float, pinhole: PinholeCamera) -> Picture:
        """The picture at programme time ``t`` of a camera that stands still at ``pinhole``."""
        step = round(self._scene.progression.at(t) * self._steps)
        return Picture.of(self._seen(self._texture(step), pinhole, self._maps(pinhole)))

    def _blurred(self, texture: NDArray, t: float) -> NDArray:
        """The picture of a moving camera while its shutter is open: the mean of two exposures."""
        exposures = []
        for instant in (t - SHUTTER_S / 4, t + SHUTTER_S / 4):
            pose, _ = self._scene.path.pose(instant)
            pinhole = self._scene.rig.pinhole(self._camera, pose)
            exposures.append(self._seen(texture, pinhole, self._maps(pinhole, COARSE_MOVING)))
        return cv2.addWeighted(exposures[0], 0.5, exposures[1], 0.5, 0)

    def _state(self, stage: int) -> NDArray:
        if stage not in self._states:
            while len(self._states) > 2:
                self._states.pop(min(self._states))
            self._states[stage] = layer_of(self._ground.state(stage, self._camera), self._gains)
        return self._states[stage]

    def _field_at(self, step: int) -> NDArray:
        stage, way = step // self._steps, step % self._steps / self._steps
        field = cv2.addWeighted(self._state(stage), 1 - way, self._state(stage + 1), way, 0)
        return self._glare.over(field, step / self._steps * self._scene.progression.stage_s) if self._glare else field

    def _texture(self, step: int) -> NDArray:
        texture = self._base.copy()
        texture[self._ground.cut] = self._field_at(step)
        return texture

    def _maps(self, pinhole: PinholeCamera, coarse: int = COARSE) -> tuple[NDArray, NDArray]:
        """Where in the ground's map each pixel lies, as `cv2.remap` takes it."""
        width, height = self._scene.scenario.size
        columns, rows = -(-width // coarse), -(-height // coarse)
        # cv2.resize puts coarse sample i at pixel coarse * i + (coarse - 1) / 2.
        x = np.arange(columns) * coarse + (coarse - 1) / 2
        y = np.arange(rows) * coarse + (coarse - 1) / 2
        gx, gy = self._scene.surface.intersect(pinhole, np.stack(np.meshgrid(x, y), -1))
        scale, shift = 1 / self._ground.pitch_mm, HALF_MM / self._ground.pitch_mm
        full = (columns * coarse, rows * coarse)
        mx, my = (cv2.resize(g * scale + shift, full, interpolation=cv2.INTER_LINEAR) for g in (gx, gy))
        return mx[:height, :width], my[:height, :width]

    def _seen(self, texture: NDArray, pinhole: PinholeCamera, maps: tuple[NDArray, NDArray]) -> NDArray:
        """The table, and the floor where the camera looks past it."""
        whole = _remapped(texture, *maps)
        if self._floor is None or self._floor_layer is None:
            return whole
        return self._floor.below(whole, self._floor_layer, pinhole, self._on_table(maps))

    def _on_table(self, maps: tuple[NDArray, NDArray]) -> tuple[NDArray, NDArray]:
        """x and y in mm of positions in the ground's map."""
        return maps[0] * self._ground.pitch_mm - HALF_MM, maps[1] * self._ground.pitch_mm - HALF_MM

    def _fresh(self, pose: int, step: int, pinhole: PinholeCamera) -> _PosePicture:
        map_x, map_y = self._maps(pinhole)
        cut = self._ground.cut
        low, high = cut[0].start + 1, cut[0].stop - 2
        mask = (map_x > low) & (map_x < high) & (map_y > low) & (map_y < high)
        if self._floor:
            mask &= self._floor.outside(*self._on_table((map_x, map_y))) < -SHADED_MM
        window = None
        if mask.any():
            rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
            window = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
            mask, map_x_cut, map_y_cut = mask[window], map_x[window] - cut[1].start, map_y[window] - cut[0].start
        else:
            map_x_cut, map_y_cut = map_x, map_y
        whole = self._seen(self._texture(step), pinhole, (map_x, map_y))
        return _PosePicture(pose, step, whole, Picture.of(whole), window, mask.astype(np.uint8), map_x_cut, map_y_cut)

    def _refreshed(self, still: _PosePicture, step: int) -> _PosePicture:
        """The same picture with the field as it has become."""
        if still.window is None:
            return attrs.evolve(still, step=step)
        whole = still.whole.copy()
        cv2.copyTo(_remapped(self._field_at(step), still.map_x, still.map_y), still.mask, whole[still.window])
        return attrs.evolve(still, step=step, whole=whole, picture=Picture.of(whole))


def _remapped(texture: NDArray, map_x: NDArray, map_y: NDArray) -> NDArray:
    return cv2.remap(texture, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
