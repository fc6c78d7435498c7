"""The page: its facts against the EDL, whatever EDL; in a real browser, on a phone's width too."""

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

from mcsl_core.analysis.measurements import Measurements
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.edl import IDENTITY, Camera, Edl, MadeBy, Media, Override, Pose, Shot, Weak, load, save
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import InputError
from mcsl_core.evaluation.evaluate import evaluate
from mcsl_core.evaluation.results import to_json
from mcsl_core.hooks.registry import discover
from mcsl_core.movement.protocol import Curve
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Silent
from mcsl_core.report.facts import gather
from mcsl_core.report.page import Lacking, page, write_report
from mcsl_core.report.pictures import clearest
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


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


def page_alone(edl: Edl, measured: Measurements | None = None) -> str:
    lacking = Lacking("", "no pictures here", "no figures here")
    return page(edl, "edl.json", measured, [None] * len(edl.poses), None, lacking)


@settings(max_examples=25)
@given(edls(), st.booleans())
def test_any_edl_makes_a_whole_page(edl: Edl, scored: bool) -> None:
    said = "".join(parsed(page_alone(edl, measured_of(edl) if scored else None)).texts)
    for camera in edl.cameras:
        assert " ".join(camera.name.split()) in " ".join(said.split())
    assert "no pictures here" in said


@pytest.fixture
def edl_of_two() -> Edl:
    from fractions import Fraction

    pose = Pose(FrameRange(0, 100), {"a": IDENTITY, "b": IDENTITY})
    return Edl(
        rate=Fraction(25),
        size=(320, 180),
        frames=100,
        reference="a",
        cameras=tuple(Camera(n, (Media(f"rec/{n}.mp4", 100),), (320, 180), Fraction(25)) for n in "ab"),
        poses=(pose,),
        shots=(Shot(FrameRange(0, 50), "a"), Shot(FrameRange(50, 100), "b")),
    )


def test_what_people_wrote_is_text_and_not_markup(edl_of_two: Edl) -> None:
    note = '<script>alert(1)</script> & "quoted"'
    weak = (Weak("b", "<b>bold</b>"),)
    edl = attrs.evolve(
        edl_of_two,
        overrides=(Override(FrameRange(0, 10), camera="b", note=note),),
        poses=(attrs.evolve(edl_of_two.poses[0], weak=weak),),
    )
    text = page_alone(edl)
    assert "<script" not in text
    assert "<b>bold" not in text
    assert note in "".join(parsed(text).texts)


@pytest.mark.parametrize(
    "hostile",
    [
        "<script>alert(1)</script>",
        '"><img src=x onerror=alert(1)>',
        "'><svg onload=alert(1)>",
        "</style><script src=//evil.example/x.js>",
        "{{ 7 * 7 }}{% include 'page.html' %}",
        "javascript:alert(1)",
        "&lt;script&gt;",
        "--></title><body onload=alert(1)>",
    ],
)
def test_names_from_files_stay_names(edl_of_two: Edl, hostile: str) -> None:
    """Of cameras, files, their folder and the EDL, reasons, and the plugins that an EDL says it was made with."""
    a, b = edl_of_two.cameras
    media = (Media(f"{hostile}/{hostile}.mp4".replace("//", "/"), 100),)
    pose = Pose(FrameRange(0, 100), {hostile: IDENTITY}, weak=(Weak("b", hostile),))
    edl = attrs.evolve(
        edl_of_two,
        reference=hostile,
        cameras=(attrs.evolve(a, name=hostile, media=media), b),
        poses=(pose,),
        shots=(Shot(FrameRange(0, 50), hostile, why=hostile), Shot(FrameRange(50, 100), "b", why=hostile)),
        overrides=(Override(FrameRange(0, 10), camera=hostile, note=hostile),),
        made_by=MadeBy(hostile, {"sync": hostile}, {"selector": hostile}),
    )
    harmless, hurt = elements(page_alone(edl_of_two)), elements(page_alone(edl))
    assert hurt <= harmless | {
        "p",
        "li",
        "ul",
        "table",
        "tr",
        "td",
        "th",
        "div",
        "span",
        "section",
        "b",
        "em",
        "strong",
    }


def elements(page: str) -> set[str]:
    """The kinds of elements of a page, with their attributes that run code or load something."""
    found: set[str] = set()

    class Reader(html.parser.HTMLParser):
        def handle_starttag(self, tag, attributes):
            found.add(tag)
            found.update(
                f"{name}={value}"
                for name, value in attributes
                if name.startswith("on") or (name in ("src", "href") and not str(value).startswith(("data:", "#")))
            )

    Reader().feed(page)
    return found


def test_the_page_asks_for_nothing_from_outside(edl_of_two: Edl) -> None:
    text = page_alone(edl_of_two)
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)|url\((?!#)|@import|<link|<script""", text)
    assert "default-src 'none'" in text


def test_every_camera_colour_stands_out_from_the_page_and_from_the_others(edl_of_two: Edl) -> None:
    """3:1 against ground and card is what WCAG asks of graphics, 4.5:1 of text."""
    text = page_alone(edl_of_two)
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


def test_the_clearest_frame_is_the_one_in_which_most_is_seen(edl_of_two: Edl) -> None:
    scores = measured_of(edl_of_two).scores
    best = int(scores.frames[5])
    scores.visible[5] = 1
    pose = attrs.evolve(edl_of_two.poses[0], solved_from=tuple(int(f) for f in scores.frames))
    assert clearest(pose, scores) == best
    assert clearest(attrs.evolve(pose, solved_from=()), None) == 50


# -------------------------------------------------------------------------------------------------- the real thing


@pytest.fixture(scope="module")
def edl_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short recording with a switch, an override, a gap, a weak camera and a name that is long."""
    folder = tmp_path_factory.mktemp("report")
    simulate(Scenario(seed=307, duration_s=6, movements=0, size=(320, 180), cameras=3), folder / "recording", Silent())
    path = folder / "edl.json"
    made = analyse([folder / "recording"], path, settings=AnalysisSettings(), plugins=discover(), progress=Silent())
    shots = tuple(Shot(FrameRange(a, b), made.cameras[n].name) for a, b, n in ((0, 60, 0), (60, made.frames, 1)))
    cameras = (*made.cameras[:2], attrs.evolve(made.cameras[2], gaps=(FrameRange(20, 40),)))
    reason = "its matches with all the others contradict each other: they may show heads, not the field"
    poses = tuple(attrs.evolve(p, weak=(Weak("cam3", reason),)) for p in made.poses)
    override = Override(FrameRange(100, 140), camera="cam1", note="a_remark_without_a_single_space_" * 5)
    edl = attrs.evolve(made, shots=shots, cameras=cameras, poses=poses, overrides=(override,))
    save(edl, path)
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
    shown = 4 + (load(edl_path).poses[0].relief is not None)
    assert text.count("data:image/jpeg;base64,") == shown, "before, after, programme, field and any relief of one pose"
    assert "contradict each other" in text


def test_figures_that_were_measured_are_taken(edl_path: Path, tmp_path: Path) -> None:
    edl = load(edl_path)
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

PROBE = """<!doctype html><body><iframe id="f" src="%s" style="width:%dpx;height:900px;border:0"></iframe><script>
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


def shown_in(browser: str, report: Path, width: int, folder: Path) -> tuple[dict, list[str]]:
    """What a headless browser says of the page at ``width``, and what it wrote on its console."""
    shutil.copy(report, folder / "copy.html")
    (folder / "probe.html").write_text(PROBE % ("copy.html", width), "utf-8")
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]
    options += ["--disable-background-networking", "--disable-component-update", "--allow-file-access-from-files"]
    options += [f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr", "--v=0"]
    options += ["--virtual-time-budget=10000", "--window-size=1300,1000", "--dump-dom"]
    command = [browser, *options, (folder / "probe.html").as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    text = re.sub(r"<[^>]*>", "", done.stdout).strip()
    return json.loads(html.unescape(text)), [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1200])
def test_a_browser_shows_all_of_it_and_scrolls_down_only(
    browser: str, report: Path, tmp_path: Path, width: int
) -> None:
    seen, console = shown_in(browser, report, width, tmp_path)
    assert seen["width"] == width
    assert seen["scroll"] <= width
    assert not seen["outside"]
    assert (seen["images"], seen["broken"]) == (4, 0)
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
    seen, console = shown_in(browser, path, 390, tmp_path)
    assert seen["scroll"] > 390
    assert seen["outside"]
    assert not seen["alts"]
    assert seen["broken"] == 1
    assert any("Content Security Policy" in line for line in console)
    path.write_text(spoiled.replace("Content-Security-Policy", "x-none"), "utf-8")
    assert "http://127.0.0.1:9/x.png" in shown_in(browser, path, 390, tmp_path)[0]["fetched"]
