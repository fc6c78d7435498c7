"""What the classifier is told about a pixel: its colour, its surroundings, its own past, and what the other views show.

Colours are log ratios, so that brighter light or another white balance shifts them all by a constant; differences from
the past are free of it altogether. Works on the whole aligned pose at half its size: (h, w) "cut" pixels, centres at
integers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from mcsl_core.hooks import U8, AlignedPose, AlignedView, Consensus, Cut, Mask

Float = NDArray[np.float32]
Box = tuple[slice, slice]  # rows and columns

COLOURS = ("red", "blue", "light")  # log(R/G), log(B/G), log(R+G+B) less the view's usual
NAMES: tuple[str, ...] = (
    *COLOURS,
    *(f"{colour} over 7" for colour in COLOURS),
    *(f"{colour} over 21" for colour in COLOURS),
    *("texture over 5", "texture over 15", "edge"),
    *(f"{colour} usually" for colour in COLOURS),
    *(f"{colour} usually over 21" for colour in COLOURS),
    *(f"{colour} usually, less the others'" for colour in COLOURS),
    "usually in the middle",
    *(f"{colour} since" for colour in COLOURS),
    *("changed", "changed over 7", "changed over 21", "unlike over 9"),
    *(f"{colour} since in the others" for colour in COLOURS),
    *("changed in the others", "no past", "no others"),
)
FIXED = sum("usually" in name for name in NAMES)
AT = {name: position for position, name in enumerate(NAMES)}
FROM_PAST = tuple(AT[n] for n in NAMES if "since" in n or "usually" in n or "changed" in n or "unlike" in n)
FROM_OTHERS = tuple(AT[n] for n in NAMES if "in the others" in n)
# What a brighter light or another white balance moves, by colour.
MOVED = {
    c: tuple(AT[n] for n in (c, f"{c} over 7", f"{c} over 21", f"{c} usually", f"{c} usually over 21"))
    for c in COLOURS[:2]
}
DARK = 8.0  # levels added before a ratio is taken: noise in the dark must not become colour
REACH = 12  # cut pixels that a pixel's features look around it, and a little more
_LOGARITHMS = np.log(np.arange(256, dtype=np.float32) + DARK)


@frozen(eq=False)
class Seen:
    """One view at one moment. picture: (h, w, 3) BGR in cut pixels. inside: (h, w), where the camera has picture."""

    picture: U8
    inside: Mask


@frozen(eq=False)
class Usual:
    """How one view looks in a stretch with nothing before it, prepared to be compared with.

    colours: (h, w, 3) log ratios. low, high: (h, w, 3), the range of Lab within a pixel. fixed: (h, w, `FIXED`), the
    features that do not change from moment to moment. light: its usual log light.
    """

    colours: Float
    low: U8
    high: U8
    fixed: Float
    light: float

    def part(self, box: Box) -> Usual:
        return evolve(
            self, colours=self.colours[box], low=self.low[box], high=self.high[box], fixed=self.fixed[box]
        )  # fmt: skip


def whole(aligned: AlignedPose) -> Cut:
    """All of the aligned, halved."""
    return Cut(0, aligned.size[1], 0, aligned.size[0])


def seen_of(views: Sequence[AlignedView], cut: Cut) -> dict[str, Seen]:
    """The views of a moment in cut pixels."""
    return {v.camera: Seen(cut.picture(v.aligned), cut.mask(v.inside)) for v in views}


def backgrounds(aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]], *, count: int = 40) -> dict[str, Seen]:
    """Every view with nothing before it, by agreement of the views (mcsl's `consensus`), all over the aligned."""
    everywhere = AlignedPose(
        aligned.size, aligned.reference, aligned.homographies, aligned.camera_sizes, np.ones(aligned.field.shape, bool)
    )
    agreed = Consensus(samples=count).scorer(everywhere, samples).background
    cut, found = whole(aligned), {}
    for views in samples:  # where a camera has picture is the same at all moments of a pose
        for view in views:
            if view.camera in agreed and view.camera not in found:
                picture = cv2.cvtColor(agreed[view.camera], cv2.COLOR_LAB2BGR)
                found[view.camera] = Seen(picture, cut.mask(view.inside))  # pyright: ignore[reportArgumentType]
        if len(found) == len(agreed):
            break
    return found


def usual_of(behind: Mapping[str, Seen]) -> dict[str, Usual]:
    """`backgrounds` prepared to be compared with."""
    colours = {name: _log_ratios(view.picture) for name, view in behind.items()}
    lights = {name: float(np.median(c[..., 2])) for name, c in colours.items()}
    found = {}
    for name, view in behind.items():
        own = colours[name] - np.array([0, 0, lights[name]], np.float32)
        fixed = [own, cv2.blur(own, (21, 21))]
        others = [n for n in behind if n != name]
        # The views' white balances differ: what is unlike the others is seen against the whole picture's difference.
        unlike = [colours[name] - colours[n] for n in others]
        unlike = [u - np.median(u[::4, ::4], axis=(0, 1)).astype(np.float32) for u in unlike]
        fixed.append(_agreed(unlike, [behind[n].inside for n in others]) if others else np.zeros_like(own))
        fixed.append(_from_middle(own.shape[:2]))
        lab = cv2.cvtColor(view.picture, cv2.COLOR_BGR2LAB)
        around = np.ones((3, 3), np.uint8)
        low, high = cv2.erode(lab, around), cv2.dilate(lab, around)
        found[name] = Usual(colours[name], low, high, np.concatenate(fixed, axis=2), lights[name])  # pyright: ignore
    return found


def to_cut(aligned: AlignedPose, camera: str, picture_size: tuple[int, int]) -> NDArray[np.float64]:
    """3x3: pixel of a reduced picture of ``camera`` -> cut pixel. Halved by area: pixel i covers 2i and 2i + 1."""
    cut = whole(aligned)
    x, y = (full / half for full, half in zip(aligned.size, cut.size, strict=True))
    halved = np.array([[1 / x, 0, 0.5 / x - 0.5], [0, 1 / y, 0.5 / y - 0.5], [0, 0, 1]])
    return halved @ aligned.warp_of(camera, picture_size)


@frozen(eq=False)
class _Since:
    """What has changed in one view: colours (h, w, 3) now, less the usual ones, and how far out of the usual range."""

    colours: Float
    less_usual: Float
    changed: Float


def features(seen: Mapping[str, Seen], usual: Mapping[str, Usual], cameras: Sequence[str]) -> dict[str, Float]:
    """camera -> (h, w, `NAMES`) of the ``cameras`` wanted, all views of the moment being in ``seen``."""
    since = {name: _since(view, usual.get(name)) for name, view in seen.items()}
    return {name: _features(name, seen, since, usual.get(name), usual) for name in cameras}


def _since(view: Seen, usual: Usual | None) -> _Since:
    picture = cv2.GaussianBlur(view.picture, (0, 0), 0.8)
    colours = _log_ratios(picture)  # pyright: ignore[reportArgumentType]
    if usual is None:
        nothing = np.zeros(colours.shape[:2], np.float32)
        return _Since(colours, np.zeros_like(colours), nothing)
    lab = cv2.cvtColor(picture, cv2.COLOR_BGR2LAB)
    out = cv2.max(cv2.subtract(lab, usual.high), cv2.subtract(usual.low, lab)).max(axis=2)
    return _Since(colours, colours - usual.colours, np.minimum(out, 80).astype(np.float32) / 40)


def _features(
    name: str,
    seen: Mapping[str, Seen],
    since: Mapping[str, _Since],
    usual: Usual | None,
    all_usual: Mapping[str, Usual],
) -> Float:
    own = since[name]
    height, width = own.changed.shape
    light = usual.light if usual else float(np.median(own.colours[..., 2]))
    now = own.colours - np.array([0, 0, light], np.float32)
    plane = np.ascontiguousarray(now[..., 2])
    parts = [now, cv2.blur(now, (7, 7)), cv2.blur(now, (21, 21))]
    parts += [_deviation(plane, 5), _deviation(plane, 15), _edge(plane)]
    fixed = usual.fixed if usual else np.zeros((height, width, FIXED), np.float32)
    before = np.ascontiguousarray(fixed[..., 2])
    parts += [fixed, own.less_usual]
    parts += [own.changed, cv2.blur(own.changed, (7, 7)), cv2.blur(own.changed, (21, 21))]
    parts.append(_unlike(plane, before) if usual else np.zeros_like(plane))
    others = [n for n in seen if n != name and n in all_usual] if usual else []
    if others:
        inside = [seen[n].inside for n in others]
        theirs = [np.dstack([since[n].less_usual, since[n].changed]) for n in others]
        parts.append(_agreed(theirs, inside))
    else:
        parts.append(np.zeros((height, width, 4), np.float32))
    parts.append(np.full((height, width), float(usual is None), np.float32))
    parts.append(np.full((height, width), float(not others), np.float32))
    return np.dstack(parts)


def without(values: Float, columns: Sequence[int], flags: Sequence[str]) -> Float:
    """(N, `NAMES`) as if what the ``columns`` tell were not known."""
    less = values.copy()
    less[:, list(columns)] = 0
    for flag in flags:
        less[:, AT[flag]] = 1
    return less


def _log_ratios(picture: U8) -> Float:
    """(h, w, 3): log(R/G), log(B/G), log of the geometric mean of the three."""
    blue, green, red = cv2.split(cv2.LUT(picture, _LOGARITHMS))
    return cv2.merge([red - green, blue - green, (red + green + blue) / 3])  # pyright: ignore[reportReturnType]


def _from_middle(shape: tuple[int, ...]) -> Float:
    """(h, w, 1): 0 in the middle of the aligned, 1 at the middle of each edge: the lamp is aimed at the field."""
    y, x = (np.linspace(-1, 1, side, dtype=np.float32) for side in shape[:2])
    return np.hypot(y[:, None], x[None])[..., None]


def _deviation(plane: Float, side: int) -> Float:
    mean, square = cv2.blur(plane, (side, side)), cv2.blur(plane * plane, (side, side))
    return np.sqrt(np.maximum(square - mean * mean, 0))


def _edge(plane: Float) -> Float:
    along, across = (cv2.Sobel(plane, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    return cv2.magnitude(along, across) / 8  # pyright: ignore[reportReturnType]


def _unlike(now: Float, before: Float, side: int = 9) -> Float:
    """1 less the correlation of two planes around each pixel: a shade leaves it near 0, another thing does not."""
    window = (side, side)
    a, b = now - cv2.blur(now, window), before - cv2.blur(before, window)
    noise = np.float32(4e-4)  # squares of log light: two levels of a hundred
    both, own, its = (cv2.blur(plane, window) for plane in (a * b, a * a, b * b))
    return np.subtract(1, both / np.sqrt((own + noise) * (its + noise)), dtype=np.float32)


def _agreed(planes: Sequence[Float], inside: Sequence[Mask]) -> Float:
    """(h, w, k): the mean over the views, of three and more without the lowest and the highest.

    A view that does not reach a pixel counts as one where nothing differs.
    """
    stack = [np.where(mask[..., None], plane, np.float32(0)) for plane, mask in zip(planes, inside, strict=True)]
    total = np.sum(stack, axis=0)
    if len(stack) < 3:
        return total / len(stack)
    return (total - np.minimum.reduce(stack) - np.maximum.reduce(stack)) / (len(stack) - 2)
