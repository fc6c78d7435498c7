"""The triage of an archive: a page that ranks its operations by what needs a person, and all figures as tables.

Written into the folder of results; its pictures and links lead into the folders of the operations.
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

import attrs
import cv2
import jinja2
from attrs import frozen

from mcsl_core import __version__
from mcsl_core import edl as edls
from mcsl_core.documents import write_atomic
from mcsl_core.errors import McslError
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Progress
from mcsl_core.report.charts import short_time

from .figures import COLUMNS, Figures, figures_of
from .reasons import KINDS, Reason, reasons_of
from .run import Work

MOST_SHOWN = 1000  # operations on the page, the neediest; the tables have all
PICTURE_WIDTH = 240
_AT_ONCE = 4


@frozen
class Entry:
    """An operation on the page."""

    row: Figures
    reasons: tuple[Reason, ...]
    length: str
    picture: str
    report: str
    kinds: str

    @property
    def need(self) -> float:
        return sum(reason.weight for reason in self.reasons)


def write_triage(works: Sequence[Work], out: Path, *, anonymous: bool, progress: Progress) -> Path:
    """Writes triage.html, operations.csv and operations.parquet into ``out``; returns the page.

    Parameters
    ----------
    works : sequence of Work
        The operations and how far each is.
    out : Path
        The folder of results.
    anonymous : bool
        Whether operations are named by number.
    progress : Progress
        Where it is told how far it is.
    """
    progress.stage("Ranking", len(works), "operations")
    entries = []
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        for done, entry in enumerate(pool.map(partial(_entry, out=out, anonymous=anonymous), works), start=1):
            entries.append(entry)
            progress.advance(done)
    write_tables([entry.row for entry in entries], out)
    path = out / "triage.html"
    write_atomic(path, page(entries).encode("utf-8", "backslashreplace"))
    return path


def _entry(work: Work, *, out: Path, anonymous: bool) -> Entry:
    folder = out / work.operation.key
    name = work.operation.key if anonymous else work.operation.folder
    row = figures_of(name, folder, work.job, work.outcome)
    picture, report = _picture(folder, work.job.video), folder / "report.html"
    return entry_of(row, picture, f"{quote(folder.name)}/report.html" if report.is_file() else "")


def entry_of(row: Figures, picture: str = "", report: str = "") -> Entry:
    """What the page shows of a row; picture, report: where they lie, relative to the page."""
    reasons = reasons_of(row)
    kinds = [reason.kind for reason in reasons] or ["waiting" if row.state == "waiting" else "fine"]
    return Entry(row, reasons, short_time(row.seconds, hours=row.seconds >= 3600), picture, report, " ".join(kinds))


def page(entries: Sequence[Entry]) -> str:
    """The page as HTML: the neediest first, then by name."""
    ranked = sorted(entries, key=lambda entry: (-entry.need, entry.row.state == "done", entry.row.operation))
    counts = Counter(kind for entry in entries for kind in entry.kinds.split())
    states = Counter(entry.row.state for entry in entries)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mcsl_core.archive", "."),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template("triage.html").render(
        entries=ranked[:MOST_SHOWN],
        total=len(entries),
        needy=sum(bool(entry.reasons) for entry in entries),
        states=states,
        length=_length(sum(entry.row.seconds for entry in entries)),
        filters=[(kind, words, counts[kind]) for kind, words in _FILTERS.items() if counts[kind]],
        kinds=KINDS,
        version=__version__,
    )


def _length(seconds: float) -> str:
    return f"{seconds / 3600:,.0f} hours" if seconds >= 36000 else short_time(seconds, hours=True)


_FILTERS = {**KINDS, "waiting": "not done yet", "fine": "nothing to do"}


def write_tables(rows: Sequence[Figures], out: Path) -> None:
    """Writes the figures as CSV and, with their types, as Parquet."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    values = [{name: _readable(value) for name, value in attrs.asdict(row).items()} for row in rows]
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(values)
    write_atomic(out / "operations.csv", text.getvalue().encode("utf-8", "backslashreplace"))
    kinds = {"str": pa.string(), "int": pa.int64(), "float": pa.float64()}
    schema = pa.schema([(a.name, kinds[str(a.type).partition(" ")[0]]) for a in attrs.fields(Figures)])
    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pylist(values, schema=schema), sink)
    write_atomic(out / "operations.parquet", sink.getvalue().to_pybytes())


def _readable(value: Any) -> Any:
    """A name that is no Unicode with its odd bytes written out."""
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value


def _picture(folder: Path, video: str) -> str:
    """Where a small picture of the programme lies, from the middle of the shot that shows least; empty without one."""
    path, programme = folder / "picture.jpg", folder / video
    try:
        if not path.is_file() or path.stat().st_mtime_ns < programme.stat().st_mtime_ns:
            edl = edls.read(folder / "edl.json")
            worst = min(edl.shots, key=lambda shot: shot.score).range
            picture = _frame(programme, Fraction((worst.start + worst.stop) // 2) / edl.rate)
            height = round(PICTURE_WIDTH * picture.shape[0] / picture.shape[1])
            small = cv2.resize(picture, (PICTURE_WIDTH, height), interpolation=cv2.INTER_AREA)
            write_atomic(path, cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 70])[1].tobytes())
    except (McslError, OSError, LookupError):
        return ""
    return f"{quote(folder.name)}/picture.jpg"


def _frame(video: Path, at: Fraction) -> Any:
    """(H, W, 3) uint8, BGR: the picture of a video at a time in seconds."""
    facts = probe(video)
    with closing(VideoReader(facts)) as reader:
        frame = next(frame for _, frame in reader.read(at) if frame is not None)
        return planes_to_bgr(to_planes(frame, facts))
