"""Hypothesis strategies for valid EDLs and their parts, shared by all property tests."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from mcsl_core.edl import (
    IDENTITY,
    NO_SOUND,
    Camera,
    CenteringKey,
    Clock,
    Colour,
    Correction,
    DrawnField,
    Edl,
    FieldStretch,
    Look,
    MadeBy,
    Matrix,
    Matrix34,
    Media,
    Movement,
    Override,
    Pose,
    Relief,
    Shot,
    Weak,
)
from mcsl_core.timing import FrameRange

# Ten significant digits is what the document keeps, so these come back from it as they went in.
DIGITS = 10


def numbers(low: float, high: float) -> SearchStrategy[float]:
    """Finite floats that the document keeps exactly."""
    return st.floats(low, high).map(lambda x: float(f"{x:.{DIGITS}g}") + 0.0).filter(lambda x: low <= x <= high)


rates = st.sampled_from(
    [Fraction(24000, 1001), Fraction(25), Fraction(30000, 1001), Fraction(30), Fraction(60000, 1001)]
) | st.fractions(Fraction(1, 10), 1000, max_denominator=2000)
sizes = st.tuples(st.integers(1, 8192), st.integers(1, 8192))
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
paths = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1, max_size=8)
names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8)


def ranges(frames: int) -> SearchStrategy[FrameRange]:
    """Any range inside [0, frames)."""
    return st.integers(0, frames - 1).flatmap(
        lambda start: st.integers(start + 1, frames).map(lambda stop: FrameRange(start, stop))
    )


@st.composite
def tilings(draw: DrawFn, frames: int, most: int = 6) -> list[FrameRange]:
    """Ranges that cover [0, frames) without gap or overlap."""
    cuts = draw(st.sets(st.integers(1, frames - 1), max_size=most - 1)) if frames > 1 else set()
    points = [0, *sorted(cuts), frames]
    return [FrameRange(a, b) for a, b in zip(points, points[1:], strict=False)]


@st.composite
def ordered_ranges(draw: DrawFn, frames: int, most: int = 3) -> list[FrameRange]:
    """Some of the pieces of a tiling: in order, not overlapping, perhaps none."""
    pieces = draw(tilings(frames, 2 * most))
    return [p for p in pieces if draw(st.booleans())][:most]


@st.composite
def homographies(draw: DrawFn) -> Matrix:
    """Homographies as lamp cameras have them: any turn and mirror-free scale, mild perspective, any shift."""
    a, d = draw(numbers(0.2, 3)), draw(numbers(0.2, 3))
    b, c = draw(numbers(-0.1, 0.1)), draw(numbers(-0.1, 0.1))
    tx, ty = draw(numbers(-2000, 2000)), draw(numbers(-2000, 2000))
    g, h = draw(numbers(-1e-6, 1e-6)), draw(numbers(-1e-6, 1e-6))
    return ((a, b, tx), (c, d, ty), (g, h, 1.0))


@st.composite
def colours(draw: DrawFn) -> Colour:
    row = st.tuples(*[numbers(-2, 2)] * 3, numbers(-255, 255))
    matrix: Matrix34 = (draw(row), draw(row), draw(row))
    return Colour(matrix)


def overrides(frames: int, cameras: Sequence[str]) -> SearchStrategy[Override]:
    maybe = st.none() | st.booleans()
    return st.builds(
        Override,
        range=ranges(frames),
        camera=st.none() | st.sampled_from(cameras),
        centering=maybe,
        fill=maybe,
        colour=maybe,
        surface=maybe,
        see_through=maybe,
        offset=st.none() | st.tuples(numbers(-500, 500), numbers(-500, 500)),
        note=texts,
    )


def corrections(frames: int, cameras: Sequence[str]) -> SearchStrategy[Correction]:
    return st.builds(
        Correction, range=ranges(frames), camera=st.sampled_from(cameras), matrix=homographies(), note=texts
    )


@st.composite
def polygons(draw: DrawFn) -> tuple[tuple[float, float], ...]:
    """A triangle of some area with more points beside it, anywhere about a picture."""
    x, y, side = draw(numbers(-2000, 8000)), draw(numbers(-2000, 8000)), draw(numbers(4, 900))
    more = draw(st.lists(st.tuples(numbers(-2000, 8000), numbers(-2000, 8000)), max_size=3))
    kept = [float(f"{value:.{DIGITS}g}") for value in (x + side, y + side)]
    return ((x, y), (kept[0], y), (x, kept[1]), *more)


outlines = st.lists(polygons(), min_size=1, max_size=2).map(tuple)


def field_stretches(piece: FrameRange) -> SearchStrategy[FieldStretch]:
    return st.builds(
        FieldStretch, range=st.just(piece), by=st.sampled_from(["hand", "pictures", "middle"]), polygons=outlines
    )


def drawn_fields(frames: int) -> SearchStrategy[DrawnField]:
    return st.builds(DrawnField, range=ranges(frames), polygons=outlines, note=texts)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**12), 10**12) | numbers(-1e6, 1e6) | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)


@st.composite
def cameras(draw: DrawFn, name: str, frames: int) -> Camera:
    medium = st.builds(Media, path=paths, frames=st.integers(1, 10**7), fingerprint=texts)
    clock = st.builds(
        Clock,
        offset_s=numbers(-1e4, 1e4),
        drift_ppm=numbers(-500, 500),
        method=st.sampled_from(["timecode", "audio", "motion", "none", "hand"]),
        confidence=numbers(0, 1),
    )
    return Camera(
        name,
        tuple(draw(st.lists(medium, min_size=1, max_size=2))),
        size=draw(sizes),
        rate=draw(rates),
        clock=draw(clock),
        gaps=tuple(draw(ordered_ranges(frames))),
    )


@st.composite
def reliefs(draw: DrawFn, known: Sequence[str]) -> Relief:
    rows, columns = draw(st.integers(2, 4)), draw(st.integers(2, 4))

    def grid(values: SearchStrategy[Any]) -> Any:
        row = st.lists(values, min_size=columns, max_size=columns).map(tuple)
        return tuple(draw(st.lists(row, min_size=rows, max_size=rows)))

    projection = st.tuples(homographies(), st.tuples(*[numbers(-100, 100)] * 3)).map(
        lambda both: tuple((*row, own) for row, own in zip(*both, strict=True))
    )
    projections = draw(st.dictionaries(st.sampled_from(known), projection, min_size=1, max_size=len(known)))
    return Relief(projections, grid(numbers(-50, 50)), grid(st.integers(0, 100)))


@st.composite
def poses(draw: DrawFn, piece: FrameRange, frames: int, known: Sequence[str], reference: str) -> Pose:
    weak = [n for n in known if n != reference and draw(st.booleans())]
    tied = [n for n in known if n not in weak or (n != reference and draw(st.booleans()))]
    some: dict[str, Any] = {"max_size": len(known)}
    return Pose(
        piece,
        {n: IDENTITY if n == reference else draw(homographies()) for n in tied},
        anchor=draw(homographies()),
        perspective=draw(st.integers(0, 5)),
        colour=draw(st.dictionaries(st.sampled_from(known), colours(), **some)),
        solved_from=tuple(draw(st.lists(st.integers(0, frames), max_size=4))),
        residual_px=draw(st.dictionaries(st.sampled_from(known), numbers(0, 100), **some)),
        support=draw(st.dictionaries(st.sampled_from(known), st.integers(0, 10**5), **some)),
        weak=tuple(Weak(n, draw(texts)) for n in weak),
        relief=draw(st.none() | reliefs(known)),
    )


@st.composite
def centering_keys(draw: DrawFn, frames: int, most: int = 5) -> tuple[CenteringKey, ...]:
    at = sorted(draw(st.sets(st.integers(0, frames - 1), max_size=most)))
    return tuple((f, draw(numbers(-500, 500)), draw(numbers(-500, 500))) for f in at)


@st.composite
def removals(draw: DrawFn, frames: int) -> tuple[FrameRange, ...]:
    """What may be removed of a programme: never everything."""
    pieces = draw(ordered_ranges(frames))
    return tuple(pieces) if sum(map(len, pieces)) < frames else ()


@st.composite
def edls(draw: DrawFn, max_frames: int = 300) -> Edl:
    """Any valid EDL, small enough to be walked frame by frame."""
    frames = draw(st.integers(1, max_frames))
    known = draw(st.lists(names, min_size=1, max_size=4, unique=True))
    reference = draw(st.sampled_from(known))
    shot = st.tuples(st.sampled_from(known), numbers(0, 1), texts)
    return Edl(
        rate=draw(rates),
        size=draw(sizes),
        frames=frames,
        reference=reference,
        cameras=tuple(draw(cameras(n, frames)) for n in known),
        movements=tuple(Movement(r, draw(numbers(0, 1))) for r in draw(ordered_ranges(frames))),
        poses=tuple(draw(poses(r, frames, known, reference)) for r in draw(tilings(frames, 3))),
        shots=tuple(Shot(r, *draw(shot)) for r in draw(tilings(frames))),
        overrides=tuple(draw(st.lists(overrides(frames, known), max_size=4))),
        corrections=tuple(draw(st.lists(corrections(frames, known), max_size=2))),
        fields=tuple(draw(field_stretches(r)) for r in draw(ordered_ranges(frames))),
        drawn_fields=tuple(draw(st.lists(drawn_fields(frames), max_size=2))),
        removed=draw(removals(frames)),
        audio_from=draw(st.sampled_from([None, NO_SOUND, *known])),
        look=Look(*draw(st.tuples(*[st.booleans()] * 4))),
        centering=draw(centering_keys(frames)),
        scores=draw(st.none() | paths),
        made_by=draw(
            st.none()
            | st.builds(
                MadeBy,
                mcsl=texts,
                settings=st.dictionaries(texts, json_values, max_size=3),
                plugins=st.dictionaries(texts, texts, max_size=3),
            )
        ),
    )


@st.composite
def decided_edls(draw: DrawFn) -> Edl:
    """EDLs that differ in what is decided only: shots, overrides and look. Quicker to draw than `edls`."""
    frames = draw(st.integers(1, 120))
    known = ("cam1", "cam2", "cam3")
    return Edl(
        rate=Fraction(25),
        size=(320, 180),
        frames=frames,
        reference="cam1",
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", frames),), (320, 180), Fraction(25)) for n in known),
        poses=(Pose(FrameRange(0, frames), dict.fromkeys(known, IDENTITY)),),
        shots=tuple(Shot(r, draw(st.sampled_from(known))) for r in draw(tilings(frames))),
        overrides=tuple(draw(st.lists(overrides(frames, known), max_size=6))),
        look=Look(*draw(st.tuples(*[st.booleans()] * 4))),
    )
