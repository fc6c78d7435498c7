"""What plugins may not do: each misbehaviour is made once, and the error must name stage, plugin, package and version.

Every fault here was once a plugin of somebody who read the protocol in a hurry.
"""

from __future__ import annotations

import types
from collections.abc import Callable
from fractions import Fraction

import attrs
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.correspondences import Correspondences
from mcsl_core.alignment.protocol import Alignment, Features
from mcsl_core.alignment.relief.protocol import ReliefCamera, ReliefScene, ReliefSurface, ReliefView
from mcsl_core.alignment.tracking.lamp import AT_REST, Lamp
from mcsl_core.alignment.tracking.protocol import End, Instant
from mcsl_core.alignment.tracking.templates import Ground, Template
from mcsl_core.centering.protocol import FieldPosition
from mcsl_core.edl import Movement, Shot, Weak
from mcsl_core.errors import Cancelled, InputError, McslError, PluginError
from mcsl_core.hooks.guards import read_only
from mcsl_core.hooks.registry import Offer
from mcsl_core.hooks.stages import STAGES
from mcsl_core.hooks.watch import Watch
from mcsl_core.imaging.planes import Planes, black
from mcsl_core.movement.protocol import Detection
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import CancelToken, Silent
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

SIZE = (32, 18)
CAMERAS = ("cam1", "cam2")
POSE = AlignedPose(
    SIZE, "cam1", dict.fromkeys(CAMERAS, np.eye(3)), dict.fromkeys(CAMERAS, SIZE), np.ones((18, 32), bool)
)
PICTURE = np.full((18, 32, 3), 90, np.uint8)
POINTS = Features(np.full((3, 2), 5, np.float32), np.eye(3, 8, dtype=np.float32), SIZE)
GOOD_ALIGNMENT = Alignment(dict.fromkeys(CAMERAS, np.eye(3)), {"cam2": 1.0}, {"cam2": 20}, ())
SEEN = ReliefCamera(SIZE, np.eye(3, 4), np.eye(3), (ReliefView(PICTURE, np.ones((18, 32), bool)),))
SCENE = ReliefScene(SIZE, dict.fromkeys(CAMERAS, SEEN), np.ones((4, 3)))
GOOD_RELIEF = ReliefSurface(np.zeros((3, 4)), np.ones((3, 4)), frozenset(CAMERAS))
LAMP = Lamp(dict.fromkeys(CAMERAS, SIZE), dict.fromkeys(CAMERAS, 50.0), dict.fromkeys(CAMERAS, np.eye(3, 4)), np.eye(4))
SHOWN = Template(PICTURE[..., 0], np.ones((4, 2), np.float32), np.ones((4, 3)))
END = End(AT_REST, Ground.of(SIZE, np.zeros((3, 4))), dict.fromkeys(CAMERAS, SHOWN), dict.fromkeys(CAMERAS, np.eye(3)))
INSTANTS = [Instant(frame, dict.fromkeys(CAMERAS, PICTURE[..., 0]), {}) for frame in (10, 12)]
FRAMES = 60


class Programme:
    """A programme frame before filling."""

    frame, rate, size, camera, others, geometry = 3, 25.0, SIZE, "cam1", ("cam2",), 0

    def __init__(self) -> None:
        self.front, self.previous = black(SIZE), black(SIZE)

    def footprint(self, camera: str) -> np.ndarray:
        return np.full((9, 16), 255, np.uint8)

    def picture(self, camera: str, rect: object) -> Planes:
        return black(SIZE)


def table() -> ScoreTable:
    return ScoreTable(np.array([0, 30]), CAMERAS, np.full((2, 2), 0.5), np.ones((2, 2), bool))


def views():
    return POSE.views(dict.fromkeys(CAMERAS, PICTURE.copy()))


def samples() -> SampleStore:
    return SampleStore([0, 30], CAMERAS, [{}, {}], None)  # pyright: ignore[reportArgumentType]


PAIR = Correspondences(np.ones((4, 2)), np.ones((4, 2)), np.ones(4), np.ones(4, np.int64))

# How the pipeline calls each method.
CALLS: dict[tuple[str, str], Callable] = {
    ("movement", "detect"): lambda s: s.detect(samples(), types.SimpleNamespace(frames=FRAMES), Silent()),
    ("matcher", "features"): lambda s: s.features(PICTURE.copy(), np.ones((18, 32), np.uint8)),
    ("matcher", "match"): lambda s: s.match(read_only(POINTS), read_only(POINTS)),
    ("aligner", "align"): lambda s: s.align({CAMERAS: PAIR}, dict.fromkeys(CAMERAS, SIZE), "cam1"),
    ("relief", "estimate"): lambda s: s.estimate(SCENE),
    ("tracker", "follow"): lambda s: s.follow(LAMP, END, END, INSTANTS),
    ("occlusion", "scorer"): lambda s: s.scorer(POSE, [views()]),
    ("occlusion", "score"): lambda s: s.scorer(POSE, [views()]).score(views()),
    ("selector", "select"): lambda s: s.select(table(), frames=FRAMES, rate=Fraction(30)),
    ("centerer", "centre"): lambda s: s.centre([FieldPosition(FrameRange(0, 60), None)], size=SIZE, rate=30.0),
    ("filler", "fill"): lambda s: s.fill(Programme()),
}


def does(method: str, function: Callable) -> types.SimpleNamespace:
    """A plugin's object: ``method`` is ``function``, which gets the arguments alone."""
    made = types.SimpleNamespace(name="mine", version=1, remembers=False)
    if method == "score":
        made.scorer = lambda pose, samples: types.SimpleNamespace(score=function)
    else:
        setattr(made, method, function)
    return made


def offer(stage: str, implementation: object, watch: Watch | None = None) -> Offer:
    return Offer(stage, "mine", "their-package", "1.2", implementation, watch)


def gives(value: object) -> Callable:
    return lambda *_, **__: value


def run(stage: str, method: str, function: Callable) -> object:
    return CALLS[stage, method](offer(stage, does(method, function)).checked)


def refused(stage: str, method: str, function: Callable) -> str:
    with pytest.raises(PluginError) as caught:
        run(stage, method, function)
    text = str(caught.value)
    assert text.startswith(f"{STAGES[stage].noun} mine (their-package 1.2): {method} ")
    assert "\n" not in text
    assert text.endswith(f"Report it to the author of their-package, or choose another with --{stage}")
    return text


def shot(start: int, stop: int, camera: str = "cam1") -> Shot:
    return Shot(FrameRange(start, stop), camera, 0.5, "")


def moved(*ranges: tuple[int, int]) -> Detection:
    return Detection(tuple(Movement(FrameRange(*r)) for r in ranges))


GOOD = {
    ("movement", "detect"): moved((0, 10), (10, 60)),
    ("matcher", "features"): POINTS,
    ("matcher", "match"): np.array([[0, 1], [1, 0]]),
    ("aligner", "align"): GOOD_ALIGNMENT,
    ("relief", "estimate"): GOOD_RELIEF,
    ("tracker", "follow"): (AT_REST, None),
    ("occlusion", "score"): {"cam1": 0, "cam2": np.float32(1)},
    ("selector", "select"): [shot(0, 20), shot(20, 60, "cam2")],
    ("centerer", "centre"): [(0, 1, 2.0), (np.int64(30), np.float64(0), 0)],
    ("filler", "fill"): black(SIZE),
}


@pytest.mark.parametrize(("stage", "method"), GOOD)
def test_what_the_protocol_promises_passes(stage: str, method: str) -> None:
    assert run(stage, method, gives(GOOD[stage, method])) is not None


NAN = float("nan")
SKEWED = np.eye(3) * np.array([1, 1, NAN])
BAD = [
    ("movement", "detect", None, "gave None, expected Detection"),
    ("movement", "detect", moved((5, 20), (10, 30)), r"begins before 20"),
    ("movement", "detect", moved((5, 61)), "up to 61, beyond the 60 frames"),
    ("movement", "detect", Detection(("soon",)), "expected Movement"),
    ("matcher", "features", POINTS.points, "gave an array of float32 and shape .3, 2., expected Features"),
    ("matcher", "features", attrs.evolve(POINTS, size=(18, 32)), "for a picture of .32, 18."),
    ("matcher", "features", attrs.evolve(POINTS, points=POINTS.points * NAN), "not inside the picture"),
    ("matcher", "features", attrs.evolve(POINTS, points=POINTS.points + 40), "not inside the picture"),
    ("matcher", "features", attrs.evolve(POINTS, descriptors=POINTS.descriptors * 9), "unit length"),
    ("matcher", "features", attrs.evolve(POINTS, descriptors=POINTS.descriptors * NAN), "unit length"),
    ("matcher", "features", attrs.evolve(POINTS, descriptors=np.ones(3, np.float32)), "expected 2-D"),
    ("matcher", "match", [(0, 1, 2)], r"expected \(M, 2\) indices"),
    ("matcher", "match", [(0.5, 1)], "expected integers"),
    ("matcher", "match", [(0, 3)], "index outside of 3 points"),
    ("matcher", "match", [(0, -1)], "index outside of 3 points"),
    ("matcher", "match", [(0, 1), (0, 2)], "gave a point twice"),
    ("aligner", "align", {}, "expected Alignment"),
    ("aligner", "align", Alignment({"cam1": np.eye(3)}, {}, {}, ()), "neither a homography nor a reason for cam2"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, weak=(Weak("cam2", "?"),)), "both .* for cam2"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, weak=(Weak("cam9", "?"),)), "gave cam9, which no camera"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, weak=("cam9",)), "expected Weak"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, homographies={"cam1": np.eye(3), "cam2": SKEWED}), "for cam2"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, homographies={"cam1": np.eye(3), "cam2": np.eye(2)}), "for cam2"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, residual_px={"cam2": NAN}), "nan as residual_px of cam2"),
    ("aligner", "align", attrs.evolve(GOOD_ALIGNMENT, support={}), r"support of \[\]"),
    ("aligner", "align", Alignment({"cam2": np.eye(3)}, {}, {}, (Weak("cam1", "?"),)), "the reference cam1"),
    ("relief", "estimate", GOOD_RELIEF.gamma, "expected ReliefSurface"),
    ("relief", "estimate", attrs.evolve(GOOD_RELIEF, gamma=np.full((3, 4), NAN)), "as gamma, expected finite nodes"),
    ("relief", "estimate", attrs.evolve(GOOD_RELIEF, gamma=np.zeros(4)), "as gamma, expected finite nodes"),
    ("relief", "estimate", attrs.evolve(GOOD_RELIEF, gamma=np.zeros((4, 4))), r"gamma \(4, 4\), confidence \(3, 4\)"),
    ("relief", "estimate", attrs.evolve(GOOD_RELIEF, confidence=np.full((3, 4), 2.0)), "a confidence outside of 0..1"),
    ("relief", "estimate", attrs.evolve(GOOD_RELIEF, cameras=frozenset(["cam9"])), "gave cam9, which no camera"),
    ("tracker", "follow", None, "gave None, expected Sequence"),
    ("tracker", "follow", [AT_REST], "gave 1 views of 2 instants"),
    ("tracker", "follow", [None, AT_REST.numbers], r"an array of float64 and shape \(7,\), expected LampView"),
    ("tracker", "follow", [None, attrs.evolve(AT_REST, turn=np.eye(3))], "as turn at frame 12, expected 3 finite"),
    ("tracker", "follow", [attrs.evolve(AT_REST, shift=np.full(3, NAN)), None], "as shift at frame 10, expected 3"),
    ("tracker", "follow", [None, attrs.evolve(AT_REST, shift=[0, 0, 0])], r"gave \[0, 0, 0\] as shift at frame 12"),
    (
        "tracker",
        "follow",
        [None, attrs.evolve(AT_REST, zoom=1000.0)],
        "gave a view at frame 12 with numbers of 10.0 and",
    ),
    ("tracker", "follow", [None, attrs.evolve(AT_REST, zoom=NAN)], "gave nan as zoom at frame 12, expected a number"),
    ("occlusion", "scorer", 3, "gave 3, which has no score"),
    ("occlusion", "score", [0.5, 0.5], "expected Mapping"),
    ("occlusion", "score", {"cam1": 0.5}, "gave None for camera cam2, expected a number in 0..1"),
    ("occlusion", "score", {"cam1": 0.5, "cam2": NAN}, "gave nan for camera cam2"),
    ("occlusion", "score", {"cam1": 1.01, "cam2": 0.5}, "gave 1.01 for camera cam1"),
    ("occlusion", "score", {"cam1": "0.5", "cam2": 0.5}, "gave '0.5' for camera cam1"),
    ("selector", "select", None, "gave None, expected Sequence"),
    ("selector", "select", ["cam1"], "expected Shot"),
    ("selector", "select", [shot(0, 60, "cam9")], "'cam9'.*expected one of cam1, cam2"),
    ("selector", "select", [shot(0, 20), shot(21, 60)], "gap or an overlap"),
    ("selector", "select", [shot(0, 59)], "gap or an overlap"),
    ("selector", "select", [], "gap or an overlap"),
    ("centerer", "centre", [(0, 1.0)], r"expected \(frame, dx, dy\)"),
    ("centerer", "centre", [(0, NAN, 0)], r"expected \(frame, dx, dy\)"),
    ("centerer", "centre", [(0.5, 0, 0)], "a key at 0.5"),
    ("centerer", "centre", [(60, 0, 0)], "a key at 60 of 60 frames"),
    ("centerer", "centre", [(5, 0, 0), (5, 0, 0)], "out of order at 5"),
    ("centerer", "centre", [(0, 33, 0)], "larger than the programme"),
    ("filler", "fill", None, "gave None, expected Planes"),
    ("filler", "fill", black((30, 18)), r"a picture of \(30, 18\), expected \(32, 18\)"),
]


@pytest.mark.parametrize(("stage", "method", "value", "message"), BAD)
def test_what_it_does_not_allow_is_refused_by_name(stage: str, method: str, value: object, message: str) -> None:
    with pytest.raises(PluginError, match=message):
        run(stage, method, gives(value))
    refused(stage, method, gives(value))


@pytest.mark.parametrize(("stage", "method"), CALLS)
def test_what_a_plugin_raises_is_one_line_with_its_name(stage: str, method: str) -> None:
    def breaks(*_, **__):
        raise RuntimeError("no\nlicence.")

    assert f"{method} raised RuntimeError: no licence. Report" in refused(stage, method, breaks)


@pytest.mark.parametrize(("stage", "method"), CALLS)
def test_an_error_for_people_keeps_its_words_and_gets_the_plugins_name(stage: str, method: str) -> None:
    def refuses(*_, **__):
        raise InputError("has no layer 'seg'", where="net.onnx", remedy="Export it anew")

    with pytest.raises(InputError) as caught:
        run(stage, method, refuses)
    noun = STAGES[stage].noun
    expected = f"{noun} mine (their-package 1.2): net.onnx: has no layer 'seg'. Export it anew"
    assert (str(caught.value), caught.value.exit_code) == (expected, 3)


@pytest.mark.parametrize(("stage", "method"), CALLS)
def test_who_stops_is_not_blamed_on_the_plugin(stage: str, method: str) -> None:
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        run(stage, method, lambda *_, **__: token.check())


def spoils(value: object) -> Callable[[object], object]:
    """A plugin that writes into one of the arrays it is handed."""

    def spoil(*given, **_):
        target = value(*given)  # pyright: ignore[reportCallIssue]
        target[...] = 0
        raise AssertionError("it could be written to")

    return spoil


@pytest.mark.parametrize(
    ("stage", "method", "target"),
    [
        ("matcher", "features", lambda picture, mask: picture),
        ("matcher", "features", lambda picture, mask: mask),
        ("matcher", "match", lambda a, b: a.points),
        ("matcher", "match", lambda a, b: b.descriptors),
        ("aligner", "align", lambda pairs, sizes, reference: pairs[CAMERAS].a),
        ("aligner", "align", lambda pairs, sizes, reference: pairs[CAMERAS].weight),
        ("relief", "estimate", lambda scene: scene.points),
        ("relief", "estimate", lambda scene: scene.cameras["cam2"].projection),
        ("relief", "estimate", lambda scene: scene.cameras["cam2"].views[0].picture),
        ("tracker", "follow", lambda lamp, before, after, instants: lamp.mounts["cam2"]),
        ("tracker", "follow", lambda lamp, before, after, instants: before.view.turn),
        ("tracker", "follow", lambda lamp, before, after, instants: after.ground.gamma),
        ("tracker", "follow", lambda lamp, before, after, instants: after.templates["cam1"].places),
        ("tracker", "follow", lambda lamp, before, after, instants: instants[1].pictures["cam1"]),
        ("occlusion", "scorer", lambda pose, samples: pose.field),
        ("occlusion", "scorer", lambda pose, samples: pose.homographies["cam2"]),
        ("occlusion", "scorer", lambda pose, samples: samples[0][1].picture),
        ("occlusion", "scorer", lambda pose, samples: samples[:1][0][1].aligned),
        ("occlusion", "score", lambda views: views[0].aligned),
        ("occlusion", "score", lambda views: views[0].inside),
        ("selector", "select", lambda table: table.visible),
        ("selector", "select", lambda table: table.frames),
        ("filler", "fill", lambda view: view.front.y),
        ("filler", "fill", lambda view: view.previous.u),
        ("filler", "fill", lambda context: context.picture("cam2", None).v),
        ("filler", "fill", lambda view: view.footprint("cam2")),
    ],
)
def test_arrays_that_are_handed_over_cannot_be_written_to(stage: str, method: str, target: Callable) -> None:
    assert "read-only" in refused(stage, method, spoils(target))


@pytest.mark.parametrize(
    ("stage", "method", "change"),
    [
        ("movement", "detect", lambda samples, footage, progress: samples.frames.append(3)),
        ("aligner", "align", lambda pairs, sizes, reference: sizes.update(cam1=(1, 1))),
        ("aligner", "align", lambda pairs, sizes, reference: pairs.clear()),
        ("relief", "estimate", lambda scene: scene.cameras.pop("cam2")),
        ("tracker", "follow", lambda lamp, before, after, instants: before.bends.pop("cam2")),
        ("tracker", "follow", lambda lamp, before, after, instants: instants.clear()),
        ("tracker", "follow", lambda lamp, before, after, instants: instants[0].late.update(cam1=1.0)),
        ("occlusion", "scorer", lambda pose, samples: pose.homographies.pop("cam2")),
        ("occlusion", "score", lambda views: setattr(views[0], "camera", "cam2")),
        ("selector", "select", lambda table, **_: setattr(table, "cameras", ())),
    ],
)
def test_the_rest_cannot_be_changed_either(stage: str, method: str, change: Callable) -> None:
    text = refused(stage, method, change)
    assert any(kind in text for kind in ("AttributeError", "FrozenInstanceError"))


def test_samples_are_a_sequence_of_which_only_what_is_asked_for_is_read() -> None:
    read: list[int] = []

    class Samples:
        def __len__(self) -> int:
            return 6

        def __getitem__(self, at: int):
            read.append(at)
            return views()

    seen = []

    def scorer(pose, samples):
        seen.append((len(samples), len(samples[::2]), len(list(samples[4:]))))
        return types.SimpleNamespace(score=gives(dict.fromkeys(CAMERAS, 1)))

    offer("occlusion", does("scorer", scorer)).checked.scorer(POSE, Samples())
    assert seen == [(6, 3, 2)]
    assert read == [4, 5]


def test_a_frame_without_anything_to_fill_goes_through_untouched() -> None:
    view = Programme()
    assert offer("filler", does("fill", lambda v: v.front)).checked.fill(view) is view.front


def test_one_that_takes_longer_than_the_recording_lasts_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(0, 1000, 10))  # every reading of the clock is ten seconds after the last: each call takes ten
    monkeypatch.setattr("mcsl_core.hooks.guards.time.monotonic", lambda: float(next(clock)))
    notes: list[str] = []
    slow = offer("selector", does("select", gives([shot(0, 60)])), Watch(25.0, notes.append)).checked
    for _ in range(9):
        CALLS["selector", "select"](slow)
    told = "selector mine (their-package 1.2) has taken {} s, for a recording of 25 s"
    assert notes == [told.format(30), told.format(70)]
    our_own = offer("selector", does("select", gives([shot(0, 60)])), Watch(25.0, notes.append))
    for _ in range(9):
        CALLS["selector", "select"](attrs.evolve(our_own, package="mcsl").checked)
    assert len(notes) == 2


def test_errors_know_where_they_came_from_only_once() -> None:
    def refuses(*_, **__):
        raise McslError("is broken", where="selector mine (their-package 1.2)")

    with pytest.raises(McslError) as caught:
        run("selector", "select", refuses)
    assert str(caught.value) == "selector mine (their-package 1.2): is broken"
