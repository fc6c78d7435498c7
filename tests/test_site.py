"""The documentation site: built strictly, with every command and preset, no link broken, nothing fetched."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import click
import pytest

import mcsl_core
from mcsl_core.cli.main import cli
from mcsl_core.delivery.presets import preset_names

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
CONFIGURATION = ROOT / "mkdocs.yml"


def build(folder: Path) -> subprocess.CompletedProcess[str]:
    """Builds the pages that lie in ``folder``/docs into ``folder``/build/site, as a person would."""
    text = CONFIGURATION.read_text("utf-8")
    assert text.count("paths: [.]") == 1
    (folder / "mkdocs.yml").write_text(text.replace("paths: [.]", f"paths: ['{ROOT.as_posix()}']"), "utf-8")
    command = [sys.executable, "-m", "zensical", "build", "--strict", "--config-file", str(folder / "mkdocs.yml")]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder)


def copied(folder: Path) -> Path:
    pytest.importorskip("zensical", reason="the extra `docs` is not installed")
    shutil.copytree(DOCS, folder / "docs", ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = copied(tmp_path_factory.mktemp("site"))
    done = build(folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "build" / "site"


class Page(HTMLParser):
    """Where a page's links lead, what it loads, and the places in it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.places: set[str] = set()
        self.classes: set[str] = set()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        self.classes |= set(given.get("class", "").split())
        loads = given.get("rel", "") not in ("canonical", "next", "prev", "alternate")
        for name in ("src", "srcset", "data", "href", "xlink:href"):
            if name in given:
                loaded = name != "href" or (tag == "link" and loads)
                (self.loads if loaded else self.links).append(given[name])


def pages(site: Path) -> Iterator[tuple[Path, Page]]:
    for path in sorted(site.rglob("*.html")):
        if path.name != "404.html":  # its links count from the root of a server
            yield path, Page(path)


@pytest.mark.slow
def test_no_link_is_broken(site: Path):
    places = {path: page.places for path, page in pages(site)}
    broken = []
    for path, page in pages(site):
        for link in [*page.links, *page.loads]:
            to = urlsplit(link)
            if to.scheme in ("http", "https", "mailto", "javascript", "data"):
                continue
            target = (path.parent / unquote(to.path)).resolve() if to.path else path
            target = target / "index.html" if target.is_dir() else target
            lost = to.fragment and target in places and unquote(to.fragment) not in places[target]
            if not target.is_file() or (lost and not to.fragment.startswith("__")):
                broken.append(f"{path.relative_to(site)}: {link}")
    assert len(places) > 25
    assert not broken


@pytest.mark.slow
def test_nothing_is_loaded_from_elsewhere(site: Path):
    for path, page in pages(site):
        assert not [link for link in page.loads if urlsplit(link).scheme not in ("", "data")], path
        # What the theme's script fetches from elsewhere when a page has it:
        assert not page.classes & {"mermaid", "glightbox", "pyodide"}, path
    for style in site.rglob("*.css"):
        fetched = re.findall(r"(?:@import\s+|url\()[\"']?(?:https?:)?//[^)\"']*", style.read_text("utf-8"))
        assert not fetched, style


@pytest.mark.slow
def test_every_command_and_option_has_its_place(site: Path):
    page = (site / "reference" / "command-line.html").read_text("utf-8")

    def commands(info: dict, path: str) -> Iterator[tuple[str, dict]]:
        yield path, info
        for name, below in info.get("commands", {}).items():
            yield from commands(below, f"{path} {name}")

    info = cli.to_info_dict(click.Context(cli, info_name="mcsl"))
    known = list(commands(info, "mcsl"))
    assert len(known) > 12
    for path, command in known:
        _, found, section = page.partition(f'<h2 id="{path.replace(" ", "-")}">')
        assert found, path
        section = section.partition("<h2")[0]
        for option in command["params"]:
            if option["param_type_name"] == "option" and "--help" not in option["opts"]:
                assert option["opts"][-1] in section, (path, option["name"])


@pytest.mark.slow
def test_every_preset_and_every_name_of_the_front_door_has_its_place(site: Path):
    presets = Page(site / "reference" / "presets.html").places
    assert set(preset_names()) <= presets
    names = set(getattr(mcsl_core, "__all__", ())) - {"__version__"}
    shown = Page(site / "reference" / "front-door.html").places
    for name in names:
        assert any(place.startswith("mcsl_core.") and place.endswith(f".{name}") for place in shown), name


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrong",
    ["[a page](nowhere.md)", "[a place](tutorials/first-recording.md#nowhere)", "::: mcsl_core.nowhere"],
    ids=["page", "place", "name"],
)
def test_a_wrong_page_is_refused(tmp_path: Path, wrong: str):
    folder = copied(tmp_path)
    index = folder / "docs" / "index.md"
    index.write_text(index.read_text("utf-8") + f"\n{wrong}\n", "utf-8")
    assert build(folder).returncode != 0


# ---------------------------------------------------------------------------------------- what needs no built site


def nav_pages() -> list[str]:
    nav = CONFIGURATION.read_text("utf-8").partition("\nnav:\n")[2]
    return re.findall(r"([\w/-]+\.md)$", nav, re.MULTILINE)


def test_every_page_stands_in_the_navigation_once():
    there = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
    assert sorted(nav_pages()) == there


def shown_commands() -> list[str]:
    """Every line that begins with ``mcsl`` in a block of code, without the words that explain it."""
    lines = []
    for path in [*sorted(DOCS.rglob("*.md")), ROOT / "README.md"]:
        if path.name == "command-line.md":
            continue
        fenced = False
        for line in path.read_text("utf-8").splitlines():
            fenced = fenced != line.startswith("```")
            if line.removeprefix("    ").startswith("mcsl ") and (fenced or line.startswith("    ")):
                lines.append(re.split(r"\s{3,}", line.strip())[0])
    return sorted(set(lines))


def parse(arguments: list[str]) -> None:
    """Raises what click raises about a wrong call; runs nothing."""
    command: click.Command = cli
    ctx = None
    name: str | None = "mcsl"
    while True:
        ctx = command.make_context(name, list(arguments), parent=ctx)
        rest = [*ctx._protected_args, *ctx.args]
        if not isinstance(command, click.Group) or not rest:
            return
        name, found, arguments = command.resolve_command(ctx, rest)
        assert found is not None
        command = found


@pytest.mark.parametrize("line", shown_commands())
def test_commands_that_pages_show_can_be_given(line: str):
    if line.startswith("mcsl plugin ") and "plugin" not in cli.commands:
        pytest.skip("`mcsl plugin new` is not here yet")
    parse(shlex.split(line.partition(" #")[0])[1:])


def test_a_wrong_command_is_noticed():
    assert len(shown_commands()) > 20
    with pytest.raises(click.UsageError):
        parse(["render", "edl.json", "-o", "x.mp4", "--engin", "direct"])
    with pytest.raises(click.UsageError):
        parse(["analize", "recording/"])


def test_the_layers_told_are_those_of_the_contract():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    layers = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    page = (DOCS / "explanation" / "architecture.md").read_text("utf-8").partition("## Layers")[2].partition("\n## ")[0]
    rows = [re.findall(r"`(\w+)`", row.split("|")[1]) for row in page.splitlines() if row.startswith("| `")]
    here = {path.stem for path in (ROOT / "mcsl_core").iterdir()}
    told = [here.intersection(row) for row in rows]
    assert [row for row in told if row] == [set(re.findall(r"\w+", layer)) for layer in layers]
