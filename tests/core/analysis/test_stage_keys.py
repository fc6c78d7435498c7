"""Keys of stages follow the code that a stage uses and what it consumes, and nothing else.

A copy of the package is edited, and asked about in place of the one that runs.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import types
from fractions import Fraction
from importlib import metadata
from pathlib import Path

import attrs
import pytest
from fresh_import import fresh_import

from mcsl_core import code_keys
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.analysis.stage_keys import identity, stage_keys
from mcsl_core.edl import Camera, Media, Shot
from mcsl_core.hooks.registry import Plugins, discover
from mcsl_core.hooks.specs import hookimpl
from mcsl_core.hooks.stages import STAGES
from mcsl_core.timing import FrameRange

BEFORE = ("clocks", "samples", "movements", "poses", "placed")
STAGE_NAMES = (*BEFORE, "colours", "merits", "followed", "scores", "around", "closer", "cuts")
SHOTS = (Shot(FrameRange(0, 50), "a"), Shot(FrameRange(50, 90), "b"))


def keys(
    *,
    media: str = "fa",
    rate: int = 25,
    shots: tuple[Shot, ...] = SHOTS,
    min_shot_s: float = 2.0,
    plugins: Plugins | None = None,
    **settings,
) -> dict[str, str]:
    plugins = plugins or discover(entry_points=False)
    made = AnalysisSettings(**settings)
    files = (("a", media), ("b", "fb"))
    cameras = [Camera(name, (Media(f"{name}.mp4", 90, print_),), (320, 180), Fraction(25)) for name, print_ in files]
    chosen = {stage: plugins.choose(stage, made.stages.get(stage)) for stage in STAGES}
    found = stage_keys(cameras, "a", Fraction(rate), 90, made, chosen)
    return {**attrs.asdict(found), "cuts": found.cuts(shots, min_shot_s)}


def changed(before: dict[str, str], after: dict[str, str]) -> set[str]:
    assert set(before) == set(after) == set(STAGE_NAMES)
    return {name for name in before if before[name] != after[name]}


def from_stage(name: str) -> set[str]:
    """A stage and all that are made from it."""
    return set(STAGE_NAMES[STAGE_NAMES.index(name) :])


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the package, of which keys are asked."""
    copy = tmp_path / "mcsl_core"
    shutil.copytree(code_keys._ROOT, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(code_keys, "_ROOT", copy)
    return copy


def test_a_copy_has_the_same_keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = keys()
    shutil.copytree(code_keys._ROOT, tmp_path / "copy", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(code_keys, "_ROOT", tmp_path / "copy")
    assert keys() == before


@pytest.mark.parametrize(
    ("file", "first"),
    [
        ("report/charts.py", None),
        ("cli/main.py", None),
        ("simulation/scenario.py", None),
        ("delivery/conform.py", None),
        ("compositing/compositor.py", None),
        ("evaluation/metrics.py", None),
        ("hooks/registry.py", None),
        ("analysis/pipeline.py", None),
        ("centering/field.py", None),
        ("__init__.py", None),
        ("occlusion/hue_area.py", None),  # not the detector chosen
        ("movement/paper.py", None),
        ("media/reading.py", "clocks"),
        ("sync/motion.py", "clocks"),
        ("recording/keyframe_sampling.py", "samples"),
        ("movement/stillness.py", "movements"),
        ("movement/displacement.py", "movements"),
        ("alignment/features.py", "poses"),
        ("alignment/anchoring.py", "poses"),
        ("alignment/tracking/following.py", "placed"),
        ("occlusion/consensus.py", "scores"),
        ("selection/switch_refinement.py", "cuts"),
    ],
)
def test_a_changed_module_changes_the_stages_that_use_it_and_what_is_made_from_them(
    tree: Path, file: str, first: str | None
) -> None:
    before = keys()
    path = tree / file
    path.write_text(path.read_text() + "\nADDED = 1\n")
    assert changed(before, keys()) == (set() if first is None else from_stage(first))


def test_how_drift_is_followed_changes_the_colours_alone(tree: Path) -> None:
    before = keys()
    path = tree / "alignment" / "drift.py"
    path.write_text(path.read_text() + "\nADDED = 1\n")
    assert changed(before, keys()) == {"colours"}


def test_another_selector_looks_closer_where_its_own_programme_is_in_doubt(tree: Path) -> None:
    before = keys()
    assert changed(before, keys(stages={"selector": "least-occluded"})) == {"closer"}, "cuts follow what it chose"
    path = tree / "selection" / "selectors.py"
    path.write_text(path.read_text() + "\nADDED = 1\n")
    assert changed(before, keys()) == {"closer"}


def test_words_and_layout_are_no_code(tree: Path) -> None:
    before = keys()
    for path in tree.rglob("*.py"):
        text = path.read_text()
        path.write_text("# a comment\n" + text.replace('"""', '"""Other words. ', 1).replace("\n\n\n", "\n\n\n\n"))
    assert keys() == before


CODE_OF = "from mcsl_core import code_keys as k; from mcsl_core.occlusion import consensus; print(k.code_of(consensus))"


def test_keys_are_the_same_in_every_process() -> None:
    """Sets in the code stand in another order in each."""
    told = {
        subprocess.run(
            [sys.executable, "-c", CODE_OF],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("1", "2", "3")
    }
    assert len(told) == 1


def test_imports_are_those_of_the_syntax_tree() -> None:
    for path in sorted(code_keys._ROOT.rglob("*.py")):
        named = set[tuple[int, str, tuple[str, ...]]]()
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.ImportFrom):
                named.add((node.level, node.module or "", tuple(alias.name for alias in node.names)))
            elif isinstance(node, ast.Import):
                named |= {(0, alias.name, ()) for alias in node.names}
        own = {each for each in named if each[0] or each[1].partition(".")[0] == "mcsl_core"}
        assert {(i.level, i.module, i.names) for i in code_keys._read(path.read_bytes()).imports} == own, path


def test_versions_are_those_that_the_standard_library_finds() -> None:
    for library, distributions in metadata.packages_distributions().items():
        versions = {name: metadata.version(name) for name in distributions}
        assert code_keys._version(library).split() == [versions[name] for name in sorted(versions)], library


@pytest.mark.parametrize(
    ("change", "first"),
    [
        ({"media": "other"}, "clocks"),
        ({"sync": "none"}, "clocks"),
        ({"rate": 50}, "samples"),
        ({"sample_s": 2.0}, "samples"),
        ({"stages": {"movement": "paper"}}, "movements"),
        ({"solve": SolveSettings(scene_width=200)}, "poses"),
        ({"stages": {"occlusion": "hue-area"}}, "scores"),
        ({"shots": SHOTS[:1]}, "cuts"),
        ({"min_shot_s": 6.0}, "cuts"),
        ({"gaze": (Path("gaze.csv"),)}, None),
    ],
    ids=str,
)
def test_a_changed_choice_changes_the_stages_it_is_for(change: dict, first: str | None) -> None:
    assert changed(keys(), keys(**change)) == (set() if first is None else from_stage(first))


def test_a_programme_that_holds_its_camera_is_made_from_the_poses_as_they_were_solved() -> None:
    assert changed(keys(), keys(movement_view="hold")) == from_stage("colours") - {"followed"}


class Blind:
    """A lamp tracker that sees nothing."""

    name = "blind"

    def follow(self, lamp, before, after, instants):
        return [None] * len(instants)


def test_the_tracker_and_its_version_change_what_is_followed_and_what_is_made_from_it() -> None:
    def theirs(version: str) -> Plugins:
        module = types.ModuleType("theirs")
        vars(module)["register_trackers"] = hookimpl(specname="register_trackers")(lambda: [Blind()])
        return discover([(module, "their-package", version)], entry_points=False)

    built_in, ask = keys(plugins=theirs("1")), {"stages": {"tracker": "blind"}}
    assert built_in == keys(), "what is not chosen counts for nothing"
    own = keys(plugins=theirs("1"), **ask)
    assert changed(built_in, own) == from_stage("followed")
    assert changed(own, keys(plugins=theirs("2"), **ask)) == from_stage("followed")
    held = {**ask, "movement_view": "hold"}
    assert changed(keys(movement_view="hold"), keys(plugins=theirs("1"), **held)) == {"followed"}, "which nothing asks"


PLUGIN = """
from mcsl_core.hooks import Consensus, hookimpl
class Halves(Consensus):
    name = "halves"
@hookimpl
def register_occlusion_detectors():
    return [Halves()]
"""


def test_a_plugin_is_asked_by_all_of_its_source_and_what_it_takes_from_mcsl(
    tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "halves").mkdir()
    (tmp_path / "halves/__init__.py").write_text(PLUGIN)
    (tmp_path / "halves/beside.py").write_text("X = 1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    offered = discover([(fresh_import("halves", monkeypatch), "halves", "1")], entry_points=False)
    ask = {"plugins": offered, "stages": {"occlusion": "halves"}}
    before = keys(**ask)
    assert identity(offered.choose("occlusion", "halves"))[0] == "halves (halves 1)"
    (tmp_path / "halves/beside.py").write_text("X = 2\n")
    after = keys(**ask)
    assert changed(before, after) == from_stage("scores")
    for file in ("hooks/__init__.py", "hooks/stage_guards.py", "hooks/registry.py"):
        path = tree / file
        path.write_text(path.read_text() + "\nADDED = 1\n")
    assert keys(**ask) == after, "the names that it imports come from elsewhere"
    path = tree / "occlusion/consensus.py"
    path.write_text(path.read_text() + "\nADDED = 1\n")
    assert changed(after, keys(**ask)) == from_stage("scores")


def test_another_version_of_a_library_is_other_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = keys()
    real = code_keys._version
    monkeypatch.setattr(code_keys, "_version", lambda name: "99" if name == "sklearn" else real(name))
    assert keys() == before, "only the detector of the paper uses it"
    monkeypatch.setattr(code_keys, "_version", lambda name: "99" if name == "poselib" else real(name))
    assert changed(before, keys()) == from_stage("poses")
