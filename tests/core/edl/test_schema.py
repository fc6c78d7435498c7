"""Wrong EDLs: each is refused with the path to the wrong value, by mcsl and, where it can know, by the JSON Schema."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from builders import R, small
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import edls

from mcsl_core.documents import Bounds
from mcsl_core.edl import IDENTITY, Edl, Look, MadeBy, Movement, Override, Pose, Shot, Weak, from_json, loads, to_json
from mcsl_core.errors import DocumentError, Fault

SCHEMA_FILE = Path(__file__).parents[3] / "docs" / "reference" / "edl.schema.json"

Step = str | int


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    schema = json.loads(SCHEMA_FILE.read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def steps_of(path: str) -> list[Step]:
    """Reads ``$.a[0]["odd name"]`` back into its steps."""
    assert path.startswith("$"), path
    token = re.compile(r'\.([\w-]+)|\[(\d+)\]|\[("(?:[^"\\]|\\.)*")\]')
    steps: list[Step] = []
    at = 1
    while at < len(path):
        match = token.match(path, at)
        assert match, f"cannot read {path!r} from {at}"
        name, index, quoted = match.groups()
        steps.append(int(index) if index else json.loads(quoted) if quoted else name)
        at = match.end()
    return steps


def refused_at(value: Any) -> list[Step]:
    with pytest.raises(DocumentError) as refused:
        from_json(value, where="x.json")
    where = refused.value.where
    assert where.startswith("x.json at $")
    assert "more fault" not in refused.value.what, "one wrong value is one fault"
    assert refused.value.what
    assert refused.value.remedy
    return steps_of(where.removeprefix("x.json at "))


def nodes(value: Any, path: tuple[Step, ...] = ()) -> list[tuple[tuple[Step, ...], Any]]:
    """Every value of a document with its path, but for the free-form settings and the schema's name."""
    if path in {("made_by", "settings"), ("schema",)}:
        return []
    found = [(path, value)] if path else []
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return found + [node for step, child in children for node in nodes(child, (*path, step))]


def parent_of(value: Any, path: tuple[Step, ...]) -> Any:
    for step in path[:-1]:
        value = value[step]
    return value


def wrong_kinds(value: Any) -> list[Any]:
    """JSON values of another kind than ``value``, none of them null since some fields may be null."""
    if isinstance(value, bool):
        return [1, "true", [], {}]
    if isinstance(value, int):
        return [value + 0.5, str(value), True, [value], {}]
    if isinstance(value, float):
        return [str(value), False, [value], {}]
    if isinstance(value, str):
        return [7, True, [value], {"text": value}]
    if isinstance(value, list):
        return [7, "list", {}, False]
    if isinstance(value, dict):
        return [7, "object", list(value), True]
    return [7, [], True]  # null, where a text or an object may stand


@given(edls(), st.data())
def test_a_value_of_the_wrong_kind_is_refused_at_its_path(validator, edl, data):
    value = json.loads(json.dumps(to_json(edl)))
    path, old = data.draw(st.sampled_from(nodes(value)))
    parent_of(value, path)[path[-1]] = data.draw(st.sampled_from(wrong_kinds(old)))
    assert refused_at(value) == list(path)
    assert not validator.is_valid(value)


@given(edls(), st.data())
def test_an_unknown_key_is_refused_at_its_path(validator, edl, data):
    value = json.loads(json.dumps(to_json(edl)))
    maps = {"homographies", "projections", "colour", "residual_px", "support", "plugins"}
    classes = [((), value)] + [
        (p, v) for p, v in nodes(value) if isinstance(v, dict) and not (p[-1] in maps and p[0] != "look")
    ]
    path, holder = data.draw(st.sampled_from(classes))
    name = data.draw(st.sampled_from(["centring", "Range", "odd name", ""]))
    holder[name] = 1
    assert refused_at(value) == [*path, name]
    assert not validator.is_valid(value)


REQUIRED = {
    (): {"rate", "size", "frames", "reference", "cameras", "poses", "shots"},
    ("cameras",): {"name", "media", "size", "rate"},
    ("cameras", "media"): {"path", "frames"},
    ("movements",): {"range"},
    ("poses",): {"range", "homographies"},
    ("poses", "weak"): {"camera", "reason"},
    ("poses", "relief"): {"projections", "gamma", "confidence"},
    ("shots",): {"range", "camera"},
    ("overrides",): {"range"},
    ("corrections",): {"range", "camera", "matrix"},
    ("made_by",): {"mcsl"},
    ("fields",): {"range", "by", "polygons"},
    ("drawn_fields",): {"range", "polygons"},
}


@given(edls(), st.data())
def test_a_missing_key_is_refused_at_its_path_and_an_optional_one_takes_its_default(validator, edl, data):
    value = json.loads(json.dumps(to_json(edl)))
    path, _ = data.draw(
        st.sampled_from([(p, v) for p, v in nodes(value) if isinstance(p[-1], str) and "colour" not in p[:-1]])
    )
    kind = tuple(s for s in path[:-1] if isinstance(s, str))
    assume(kind not in {("poses", m) for m in ("homographies", "residual_px", "support")} | {("made_by", "plugins")})
    assume(kind != ("poses", "relief", "projections"))  # cameras' names, of which one must be left
    # A camera without a homography must be called weak, so here the default is no true default.
    assume(not (kind == ("poses",) and path[-1] == "weak" and parent_of(value, path)["weak"]))
    del parent_of(value, path)[path[-1]]
    if path[-1] in REQUIRED.get(kind, ()):
        assert refused_at(value) == list(path)
        assert not validator.is_valid(value)
    else:
        assert isinstance(from_json(value), Edl)
        assert validator.is_valid(value)


@given(edls())
def test_the_json_schema_accepts_every_edl(validator, edl):
    validator.validate(json.loads(json.dumps(to_json(edl))))


def full() -> dict[str, Any]:
    """Something in every place."""
    h = ((0.5, 0.1, 10.0), (-0.1, 0.5, 20.0), (1e-6, 0.0, 1.0))
    both = {"cam1": IDENTITY, "cam2": h}
    edl = small(
        movements=(Movement(R(20, 30)), Movement(R(40, 50))),
        poses=(
            Pose(R(0, 25), both, residual_px={"cam2": 0.8}, support={"cam2": 40}, solved_from=(3, 9)),
            Pose(R(25, 100), both, anchor=h, weak=(Weak("cam2", "dark"),)),
        ),
        shots=(Shot(R(0, 40), "cam1", 0.9, "clear"), Shot(R(40, 100), "cam2")),
        overrides=(Override(R(5, 10), camera="cam2"), Override(R(7, 9), fill=False)),
        look=Look(),
        centering=((0, 1.0, 2.0), (50, 3.0, 4.0)),
        made_by=MadeBy("0.1.0", {"every_s": 1.0}, {"filler": "footprint"}),
    )
    value = json.loads(json.dumps(to_json(edl)))
    value["cameras"][0]["gaps"] = [[3, 6], [6, 8]]
    value["poses"][0]["colour"] = {"cam2": {"matrix": [[1.0, 0.0, 0.0, 4.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0]]}}
    value["poses"][0]["relief"] = {
        "projections": {"cam2": [[1.0, 0.0, 4.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0]]},
        "gamma": [[0.0, 1.5, 0.0], [0.25, -3.0, 0.0]],
        "confidence": [[0, 100, 0], [50, 20, 7]],
    }
    return value


# (path that is set, wrong value, path it is refused at when another, words of the message, does the JSON Schema know?)
WRONG = [
    ("$.frames", 0, None, "must be 1 to 50000000, got 0", True),
    ("$.frames", 99, "$.poses", "poses must tile [0, 99): they end at frame 100", False),
    ("$.size[1]", -2, None, "must be 1 to 16384, got -2", True),
    ("$.size[1]", True, None, "expected a whole number, got true", True),
    ("$.size[1]", 1080.0, None, "expected a whole number, got 1080.0", False),  # to JSON Schema 1080.0 is whole
    ("$.shots[0].score", True, None, "expected a number, got true", True),
    ("$.shots[0].camera", 1, None, "expected a text, got 1", True),
    ("$.size", [1, 2, 3], None, "expected 2 values, got 3", True),
    ("$.rate", "0/1", None, "a rate must be positive", False),
    ("$.rate", "30/0", None, "expected a rate such as '30000/1001'", False),
    ("$.rate", "fast", None, "expected a rate such as '30000/1001' or '25', got 'fast'", True),
    ("$.rate", "1e999999999", None, "expected a rate", True),
    ("$.rate", "-25", None, "expected a rate", True),
    ("$.rate", "1/999999999", None, "a rate must lie in 0.01 to 1000 frames/s", False),
    ("$.rate", "999999999", None, "a rate must lie in 0.01 to 1000 frames/s", False),
    ("$.cameras[0].rate", "999999999/1", None, "a rate must lie in", False),
    ("$.frames", 10**9, None, "must be 1 to 50000000, got 1000000000", True),
    ("$.frames", 10**400, None, "expected a whole number of at most 18 digits, got 1000", True),
    ("$.size", [10**6, 10**6], "$.size[0]", "must be 1 to 16384", True),
    ("$.cameras[1].size", [320, 10**6], "$.cameras[1].size[1]", "must be 1 to 16384", True),
    ("$.overrides[0].range", [5, 10**12], None, "ends after the programme's 100 frames", False),
    ("$.overrides[0].offset", [1e300, 0], "$.overrides[0].offset[0]", "must be -10000000 to 10000000", False),
    ("$.poses[0].homographies.cam2[0][2]", 1e300, None, "must be -10000000 to 10000000", False),
    ("$.centering[1][1]", 1e30, None, "must be -10000000 to 10000000", False),
    ("$.reference", "cam9", None, "'cam9' is not a camera, expected one of cam1, cam2", False),
    ("$.cameras", [], None, "must not be empty", True),
    ("$.cameras[0].name", "", None, "must not be empty", True),
    ("$.cameras[1].name", "cam1", None, "a camera before it is also called 'cam1'", False),
    ("$.cameras[0].media", [], None, "must not be empty", True),
    ("$.cameras[0].media[0].path", "", None, "must not be empty", True),
    ("$.cameras[0].media[0].frames", 0, None, "must be 1 to 50000000", True),
    ("$.cameras[0].clock.confidence", 1.01, None, "must be 0 to 1, got 1.01", True),
    ("$.cameras[0].clock.drift_ppm", -1e6, None, "must be -100000 to 100000", True),
    ("$.cameras[0].clock.offset_s", 10**400, None, "expected a finite number", True),
    ("$.cameras[0].gaps[1]", [5, 8], None, "[5, 8) begins before the one before it ends at 6", False),
    ("$.cameras[0].gaps[1]", [6, 101], None, "ends after the programme's 100 frames", False),
    ("$.movements[1].range", [29, 50], None, "begins before the one before it ends at 30", False),
    ("$.movements[1].range", [40, 101], None, "ends after the programme's 100 frames", False),
    ("$.movements[1].range", [40, 40], None, "a range ends after it starts, got [40, 40]", False),
    ("$.movements[1].range", [40], None, "expected a range [start, stop], got [40]", True),
    ("$.movements[0].range[0]", -1, "$.movements[0].range", "a range starts at 0 or later", True),
    ("$.movements[0].confidence", -0.1, None, "must be 0 to 1", True),
    ("$.poses", [], None, "poses must tile [0, 100): they end at frame 0", False),
    ("$.poses[1].range", [26, 100], "$.poses[1]", "gap at frame 25, this is [26, 100)", False),
    ("$.poses[0].range", [0, 26], "$.poses[1]", "overlap at frame 26, this is [25, 100)", False),
    ("$.poses[1].range", [25, 99], "$.poses", "they end at frame 99", False),
    ("$.poses[0].homographies", {"cam1": IDENTITY}, None, "lacks cam2, not weak either", False),
    ("$.poses[0].homographies.cam9", IDENTITY, None, "'cam9' is not a camera", False),
    ("$.poses[0].homographies.cam1[0][2]", 1.0, "$.poses[0].homographies.cam1", "must be the identity", False),
    ("$.poses[0].homographies.cam2", [[1, 0, 0], [0, 0, 0], [0, 0, 1]], None, "is singular", False),
    ("$.poses[0].homographies.cam2[2][2]", 2.0, None, "scaled so that its last element is 1, got 2.0", False),
    ("$.poses[0].homographies.cam2[1]", [1.0, 2.0], None, "expected 3 values, got 2", True),
    ("$.poses[1].anchor[2][2]", 0.0, None, "scaled so that its last element is 1", False),
    ("$.poses[1].perspective", -1, None, "must be 0 or more", True),
    ("$.poses[0].colour.cam9", {"matrix": [[0.0] * 4] * 3}, None, "'cam9' is not a camera", False),
    ("$.poses[0].relief.projections.cam9", [[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], None, "'cam9' is not", False),
    ("$.poses[0].relief.projections", {}, None, "must not be empty", False),
    ("$.poses[0].relief.projections.cam2[2]", [0, 0, 1.0], None, "expected 4 values, got 3", True),
    ("$.poses[0].relief.projections.cam2[2][2]", 2.0, None, "scaled so that its last element is 1", False),
    ("$.poses[0].relief.projections.cam2[1][1]", 0, "$.poses[0].relief.projections.cam2", "is singular", False),
    ("$.poses[0].relief.projections.cam2[0][3]", 1e300, None, "must be -10000000 to", False),
    ("$.poses[0].relief.gamma", [[0.0, 1.5, 0.0]], None, "has 1 rows, 2 to 1024 are taken", False),
    ("$.poses[0].relief.gamma", [], None, "has 0 rows, 2 to 1024 are taken", False),
    ("$.poses[0].relief.gamma", [[0.0], [0.0]], "$.poses[0].relief.gamma[0]", "has 1 nodes, 2 to 1024", False),
    ("$.poses[0].relief.gamma[1]", [0.0, 1.0], None, "has 2 nodes, gamma[0] has 3", False),
    ("$.poses[0].relief.gamma[1][1]", 1e300, None, "must be -10000000 to 10000000", True),
    ("$.poses[0].relief.gamma[1][1]", None, None, "expected a number, got null", True),
    ("$.poses[0].relief.confidence", [[0, 1, 2]], None, "has 1 rows, gamma has 2", False),
    ("$.poses[0].relief.confidence[0]", [1, 2, 3, 4], None, "has 4 nodes, gamma[0] has 3", False),
    ("$.poses[0].relief.confidence[1][0]", 101, None, "must be 0 to 100, got 101", True),
    ("$.poses[0].relief.confidence[1][0]", 50.5, None, "expected a whole number, got 50.5", True),
    ("$.overrides[0].surface", 1, None, "expected true or false, got 1", True),
    ("$.poses[0].residual_px.cam2", -0.1, None, "must be 0 or more", True),
    ("$.poses[0].support.cam2", -1, None, "must be 0 or more", True),
    ("$.poses[0].solved_from[1]", -1, None, "must be 0 or more", True),
    ("$.poses[1].weak[0].camera", "cam9", None, "'cam9' is not a camera", False),
    ("$.shots", [], None, "shots must tile [0, 100): they end at frame 0", False),
    ("$.shots[1].range", [41, 100], "$.shots[1]", "gap at frame 40", False),
    ("$.shots[1].range", [39, 100], "$.shots[1]", "overlap at frame 40", False),
    ("$.shots[0].camera", "cam3", None, "'cam3' is not a camera", False),
    ("$.shots[0].score", 1.5, None, "must be 0 to 1", True),
    ("$.overrides[1].camera", "cam3", None, "'cam3' is not a camera", False),
    ("$.overrides[0].range", [5, 101], None, "ends after the programme's 100 frames", False),
    ("$.look.fill", None, None, "expected true or false, got null", True),
    ("$.centering[1][0]", 0, None, "keys must rise, got frame 0 after 0", False),
    ("$.centering[1][0]", 100, None, "frame 100 is outside [0, 100)", False),
    ("$.made_by.plugins.filler", 3, None, "expected a text, got 3", True),
]


@pytest.mark.parametrize(("path", "wrong", "at", "words", "schema_knows"), WRONG, ids=lambda x: str(x)[:40])
def test_a_value_that_breaks_a_rule_is_refused_where_it_stands(validator, path, wrong, at, words, schema_knows):
    value = full()
    from_json(value)
    validator.validate(value)
    steps = tuple(steps_of(path))
    parent_of(value, steps)[steps[-1]] = json.loads(json.dumps(wrong))
    with pytest.raises(DocumentError) as refused:
        from_json(copy.deepcopy(value))
    assert refused.value.where == (at or path)
    assert words in refused.value.what
    assert validator.is_valid(value) != schema_knows


@pytest.mark.parametrize(
    ("part", "count", "most"),
    [
        ("cameras", 100_000, 256),
        ("shots", 100_001, 100_000),
        ("overrides", 100_001, 100_000),
        ("poses", 10_001, 10_000),
    ],
)
def test_there_are_no_more_of_anything_than_an_operation_can_have(part, count, most):
    """Also a programme that is as long as all that: the number is refused, not what it does to the rest."""
    value = full()
    value["frames"] = 1_000_000
    one = value[part][0]
    value[part] = [
        {**one, "name": f"cam{n}"} if part == "cameras" else {**one, "range": [n, n + 1]} for n in range(count)
    ]
    with pytest.raises(DocumentError, match=f"holds {count}, at most {most} are taken"):
        from_json(value)


def test_a_programme_of_more_than_two_days_is_refused():
    value = full()
    value["rate"], value["frames"] = "1/100", 20_000
    with pytest.raises(DocumentError, match=r"\$\.frames: 2e\+06 s are longer than two days"):
        from_json(value)


def test_the_reference_camera_must_have_its_homography_even_where_it_is_called_weak():
    value = full()
    value["poses"][1]["weak"].append({"camera": "cam1", "reason": "out of focus"})
    del value["poses"][1]["homographies"]["cam1"]
    assert refused_at(value) == ["poses", 1, "homographies", "cam1"]


def test_several_faults_are_counted_and_the_first_is_shown():
    value = full()
    value["size"][0] = "wide"
    value["shots"][0]["camera"] = 3
    value["more"] = 1
    with pytest.raises(DocumentError) as refused:
        from_json(value, where="a.json")
    assert str(refused.value) == (
        "a.json at $.more: unknown key, expected one of rate, size, frames, reference, cameras, movements, poses, "
        "shots, overrides, corrections, fields, drawn_fields, removed, audio_from, look, centering, scores, "
        "made_by (and 2 more faults). Correct the value; docs/ describes the EDL (edl.md)"
    )


def test_an_unknown_key_is_answered_with_those_that_there_are():
    value = full()
    value["look"]["centring"] = True
    with pytest.raises(DocumentError, match="unknown key, expected one of centering, fill, colour"):
        from_json(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"schema": "mcsl.edl/1",', r"^f\.json, line 1, column 25: is not JSON"),
        ('{"look": {"fill": true, "fill": false}}', "f.json: is refused: the key 'fill' stands twice in one object"),
        ('{"frames": NaN}', "f.json: is refused: NaN is not a number"),
        ('{"frames": -Infinity}', "-Infinity is not a number"),
        ('{"frames": 1' + "0" * 5000 + "}", "f.json: is refused"),
        ("[" * 100_000, "f.json: is nested too deeply"),
        ("", "line 1, column 1: is not JSON"),
    ],
)
def test_text_that_is_not_strict_json_is_refused(text, message):
    with pytest.raises(DocumentError, match=message):
        loads(text, where="f.json")


def test_values_made_in_code_are_checked_as_well():
    with pytest.raises(Fault, match=r"^homographies\.cam2\[2\]\[2\]: must be scaled"):
        Pose(R(0, 1), {"cam2": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 2.0))})
    with pytest.raises(Fault, match="must be a tuple of three rows of three numbers"):
        Pose(R(0, 1), {"cam2": [[1.0, 0.0], [0.0, 1.0]]})  # pyright: ignore[reportArgumentType]
    with pytest.raises(Fault, match=r"^score: must be 0 to 1, got nan"):
        Shot(R(0, 1), "cam1", float("nan"))
    with pytest.raises(Fault, match=r'^residual_px\["cam 2"\]: must be 0 or more, got inf'):
        Pose(R(0, 1), {}, residual_px={"cam 2": float("inf")})
    with pytest.raises(Fault, match=r"^x: must be finite"):
        Bounds().check(float("inf"), ".x")
    with pytest.raises(TypeError):
        R(0, 1.0)  # pyright: ignore[reportArgumentType]


def test_other_decisions_are_checked_as_in_a_new_document():
    edl, said = small(), Override(R(5, 9), camera="cam2")
    assert edl.redecided(overrides=(said,), look=Look(fill=True)) == small(overrides=(said,), look=Look(fill=True))
    assert edl.overrides == ()
    for wrong in (Override(R(5, 9), camera="cam9"), Override(R(5, 1000), camera="cam2")):
        with pytest.raises(Fault) as new:
            small(overrides=(wrong,))
        with pytest.raises(Fault) as again:
            edl.redecided(overrides=(wrong,))
        assert str(again.value) == str(new.value)
