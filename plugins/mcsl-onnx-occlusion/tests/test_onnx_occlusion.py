"""Networks made here, whose answers are plain; refusals by file and key; a whole analysis by one of them."""

from __future__ import annotations

from pathlib import Path

import mcsl_onnx_occlusion as plugin
import networks
import numpy as np
import onnx
import pytest
from mcsl_onnx_occlusion.description import read_description
from mcsl_onnx_occlusion.network import Network

import mcsl_core as mcsl
from mcsl_core.analysis.stage_keys import identity
from mcsl_core.hooks import AlignedPose, DocumentError, InputError, Silent, UsageError, discover
from mcsl_core.simulation import Scenario, simulate

FIELD = '[output]\nmeaning = "sigmoid"\nfield = [0]\n'
RED, GREEN, BLUE = (30, 30, 220), (40, 200, 40), (220, 60, 30)  # BGR


def described(network: Path, text: str) -> Path:
    network.with_suffix(".toml").write_text(text, "utf-8")
    return network


def halves(left, right, size=(96, 64)) -> np.ndarray:
    picture = np.zeros((size[1], size[0], 3), np.uint8)
    picture[:, : size[0] // 2], picture[:, size[0] // 2 :] = left, right
    return picture


@pytest.fixture
def use(monkeypatch):
    """Names a network, as a user does."""
    return lambda path: monkeypatch.setenv(plugin.VARIABLE, str(path))


# ------------------------------------------------------------------------------------------- what the numbers mean


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (networks.reddish, FIELD),
        (lambda path: networks.reddish(path, logits=False), '[output]\nmeaning="probabilities"\nfield=[0]'),
        (networks.channels, '[output]\nmeaning="softmax"\nfield=[0]\nthreshold=0.4'),
        (networks.channels, '[output]\nmeaning="probabilities"\nfield=[0]'),
        (networks.channels, '[input]\ncolour="BGR"\n[output]\nmeaning="probabilities"\nfield=[2]'),
        (networks.labels, '[output]\nmeaning="labels"\nfield=[0]'),
        (
            lambda path: networks.channels(path, layout="NHWC"),
            '[input]\nlayout="NHWC"\n[output]\nlayout="NHWC"\nmeaning="probabilities"\nfield=[0]',
        ),
        (
            lambda path: networks.channels(path, kind="half"),
            '[output]\nmeaning="probabilities"\nfield=[0]',
        ),
        (
            lambda path: networks.channels(path, size=("w", "h")),
            '[input]\nsize=[48, 32]\n[output]\nmeaning="probabilities"\nfield=[0]',
        ),
    ],
    ids=["sigmoid", "its-sigmoid", "softmax", "probabilities", "bgr", "labels", "nhwc", "half", "free-size"],
)
def test_red_is_the_field_by_every_meaning_and_layout(tmp_path, make, text) -> None:
    maps = Network.load(described(make(tmp_path / "net.onnx"), text)).maps(halves(RED, GREEN, (192, 128)))
    assert maps.occluder is None
    assert maps.field is not None
    threshold = 0.4 if "0.4" in text else 0.5
    columns = maps.field.shape[1]
    assert (maps.field[:, : columns // 2 - 2] >= threshold).all()
    assert (maps.field[:, columns // 2 + 2 :] < threshold).all()


def test_normalisation_is_what_the_description_says(tmp_path) -> None:
    text = """
        [input]
        scale = 0.01
        mean = [0.5, 1.0, 0.25]
        deviation = [2.0, 4.0, 8.0]
        [output]
        meaning = "sigmoid"
        field = [0]
        occluder = [1, 2]
    """
    network = Network.load(described(networks.channels(tmp_path / "net.onnx"), text))
    maps = network.maps(np.full((64, 96, 3), (10, 150, 200), np.uint8))  # B, G, R
    r, g, b = ((v * 0.01 - m) / d for v, m, d in ((200, 0.5, 2.0), (150, 1.0, 4.0), (10, 0.25, 8.0)))
    assert maps.field is not None and maps.occluder is not None  # noqa: PT018
    np.testing.assert_allclose(maps.field, 1 / (1 + np.exp(-r)), atol=1e-5)
    np.testing.assert_allclose(maps.occluder, max(1 / (1 + np.exp(-g)), 1 / (1 + np.exp(-b))), atol=1e-5)


def test_several_classes_of_a_softmax_count_together(tmp_path) -> None:
    text = '[output]\nmeaning="softmax"\nfield=[0, 2]'
    network = Network.load(described(networks.channels(tmp_path / "net.onnx"), text))
    maps = network.maps(np.full((64, 96, 3), 90, np.uint8))
    assert maps.field is not None
    np.testing.assert_allclose(maps.field, 2 / 3, atol=1e-5)


# ------------------------------------------------------------------------------------------------------ scoring


def test_what_is_in_the_way_is_laid_into_the_scene(tmp_path, use) -> None:
    """The camera is turned by half a turn to the scene: its blue right half hides the scene's left half."""
    use(described(networks.labels(tmp_path / "net.onnx"), '[output]\nmeaning="labels"\noccluder=[2]'))
    turn = np.array([[-1.0, 0, 191], [0, -1, 127], [0, 0, 1]])
    field = np.zeros((128, 192), bool)
    field[32:96, 48:144] = True
    scene = AlignedPose((192, 128), "a", {"a": np.eye(3), "b": turn}, {"a": (192, 128), "b": (192, 128)}, field)
    blue_right = halves(GREEN, BLUE, (192, 128))
    views = scene.views({"a": halves(GREEN, GREEN, (192, 128)), "b": blue_right})
    scorer = plugin.OnnxOcclusion().scorer(scene, [views])
    assert scorer.score(views) == {"a": 1.0, "b": pytest.approx(0.5, abs=0.02)}
    visible = scorer.visible(views[1])
    assert not visible[:, :90].any()
    assert visible[:, 102:].all()


def test_a_network_that_knows_the_field_says_where_it_lies(tmp_path, use) -> None:
    """The scene takes everything for the field, as hue does under a drape of the skin's colour."""
    use(described(networks.reddish(tmp_path / "net.onnx"), FIELD))
    scene = AlignedPose((192, 128), "a", {"a": np.eye(3)}, {"a": (192, 128)}, np.ones((128, 192), bool))
    moments = [scene.views({"a": halves(RED, GREEN, (192, 128))})] * 4
    scorer = plugin.OnnxOcclusion().scorer(scene, moments)
    assert scorer.score(moments[0])["a"] > 0.99
    assert scorer.score(scene.views({"a": halves(GREEN, GREEN, (192, 128))}))["a"] == 0
    covered = halves(RED, GREEN, (192, 128))
    covered[:64] = BLUE
    assert scorer.score(scene.views({"a": covered}))["a"] == pytest.approx(0.5, abs=0.05)


def test_another_network_is_another_result_in_the_cache(tmp_path, use) -> None:
    offer = discover().choose("occlusion", "onnx")
    use(described(networks.reddish(tmp_path / "net.onnx"), FIELD))
    first = identity(offer)
    described(tmp_path / "net.onnx", FIELD + "threshold = 0.6\n")
    second = identity(offer)
    use(described(networks.channels(tmp_path / "other.onnx"), FIELD))
    assert len({first, second, identity(offer)}) == 3


@pytest.mark.parametrize("name", ["net[1].onnx", "net*.onnx", "[a-z]?.onnx", "net.onnx"])
def test_the_content_is_the_identity_whatever_the_file_is_called(tmp_path, name) -> None:
    """A name with brackets is no pattern; of another network's weights, in a file of any name, nothing is shared."""
    path = described(networks.reddish(tmp_path / name), FIELD)
    seen = {plugin.fingerprint(path)}
    described(networks.reddish(path, logits=False), FIELD)
    seen.add(plugin.fingerprint(path))
    described(path, FIELD + "threshold = 0.6\n")
    seen.add(plugin.fingerprint(path))
    onnx.save(onnx.load(path), path, save_as_external_data=True, location="weights of it.bin", size_threshold=0)
    seen.add(plugin.fingerprint(path))
    (tmp_path / "weights of it.bin").write_bytes(b"others")
    seen.add(plugin.fingerprint(path))
    assert len(seen) == 5


# ----------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("text", "spot", "what"),
    [
        ("", "", "output is missing|is missing"),
        ("[output", "", "is not TOML"),
        ('[output]\nmeaning="sigmoid"', "output.field", "at least one class"),
        ('[output]\nmeaning="sigmoid"\nfield=[1]\noccluder=[1]', "output.occluder", "class 1 is the field"),
        ('[output]\nmeaning="magic"\nfield=[0]', "output.meaning", "softmax, sigmoid"),
        ('[output]\nmeaning="sigmoid"\nfield=["skin"]', "output.field", "expected a whole number"),
        (FIELD + "treshold=0.4", "output.treshold", "unknown key"),
        (FIELD + "threshold=1.5", "output.threshold", "between 0 and 1"),
        (FIELD + "[input]\nmean=[0.5]", "input.mean", "expected 3 values"),
        (FIELD + "[input]\ndeviation=[1, 0, 1]", "input.deviation", "above 0"),
        (FIELD + '[input]\nlayout="CHW"', "input.layout", "NCHW, NHWC"),
        (FIELD + "[input]\nsize=[4, 100000]", "input.size", "8 to 4096"),
    ],
)
def test_a_wrong_description_is_refused_by_file_and_key(tmp_path, text, spot, what) -> None:
    path = tmp_path / "net.toml"
    path.write_text(text)
    with pytest.raises(DocumentError, match=what) as caught:
        read_description(path)
    assert caught.value.where.startswith(str(path))
    assert spot in caught.value.where
    assert "README" in caught.value.remedy


@pytest.mark.parametrize(
    ("make", "text", "spot", "what"),
    [
        (networks.reddish, FIELD.replace("[0]", "[1]"), "net.toml at output.field", "no class 1"),
        (networks.channels, '[output]\nmeaning="sigmoid"\noccluder=[3]', "net.toml at output.occluder", "no class 3"),
        (networks.reddish, FIELD + 'name="mask"', "net.toml at output.name", "no output 'mask' but out"),
        (networks.reddish, FIELD + "[input]\nsize=[64, 64]", "net.toml at input.size", "is 64x64, .* wants 96x64"),
        (lambda p: networks.reddish(p, size=("w", "h")), FIELD, "net.toml at input.size", "any size"),
        (networks.reddish, FIELD + '[input]\nlayout="NHWC"', "net.toml at input.layout", "96 channels"),
        (networks.labels, FIELD, "net.toml at output.meaning", "int64"),
        (networks.channels, '[output]\nmeaning="labels"\nfield=[0]', "net.toml at output.meaning", "one number"),
        (
            networks.channels,
            '[input]\nscale=1.0\n[output]\nmeaning="probabilities"\nfield=[0]',
            "net.toml at output.meaning",
            "0..1, the network gives 128 to 128",
        ),
        (lambda p: networks.channels(p, inputs=("picture", "depth")), FIELD, "net.onnx", "picture, depth"),
    ],
)  # fmt: skip
def test_a_network_that_does_not_fit_is_refused_by_file_and_key(tmp_path, make, text, spot, what) -> None:
    path = described(make(tmp_path / "net.onnx"), text)
    with pytest.raises(InputError, match=what) as caught:
        Network.load(path)
    assert spot in caught.value.where


def nhwc(path: Path, *, pooled: bool = False) -> Path:
    """1xHxWx1 out of 1xHxWx3; pooled: 1x1x1x1."""
    nodes = [
        networks.helper.make_node("ReduceMean", ["picture"], ["out"], axes=[1, 2, 3] if pooled else [3], keepdims=1),
    ]
    return networks.save(path, nodes, layout="NHWC")


@pytest.mark.parametrize("wide", [True, False])
def test_an_output_of_another_shape_is_refused_with_what_to_write(tmp_path, wide) -> None:
    path = described(nhwc(tmp_path / "net.onnx", pooled=not wide), '[input]\nlayout="NHWC"\n' + FIELD)
    with pytest.raises(InputError) as caught:
        Network.load(path)
    assert caught.value.where == f"{tmp_path / 'net.toml'} at output.layout"
    given = "1x64x96x1, by NCHW maps of 1x96 pixels" if wide else "1x1x1x1, by NCHW maps of 1x1 pixels"
    assert f"the network gives {given}, which is no picture of 96x64" in caught.value.what
    assert 'layout = "NHWC" under [output]' in caught.value.remedy


def test_the_network_that_was_reported_is_refused_by_shape() -> None:
    path = Path(__file__).parents[4] / "shared" / "data" / "faults" / "onnx" / "nhwc3.onnx"
    if not path.is_file():
        pytest.skip("the material is not here")
    with pytest.raises(InputError, match="which is no picture of 96x64"):
        Network.load(path)


def test_a_file_that_is_no_network_is_refused_by_name(tmp_path) -> None:
    path = tmp_path / "net.onnx"
    with pytest.raises(InputError, match=r"net\.toml: does not exist"):
        Network.load(path)
    described(path, FIELD)
    with pytest.raises(InputError, match=r"net\.onnx: is not there"):
        Network.load(path)
    path.write_bytes(b"half a download")
    with pytest.raises(InputError, match=r"net\.onnx: cannot be used as an ONNX network"):
        Network.load(path)


def test_values_that_are_no_numbers_are_refused_by_name(tmp_path) -> None:
    network = Network.load(described(networks.not_a_number(tmp_path / "net.onnx"), FIELD))
    with pytest.raises(InputError, match=r"net\.onnx: gives values that are no numbers"):
        network.maps(np.zeros((64, 96, 3), np.uint8))


def test_without_a_name_it_says_how_to_name_one(monkeypatch) -> None:
    monkeypatch.delenv(plugin.VARIABLE, raising=False)
    offer = discover().choose("occlusion", "onnx")
    assert offer.package == "mcsl-onnx-occlusion"
    assert "network=None" in repr(offer.implementation)
    with pytest.raises(UsageError, match=plugin.VARIABLE):
        offer.implementation.prepare()


def test_a_missing_network_is_told_before_any_work_is_done(tmp_path, monkeypatch) -> None:
    """Before the recording is even looked for."""
    monkeypatch.delenv(plugin.VARIABLE, raising=False)
    nowhere, out = tmp_path / "none", tmp_path / "edl.json"
    with pytest.raises(UsageError, match=r"mcsl-onnx-occlusion 0\.1\.0.*MCSL_ONNX_MODEL"):
        mcsl.analyse(nowhere, out, occlusion="onnx")
    with pytest.raises(InputError, match="does not exist"):
        mcsl.analyse(nowhere, out)


# ------------------------------------------------------------------------------------------------ the whole way


@pytest.mark.slow
def test_a_whole_analysis_by_a_network_takes_cameras_that_see_the_field(tmp_path, use) -> None:
    """The network tells skin and tissue from green drapes, white gloves and blue caps by colour."""
    use(described(networks.reddish(tmp_path / "net.onnx", size=(320, 180)), FIELD))
    scenario = Scenario(seed=341, duration_s=24, size=(480, 270), rate=6, movements=0, audio=False, heads=4)
    truth = simulate(scenario, tmp_path / "recording", Silent())
    settings = mcsl.AnalysisSettings(sync="none", cache=False)
    made = mcsl.analyse(tmp_path / "recording", tmp_path / "edl.json", settings=settings, occlusion="onnx").edl
    assert made.made_by is not None
    assert made.made_by.plugins["occlusion"] == "onnx (mcsl-onnx-occlusion 0.1.0)"
    seen = truth.visible_field
    got = np.concatenate([seen[s.range.start : s.range.stop, truth.cameras.index(s.camera)] for s in made.shots])
    assert got.sum() > 0.93 * seen.max(axis=1).sum()
    assert got.mean() > seen.mean() + 0.5 * (seen.max(axis=1).mean() - seen.mean())
    with np.load(tmp_path / "edl.scores.npz") as table:
        said, true = table["visible"], seen[table["frames"]]
    known = ~np.isnan(said)
    assert np.corrcoef(said[known], true[known])[0, 1] > 0.8
