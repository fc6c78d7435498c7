"""docs/hooks.md keeps its word: a package written from it alone changes a recording's shots, and nothing else is done.

Everything here runs the real command line with the package installed by pip into a folder of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hooks_page import blocks, shown_plugins, write_package

from mcsl_core import edl
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

PRINTS = """
import os
print("hello from the plugin")
os.write(1, b"hello from its library\\n")
os.system("echo hello from its child")
"""


@pytest.mark.parametrize("text", blocks("python"), ids=lambda text: text.split('name = "')[1].split('"')[0])
def test_the_plugins_of_the_page_are_short(text: str) -> None:
    lines = [line for line in text.splitlines() if line.strip()]
    assert len(lines) < 40


def test_every_plugin_of_the_page_is_found_by_its_name() -> None:
    here = discover(shown_plugins(), entry_points=False).offers
    shown = {(o.stage, o.name): o for o in here if o.package == "docs/hooks.md"}
    assert set(shown) == {("occlusion", "own-past"), ("selector", "last-camera"), ("filler", "behind")}
    assert all(len(o.summary) > 20 for o in shown.values())


def test_the_table_of_the_page_is_what_comes_with_mcsl() -> None:
    from hooks_page import PAGE

    from mcsl_core.hooks.stages import STAGES

    for stage, kind in STAGES.items():
        names = ", ".join(f"`{o.name}`" for o in discover(entry_points=False).offers if o.stage == stage)
        row = next(line for line in PAGE.read_text("utf-8").splitlines() if f"| `{kind.hook}` |" in line)
        assert row.endswith(f"| `{kind.hook}` | `--{stage}` | {names} |")


class Desk:
    """Somebody's machine: mcsl, and a folder that pip installs into."""

    def __init__(self, folder: Path) -> None:
        self.installed = folder / "installed"
        self.recording = folder / "recording"
        self.edl = folder / "edl.json"

    def mcsl(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "mcsl_core.cli", *(str(a) for a in arguments)]
        environment = {**os.environ, "PYTHONPATH": str(self.installed)}
        return subprocess.run(command, capture_output=True, text=True, env=environment, cwd=self.installed.parent)

    def shots(self, *options: str) -> list[tuple[int, str]]:
        done = self.mcsl("--progress", "json", "analyse", self.recording, "-o", self.edl, *options)
        assert done.returncode == 0, done.stdout[-500:] + done.stderr[-500:]
        assert [list(json.loads(line)) for line in done.stdout.splitlines()][-1] == ["result"]
        self.said = done.stderr
        return [(s.range.start, s.camera) for s in edl.load(self.edl).shots]


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    desk = Desk(tmp_path_factory.mktemp("elsewhere"))
    scenario = Scenario(seed=313, duration_s=40, size=(320, 180), rate=8, cameras=4, movements=0, heads=4)
    simulate(scenario, desk.recording, Silent())
    return desk


@pytest.mark.slow
def test_a_package_from_the_page_changes_the_shots_by_pip_install_and_its_name_alone(desk: Desk, tmp_path) -> None:
    """About a minute: simulated, analysed as it comes, the package installed, analysed by its detector."""
    before = desk.shots()
    refused = desk.mcsl("analyse", desk.recording, "-o", desk.edl, "--occlusion", "own-past")
    assert refused.returncode == 2
    assert "there is no occlusion detector named 'own-past'. Choose one of consensus, hue-area" in refused.stderr

    write_package(tmp_path)
    # --no-deps: mcsl is there. pip brings the page's build system by itself, as it does for everybody.
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(desk.installed), "."]
    done = subprocess.run(install, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr

    rows = json.loads(desk.mcsl("plugins", "--json").stdout)
    row = next(r for r in rows if r["name"] == "own-past")
    assert (row["stage"], row["package"], row["version"], row["default"]) == ("occlusion", "own-past", "0.1", False)
    after = desk.shots("--occlusion", "own-past")
    assert {camera for _, camera in after} != {camera for _, camera in before} or len(after) != len(before)
    made = edl.load(desk.edl).made_by
    assert made is not None
    assert made.plugins["occlusion"] == "own-past (own-past 0.1)"

    # The same package, that prints, then fails, then is gone: nothing it says is lost, nothing it does is silent.
    module = desk.installed / "own_past.py"
    right = module.read_text("utf-8")
    module.write_text(right + PRINTS, "utf-8")
    assert desk.shots("--occlusion", "own-past") == after
    assert {f"hello from {who}" for who in ("the plugin", "its library", "its child")} <= set(desk.said.splitlines())
    assert row in json.loads(desk.mcsl("plugins", "--json").stdout)

    module.write_text(right.replace("float((apart < 40)", "float('nan' if 1 else (apart < 40)"), "utf-8")
    wrong = desk.mcsl("--progress", "json", "analyse", desk.recording, "-o", desk.edl, "--occlusion", "own-past")
    assert wrong.returncode == 4
    assert json.loads(wrong.stdout.splitlines()[-1])["error"] == {
        "what": "score gave nan for camera cam1, expected a number in 0..1",
        "where": "occlusion detector own-past (own-past 0.1)",
        "remedy": "Report it to the author of own-past, or choose another with --occlusion",
        "exit_code": 4,
    }
    module.write_text("import nosuch_library\n", "utf-8")
    broken = desk.mcsl("plugins")
    assert broken.returncode == 0
    assert broken.stderr == (
        "plugin own-past 0.1 (own_past) cannot be imported: ModuleNotFoundError: No module named 'nosuch_library': "
        "it is left out. Repair or uninstall it: pip uninstall own-past\n"
    )
    module.write_text(right, "utf-8")


@pytest.mark.slow
def test_a_filler_that_is_not_here_is_asked_for_by_package_and_version(desk: Desk) -> None:
    """An EDL from another machine: what made it is named, whoever needs it."""
    desk.shots()
    made = json.loads(desk.edl.read_text("utf-8"))
    assert set(made["made_by"]["plugins"]) == {
        *("movement", "matcher", "aligner", "relief", "tracker", "occlusion", "selector", "centerer", "filler")
    }
    made["made_by"]["plugins"]["filler"] = "watercolour (hospital-fillers 2.3)"
    other = desk.edl.with_name("other.json")
    other.write_text(json.dumps(made), "utf-8")
    expected = (
        "the EDL: was made with the filler watercolour (hospital-fillers 2.3), which is not installed. "
        "Install hospital-fillers 2.3, or analyse again with another --filler"
    )
    for command in (["conform", other], ["render", other, "-o", desk.edl.with_name("v.mp4"), "--engine", "direct"]):
        done = desk.mcsl(*command)
        assert (done.returncode, done.stderr.splitlines()[-1]) == (4, f"mcsl: {expected}")
