"""For a person at a terminal: progress as a bar, with rate and time left (one line a stage elsewhere), and tables."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from attrs import define, field
from rich.console import Console, Group
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as RichProgress
from rich.table import Table
from rich.text import Text

from mcsl_core.hooks.stages import STAGES
from mcsl_core.progress import CancelToken

from .language import told, word

if TYPE_CHECKING:  # they import scipy and OpenCV, and bars must not wait for that
    from mcsl_core.evaluation.questionnaire import Result
    from mcsl_core.evaluation.results import Evaluation, SeenThrough
    from mcsl_core.hooks.registry import Offer


_TOLD = 0.005  # of the field: a smaller share would read 0%


class _RateColumn(ProgressColumn):
    """Units a second, as the rate of the whole stage."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        unit = word(task.fields.get("unit") or "steps")
        return Text(f"{speed:.1f} {unit}/s" if speed else "", style="progress.data.speed")


@define
class Bars:
    """A bar per stage on ``console`` (standard error), live on a terminal; notes stand above the bars."""

    console: Console
    token: CancelToken = field(factory=CancelToken)
    _rich: RichProgress | None = None
    _task: TaskID | None = None

    def __enter__(self) -> Bars:
        self._rich = RichProgress(
            SpinnerColumn(finished_text="[green]✓[/]"),
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            MofNCompleteColumn(),
            _RateColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(compact=True),
            console=self.console,
        )
        self._rich.start()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        assert self._rich is not None
        if kind is None:
            self._finish()
        self._rich.stop()

    def _finish(self) -> None:
        if self._rich is not None and self._task is not None:
            task = next(t for t in self._rich.tasks if t.id == self._task)
            done = (task.completed if task.total is None else task.total) or 1  # an empty stage is a finished one
            self._rich.update(self._task, completed=done, total=done)

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.token.check()
        assert self._rich is not None
        self._finish()
        self._task = self._rich.add_task(told(name), total=total, unit=unit)

    def advance(self, done: int) -> None:
        self.token.check()
        if self._rich is not None and self._task is not None:
            self._rich.update(self._task, completed=done)

    def note(self, text: str) -> None:
        self.token.check()
        self.console.print(Text.assemble((word("note"), "yellow"), " ", told(text)))


@define
class Lines:
    """One line when a stage begins, one for a note: for log files and pipes."""

    write: Callable[[str], Any]
    token: CancelToken = field(factory=CancelToken)
    _began: float = field(factory=time.monotonic)

    def stage(self, name: str, total: int | None = None, unit: str = "") -> None:
        self.token.check()
        size = f" ({total} {word(unit)})" if total and total > 1 else ""  # units are in the plural
        self.write(f"{time.monotonic() - self._began:7.1f} s  {told(name)}{size}")

    def advance(self, done: int) -> None:
        self.token.check()

    def note(self, text: str) -> None:
        self.token.check()
        self.write(f"{time.monotonic() - self._began:7.1f} s  {word('note')}: {told(text)}")


def steadiness_table(evaluation: Evaluation, rate: Fraction) -> Group:
    """The figures of every variant, over the whole and over the switches; what is seen through; the conditions."""
    conditions, (width, height) = evaluation.conditions, evaluation.conditions.size
    sampled = {0: ", switches alone", 1: ""}.get(conditions.every, f", one in {conditions.every} pairs within shots")
    names = {m.name for m in evaluation.measured}
    gains = evaluation.gains() if {"auto", "manual"} <= names else {}
    headings = {
        "itf": "ITF",
        "itf_valid": "valid",
        "itf_field": "field",
        "av_speed": "AvSpeed",
        "av_speed_field": "field",
    }
    scopes = {"": "whole", "switches_": "switches"} if conditions.every else {"switches_": "switches"}
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("", no_wrap=True)
    for heading in headings.values():
        table.add_column(word(heading), justify="right", no_wrap=True)
    for prefix, scope in scopes.items():
        table.add_row(Text(word("at switches" if prefix else "whole programme"), style="bold"))
        for row in evaluation.measured:
            means = getattr(row, scope)
            values = [getattr(means, f"{name}_{'px' if name.startswith('av') else 'db'}") for name in headings]
            table.add_row(row.label, *("-" if v is None else f"{v:.2f}" for v in values))
        if any(prefix + name in gains for name in headings):
            signs = [-1 if name.startswith("av") else 1 for name in headings]
            found = [gains.get(prefix + name) for name in headings]
            changes = ("-" if v is None else f"{s * v:+.0f} %" for s, v in zip(signs, found, strict=True))
            table.add_row(Text(word("Auto against Manual"), style="dim"), *changes)
    foot = told(
        "ITF in dB: over all pixels; over the valid ones, which both frames have from a camera; over those about the "
        f"field, within {conditions.field:.0%} of the width of its middle. AvSpeed in pixels a frame: all points; "
        f"those about the field. Pictures: {width}x{height}, {conditions.picture}{sampled}. Points within shots: "
        f"{conditions.within_camera}. Points at switches: {conditions.at_switches}."
    )
    seen = [seen_through_table(evaluation.seen_through, rate), ""] if evaluation.seen_through else []
    return Group(table, "", *seen, foot)


def seen_through_table(stretches: Sequence[SeenThrough], rate: Fraction) -> Table:
    """When, how much of the field, and by whom."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("seen through, s", "camera", "field", "at most", "as others see it"):
        table.add_column(word(heading), justify="right" if heading in ("field", "at most") else "left")
    for each in stretches:
        span = told(f"{float(each.range.start / rate):.1f} to {float(each.range.stop / rate):.1f}")
        named = sorted(((share, name) for name, share in each.by.items() if share >= _TOLD), reverse=True)
        by = ", ".join(f"{name} {share:.0%}" for share, name in named)
        table.add_row(span, each.camera, f"{each.share:.0%}", f"{each.most:.0%}", by)
    return table


def study_table(results: Sequence[Result]) -> Group:
    """Each video's and factor's tests, those significant at 5 % marked by a star."""
    foot = told(
        "* significant at 5 %. Friedman: chi-square, effect Kendall's W. Pairs: Wilcoxon's signed ranks, two-sided; n "
        "who differ (equal ratings left out), the smaller sum of ranks, p exact unless marked ~, effect the "
        "rank-biserial correlation."
    )
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("video", "factor", "test"):
        table.add_column(word(heading), overflow="fold")
    for heading in ("n", "statistic", "p", "p (Holm)", "effect"):
        table.add_column(word(heading), justify="right", no_wrap=True)
    for r in results:
        f = r.friedman
        if f is not None:
            p = "-" if f.p is None else f"{f.p:.4f}{'*' if f.significant else ' '}"
            numbers = ["-" if v is None else f"{v:.2f}" for v in (f.statistic, f.kendall_w)]
            table.add_row(r.video, r.factor, "Friedman", str(r.participants), numbers[0], p, "", numbers[1])
        for w in r.pairs:
            p = f"{'' if w.exact else '~'}{w.p:.4f}{'*' if w.significant else ' '}"
            numbers = [f"{w.statistic:g}", p, f"{w.p_holm:.4f}", f"{w.effect:+.2f}"]
            table.add_row(r.video, r.factor, f"{w.a} - {w.b}", str(w.n), *numbers)
    return Group(table, "", foot)


def offers_table(offers: Sequence[Offer]) -> Table:
    """What can do each stage, the defaults marked."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("stage", "name", "from", "what it does"):
        table.add_column(word(heading), overflow="fold")
    for offer in offers:
        mark = f" {word('(default)')}" if STAGES[offer.stage].default == offer.name else ""
        table.add_row(
            offer.stage,
            Text.assemble(offer.name, (mark, "dim")),
            f"{offer.package} {offer.version}",
            told(offer.summary),
        )
    return table
