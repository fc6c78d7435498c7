"""`mcsl plugin new`: what it writes installs, passes its own tests and the contract of its stage, and is well typed.

Each stage's template once, all of them in one folder that lies in Python's way as pip would have put them there; one is
installed by pip itself.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from mcsl_core.cli.main import main
from mcsl_core.cli.new_plugin import new_plugin
from mcsl_core.errors import InputError, UsageError
from mcsl_core.hooks.stages import STAGES

ROOT = Path(__file__).parents[2]
HOOK = "from mcsl_core.hooks import hookimpl\n@hookimpl\n"


class Written:
    """A plugin for every stage, named new-STAGE."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.projects = {stage: folder / f"new-{stage}" for stage in STAGES}
        for stage, project in self.projects.items():
            new_plugin(project.name, stage, project)
            self._register(project)

    def _register(self, project: Path) -> None:
        """What pip would write about it: name, version, entry points."""
        about = tomllib.loads((project / "pyproject.toml").read_text("utf-8"))["project"]
        info = self.folder / "site" / f"{about['name'].replace('-', '_')}-{about['version']}.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {about['name']}\nVersion: {about['version']}\n", "utf-8"
        )
        points = "".join(f"{name} = {module}\n" for name, module in about["entry-points"]["mcsl"].items())
        (info / "entry_points.txt").write_text(f"[mcsl]\n{points}", "utf-8")

    def run(self, *command: object, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
        way = [ROOT, self.folder / "site", *self.projects.values(), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(str(part) for part in way if str(part))}
        arguments = [sys.executable, *(str(part) for part in command)]
        return subprocess.run(arguments, capture_output=True, text=True, env=environment, cwd=cwd, check=False)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    return Written(tmp_path_factory.mktemp("written"))


def test_all_of_them_are_listed_with_what_they_do(written: Written) -> None:
    done = written.run("-m", "mcsl_core.cli", "plugins", "--json")
    assert done.returncode == 0, done.stderr
    rows = {row["stage"]: row for row in json.loads(done.stdout) if row["package"].startswith("new-")}
    assert {stage: (row["name"], row["version"]) for stage, row in rows.items()} == {
        stage: (f"new-{stage}", "0.1.0") for stage in STAGES
    }
    assert all(len(row["summary"]) > 40 for row in rows.values())


def test_they_import_what_is_public_and_say_so(written: Written) -> None:
    for project in written.projects.values():
        for path in project.rglob("*.py"):
            found = re.findall(r"^(?:from|import) (mcsl_core[\w.]*)", path.read_text("utf-8"), re.MULTILINE)
            assert set(found) == {"mcsl_core.hooks"}, path


def test_they_keep_to_120_columns_whatever_is_written_into_them(written: Written) -> None:
    for project in written.projects.values():
        for path in (*project.rglob("*.py"), *project.rglob("*.md")):
            text = path.read_text("utf-8")
            assert max(map(len, text.splitlines())) <= 120, path
            assert "{{" not in text
            assert text.endswith("\n")


@pytest.mark.slow
def test_their_own_tests_pass(written: Written) -> None:
    options = ("-q", "--import-mode=importlib", "-p", "no:cacheprovider")
    done = written.run("-m", "pytest", *options, *written.projects.values(), cwd=written.folder)
    assert done.returncode == 0, done.stdout[-3000:]
    passed = re.search(r"(\d+) passed", done.stdout)
    assert passed is not None
    assert int(passed[1]) >= 2 * len(STAGES)


@pytest.mark.slow
def test_they_keep_the_contract_of_their_stage(written: Written) -> None:
    """A minute or two: the movement detector is shown films."""
    options = ("-q", "-p", "no:cacheprovider", "-k", " or ".join(f"new-{stage}" for stage in STAGES), "-rA")
    done = written.run("-m", "pytest", *options, "tests/contract/test_stages.py", "tests/contract/test_fillers.py")
    assert done.returncode == 0, done.stdout[-3000:]
    for stage in STAGES:
        assert re.search(rf"^PASSED .*new-{stage}", done.stdout, re.MULTILINE), stage
    assert "SKIPPED" not in done.stdout


@pytest.mark.slow
def test_type_checkers_have_nothing_to_say(written: Written) -> None:
    folders = [str(ROOT), *(str(project) for project in written.projects.values())]
    about = {"typeCheckingMode": "standard", "pythonVersion": "3.11", "extraPaths": folders}
    (written.folder / "pyrightconfig.json").write_text(json.dumps(about), "utf-8")
    done = written.run("-m", "pyright", "--pythonpath", sys.executable, "--outputjson", cwd=written.folder)
    found = json.loads(done.stdout)
    assert found["summary"]["filesAnalyzed"] == 2 * len(STAGES)
    assert [f"{d['file']}: {d['message']}" for d in found["generalDiagnostics"]] == []


@pytest.mark.slow
def test_pip_installs_one_and_mcsl_finds_it(tmp_path: Path) -> None:
    assert main(["plugin", "new", "tried-out", "--stage", "selector", "-o", str(tmp_path / "tried-out")]) == 0
    target = tmp_path / "installed"
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(target), "."]
    done = subprocess.run(install, cwd=tmp_path / "tried-out", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    code = "from mcsl_core.hooks import discover; print(discover().choose('selector', 'tried-out'))"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(target)])}
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert found.stdout == "tried-out (tried-out 0.1.0)\n"


def test_it_says_what_it_wrote_and_what_comes_next(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["plugin", "new", "own-past", "--stage", "occlusion"]) == 0
    told = capsys.readouterr().out
    assert f"own-past: occlusion detector own-past. Install it: {sys.executable} -m pip install -e " in told
    assert "--occlusion own-past" in told
    files = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {
        *("own-past/pyproject.toml", "own-past/README.md"),
        *("own-past/own_past/__init__.py", "own-past/tests/test_own_past.py"),
    }
    assert "class OwnPast:" in (tmp_path / "own-past/own_past/__init__.py").read_text("utf-8")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        *(
            (wrong, "is no name for a plugin")
            for wrong in ("Own", "own_past", "-own", "own-", "1st", "a--b", "../x", "")
        ),
        ("class", "is no name for a plugin"),
        ("none", "its class would be called None, which is taken"),
        ("score-table", "its class would be called ScoreTable, which is taken"),
        ("scorer", "its class would be called Scorer, which is taken"),
        ("numpy", "there is a Python package 'numpy' already"),
        ("consensus", r"the name is that of the occlusion detector consensus \(mcsl "),
    ],
)
def test_a_name_that_cannot_be_is_refused(tmp_path: Path, name: str, told: str) -> None:
    with pytest.raises(UsageError, match=told):
        new_plugin(name, "occlusion", tmp_path / "new")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_there_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "own-past").mkdir()
    (tmp_path / "own-past" / "mine.txt").write_text("mine", "utf-8")
    with pytest.raises(InputError, match="is there already"):
        new_plugin("own-past", "occlusion", tmp_path / "own-past")
    assert [path.name for path in (tmp_path / "own-past").iterdir()] == ["mine.txt"]
    assert [path.name for path in tmp_path.iterdir()] == ["own-past"]


def test_a_stage_that_there_is_not_lists_those_that_there_are(capsys) -> None:
    assert main(["plugin", "new", "mine", "--stage", "magic"]) == 2
    assert "'movement', 'matcher', 'aligner', 'relief', 'tracker', 'occlusion'" in capsys.readouterr().err


BROKEN = {
    "imports what is not here": "import nosuch_library",
    "is no Python": "def (:",
    "raises": "raise RuntimeError('no licence')",
    "ends the program": "import sys; sys.exit('bye')",
    "ends it in silence": "raise SystemExit",
    "has a hook that fails": HOOK + "def register_selectors():\n    raise RuntimeError('no licence')",
    "has a hook that ends the program": HOOK + "def register_selectors():\n    raise SystemExit(3)",
    "has a hook of another name": HOOK + "def register_sellectors():\n    return []",
    "offers what is no selector": HOOK + "def register_selectors():\n    return [object()]",
    "returns no list": HOOK + "def register_selectors():\n    return 5",
}


@pytest.fixture(scope="module")
def beside(tmp_path_factory: pytest.TempPathFactory) -> Written:
    """An installed plugin `new-selector` that works, beside one whose module a test writes."""
    return Written(tmp_path_factory.mktemp("beside"))


@pytest.mark.parametrize("kind", BROKEN)
def test_one_that_cannot_be_used_is_named_and_left_out(beside: Written, kind: str) -> None:
    info = beside.folder / "site" / "broken-2.0.dist-info"
    info.mkdir(exist_ok=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 2.0\n", "utf-8")
    (info / "entry_points.txt").write_text("[mcsl]\nbroken = broken_module\n", "utf-8")
    (beside.folder / "site" / "broken_module.py").write_text(BROKEN[kind] + "\n", "utf-8")
    done = beside.run("-m", "mcsl_core.cli", "plugins", "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("plugin broken 2.0")
    assert "it is left out" in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert {"new-selector", "shortest-path"} <= {row["name"] for row in json.loads(done.stdout)}
    chosen = "from mcsl_core.hooks.registry import discover; discover().choose('selector', 'brokens-own')"
    refused = beside.run("-c", chosen)
    assert "there is no selector named 'brokens-own', but plugin broken 2.0" in refused.stderr
    assert beside.run("-c", chosen.replace("brokens-own", "new-selector")).returncode == 0


def test_one_that_hangs_is_named(beside: Written) -> None:
    (beside.folder / "site" / "broken_module.py").write_text("import time; time.sleep(1)\n", "utf-8")
    done = beside.run("-c", "from mcsl_core.hooks import registry; registry._SLOW_S = 0.3; registry.discover()")
    assert "plugin broken 2.0 (broken_module) has been importing for 0.3 s" in done.stderr
    assert done.returncode == 0, done.stderr
