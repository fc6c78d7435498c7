"""The report: its curves and bars against the EDL, whatever EDL; the page in a real browser, on a phone's width too."""

from __future__ import annotations

import html.parser
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import edls

from mcsl_core import edl as document
from mcsl_core.analysis.measurements import Measurements
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.edl import Camera, Edl, Override, Weak
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import InputError
from mcsl_core.evaluation.evaluate import evaluate
from mcsl_core.evaluation.results import to_json
from mcsl_core.hooks.registry import discover
from mcsl_core.movement.protocol import Curve
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Silent
from mcsl_core.report.charts import BINS, HEIGHT, WIDTH, bar, binned, line, short_time, time_ticks
from mcsl_core.report.facts import gather
from mcsl_core.report.page import page, write_report
from mcsl_core.report.pictures import clearest, superimposed
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


# --------------------------------------------------------------------------------------------------------- charts


def points_of(path: str) -> list[list[tuple[float, float]]]:
    return [
        [(float(x), float(y)) for x, y in (pair.split() for pair in run.rstrip("Z").split("L"))]
        for run in path.split("M")[1:]
    ]


def test_a_curve_breaks_where_there_is_no_data() -> None:
    x, y = np.arange(6) * 20.0, np.array([0, 0.5, np.nan, 1, np.nan, 0.25])
    first, second, third = points_of(line(x, y, 100, 0, 1))
    assert first == [(0, HEIGHT), (200, HEIGHT / 2)]
    assert second[0] == (600, 0)
    assert len(second) == len(third) == 2, "a point alone is drawn as a dash"
    closed = points_of(line(x, y, 100, 0, 1, closed=True))
    assert closed[0][-2:] == [(200, HEIGHT), (0, HEIGHT)]
    assert line(x, np.full(6, np.nan), 100, 0, 1) == ""


def test_hours_of_samples_become_few_points_that_keep_their_peaks() -> None:
    frames = np.arange(20_000) * 30
    values = np.zeros(20_000)
    values[12_345] = 1
    values[:100] = np.nan
    x, y = binned(frames, values, 600_000, keep="max")
    assert len(x) == BINS
    assert np.nanmax(y) == 1
    assert np.isnan(y[0])
    assert np.nanmax(binned(frames, values, 600_000)[1]) == pytest.approx(1 / 50)


@pytest.mark.parametrize(
    ("seconds", "texts"),
    [
        (4, ["0:00", "0:01", "0:02", "0:03"]),
        (600, ["0:00", "2:00", "4:00", "6:00", "8:00"]),
        (7200, ["0:00:00", "0:30:00", "1:00:00", "1:30:00"]),
    ],
)
def test_ticks_are_round_and_few(seconds: float, texts: list[str]) -> None:
    assert [t.text for t in time_ticks(seconds)] == texts


@given(st.floats(0.04, 200_000))
def test_ticks_lie_on_the_axis(seconds: float) -> None:
    ticks = time_ticks(seconds)
    assert 1 <= len(ticks) <= 14
    assert all(0 <= float(t.at) <= 96 for t in ticks)
    assert short_time(3599.6) == "1:00:00"


@given(st.integers(1, 10**6).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n - 1))), st.integers(1, 10**6))
def test_bars_stay_inside_and_can_be_seen(place: tuple[int, int], length: int) -> None:
    frames, start = place
    made = bar(start, min(start + length, frames), frames, "", "")
    assert float(made.x) >= 0
    assert float(made.width) >= 1.5
    assert float(made.x) + float(made.width) <= WIDTH + 0.011


# ---------------------------------------------------------------------------------------------------------- facts


def measured_of(edl: Edl, visible: float = 0.5) -> Measurements:
    frames = np.unique(np.linspace(0, edl.frames - 1, 9).astype(np.int64))
    shape = (len(frames), len(edl.cameras))
    values = np.full(shape, visible)
    values[:, 0] = 1
    curve = Curve("degree of misalignment", "px", frames, frames * 1.0, np.full(len(frames), 5.0))
    return Measurements(ScoreTable(frames, tuple(c.name for c in edl.cameras), values, np.ones(shape, bool)), curve)


@given(edls())
def test_the_bars_tile_the_programme_and_tell_the_resolved_camera(edl: Edl) -> None:
    facts = gather(edl, None)
    shown = [(p, d.camera) for p, d in resolve(edl)]
    changes = sum(a[1] != b[1] for a, b in zip(shown, shown[1:], strict=False))
    assert len(facts.programme) == changes + 1
    assert len(facts.lanes) == len(edl.cameras)
    assert sum(len(lane.chosen) for lane in facts.lanes) == changes + 1
    assert [t.value for t in facts.tiles if t.label.startswith("switch")] == [str(changes)]
    assert len(facts.overrides) == len(edl.overrides)
    assert all(c.gaps == "" or " to " in c.gaps for c in facts.clocks)


def test_the_visible_share_is_that_of_the_cameras_shown(edl_of_two: Edl) -> None:
    """The first half from the camera that sees all, the second from the one that sees half."""
    facts = gather(edl_of_two, measured_of(edl_of_two))
    tile = next(t for t in facts.tiles if t.label == "of the field visible")
    frames = measured_of(edl_of_two).scores.frames
    expected = np.where(frames < 50, 1, 0.5).mean()
    assert tile.value == f"{expected:.0%}"
    assert facts.movement is not None
    assert facts.movement.label == "degree of misalignment"


class _Balance(html.parser.HTMLParser):
    """Every element that is opened is closed, in order."""

    VOID = frozenset({"meta", "img", "br"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.faults: list[str] = []
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.faults.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def parsed(text: str) -> _Balance:
    balance = _Balance()
    balance.feed(text)
    assert not balance.faults
    assert not balance.open
    return balance


def bare(edl: Edl, measured: Measurements | None = None) -> str:
    return page(edl, "edl.json", measured, "", [None] * len(edl.poses), "no pictures here", None, "no figures here")


@settings(max_examples=25)
@given(edls(), st.booleans())
def test_any_edl_makes_a_whole_page(edl: Edl, scored: bool) -> None:
    said = "".join(parsed(bare(edl, measured_of(edl) if scored else None)).texts)
    for camera in edl.cameras:
        assert " ".join(camera.name.split()) in " ".join(said.split())
    assert "no pictures here" in said


@pytest.fixture
def edl_of_two() -> Edl:
    from fractions import Fraction

    pose = document.Pose(FrameRange(0, 100), {"a": document.IDENTITY, "b": document.IDENTITY})
    return Edl(
        rate=Fraction(25),
        size=(320, 180),
        frames=100,
        reference="a",
        cameras=tuple(Camera(n, (document.Media(f"rec/{n}.mp4", 100),), (320, 180), Fraction(25)) for n in "ab"),
        poses=(pose,),
        shots=(document.Shot(FrameRange(0, 50), "a"), document.Shot(FrameRange(50, 100), "b")),
    )


def test_what_people_wrote_is_text_and_not_markup(edl_of_two: Edl) -> None:
    note = '<script>alert(1)</script> & "quoted"'
    weak = (Weak("b", "<b>bold</b>"),)
    edl = attrs.evolve(
        edl_of_two,
        overrides=(Override(FrameRange(0, 10), camera="b", note=note),),
        poses=(attrs.evolve(edl_of_two.poses[0], weak=weak),),
    )
    text = bare(edl)
    assert "<script" not in text
    assert "<b>bold" not in text
    assert note in "".join(parsed(text).texts)


def test_the_page_asks_for_nothing_from_outside(edl_of_two: Edl) -> None:
    text = bare(edl_of_two)
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)|url\((?!#)|@import|<link|<script""", text)
    assert "default-src 'none'" in text


def test_every_camera_colour_stands_out_from_the_page_and_from_the_others(edl_of_two: Edl) -> None:
    """3:1 against ground and card is what WCAG asks of graphics, 4.5:1 of text."""
    text = bare(edl_of_two)
    themes = [dict(re.findall(r"--(\w+): (#\w+)", block)) for block in re.findall(r":root \{([^}]*)\}", text)]
    assert len(themes) == 2
    for theme in themes:
        cameras = [theme[f"c{n}"] for n in range(7)]
        assert len(set(cameras)) == 7
        for ground in (theme["ground"], theme["card"]):
            assert min(contrast(colour, ground) for colour in (*cameras, theme["move"])) >= 3
            assert min(contrast(theme[name], ground) for name in ("text", "soft", "warn")) >= 4.5


def contrast(a: str, b: str) -> float:
    """WCAG 2's contrast ratio of two colours such as #fff or #0072b2."""

    def luminance(colour: str) -> float:
        digits = colour[1:] if len(colour) == 7 else "".join(2 * c for c in colour[1:])
        parts = [int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4)]
        r, g, b = (p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


def test_the_clearest_moment_is_the_one_in_which_most_is_seen(edl_of_two: Edl) -> None:
    scores = measured_of(edl_of_two).scores
    best = int(scores.frames[5])
    scores.visible[5] = 1
    pose = attrs.evolve(edl_of_two.poses[0], solved_from=tuple(int(f) for f in scores.frames))
    assert clearest(pose, scores) == best
    assert clearest(attrs.evolve(pose, solved_from=()), None) == 50


def test_views_laid_over_each_other_are_their_mean_where_they_reach() -> None:
    dark, light = np.full((10, 20, 3), 40, np.uint8), np.full((10, 20, 3), 240, np.uint8)
    aside = np.array([[1, 0, 10.0], [0, 1, 0], [0, 0, 1]])
    made = superimposed({"a": dark, "b": light}, {"a": np.eye(3), "b": aside}, (20, 10))
    assert (made[:, :10] == 40).all()
    assert (made[:, 10:] == 140).all()


# -------------------------------------------------------------------------------------------------- the real thing


@pytest.fixture(scope="module")
def edl_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short recording with a switch, an override, a gap, a weak camera and a name that is long."""
    folder = tmp_path_factory.mktemp("report")
    simulate(Scenario(seed=307, duration_s=6, movements=0, size=(320, 180), cameras=3), folder / "recording", Silent())
    path = folder / "edl.json"
    made = analyse([folder / "recording"], path, settings=AnalysisSettings(), plugins=discover(), progress=Silent())
    shots = tuple(
        document.Shot(FrameRange(a, b), made.cameras[n].name) for a, b, n in ((0, 60, 0), (60, made.frames, 1))
    )
    cameras = (*made.cameras[:2], attrs.evolve(made.cameras[2], gaps=(FrameRange(20, 40),)))
    reason = "its matches with all the others contradict each other: they may show heads, not the field"
    poses = tuple(attrs.evolve(p, weak=(Weak("cam3", reason),)) for p in made.poses)
    override = Override(FrameRange(100, 140), camera="cam1", note="a_remark_without_a_single_space_" * 5)
    edl = attrs.evolve(made, shots=shots, cameras=cameras, poses=poses, overrides=(override,))
    document.save(edl, path)
    return path


@pytest.fixture(scope="module")
def report(edl_path: Path) -> Path:
    out = edl_path.with_name("report.html")
    write_report(edl_path, out)
    return out


def test_the_same_edl_gives_the_same_bytes_and_tells_nothing_of_the_machine(report: Path, edl_path: Path) -> None:
    again = report.with_name("again.html")
    write_report(edl_path, again)
    assert again.read_bytes() == report.read_bytes()
    text = report.read_text("utf-8")
    parsed(text)
    assert str(edl_path.parent) not in text
    assert text.count("data:image/jpeg;base64,") == 3, "before, after and programme of one pose"
    assert "contradict each other" in text


def test_figures_that_were_measured_are_taken(edl_path: Path, tmp_path: Path) -> None:
    edl = document.load(edl_path)
    figures = tmp_path / "figures.json"
    done = evaluate(edl, edl_path.parent, every=60)
    figures.write_text(to_json(done), "utf-8")
    write_report(edl_path, tmp_path / "r.html", figures_path=figures)
    text = (tmp_path / "r.html").read_text("utf-8")
    assert "whole programme" in text
    whole = done.row("auto").whole
    assert whole is not None
    assert f"{whole.itf_db:.1f}" in text
    with pytest.raises(InputError):
        write_report(edl_path, tmp_path / "r.html", figures_path=tmp_path / "none.json")


def test_what_is_missing_is_told_in_its_place(edl_path: Path, tmp_path: Path) -> None:
    shutil.copy(edl_path, tmp_path / "edl.json")
    write_report(tmp_path / "edl.json", tmp_path / "r.html")
    text = (tmp_path / "r.html").read_text("utf-8")
    said = " ".join("".join(parsed(text).texts).split())
    assert "What each camera sees over time is not known: edl.scores.npz is missing" in said
    assert "The pictures cannot be shown: recording/cam1.mp4" in said
    assert "The steadiness cannot be measured: recording/" in said
    assert str(tmp_path) not in text


# ------------------------------------------------------------------------------------------------------ a browser

LOOK = """<!doctype html><body><iframe id="f" src="%s" style="width:%dpx;height:900px;border:0"></iframe><script>
f.onload = () => {
  const d = f.contentDocument, w = f.contentWindow, images = [...d.images];
  document.body.textContent = JSON.stringify({
    width: w.innerWidth, scroll: d.documentElement.scrollWidth,
    outside: [...d.querySelectorAll("main *")].filter(e => !e.closest("svg") || e.localName == "svg")
      .filter(e => e.getBoundingClientRect().right > w.innerWidth + 0.5).map(e => e.className || e.localName),
    images: images.filter(i => i.complete && i.naturalWidth > 0).length,
    broken: images.filter(i => !i.naturalWidth).length,
    alts: images.every(i => i.alt) && [...d.querySelectorAll("svg")].every(s => s.getAttribute("aria-label")),
    fetched: w.performance.getEntriesByType("resource").map(e => e.name).filter(n => !n.startsWith("data:")),
  });
};
</script></body>"""


@pytest.fixture(scope="session")
def browser() -> str:
    given = os.environ.get("MCSL_BROWSER")
    found = given or next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if not found:
        pytest.skip("no browser here (Debian: apt-get install -y chromium; another: MCSL_BROWSER)")
    return found


def look(browser: str, report: Path, width: int, folder: Path) -> tuple[dict, list[str]]:
    """What a headless browser says of the page at ``width``, and what it wrote on its console."""
    shutil.copy(report, folder / "looked-at.html")
    (folder / "look.html").write_text(LOOK % ("looked-at.html", width), "utf-8")
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]
    options += ["--disable-background-networking", "--disable-component-update", "--allow-file-access-from-files"]
    options += [f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr", "--v=0"]
    options += ["--virtual-time-budget=10000", "--window-size=1300,1000", "--dump-dom"]
    command = [browser, *options, (folder / "look.html").as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    text = re.sub(r"<[^>]*>", "", done.stdout).strip()
    return json.loads(html.unescape(text)), [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1200])
def test_a_browser_shows_all_of_it_and_scrolls_down_only(
    browser: str, report: Path, tmp_path: Path, width: int
) -> None:
    seen, console = look(browser, report, width, tmp_path)
    assert seen["width"] == width
    assert seen["scroll"] <= width
    assert not seen["outside"]
    assert (seen["images"], seen["broken"]) == (3, 0)
    assert seen["alts"]
    assert not seen["fetched"]
    assert not console


@pytest.mark.slow
def test_the_browser_would_tell_what_is_wrong(browser: str, report: Path, tmp_path: Path) -> None:
    """Each of its checks is broken on purpose."""
    text = report.read_text("utf-8")
    picture = '<img src="http://127.0.0.1:9/x.png" alt="">'
    spoiled = text.replace("<header>", f'<header><div style="width:500px">wide</div>{picture}')
    path = tmp_path / "spoiled.html"
    path.write_text(spoiled, "utf-8")
    seen, console = look(browser, path, 390, tmp_path)
    assert seen["scroll"] > 390
    assert seen["outside"]
    assert not seen["alts"]
    assert seen["broken"] == 1
    assert any("Content Security Policy" in line for line in console)
    path.write_text(spoiled.replace("Content-Security-Policy", "x-none"), "utf-8")
    assert "http://127.0.0.1:9/x.png" in look(browser, path, 390, tmp_path)[0]["fetched"]
