"""The page and the tables of many operations, read back by other roads: csv, pyarrow, a browser."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
import time
from html import unescape
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from archive_rows import rows

from mcsl_core.archive.figures import COLUMNS, Figures
from mcsl_core.archive.reasons import KINDS, reasons_of
from mcsl_core.archive.triage import entry_of, page, write_tables

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


def a_row(**changes) -> Figures:
    """An operation of which nothing needs a person."""
    row = next(row for row in rows(10) if row.state == "done")
    calm = {"weak_cameras": 0, "weak_share": 0.0, "visible": 0.9, "visible_best": 0.95, "field_unknown_share": 0.0}
    calm |= {"unsure_clocks": 0, "clock_confidence": 0.9, "gap_share": 0.0, "longest_movement_s": 5.0}
    return attrs.evolve(row, **{**calm, "overrides_without_picture": 0, **changes})


@pytest.mark.parametrize(
    ("kind", "changes", "command"),
    [
        ("stopped", {"state": "refused", "step": "open", "why": "no"}, "mcsl analyse"),
        ("stopped", {"state": "failed", "step": "conform-2-of-3", "why": "no"}, "mcsl conform"),
        ("weak", {"weak_cameras": 1, "weak_share": 0.1}, "mcsl timeline"),
        ("field", {"visible": 0.3}, "mcsl timeline"),
        ("field", {"field_unknown_share": 0.5}, "mcsl field"),
        ("clocks", {"unsure_clocks": 2, "clock_confidence": 0.1}, "--sync motion"),
        ("gaps", {"gap_share": 0.05}, "mcsl analyse"),
        ("movements", {"longest_movement_s": 40.0}, "--movement-view hold"),
        ("overrides", {"overrides_without_picture": 1}, "mcsl timeline"),
    ],
)
def test_each_kind_of_need_has_its_reason_and_a_command(kind: str, changes: dict, command: str) -> None:
    assert reasons_of(a_row()) == ()
    (reason,) = reasons_of(a_row(**changes, results="op 1"))
    assert reason.kind == kind
    assert command in reason.command
    assert "'op 1'" in reason.command
    assert kind in KINDS


def test_the_neediest_come_first_and_the_page_says_how_many() -> None:
    few = [a_row(operation=name) for name in ("calm", "b-calm")]
    few += [
        a_row(operation="weak", weak_cameras=1, weak_share=0.2),
        a_row(operation="lost", state="refused", why="<gone>"),
    ]
    few += [a_row(operation="worse", weak_cameras=2, weak_share=0.4, gap_share=0.3)]
    text = page([entry_of(row) for row in few])
    order = re.findall(r"<h2>([^<]+)</h2>", text)
    assert order == ["lost", "worse", "weak", "b-calm", "calm"]
    assert "3 of 5 operations need a person" in text
    assert "&lt;gone&gt;" in text
    assert "<script" not in text


def test_the_tables_hold_every_figure(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra `archive` is not installed")
    many = list(rows(60))
    write_tables(many, tmp_path)
    table = parquet.read_table(tmp_path / "operations.parquet")
    assert table.column_names == list(COLUMNS)
    assert [Figures(**row) for row in table.to_pylist()] == many
    assert str(table.schema.field("visible").type) == "double"
    assert str(table.schema.field("shots").type) == "int64"
    with (tmp_path / "operations.csv").open(encoding="utf-8") as stream:
        written = list(csv.DictReader(stream))
    assert [row["operation"] for row in written] == [row.operation for row in many]
    assert float(written[0]["visible"]) == pytest.approx(many[0].visible)
    assert written[7]["visible"] == ""


# ------------------------------------------------------------------------------------------------------- in a browser

PROBE = """<!doctype html><body><iframe id="f" src="%s" style="width:%dpx;height:900px;border:0"></iframe><script>
f.onload = () => {
  const d = f.contentDocument, w = f.contentWindow, shown = () => [...d.querySelectorAll("article")]
    .filter(a => getComputedStyle(a).display != "none").length;
  const opened = w.performance.getEntriesByType("navigation")[0], before = shown();
  const only = d.getElementById("only-weak"); only.click();
  document.body.textContent = JSON.stringify({
    scroll: d.documentElement.scrollWidth, before, weak: shown(),
    loaded_ms: opened.loadEventEnd || w.performance.now(),
    outside: [...d.querySelectorAll("main *")].filter(e => e.getBoundingClientRect().right > w.innerWidth + 0.5).length,
    alts: [...d.images].every(i => i.alt),
  });
};
</script></body>"""


@pytest.fixture(scope="session")
def browser() -> str:
    found = os.environ.get("MCSL_BROWSER") or next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if not found:
        pytest.skip("no browser here (Debian: apt-get install -y chromium; another: MCSL_BROWSER)")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1200])
def test_a_thousand_operations_open_at_once_and_are_filtered(browser: str, tmp_path: Path, width: int) -> None:
    many = list(rows(1000))
    (tmp_path / "op").mkdir()
    cv2.imwrite(str(tmp_path / "op" / "picture.jpg"), np.full((135, 240, 3), 90, np.uint8))
    text = page([entry_of(row, "op/picture.jpg", "op/report.html") for row in many])
    (tmp_path / "triage.html").write_text(text, "utf-8")
    (tmp_path / "probe.html").write_text(PROBE % ("triage.html", width), "utf-8")
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]
    options += ["--disable-background-networking", "--allow-file-access-from-files", "--enable-logging=stderr", "--v=0"]
    options += [f"--user-data-dir={tmp_path / 'profile'}", "--window-size=1300,1000", "--dump-dom"]
    command = [browser, *options, (tmp_path / "probe.html").as_uri()]
    began = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    print(f"{width}: {time.monotonic() - began:.1f} s with the browser's start")
    seen = json.loads(unescape(re.sub(r"<[^>]*>", "", done.stdout)).strip())
    assert (seen["before"], seen["weak"]) == (1000, sum("weak" in entry_of(row).kinds for row in many))
    assert seen["scroll"] <= width
    assert not seen["outside"]
    assert seen["alts"]
    assert "Content Security Policy" not in done.stderr
    print(seen)
