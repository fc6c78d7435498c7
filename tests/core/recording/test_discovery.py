"""Which files are one camera, in what order, and what is told of it."""

from pathlib import Path

import av
import pytest
from coded_video import write_coded
from notes import Notes
from remuxed import split

from mcsl_core.errors import InputError
from mcsl_core.recording.cameras import open_cameras
from mcsl_core.recording.discovery import discover


def folder_of(tmp_path: Path, *names: str) -> Path:
    film = write_coded(tmp_path / "film.mp4", range(5))
    folder = tmp_path / "recording"
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(film.read_bytes())
    return folder


def found(folder: Path) -> dict[str, list[str]]:
    return {name: [f.name for f in files] for name, files in discover([folder])}


def test_chapters_of_a_gopro_follow_each_other(tmp_path):
    hero = ["GH010123.MP4", "GH020123.MP4", "GH100123.MP4"]
    old = ["GOPR0077.MP4", "GP010077.MP4", "GP020077.MP4"]
    folder = folder_of(tmp_path, *old[1:], *hero, old[0], "GX010123.MP4", "GH010124.MP4")
    assert found(folder) == {
        "GH0123": hero,
        "GH010124": ["GH010124.MP4"],
        "GOPR0077": old,
        "GX010123": ["GX010123.MP4"],
    }


@pytest.mark.parametrize(
    "names",
    [
        ["GH010123.MP4", "GH020123.MP4", "GH010124.MP4", "GH020124.MP4"],
        ["GOPR0009.MP4", "GP010009.MP4", "GOPR0010.MP4"],
        ["cam1.mp4", "cam1-2.mp4", "cam1-10.mp4"],
        ["cam1.mp4", "cam1 (2).mp4", "cam1 (3).mp4"],
        ["cam1_1.mp4", "cam1_2.mp4", "cam1_10.mp4"],
        ["DJI_0009.MP4", "DJI_0010.MP4", "DJI_0100.MP4"],
        ["2026-01-01 09-59-58.mp4", "2026-01-01 10-04-58.mp4", "2026-01-02 00-00-01.mp4"],
    ],
    ids=lambda names: names[1],
)
def test_the_files_of_a_camera_s_folder_are_in_order(tmp_path, names):
    folder = folder_of(tmp_path, *(f"cam/{name}" for name in reversed(names)), "other.mp4")
    assert found(folder)["cam"] == names


def test_cameras_are_not_glued_by_a_number_alone_and_it_is_told(tmp_path):
    folder = folder_of(tmp_path, "lamp.mp4", "lamp-2.mp4", "lamp (3).mp4", "lamp10.mp4")
    progress = Notes()
    cameras = open_cameras([folder], tmp_path, progress)
    assert {c.name for c in cameras} == {"lamp", "lamp-2", "lamp (3)", "lamp10"}
    told = [note for note in progress.notes if "taken for two cameras" in note]
    assert len(told) == 2
    assert any("lamp and lamp-2" in note and "put both into a folder lamp" in note for note in told)


def test_names_that_differ_in_case_alone_are_refused(tmp_path):
    with pytest.raises(InputError, match="two cameras are named"):
        discover([folder_of(tmp_path, "cam1.mp4", "CAM1.mov")])


def test_names_that_differ_in_their_code_points_alone_are_refused(tmp_path):
    """Macs write the letter in two: two cameras that nobody can tell apart, and one file on other machines."""
    names = ["\u00e4.mp4", "a\u0308.mp4"]
    folder = folder_of(tmp_path, *names)
    if len(list(folder.iterdir())) < 2:
        pytest.skip("this file system takes the two for one name")
    with pytest.raises(InputError, match="two cameras are named"):
        discover([folder])


def test_a_copy_left_among_the_cameras_is_told(tmp_path):
    folder = folder_of(tmp_path, "cam1.mp4", "Kopie von cam1.mp4")
    write_coded(folder / "cam2.mp4", range(6))
    (folder / "link.mp4").symlink_to(folder / "cam2.mp4")
    progress = Notes()
    open_cameras([folder], tmp_path, progress)
    told = sorted(note.partition(" are one film, byte for byte")[0] for note in progress.notes if "one film" in note)
    assert told == ["cam1 and Kopie von cam1", "cam2 and link"]


def test_what_was_joined_is_told_and_where_names_and_clocks_contradict(tmp_path):
    folder = folder_of(tmp_path, "a.mp4", "b.mp4")
    film = write_coded(tmp_path / "c.mp4", range(100), gop=20)
    (folder / "c").mkdir()
    one, two = split(film, suffix=".mkv", at_s=[1])
    one.rename(folder / "c" / "y.mkv")
    two.rename(folder / "c" / "x.mkv")
    progress = Notes()
    open_cameras([folder], tmp_path, progress)
    assert "c: 2 files one after another, x.mkv, y.mkv" in progress.notes
    assert "c: by their clock the files follow each other as y.mkv, x.mkv; their names were followed" in progress.notes


def test_names_and_times_of_making_that_contradict_are_told(tmp_path):
    folder = folder_of(tmp_path, "a.mp4", "b.mp4")
    (folder / "c").mkdir()
    for name, made in (("1.mp4", "2026-01-01T10:00:00.000000Z"), ("2.mp4", "2026-01-01T09:00:00.000000Z")):
        with av.open(str(tmp_path / "film.mp4")) as film, av.open(str(folder / "c" / name), "w") as out:
            copy = out.add_stream_from_template(film.streams.video[0])
            out.metadata["creation_time"] = made
            for packet in film.demux(video=0):
                if packet.dts is not None:
                    packet.stream = copy
                    out.mux(packet)
    progress = Notes()
    open_cameras([folder], tmp_path, progress)
    assert any(
        note.startswith("c: by its name 2.mp4 follows 1.mp4, but it was made earlier") for note in progress.notes
    )
