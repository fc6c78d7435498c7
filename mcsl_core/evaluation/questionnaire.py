"""A viewers' questionnaire: do the methods differ, and which pairs of them? The paper's two tests.

Per video and factor, over all methods: Friedman's test (chi-square with k - 1 degrees of freedom, corrected for ties;
effect size Kendall's W). Per pair of methods: Wilcoxon's signed-rank test, two-sided. Participants who rated both the
same are left out of it, as Wilcoxon did; equal differences share their mean rank. With up to `EXACT` others the p is
exact, over all patterns of signs given those ranks; with more it is the normal approximation, corrected for ties.
Effect size: the matched-pairs rank-biserial correlation, (W+ - W-) / (W+ + W-). `p_holm` is p after Holm's correction
for the pairs of one video and factor; "significant" says p < 5 %, as the paper tests.

References
----------
The paper's section on its questionnaire.
M. Friedman: The use of ranks to avoid the assumption of normality. J. Am. Stat. Assoc. 32, 1937.
F. Wilcoxon: Individual comparisons by ranking methods. Biometrics Bulletin 1(6), 1945.
D. S. Kerby: The simple difference formula (rank-biserial correlation). Comprehensive Psychology 3, 2014.
S. Holm: A simple sequentially rejective multiple test procedure. Scand. J. Statistics 6(2), 1979.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from attrs import frozen
from numpy.typing import NDArray
from scipy import stats

from mcsl_core.documents import canonical_json, make_converter
from mcsl_core.errors import DocumentError
from mcsl_core.progress import counted
from mcsl_core.tables import read_table

COLUMNS = ("participant", "video", "factor", "method", "rating")
SCHEMA = "mcsl.study/1"
LEVEL = 0.05
LEAST = 6  # with five, even five out of five for one method gives p = 2 / 2**5 = 0.0625
EXACT = 15  # 2**15 patterns of signs are still counted quickly
_MOST_NAMED = 3


@frozen
class Friedman:
    """Friedman's test over all methods.

    Attributes
    ----------
    statistic, p : float or None
        Chi-square and its p; None where all participants rated all alike.
    kendall_w : float or None
        Effect size, Kendall's W, 0..1.
    significant : bool
        Whether p < `LEVEL`.
    """

    statistic: float | None
    p: float | None
    kendall_w: float | None
    significant: bool


@frozen
class Wilcoxon:
    """Wilcoxon's signed-rank test of one method against another.

    Attributes
    ----------
    a, b : str
        The methods.
    n, ties : int
        Participants who rated them differently, and those who did not.
    statistic : float
        The smaller sum of ranks.
    p, p_holm : float
        Two-sided, and after Holm's correction; 1 where nobody differed.
    effect : float
        Matched-pairs rank-biserial correlation: 1 where everybody rated ``a`` higher, -1 where ``b``.
    exact : bool
        Whether p is exact; else the normal approximation.
    significant : bool
        Whether p < `LEVEL`.
    """

    a: str
    b: str
    n: int
    ties: int
    statistic: float
    p: float
    p_holm: float
    effect: float
    exact: bool
    significant: bool


@frozen
class Result:
    """The tests of one video and factor.

    Attributes
    ----------
    video, factor : str
        As in the file.
    participants : int
        How many rated it.
    medians : mapping of str to float
        By method: the median rating.
    friedman : Friedman or None
        None with fewer than three methods.
    pairs : tuple of Wilcoxon
        Every pair of methods.
    """

    video: str
    factor: str
    participants: int
    medians: Mapping[str, float]
    friedman: Friedman | None
    pairs: tuple[Wilcoxon, ...]


def read_ratings(path: Path) -> dict[tuple[str, str], dict[str, dict[str, int]]]:
    """Read a file of ratings.

    Parameters
    ----------
    path : Path
        CSV with a line of `COLUMNS`, as `read_table` takes it.

    Returns
    -------
    dict
        (video, factor) -> method -> participant -> rating 1..5, in the file's order.

    Raises
    ------
    DocumentError
        Names the rating that is no whole number from 1 to 5, stands twice, or is missing, and a video and factor with
        too few participants.
    InputError
        Where the file cannot be read.
    """
    head = f"The first line is {','.join(COLUMNS)}"
    rows = read_table(path, wanted="a file of ratings", remedy=head)
    lacking = [name for name in COLUMNS if name not in rows.columns]
    if lacking:
        raise DocumentError(f"lacks the column {', '.join(lacking)}", where=str(path), remedy=head)
    found: dict[tuple[str, str], dict[str, dict[str, int]]] = {}
    for row in rows:
        where = f"{path}, line {row.line}"
        participant, video, factor, method, text = [row.cells[name] for name in COLUMNS]
        rating = re.fullmatch(r"([1-5])([.,]0*)?", text)  # 5.0 and 5,00 as spreadsheets write them
        if rating is None:
            raise DocumentError(
                f"the rating is {text[:40]!r}", where=where, remedy="Ratings are whole numbers from 1 to 5"
            )
        if not participant or not method:
            lacks = "method" if participant else "participant"
            raise DocumentError(f"names no {lacks}", where=where, remedy="Complete or delete the line")
        cell = found.setdefault((video, factor), {}).setdefault(method, {})
        if participant in cell:
            what = f"participant {participant} rated {method} in video {video}, factor {factor}, twice"
            raise DocumentError(what, where=where, remedy="Keep one of the two lines")
        cell[participant] = int(rating[1])
    if not found:
        raise DocumentError("holds no ratings", where=str(path), remedy=f"Add lines of {','.join(COLUMNS)}")
    _check_complete(found, path)
    return found


def _check_complete(found: Mapping[tuple[str, str], Mapping[str, Mapping[str, int]]], path: Path) -> None:
    methods = list(dict.fromkeys(m for cells in found.values() for m in cells))
    if len(methods) < 2:
        raise DocumentError(f"has one method only, {methods[0]}", where=str(path), remedy="Rate at least two methods")
    for (video, factor), cells in found.items():
        where = f"{path}, video {video}, factor {factor}"
        people = list(dict.fromkeys(p for cell in cells.values() for p in cell))
        missing = [f"{m} by {p}" for m in methods for p in people if p not in cells.get(m, {})]
        if missing:
            more = f" and {len(missing) - _MOST_NAMED} more" if len(missing) > _MOST_NAMED else ""
            raise DocumentError(
                f"lacks the rating of {', '.join(missing[:_MOST_NAMED])}{more}",
                where=where,
                remedy="The tests compare ratings within each participant: add them, or leave the participant out",
            )
        if len(people) < LEAST:
            raise DocumentError(
                f"has {counted(len(people), 'participants')}",
                where=where,
                remedy=f"At least {LEAST} are needed: with fewer no outcome can be significant at 5 %",
            )


def analyse_questionnaire(path: Path) -> tuple[Result, ...]:
    """Both tests for every video and factor of a file of ratings; raises what `read_ratings` raises."""
    return tuple(_result(video, factor, cells) for (video, factor), cells in read_ratings(path).items())


def _result(video: str, factor: str, cells: Mapping[str, Mapping[str, int]]) -> Result:
    people = list(next(iter(cells.values())))
    ratings = {method: np.array([cell[p] for p in people], np.float64) for method, cell in cells.items()}
    tests = {(a, b): wilcoxon(ratings[a] - ratings[b]) for a, b in combinations(ratings, 2)}
    holm = _holm([test.p for test in tests.values()])
    return Result(
        video,
        factor,
        len(people),
        {method: float(np.median(values)) for method, values in ratings.items()},
        friedman(list(ratings.values())) if len(ratings) > 2 else None,
        tuple(
            _pair(a, b, len(people), test, p_holm) for ((a, b), test), p_holm in zip(tests.items(), holm, strict=True)
        ),
    )


def _pair(a: str, b: str, participants: int, test: SignedRanks, p_holm: float) -> Wilcoxon:
    return Wilcoxon(
        a,
        b,
        n=test.n,
        ties=participants - test.n,
        statistic=min(test.plus, test.minus),
        p=test.p,
        p_holm=p_holm,
        effect=_effect(test.plus, test.minus),
        exact=test.exact,
        significant=test.p < LEVEL,
    )


def friedman(ratings: Sequence[NDArray[np.float64]]) -> Friedman:
    """Friedman's test.

    Parameters
    ----------
    ratings : sequence of (N,) float64
        Three or more methods' ratings, each by the same participants in the same order.

    Returns
    -------
    Friedman
    """
    if all((values == ratings[0]).all() for values in ratings):
        return Friedman(None, None, None, significant=False)
    found = stats.friedmanchisquare(*ratings)
    statistic, p = float(found[0]), float(found[1])
    return Friedman(statistic, p, statistic / (len(ratings[0]) * (len(ratings) - 1)), p < LEVEL)


class SignedRanks(NamedTuple):
    """Wilcoxon's signed-rank test of differences.

    Attributes
    ----------
    n : int
        How many are not zero.
    plus, minus : float
        W+ and W-, the sums of ranks of the positive and of the negative ones.
    p : float
        Two-sided.
    exact : bool
        Whether p is exact; else the normal approximation.
    """

    n: int
    plus: float
    minus: float
    p: float
    exact: bool


def wilcoxon(differences: NDArray[np.float64]) -> SignedRanks:
    """Wilcoxon's signed-rank test.

    Parameters
    ----------
    differences : (N,) float64
        One a participant; zeros are left out.

    Returns
    -------
    SignedRanks
    """
    kept = differences[differences != 0]
    n = len(kept)
    if n == 0:
        return SignedRanks(0, 0.0, 0.0, 1.0, True)
    ranks = stats.rankdata(np.abs(kept))
    plus, minus = float(ranks[kept > 0].sum()), float(ranks[kept < 0].sum())
    if n > EXACT:
        _, p = map(float, stats.wilcoxon(kept, zero_method="wilcox", correction=False, method="asymptotic"))
        return SignedRanks(n, plus, minus, p, False)
    # How many of the 2**n patterns of signs give each sum of positive ranks; halves, since tied ranks end in .5.
    counts = np.ones(1)
    for doubled in np.round(2 * ranks).astype(int):
        counts = np.pad(counts, (0, doubled)) + np.pad(counts, (doubled, 0))
    p = min(1.0, 2 * float(counts[: round(2 * min(plus, minus)) + 1].sum()) / 2**n)
    return SignedRanks(n, plus, minus, p, True)


def _effect(plus: float, minus: float) -> float:
    return (plus - minus) / (plus + minus) if plus + minus else 0.0


def _holm(ps: Sequence[float]) -> list[float]:
    """Holm's step-down correction of the p values of one family."""
    corrected, highest = [0.0] * len(ps), 0.0
    for rank, index in enumerate(sorted(range(len(ps)), key=lambda i: ps[i])):
        highest = max(highest, min(1.0, (len(ps) - rank) * ps[index]))
        corrected[index] = highest
    return corrected


# ------------------------------------------------------------------------------------------------------ written down


def to_json(results: Sequence[Result]) -> str:
    """Canonical text: the same ratings give the same bytes."""
    made = make_converter().unstructure(list(results))
    return canonical_json({"schema": SCHEMA, "level": LEVEL, "results": made})


def to_csv(results: Sequence[Result]) -> str:
    """One row per test: Friedman's with the methods together, then each pair's."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(
        ["video", "factor", "test", "a", "b", "n", "ties", "statistic", "p", "p_holm", "effect", "exact", "significant"]
    )
    for r in results:
        f = r.friedman
        if f is not None:
            shown = ["" if v is None else f"{v:.6g}" for v in (f.statistic, f.p)]
            effect = "" if f.kendall_w is None else f"{f.kendall_w:.6g}"
            answer = [*shown, "", effect, "no", _word(f.significant)]
            writer.writerow([r.video, r.factor, "friedman", "", "", r.participants, "", *answer])
        for w in r.pairs:
            values = [f"{v:.6g}" for v in (w.statistic, w.p, w.p_holm, w.effect)]
            answer = [*values, _word(w.exact), _word(w.significant)]
            writer.writerow([r.video, r.factor, "wilcoxon", w.a, w.b, w.n, w.ties, *answer])
    return stream.getvalue()


def _word(value: bool) -> str:
    return "yes" if value else "no"
