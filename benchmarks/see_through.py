"""How well a programme sees through heads that are pasted into one camera, against its pictures as they were.

    python -m benchmarks.see_through FOLDER NAME ...    FOLDER and NAME as of benchmarks.ideal; writes the page

Where a camera sees the field freely (by the scene's truth), a head of the size of those in the scene is pasted into its
own pictures and drifts over them; no other camera sees it, so that what the others show is right. Then the programme of
that camera is made with `see_through` and without, and both are held against the programme without the head: under the
head, and in the rest of the field. Beside it how much of the scene's own hands was replaced, which nobody covers.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Sequence
from datetime import date
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import RESULTS, table
from benchmarks.ideal_distance import distance
from mcsl_core import edl
from mcsl_core.compositing.camera_warper import CameraWarper
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.picture_source import PicturePlayer
from mcsl_core.edl import Edl, Look, Override
from mcsl_core.edl.placement import still_range
from mcsl_core.imaging.planes import Planes, median_planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.recording.footage import Footage
from mcsl_core.simulation import Truth, load_truth
from mcsl_core.timing import FrameRange

GOAL = 6.0  # dB
FREE = 0.97  # of its field that a camera must see past the scene's own heads
LASTS, EVERY = 30, 6  # frames that a head stays; frames that are judged
LOOK = Look(centering=False, fill=False, colour=True, surface=True)
CAPS = ((105, 160, 90), (120, 108, 118), (70, 140, 120))  # Y', Cb, Cr


class Pasted:
    """A `PictureSource` with a head in one camera's pictures over a stretch."""

    def __init__(self, footage: Footage, camera: str, piece: FrameRange, cap: tuple[int, int, int]) -> None:
        self._footage, self._camera, self._piece, self._cap = footage, camera, piece, cap

    def player(self, camera: str) -> PicturePlayer:
        """See `PictureSource`."""
        return _Player(self, camera, self._footage.player(camera))

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        """See `PictureSource`."""
        if camera != self._camera or not any(frame in self._piece for frame in frames):
            return self._footage.median(camera, frames, within)
        player = self.player(camera)
        found = [planes for frame in frames if (planes := player.at(frame)) is not None]
        player.close()
        return median_planes(found) if found else None

    def mask(self, size: tuple[int, int], frame: int) -> NDArray[np.float32]:
        """(H, W), 0..1: where the head is in the camera's picture."""
        part = (frame - self._piece.start) / len(self._piece)
        centre = (size[0] * (0.4 + 0.2 * part), size[1] * (0.45 + 0.1 * part))
        y, x = np.mgrid[: size[1], : size[0]]
        away = np.hypot((x - centre[0]) / (0.16 * size[0]), (y - centre[1]) / (0.2 * size[0]))
        return np.clip((1.03 - away) / 0.06, 0, 1).astype(np.float32)  # out of focus

    def painted(self, camera: str, frame: int, planes: Planes | None) -> Planes | None:
        """A picture with the head in it."""
        if planes is None or camera != self._camera or frame not in self._piece:
            return planes
        full = self.mask(planes.size, frame)
        half = cv2.resize(full, planes.u.shape[::-1], interpolation=cv2.INTER_AREA)
        fold = 12 * np.sin(np.mgrid[: planes.size[1], : planes.size[0]][1] / (0.03 * planes.size[0]))
        shade = (self._cap[0] + fold, self._cap[1], self._cap[2])
        weights = (full, half, half)
        mixed = (p * (1 - w) + s * w for p, w, s in zip(planes, weights, shade, strict=True))
        return Planes(*(np.asarray(each, np.uint8) for each in mixed))


class _Player:
    def __init__(self, pasted: Pasted, camera: str, player: PicturePlayer) -> None:
        self._pasted, self._camera, self._player = pasted, camera, player

    def at(self, frame: int) -> Planes | None:
        return self._pasted.painted(self._camera, frame, self._player.at(frame))

    def close(self) -> None:
        self._player.close()


def stretches(made: Edl, truth: Truth) -> list[tuple[str, FrameRange]]:
    """Cameras and stretches in which they see the field freely: one in each pose, and movements that are followed."""
    found = []
    for pose in made.poses:
        still = still_range(made, pose)
        for name in pose.relief.projections if pose.relief else ():
            free = truth.visible_field_without_hands[:, truth.camera_index(name)] >= FREE
            starts = range(still.start + 6, min(still.stop, len(free)) - LASTS - 6, 5)
            start = next((s for s in starts if free[s - 5 : s + LASTS + 5].all()), None)
            if start is not None:
                found.append((name, FrameRange(start, start + LASTS)))
    for movement in made.movements:
        if movement.views:
            piece = FrameRange(movement.views[0].frame, movement.views[-1].frame + 1)
            free = truth.visible_field_without_hands[max(0, piece.start - 5) : piece.stop + 5] >= FREE
            found += [(name, piece) for name in truth.cameras if free[:, truth.camera_index(name)].all()]
    return found


def measured(made: Edl, base: Path, camera: str, piece: FrameRange, cap: tuple[int, int, int]) -> NDArray[np.float64]:
    """(4,): PSNR under the head without and with seeing through; share of the rest that is replaced, and its PSNR."""
    made = attrs.evolve(made, overrides=(Override(FrameRange(0, made.frames), camera=camera),))
    footage = Footage(made.cameras, rate=made.rate, frames=made.frames, base=base)
    pasted = Pasted(footage, camera, piece, cap)
    ways = [(footage, LOOK), (pasted, LOOK), (pasted, attrs.evolve(LOOK, see_through=True))]
    pictures = []
    for source, look in ways:
        with Compositor(made, source, look=look) as compositor:
            pictures.append([planes.y.copy() for planes in compositor.frames(piece)])
    warper, whole = CameraWarper(made, footage, "linear"), Rect(0, 0, *made.size)
    rows = []
    for n in range(2, len(piece), EVERY):
        frame = piece.start + n
        head = (255 * pasted.mask(made.camera(camera).size, frame)).astype(np.uint8)
        grey = np.full((head.shape[0] // 2, head.shape[1] // 2), 128, np.uint8)
        laid = warper.warped(Planes(head, grey, grey), warper.pose_at(frame), camera, (0.0, 0.0), whole, laid="surface")
        under = laid.y > 128
        rest = cv2.dilate(under.astype(np.uint8), np.ones((25, 25), np.uint8)) == 0
        clear, plain, seen = (each[n] for each in pictures)
        told = [distance(each, clear, mask) for each, mask in ((plain, under), (seen, under), (seen, rest))]
        if all(told):
            changed = float((plain != seen)[rest].mean())
            rows.append([told[0].psnr_db, told[1].psnr_db, changed, told[2].psnr_db])  # pyright: ignore
    return np.mean(rows, axis=0)


def page(rows: Sequence[tuple[str, str, FrameRange, bool, NDArray[np.float64]]]) -> str:
    """The table, and what it comes to."""
    heads = (
        "",
        "camera",
        "frames",
        "the lamp",
        "under the head, dB: as filmed",
        "seen through",
        "elsewhere: replaced",
        "dB there",
    )
    lines = [
        "# Heads seen through\n",
        f"Made by `python -m benchmarks.see_through FOLDER NAME ...` on {date.today()}, {platform.machine()}, Python "
        f"{platform.python_version()}. Recordings of `benchmarks.ideal`, none of them tuned on.\n",
        "A head is pasted into one camera's pictures where it sees its field freely, and drifts over it; other cameras "
        "do not see it, but have the scene's own heads before them. PSNR against the pictures as they were: under the "
        "head, as filmed and seen through; and elsewhere, where the scene's own heads are seen through as well.\n",
        f"**While the lamp stands {_told([values for *_, moves, values in rows if not moves])}; while it moves "
        f"{_told([values for *_, moves, values in rows if moves])}.** Where nobody is sure to see the field under a "
        "head, the head stays: 0 dB.\n",
        table(heads, [(*at, "moves" if moves else "", *_cells(*values)) for *at, moves, values in rows]),
    ]
    return "\n".join(lines) + "\n"


def _told(values: Sequence[NDArray[np.float64]]) -> str:
    """How much nearer heads come; said of none as well."""
    if not values:
        return "there was no such head"
    gains = np.array([seen - plain for plain, seen, *_ in values])
    return (
        f"{(gains >= GOAL).sum()} of {len(gains)} heads are at least {GOAL:.0f} dB nearer, {np.median(gains):+.1f} dB "
        f"in the median, {np.mean(gains):+.1f} in the mean, {gains.min():+.1f} at worst"
    )


def _cells(plain: float, seen: float, changed: float, rest: float) -> tuple[str, ...]:
    return f"{plain:.1f}", f"{seen:.1f}", f"{changed:.2%}", f"{rest:.1f}"


def main(arguments: Sequence[str]) -> None:
    folder = Path(arguments[0])
    cv2.setNumThreads(1)
    rows = []
    for name in arguments[1:]:
        base = folder / f"{name.replace(':', '-')}.edl"
        made, truth = edl.load(base / "edl.json"), load_truth(folder / name.replace(":", "-"))
        for n, (camera, piece) in enumerate(stretches(made, truth)):
            moves = any(movement.views and piece.start == movement.views[0].frame for movement in made.movements)
            rows.append((name, camera, piece, moves, measured(made, base, camera, piece, CAPS[n % len(CAPS)])))
            print(name, camera, *np.round(rows[-1][-1], 2), flush=True)
    (RESULTS / "see_through.md").write_text(page(rows), "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
