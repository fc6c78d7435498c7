"""The demo, shorter than a newcomer sees it: everything it names is there and of this recording."""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import pytest

from mcsl_core import edl as edls
from mcsl_core.blender.installation import Blender
from mcsl_core.cli import demo
from mcsl_core.errors import InputError
from mcsl_core.progress import Silent

SHORT_S = 14.0


@pytest.mark.slow
def test_the_demo_goes_the_whole_way(blender: Blender, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo, "DURATION_S", SHORT_S)
    folder = tmp_path / "demo"
    made = demo.run_demo(folder, seed=1, blender=str(blender.command[0]), progress=Silent())
    edl = edls.load(folder / "edl.json")
    assert len(edl.movements) == 1
    assert len(edl.poses) == 2
    assert {error["pose"] for error in made.values["alignment"]} == {0, 1}
    with av.open(made.values["video"]) as video:
        assert sum(1 for _ in video.decode(video=0)) == edl.frames
    for name in ("contact_sheet", "movement_sheet"):
        assert cv2.imread(made.values[name]).std() > 20
    for name in ("recording", "edl", "timeline", "video", "contact_sheet", "movement_sheet"):
        assert Path(made.values[name]).exists()
        assert made.values[name] in made.text
    with pytest.raises(InputError, match="is not empty"):
        demo.run_demo(tmp_path, seed=1, blender=str(blender.command[0]), progress=Silent())
