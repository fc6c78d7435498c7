"""The notebooks in examples/ run from top to bottom on a simulated recording, and what they find is so."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import pytest

import mcsl_core

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
FRONT_DOOR = {
    *("analyse", "edl", "scores", "frame", "camera_frame", "to_programme", "to_camera", "override", "save"),
    *("align", "homographies", "conform", "render", "evaluate"),
}


def cells(path: Path, kind: str) -> list[dict[str, Any]]:
    return [cell for cell in json.loads(path.read_text("utf-8"))["cells"] if cell["cell_type"] == kind]


def code(path: Path) -> str:
    return "\n".join("".join(cell["source"]) for cell in cells(path, "code"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_what_it_printed(path: Path):
    assert cells(path, "code")
    assert not [cell for cell in cells(path, "code") if cell["outputs"] or cell["execution_count"] is not None]


def test_the_first_notebook_goes_through_the_whole_front_door():
    tree = ast.walk(ast.parse(code(EXAMPLES / "first_programme.ipynb")))
    assert not FRONT_DOOR - {node.attr for node in tree if isinstance(node, ast.Attribute)}


def run(path: Path, folder: Path, *names: str) -> dict[str, Any]:
    """What the notebook's variables (or expressions) hold after it ran in ``folder``."""
    pytest.importorskip("nbclient", reason="the extra `examples` is not installed")
    if not hasattr(mcsl_core, "analyse"):
        pytest.skip("the front door is not here yet")
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    asked = ", ".join(f"{name!r}: {name}" for name in names)
    notebook.cells.append(nbformat.v4.new_code_cell(f"import json\nprint(json.dumps({{{asked}}}))"))
    where = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=None, kernel_name="python3", resources=where).execute()
    return json.loads("".join(output["text"] for output in notebook.cells[-1]["outputs"]))


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_from_a_recording_to_plots_and_a_video(tmp_path: Path):
    found = run(
        EXAMPLES / "first_programme.ipynb",
        tmp_path,
        "[list(m) for m in truth.movements]",
        "[[m.range.start, m.range.stop] for m in p.edl.movements]",
        "dom.label",
        "float(np.nanmax(dom.values))",
        "float(np.nanmean(p.scores.visible))",
        "[[o.range.start, o.range.stop, o.camera] for o in p.edl.overrides]",
        "sorted(homographies)",
        "float(np.abs(back - points).max())",
        "{row.name: row.whole.av_speed_px for row in evaluation.measured}",
    )
    true, seen, label, dom, visible, overrides, aligned, apart, speed = found.values()
    assert len(true) == len(seen) == 1
    assert seen[0][0] < true[0][1]  # they overlap
    assert seen[0][1] > true[0][0]
    assert label == "degree of misalignment"
    assert dom > 5  # px: the lamp's movement shifts the views by far more
    assert 0.3 < visible < 1
    assert overrides == [[240, 280, "cam2"]]
    assert aligned == ["cam1", "cam2"]
    assert apart < 1e-6
    assert all(value is not None and value < 50 for name, value in speed.items() if name == "auto")
    assert json.loads((tmp_path / "edl.json").read_text("utf-8"))["overrides"]
    assert (tmp_path / "programme.mp4").stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_two_detectors_against_the_truth(tmp_path: Path):
    found = run(EXAMPLES / "compare_detectors.ipynb", tmp_path, "correlation", "share")
    assert set(found["correlation"]) == set(found["share"]) == {"hue-area", "consensus"}
    # Gloves of the skin's colour are field to whoever goes by hue; the notebook says that this is hard for it.
    assert found["correlation"]["consensus"] > found["correlation"]["hue-area"]
    assert 0.5 < found["correlation"]["consensus"] <= 1
    assert all(0.7 < value <= 1 for value in found["share"].values())
