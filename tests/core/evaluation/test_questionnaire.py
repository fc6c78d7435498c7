"""The questionnaire's tests against scipy's own counting and against worked examples; refusals by their words."""

from __future__ import annotations

import csv
import io
import json
import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mcsl_core.errors import McslError
from mcsl_core.evaluation.questionnaire import EXACT, LEAST, analyse_questionnaire, friedman, to_csv, to_json, wilcoxon

DIFFERENCES = st.lists(st.integers(-4, 4), min_size=6, max_size=10).map(lambda v: np.array(v, float))


def table(ratings: dict[str, list[object]], video: str = "1", factor: str = "comfort") -> str:
    lines = ["participant,video,factor,method,rating"]
    for method, values in ratings.items():
        lines += [f"p{n},{video},{factor},{method},{value}" for n, value in enumerate(values)]
    return "\n".join(lines) + "\n"


def write(folder: Path, text: str) -> Path:
    path = folder / "ratings.csv"
    path.write_text(text, "utf-8")
    return path


@given(DIFFERENCES)
def test_the_exact_p_counts_all_patterns_of_signs(differences: np.ndarray) -> None:
    """Counted out one by one, ties and zeros included: what no table of Wilcoxon's test holds."""
    n, plus, minus, p, exact = wilcoxon(differences)
    kept = differences[differences != 0]
    assert (n, exact) == (len(kept), True)
    if not n:
        assert p == 1
        return
    ranks = stats.rankdata(np.abs(kept))
    assert plus + minus == pytest.approx(n * (n + 1) / 2)
    sums = [sum(r for r, up in zip(ranks, signs, strict=True) if up) for signs in product((0, 1), repeat=n)]
    extreme = np.mean([min(s, ranks.sum() - s) <= min(plus, minus) + 1e-9 for s in sums])
    assert p == pytest.approx(extreme)


def test_without_ties_it_is_scipys_exact_test() -> None:
    differences = np.array([1.0, -2, 3, 4, 5, -6, 7, 8, 9, 10, 11])
    theirs = stats.wilcoxon(differences, method="exact")
    n, plus, minus, p, exact = wilcoxon(differences)
    assert (n, min(plus, minus), exact) == (11, theirs.statistic, True)
    assert p == pytest.approx(theirs.pvalue)


def test_many_participants_take_the_normal_approximation() -> None:
    differences = np.array([1, 2, 1, -1, 2, 3, 1, 1, 2, -1, 1, 2, 4, 1, 1, -2, 1.0, 0])
    n, _, _, p, exact = wilcoxon(differences)
    assert (n, exact) == (17, False)
    assert n > EXACT
    ranks = stats.rankdata(np.abs(differences[differences != 0]))
    ties = np.unique(ranks, return_counts=True)[1]
    deviation = np.sqrt(n * (n + 1) * (2 * n + 1) / 24 - np.sum(ties**3 - ties) / 48)
    low = ranks[differences[differences != 0] < 0].sum()
    assert p == pytest.approx(2 * stats.norm.cdf((low - n * (n + 1) / 4) / deviation))


def test_friedman_by_its_formula_with_ties() -> None:
    ratings = np.array([[1, 2, 5], [1, 3, 4], [2, 2, 5], [1, 4, 4], [2, 3, 5], [1, 1, 3]], float)
    n, k = ratings.shape
    ranks = np.apply_along_axis(stats.rankdata, 1, ratings)
    spread = np.sum((ranks.sum(axis=0) - n * (k + 1) / 2) ** 2)
    ties = sum((c**3 - c).sum() for c in (np.unique(row, return_counts=True)[1] for row in ratings))
    expected = 12 * spread / (n * k * (k + 1) - ties / (k - 1))
    found = friedman(list(ratings.T))
    assert found.statistic == pytest.approx(expected)
    assert found.p == pytest.approx(stats.chi2.sf(expected, k - 1))
    assert found.kendall_w == pytest.approx(expected / (n * (k - 1)))


def test_a_study_like_the_papers(tmp_path: Path) -> None:
    """Eleven surgeons, three methods: everybody prefers the third, nobody can tell the first two apart."""
    ratings = {"no": [1, 2] * 5 + [1], "manual": [2, 1] * 5 + [1], "auto": [5, 4] * 5 + [5]}
    (result,) = analyse_questionnaire(write(tmp_path, table(ratings)))  # pyright: ignore[reportArgumentType]
    assert (result.participants, result.medians) == (11, {"no": 1, "manual": 1, "auto": 5})
    assert result.friedman is not None
    assert result.friedman.significant
    pairs = {(w.a, w.b): w for w in result.pairs}
    assert pairs["no", "manual"].p == 1
    assert pairs["no", "manual"].ties == 1
    better = pairs["manual", "auto"]
    assert (better.statistic, better.effect, better.significant) == (0, -1, True)
    assert better.p == pytest.approx(2 / 2**11)
    assert better.p_holm == pytest.approx(3 * 2 / 2**11)


def test_two_methods_have_no_friedman_test_and_all_alike_no_statistic(tmp_path: Path) -> None:
    (two,) = analyse_questionnaire(write(tmp_path, table({"a": [3] * 6, "b": [3] * 6})))
    assert two.friedman is None
    assert (two.pairs[0].n, two.pairs[0].p, two.pairs[0].significant) == (0, 1, False)
    (three,) = analyse_questionnaire(write(tmp_path, table({"a": [3] * 6, "b": [3] * 6, "c": [3] * 6})))
    assert three.friedman is not None
    assert (three.friedman.statistic, three.friedman.significant) == (None, False)


def test_what_is_written_is_what_was_found(tmp_path: Path) -> None:
    path = write(tmp_path, table({"a": [1, 2, 1, 2, 1, 2], "b": [3, 4, 3, 2, 5, 5], "c": [3, 3, 3, 3, 3, 3]}))
    results = analyse_questionnaire(path)
    value = json.loads(to_json(results))
    assert value["results"][0]["pairs"][0]["p"] == pytest.approx(results[0].pairs[0].p)
    rows = list(csv.DictReader(io.StringIO(to_csv(results))))
    assert [row["test"] for row in rows] == ["friedman", "wilcoxon", "wilcoxon", "wilcoxon"]
    assert float(rows[1]["p"]) == pytest.approx(results[0].pairs[0].p, rel=1e-5)
    assert rows[1]["ties"] == "1"


def test_separators_of_spreadsheets_are_read(tmp_path: Path) -> None:
    text = table({"a": [1] * 6, "b": [2, 3, 4, 5, 5, 5]})
    plain = analyse_questionnaire(write(tmp_path, text))
    for separator in ";\t":
        assert analyse_questionnaire(write(tmp_path, "\ufeff" + text.replace(",", separator))) == plain


FAULTS = Path(__file__).parents[3].parent / "shared" / "data" / "faults" / "ratings"
WRITTEN_OTHERWISE = {
    "trailing separators": lambda text: text.replace("\n", ",,\n"),
    "empty lines of a spreadsheet": lambda text: text.replace("\n", "\r\n") + ",,,,\r\n,,,,\r\n",
    "UTF-16": lambda text: text.replace(",", "\t").encode("utf-16"),
    "UTF-16, the other order": lambda text: b"\xfe\xff" + text.encode("utf-16-be"),
    "decimals": lambda text: re.sub(r",(\d)\n", r",\1.0\n", text),
    "decimal commas": lambda text: re.sub(r";(\d)\n", r";\1,00\n", text.replace(",", ";")),
    "quotation marks": lambda text: re.sub(r"(p\d)", r'"\1"', text),
    "blanks": lambda text: text.replace(",", " , "),
    "old Macintosh": lambda text: text.replace("\n", "\r"),
}


@pytest.mark.parametrize("name", WRITTEN_OTHERWISE)
def test_ratings_as_spreadsheets_write_them_are_the_same_ratings(tmp_path: Path, name: str) -> None:
    text = table({"a": [1] * 6, "b": [2, 3, 4, 5, 5, 5]})
    plain = analyse_questionnaire(write(tmp_path, text))
    other = WRITTEN_OTHERWISE[name](text)
    path = tmp_path / "other.csv"
    path.write_bytes(other if isinstance(other, bytes) else other.encode())
    assert analyse_questionnaire(path) == plain


@pytest.mark.parametrize("name", ["trail", "u16", "float"])
def test_the_odd_files_that_were_reported_are_read(name: str) -> None:
    if not FAULTS.is_dir():
        pytest.skip("the material is not here")
    (result,) = analyse_questionnaire(FAULTS / f"s_{name}.csv")
    assert (result.participants, len(result.pairs)) == (8, 3)


FULL = {"a": [1, 2, 3, 4, 5, 1], "b": [2, 2, 3, 3, 5, 5]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (table({"a": [1, 2, 3, 4, 5, 1], "b": [2, 2, 3, 3, 5]}), "lacks the rating of b by p5"),
        (table({**FULL, "b": [2, 2, 3, 3, 5, "4.5"]}), "line 13: the rating is '4.5'"),
        (table({**FULL, "b": [2, 2, 3, 3, 5, 6]}), "the rating is '6'"),
        (table({**FULL, "b": [2, 2, 3, 3, 5, ""]}), "the rating is ''"),
        (table(FULL) + "p1,1,comfort,a,3\n", "participant p1 rated a in video 1, factor comfort, twice"),
        (table({k: v[: LEAST - 1] for k, v in FULL.items()}), "has 5 participants. At least 6 are needed"),
        (table({"a": FULL["a"]}), "has one method only"),
        (table(FULL).replace("factor", "question", 1), "lacks the column factor"),
        ("participant,video,factor,method,rating\n", "holds no ratings"),
        ("", "is empty. The first line is participant,"),
        (table(FULL) + ",1,comfort,a,3\n", "line 14: names no participant"),
        (table(FULL) + "p6,1,comfort,a,3,4\n", "line 14: has 6 cells"),
        (table(FULL) + 'p6,1,"comfort,a,3\n', "line 14: a quotation mark is opened and not closed"),
        (table(FULL) + table({"a": FULL["a"]}, video="2").partition("\n")[2], "lacks the rating of b by p0, b by p1"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(McslError) as refused:
        analyse_questionnaire(write(tmp_path, text))
    assert message in str(refused.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(McslError, match="does not exist"):
        analyse_questionnaire(tmp_path / "none.csv")
