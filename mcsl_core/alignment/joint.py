"""From matched points to one homography per camera: pairwise, robust, then all pairs together.

Homographies map full-size camera pixels to full-size reference pixels, pixel centres at integers. The field is a
relief, so true matches lie off any plane by several pixels; what they do obey is the epipolar geometry of their pair.
So matches are sifted by a generous homography and by the fundamental matrix, and the plane is then fitted by least
squares over the surgical field instead of by the count of close matches.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
import poselib
import scipy
from attrs import field, frozen

from mcsl_core.edl import Weak
from mcsl_core.imaging.geometry import Array, half_widths, transform_points
from mcsl_core.parallel import by_threads

from .correspondences import CELL_PX, Correspondences, off_epipolar
from .protocol import Alignment

Pair = tuple[str, str]
# Matches nearly all of which obey one epipolar geometry, most of them near a plane, are a relief's. Its steep sides lie
# farther off than wrong matches may; without them a limb's planes were 1.32 to 1.35 times the best, with them 1.15.
_PURE, _MOST_NEAR = 0.95, 0.6


@frozen
class AlignmentSettings:
    """When a pair of cameras is trusted; the EDL keeps all of these under their names.

    Attributes
    ----------
    relief : float
        How far a true match may lie off the plane, in diagonals of the picture.
    epipolar : float
        How far off its epipolar line, in diagonals (2 px at 960x540).
    min_support : int
        Distinct cells below which a pair is not trusted.
    min_spread : float
        Share of the picture that the hull of a pair's matches covers at least, 0..1.
    """

    relief: float = field(default=0.02)
    epipolar: float = field(default=0.0018)
    min_support: int = field(default=16)
    min_spread: float = field(default=0.015)


@frozen(eq=False)
class PairFit:
    """Two cameras tied by one homography, with the matches that agree.

    Attributes
    ----------
    homography : (3, 3) array
        Full-size pixel of camera a -> of camera b.
    kept : Correspondences
        The matches that agree.
    support : int
        In how many distinct cells they lie, in the camera where those are fewer.
    spread : float
        Share of the picture that their hull covers, 0..1, likewise.
    """

    homography: Array
    kept: Correspondences
    support: int
    spread: float


@frozen
class JointPlane:
    """All cameras tied by the plane that serves the surgical field best: robust pairs, then all pairs together.

    Attributes
    ----------
    settings : AlignmentSettings
        When a pair is trusted.
    """

    settings: AlignmentSettings = field(factory=AlignmentSettings)
    name = "joint-plane"

    def align(
        self,
        pairs: Mapping[Pair, Correspondences],
        sizes: Mapping[str, tuple[int, int]],
        reference: str,
    ) -> Alignment:
        """Ties the cameras together by the matches of their pairs; see `align` and `Aligner.align`."""
        return align(pairs, sizes, reference, self.settings)


def align(
    pairs: Mapping[Pair, Correspondences],
    sizes: Mapping[str, tuple[int, int]],
    reference: str,
    settings: AlignmentSettings | None = None,
) -> Alignment:
    """Ties every camera to the reference: pairwise fits, the tree of most agreed support, joint refinement.

    Parameters
    ----------
    pairs : mapping of (str, str) to Correspondences
        Cameras (a, b) -> their pooled matches.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    reference : str
        One of ``sizes``.
    settings : AlignmentSettings, optional
        The defaults without.

    Returns
    -------
    Alignment
        A camera that lies farther off than any relief is weak: its pairs agree in no one plane.
    """
    settings = settings or AlignmentSettings()
    names = sorted(sizes)
    order = sorted(pairs)
    fitted = by_threads(lambda pair: fit_pair(pairs[pair], sizes[pair[0]], sizes[pair[1]], settings), order)
    fits: dict[Pair, PairFit] = {pair: fit for pair, fit in zip(order, fitted, strict=True) if fit is not None}
    trusted = set(names)
    while True:
        possible = {pair: fit for pair, fit in fits.items() if trusted.issuperset(pair)}
        tied, agreed = _tie(possible, sizes, reference, settings)
        homographies = _refine(agreed, tied, reference, sizes)
        quality = {n: _quality(n, agreed, homographies) for n in homographies if n != reference}
        off = {name: rms for name, (rms, _) in quality.items()}
        worst = max(off, key=off.__getitem__, default=None)
        if worst is None or off[worst] <= settings.relief * float(np.hypot(*sizes[reference])):
            break
        trusted.remove(worst)
    residual = {name: rms for name, (rms, _) in sorted(quality.items())}
    support = {name: cells for name, (_, cells) in sorted(quality.items())}
    weak = tuple(
        Weak(name, _diagnosis(name, pairs, fits, homographies, settings)) for name in names if name not in homographies
    )
    return Alignment(homographies, residual, support, weak)


def fit_pair(
    pair: Correspondences, size_a: tuple[int, int], size_b: tuple[int, int], settings: AlignmentSettings
) -> PairFit | None:
    """Fits the homography of two cameras, robustly.

    Parameters
    ----------
    pair : Correspondences
        Their pooled matches.
    size_a, size_b : (int, int)
        Full width and height of each.
    settings : AlignmentSettings
        When the pair is trusted.

    Returns
    -------
    PairFit or None
        None when the matches do not tie the two together: judged by distinct cells and the area they span, never by the
        number of matches.

    References
    ----------
    Larsson, "PoseLib - minimal solvers for camera pose estimation", 2020: robust homography and fundamental matrix.
    """
    if len(pair) < settings.min_support:
        return None
    diagonal = float(np.hypot(*size_b))
    homography, info = poselib.estimate_homography(
        pair.a, pair.b, {"max_reproj_error": settings.relief * diagonal, "seed": 0, "max_iterations": 20000}
    )
    near = np.asarray(info["inliers"], bool)
    if near.sum() < settings.min_support:
        return None
    kept = pair.where(near)
    bound = settings.epipolar * diagonal
    fundamental, info = poselib.estimate_fundamental(
        kept.a, kept.b, {"max_epipolar_error": bound, "seed": 0, "max_iterations": 20000}
    )
    kept = kept.where(np.asarray(info["inliers"], bool))
    support = min(_cells(kept.a), _cells(kept.b))
    spread = min(_hull_area(kept.a) / (size_a[0] * size_a[1]), _hull_area(kept.b) / (size_b[0] * size_b[1]))
    if support < settings.min_support or spread < settings.min_spread:
        return None
    obeys = off_epipolar(np.asarray(fundamental), pair) < bound
    if obeys.mean() > _PURE and near.mean() > _MOST_NEAR:
        kept = pair.where(obeys)
    refined = fit_homography(kept, np.asarray(homography, np.float64))
    return None if refined is None else PairFit(refined, kept, support, spread)


def fit_homography(pair: Correspondences, start: Array, rounds: int = 10) -> Array | None:
    """Refines a homography by weighted least squares on its transfer error.

    Parameters
    ----------
    pair : Correspondences
        What counts, by its weights.
    start : (3, 3) array
        Pixel of a -> pixel of b.
    rounds : int, optional
        Steps at most.

    Returns
    -------
    (3, 3) array or None
        [2, 2] is 1. None where it degenerates.

    Notes
    -----
    Gauss-Newton on normalised points (Hartley, "In defense of the eight-point algorithm", PAMI 1997), Huber at 1.5
    times the median residual.
    """
    to_a, to_b = _normaliser(pair.a), _normaliser(pair.b)
    a, b = transform_points(to_a, pair.a), transform_points(to_b, pair.b)
    h = to_b @ start @ np.linalg.inv(to_a)
    h = h / h[2, 2]
    ones = np.ones(len(a))
    for _ in range(rounds):
        denominator = a @ h[2, :2] + h[2, 2]
        moved = (a @ h[:2, :2].T + h[:2, 2]) / denominator[:, None]
        error = moved - b
        length = np.hypot(*error.T)
        bound = 1.5 * max(float(np.median(length)), 1e-9)
        weight = pair.weight * np.minimum(1, bound / np.maximum(length, 1e-12))
        root = np.sqrt(weight)
        basis = np.column_stack([a, ones]) / denominator[:, None]
        zero = np.zeros_like(basis)
        jx = np.hstack([basis, zero, -moved[:, :1] * basis[:, :2]])
        jy = np.hstack([zero, basis, -moved[:, 1:] * basis[:, :2]])
        jacobian = np.vstack([jx, jy]) * np.tile(root, 2)[:, None]
        step = np.linalg.lstsq(jacobian, -np.concatenate([error[:, 0], error[:, 1]]) * np.tile(root, 2), rcond=None)[0]
        h = h + np.append(step, 0).reshape(3, 3)
        if np.abs(step).max() < 1e-10:
            break
    result = np.linalg.inv(to_b) @ h @ to_a
    if not np.isfinite(result).all() or abs(result[2, 2]) < 1e-12:
        return None
    return result / result[2, 2]


def _tie(
    fits: Mapping[Pair, PairFit],
    sizes: Mapping[str, tuple[int, int]],
    reference: str,
    settings: AlignmentSettings,
) -> tuple[dict[str, Array], dict[Pair, PairFit]]:
    """(homographies to the reference, the fits that agree with them), grown from the reference like a maximum
    spanning tree (Prim), but by *agreed* support: a camera is laid where most of its pairs agree that it lies.

    A pair can be wrong as a whole: two cameras that see the same head match it well, a metre off the field's plane.
    Such a pair contradicts the others, and a camera whose pairs mostly contradict it is not tied in.
    """
    tied: dict[str, Array] = {reference: np.eye(3)}
    agreed: dict[Pair, PairFit] = {}
    bound = settings.relief * float(np.hypot(*sizes[reference]))
    while True:
        best: tuple[int, str, Array, list[Pair]] | None = None
        for name in sorted(set(sizes) - set(tied)):
            pairs = [key for key in fits if name in key and (key[0] in tied or key[1] in tied)]
            for key in pairs:
                homography = _by_way_of(name, key, fits[key], tied)
                agree = [k for k in pairs if _disagreement(fits[k], tied | {name: homography}, k) < bound]
                support = sum(fits[k].support for k in agree)
                against = sum(fits[k].support for k in pairs if k not in agree)
                if support > against and (best is None or support > best[0]):
                    best = (support, name, homography, agree)
        if best is None:
            return tied, agreed
        _, name, homography, agree = best
        tied[name] = homography
        agreed |= {key: fits[key] for key in agree}


def _by_way_of(name: str, key: Pair, fit: PairFit, tied: Mapping[str, Array]) -> Array:
    """The homography of ``name`` to the reference by way of the other camera of a pair."""
    a, b = key
    h = tied[b] @ fit.homography if name == a else tied[a] @ np.linalg.inv(fit.homography)
    return h / h[2, 2]


def _disagreement(fit: PairFit, homographies: Mapping[str, Array], key: Pair) -> float:
    """Median distance in reference pixels between where a pair's two cameras have the same points."""
    a, b = key
    error = transform_points(homographies[a], fit.kept.a) - transform_points(homographies[b], fit.kept.b)
    return float(np.median(np.hypot(error[:, 0], error[:, 1])))


def _refine(
    fits: Mapping[Pair, PairFit],
    homographies: dict[str, Array],
    reference: str,
    sizes: Mapping[str, tuple[int, int]],
) -> dict[str, Array]:
    """All homographies together: 8 parameters a camera, Huber transfer error over all pairs, in reference pixels."""
    free = [name for name in homographies if name != reference]
    used = [(a, b, fit.kept) for (a, b), fit in fits.items() if a in homographies and b in homographies]
    if not free or not used:
        return homographies
    own = {name: half_widths(sizes[name]) for name in homographies}
    scale = own[reference]
    start = {n: scale @ homographies[n] @ np.linalg.inv(own[n]) for n in homographies}
    x0 = np.concatenate([(start[n] / start[n][2, 2]).ravel()[:8] for n in free])
    terms = []
    total = sum(float(kept.weight.sum()) for _, _, kept in used)
    for a, b, kept in used:
        # The reference's pairs say where a pixel belongs; the others keep the cameras consistent.
        root = np.sqrt(kept.weight / total * (1.0 if reference in (a, b) else 0.5))
        points_a, points_b = transform_points(own[a], kept.a), transform_points(own[b], kept.b)
        terms.append((a, b, points_a, points_b, np.concatenate([root, root])))

    def homography(x: Array, name: str) -> Array:
        i = free.index(name) * 8
        return np.append(x[i : i + 8], 1.0).reshape(3, 3)

    def moved(x: Array, name: str, points: Array) -> Array:
        return points if name == reference else transform_points(homography(x, name), points)

    def residuals(x: Array) -> Array:
        parts = []
        for a, b, points_a, points_b, root in terms:
            error = moved(x, a, points_a) - moved(x, b, points_b)
            parts.append(np.concatenate([error[:, 0], error[:, 1]]) * root)
        return np.concatenate(parts)

    at_start = residuals(x0)
    # Huber beyond 5 % of the width, in the units that the weights give the residuals: relief is no outlier, and the
    # plane that serves the field best is the one of least squares (1 % instead: 0.05 more of the best plane's error).
    typical = float(np.median(np.concatenate([root for *_, root in terms])))
    solved = scipy.optimize.least_squares(residuals, x0, loss="huber", f_scale=max(0.1 * typical, 1e-12), max_nfev=60)
    if not np.isfinite(solved.x).all() or np.square(solved.fun).sum() > 4 * np.square(at_start).sum():
        return homographies
    refined = {reference: np.eye(3)}
    for name in free:
        h = np.linalg.inv(scale) @ homography(solved.x, name) @ own[name]
        refined[name] = h / h[2, 2]
    return refined


def _quality(name: str, fits: Mapping[Pair, PairFit], homographies: Mapping[str, Array]) -> tuple[float, int]:
    """(weighted rms transfer error in reference pixels, distinct cells) over a camera's pairs."""
    squares, weights, points = [], [], []
    for (a, b), fit in fits.items():
        if name in (a, b) and a in homographies and b in homographies:
            error = transform_points(homographies[a], fit.kept.a) - transform_points(homographies[b], fit.kept.b)
            squares.append((error**2).sum(axis=1))
            weights.append(fit.kept.weight)
            points.append(fit.kept.a if name == a else fit.kept.b)
    rms = float(np.sqrt(np.average(np.concatenate(squares), weights=np.concatenate(weights))))
    return rms, _cells(np.concatenate(points))


def _diagnosis(
    name: str,
    pairs: Mapping[Pair, Correspondences],
    fits: Mapping[Pair, PairFit],
    homographies: Mapping[str, Array],
    settings: AlignmentSettings,
) -> str:
    """Why a camera could not be tied in, in words for a person."""
    own = {(b if a == name else a): matches for (a, b), matches in pairs.items() if name in (a, b)}
    tied = [b if a == name else a for (a, b) in fits if name in (a, b)]
    if set(tied) & homographies.keys():
        return f"its matches with {', '.join(sorted(tied))} contradict each other: they may show heads, not the field"
    if tied:
        return f"matches only {', '.join(tied)}, which cannot be tied to the reference camera either"
    if not own:
        return "no clear frame shows this camera together with another one"
    best, matches = max(own.items(), key=lambda item: len(item[1]))
    if len(matches) < settings.min_support:
        return (
            f"too few points in common with any other camera: at most {len(matches)} distinct places, with {best}; "
            f"{settings.min_support} are needed"
        )
    return (
        f"its points match no other camera in one plane: {len(matches)} distinct places match {best}, "
        "but they contradict each other or lie in one small spot"
    )


def _cells(points: Array, cell_px: float = CELL_PX) -> int:
    """In how many distinct cells the points lie."""
    return len(np.unique(np.floor(points / cell_px).astype(np.int64), axis=0))


def _hull_area(points: Array) -> float:
    return float(cv2.contourArea(cv2.convexHull(points.astype(np.float32)))) if len(points) >= 3 else 0.0


def _normaliser(points: Array) -> Array:
    """(3, 3): points moved to the origin and scaled to unit spread."""
    centre, scale = points.mean(axis=0), np.sqrt(2) / max(float(points.std(axis=0).mean()), 1e-9)
    return np.array([[scale, 0, -scale * centre[0]], [0, scale, -scale * centre[1]], [0, 0, 1]])
