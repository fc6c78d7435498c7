"""An EDL names files of its own folder and of the recording it was made from here; everything else is refused."""

import os
import stat
import sys

import attrs
import platformdirs
import pytest
from builders import small_edl

from mcsl_core import edl as edls
from mcsl_core.edl import outside
from mcsl_core.errors import InputError


@pytest.fixture(autouse=True)
def own_state(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("MCSL_STATE", str(tmp_path_factory.mktemp("state")))
    monkeypatch.delenv("MCSL_ALLOW_OUTSIDE", raising=False)


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "from elsewhere" / "edit"
    made.mkdir(parents=True)
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "patient.mp4").write_bytes(b"a film")
    return made


def naming(path, *, scores=None):
    """An EDL whose second camera's file is ``path``."""
    edl = small_edl(scores=scores)
    second = attrs.evolve(edl.cameras[1], media=(edls.Media(str(path), edl.frames),))
    return attrs.evolve(edl, cameras=(edl.cameras[0], second, *edl.cameras[2:]))


def written(edl, path):
    edls.save(edl, path)
    return path


@pytest.mark.parametrize(
    "name", ["cam2.mp4", "./cam2.mp4", "rec/cam2.mp4", "rec/../cam2.mp4", "..cam2.mp4", "12:30:01.mp4"]
)
def test_files_in_its_own_folder_are_fine(folder, name):
    edls.load(written(naming(name), folder / "edl.json"))


def test_an_absolute_path_into_its_own_folder_is_fine(folder):
    edls.load(written(naming(folder / "rec" / "cam2.mp4"), folder / "edl.json"))


@pytest.mark.parametrize(
    "name",
    [
        "../../secret/patient.mp4",
        "rec/../../../secret/patient.mp4",
        "../edit2/cam2.mp4",
        "{top}/secret/patient.mp4",
        "/etc/passwd",
        "/dev/video0",
        "//host/share/cam2.mp4",
        "..",
    ],
)
def test_what_leads_out_is_refused_by_name(folder, tmp_path, name):
    path = written(naming(name.format(top=tmp_path)), folder / "edl.json")
    with pytest.raises(InputError, match="leads out of the EDL's folder, to ") as refused:
        edls.load(path)
    assert refused.value.where == f"{path} at $.cameras[1].media[0].path"
    assert "--allow-outside" in refused.value.remedy
    assert "allow_outside=True" in refused.value.remedy


def test_links_that_lead_out_are_refused(folder, tmp_path):
    (folder / "cam2.mp4").symlink_to(tmp_path / "secret" / "patient.mp4")
    (folder / "rec").symlink_to(tmp_path / "secret")
    (folder / "twice").symlink_to(folder / "rec")
    for name in ("cam2.mp4", "rec/patient.mp4", "twice/patient.mp4", "rec/../secret/patient.mp4"):
        with pytest.raises(InputError, match=r"to .*secret"):
            edls.load(written(naming(name), folder / "edl.json"))


def test_links_that_stay_inside_are_fine(folder):
    (folder / "film.mp4").write_bytes(b"a film")
    (folder / "cam2.mp4").symlink_to("film.mp4")
    edls.load(written(naming("cam2.mp4"), folder / "edl.json"))


def test_the_scores_lie_inside_too(folder):
    path = written(naming("cam2.mp4", scores="../../secret/x.npz"), folder / "edl.json")
    with pytest.raises(InputError, match="leads out") as refused:
        edls.load(path)
    assert refused.value.where.endswith("$.scores")


def test_all_that_lead_out_are_counted(folder):
    edl = naming("/a/cam2.mp4", scores="/b/x.npz")
    with pytest.raises(InputError, match=r"/a/cam2.mp4 \(and 1 more path\)"):
        edls.load(written(edl, folder / "edl.json"))


@pytest.mark.parametrize("given", [{"allow_outside": True}, {}])
def test_what_was_allowed_once_is_remembered(folder, given):
    path = written(naming("../../secret/patient.mp4"), folder / "edl.json")
    if given:
        edls.load(path, **given)
    else:
        with edls.allowed_outside():
            edls.load(path)
        assert "MCSL_ALLOW_OUTSIDE" not in os.environ
    edls.load(path)
    other = written(naming("../../secret/patient.mp4"), folder / "another.json")
    with pytest.raises(InputError):
        edls.load(other)
    written(naming("../../elsewhere/patient.mp4"), path)  # another recording is not what was allowed
    with pytest.raises(InputError):
        edls.load(path)


def test_what_was_allowed_through_a_link_is_remembered(folder, tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "secret")
    path = written(naming("../../link/patient.mp4"), folder / "edl.json")
    edls.load(path, allow_outside=True)
    edls.load(path)
    (tmp_path / "by link").symlink_to(folder)
    edls.load(tmp_path / "by link" / "edl.json")


def test_what_is_remembered_is_nobody_elses(folder):
    edls.load(written(naming("../../secret/patient.mp4"), folder / "edl.json"), allow_outside=True)
    (record,) = outside._state_folder().rglob("*.json")
    assert stat.S_IMODE(record.stat().st_mode) == 0o600
    assert stat.S_IMODE(record.parent.stat().st_mode) == 0o700


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"folders": 1}', '{"folders": [1, "."]}', "\0", '{"folders": null}'])
def test_a_damaged_record_allows_nothing(folder, text):
    path = written(naming("../../secret/patient.mp4"), folder / "edl.json")
    edls.load(path, allow_outside=True)
    (record,) = outside._state_folder().rglob("*.json")
    record.write_text(text)
    with pytest.raises(InputError, match="leads out"):
        edls.load(path)


def test_where_nothing_can_be_remembered_the_flag_serves_still(folder, tmp_path, monkeypatch):
    (tmp_path / "a file").write_text("")
    monkeypatch.setenv("MCSL_STATE", str(tmp_path / "a file"))
    path = written(naming("../../secret/patient.mp4"), folder / "edl.json")
    edl = edls.load(path, allow_outside=True)
    assert not edls.remember(edl, path)
    with pytest.raises(InputError):
        edls.load(path)


def test_the_state_lies_where_the_house_keeps_what_is_the_users(monkeypatch):
    for name in ("MCSL_STATE", "MCSL_HOME"):
        monkeypatch.delenv(name, raising=False)
    assert str(outside._state_folder()) == platformdirs.user_data_dir("mcsl")
    assert sys.platform
