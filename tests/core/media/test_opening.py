"""Only local, regular files are opened, by whatever name, and nothing that their content leads to."""

import os
import socket
import struct
from contextlib import closing
from pathlib import Path

import av
import pytest
from coded_video import read_number, write_coded

from mcsl_core.errors import InputError, MediaError
from mcsl_core.media.opening import open_file
from mcsl_core.media.probing import probe
from mcsl_core.media.writing import VideoWriter
from mcsl_core.recording.discovery import discover

NAMES = [
    "12:30:01.mp4",
    "-i.mp4",
    "%03d.mp4",
    "ä[1].mp4",
    "two\nlines.mp4",
    "file:x.mp4",
    "concat:a|b.mp4",
    "?*'\" .mp4",
]
PROTOCOLS = [
    "http:",
    "https:",
    "data:",
    "subfile,,start,0,end,9,,:",
    "pipe:",
    "tcp:",
    "cache:",
    "file:",
    "async:",
    "udp:",
]

PLAYLISTS = {
    "hls": "#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{secret}\n#EXT-X-ENDLIST\n",
    "hls-with-mark": "\ufeff#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{secret}\n#EXT-X-ENDLIST\n",
    "hls-of-host": "#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\nhttp://127.0.0.1:{port}/a.ts\n#EXT-X-ENDLIST\n",
    "hls-with-key": '#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXT-X-KEY:METHOD=AES-128,URI="http://127.0.0.1:{port}/k"\n'
    "#EXTINF:9,\n{secret}\n#EXT-X-ENDLIST\n",
    "ffconcat": "ffconcat version 1.0\nfile '{secret}'\n",
    "ffconcat-options": "ffconcat version 1.0\nfile 'secret.mp4'\noption safe 0\n",
    "ffconcat-of-host": "ffconcat version 1.0\nfile http://127.0.0.1:{port}/a.mp4\n",
    "sdp": "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video {port} RTP/AVP 96\n"
    "a=rtpmap:96 H264/90000\n",
    "dash": '<?xml version="1.0"?>\n<MPD xmlns="urn:mpeg:dash:schema:mpd:2011" type="static" '
    'mediaPresentationDuration="PT1S" profiles="urn:mpeg:dash:profile:isoff-main:2011"><Period><AdaptationSet '
    'mimeType="video/mp4"><Representation id="1" bandwidth="9"><BaseURL>{secret}</BaseURL></Representation>'
    "</AdaptationSet></Period></MPD>\n",
    "imf": '<?xml version="1.0"?>\n<CompositionPlaylist xmlns="http://www.smpte-ra.org/schemas/2067-3/2016">\n',
    "asx": '<ASX version="3.0"><Entry><Ref href="http://127.0.0.1:{port}/a.mp4"/></Entry></ASX>\n',
    "pls": "[playlist]\nFile1=http://127.0.0.1:{port}/a.mp4\n",
    "mpv-edl": "# mpv EDL v0\n{secret}\n",
}


@pytest.fixture
def listener():
    """A local server that must see nobody."""
    with closing(socket.create_server(("127.0.0.1", 0))) as server:
        server.settimeout(0.02)
        yield server
        with pytest.raises(TimeoutError):
            server.accept()


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def shown_number(path: Path) -> int:
    with open_file(path) as container:
        return read_number(next(container.decode(video=0)).to_ndarray(format="gray"))


@pytest.mark.parametrize("name", NAMES)
def test_any_name_is_a_file(here, name):
    film = write_coded(here / "film.mp4", range(7, 12))
    film.rename(here / name)
    assert shown_number(Path(name)) == 7
    assert probe(name).frames == 5
    assert [files for _, files in discover([Path(name)])] == [(Path(name),)]


@pytest.mark.parametrize("folder", PROTOCOLS)
def test_a_relative_folder_is_no_protocol(here, folder):
    (here / folder).mkdir()
    write_coded(here / "film.mp4", range(9, 12)).rename(here / folder / "cam1.mp4")
    assert shown_number(Path(folder) / "cam1.mp4") == 9
    with VideoWriter(Path(folder) / "12:30.mp4", size=(64, 48), rate=probe(f"{folder}/cam1.mp4").rate) as writer:
        writer.write(grey())
    assert probe(f"{folder}/12:30.mp4").frames == 1
    assert sorted(p.name for p in here.rglob("*.mp4")) == ["12:30.mp4", "cam1.mp4"]


def grey():
    return av.VideoFrame(64, 48, "bgr24").to_ndarray()


@pytest.mark.parametrize(
    "name", ["http://127.0.0.1:{port}/cam1.mp4", "http:/127.0.0.1:{port}/cam1.mp4", "tcp:127.0.0.1:{port}"]
)
def test_no_name_reaches_a_host(here, listener, name):
    with pytest.raises(MediaError, match="cannot be opened"):
        open_file(Path(name.format(port=listener.getsockname()[1])))


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".ts", ".m3u8", ".sdp", ".mpd", ".txt"])
@pytest.mark.parametrize("kind", PLAYLISTS)
def test_a_playlist_is_refused_by_name(here, listener, kind, suffix):
    write_coded(here / "secret.mp4", range(99, 104))
    told = PLAYLISTS[kind].format(secret="secret.mp4", port=listener.getsockname()[1])
    path = here / f"cam1{suffix}"
    path.write_text(told, "utf-8")
    with pytest.raises(MediaError, match=r"is a (playlist|list of files|description)") as refused:
        open_file(path)
    assert refused.value.where == str(path)
    assert refused.value.remedy == "Hand in the camera's video file itself"
    with pytest.raises(InputError, match="is a "):
        discover([path])


@pytest.mark.parametrize("name", ["a001.png", "a001.jpg", "a001.bmp"])
def test_a_picture_is_no_numbered_series(here, name):
    film = write_coded(here / "film.mp4", range(3))
    with av.open(str(film)) as container:
        picture = next(container.decode(video=0))
    for number in (1, 2):
        with av.open(str(here / name.replace("1", str(number))), "w", format="image2", options={"update": "1"}) as out:
            stream = out.add_stream({"png": "png", "jpg": "mjpeg", "bmp": "bmp"}[name[-3:]], rate=1)
            stream.width, stream.height = picture.width, picture.height
            stream.pix_fmt = {"png": "rgb24", "jpg": "yuvj420p", "bmp": "bgr24"}[name[-3:]]
            out.mux(stream.encode(picture.reformat(format=stream.pix_fmt)))
            out.mux(stream.encode(None))
    for path in (Path(name), Path(f"a%03d{name[-4:]}")):
        with pytest.raises(MediaError):
            open_file(path)


def test_a_track_of_another_file_is_not_read(here):
    """A QuickTime reference movie: its data reference is an alias of another file, which FFmpeg can be told to open."""
    raw = {"codec": "rawvideo", "pix_fmt": "uyvy422", "options": {"strict": "0"}}  # so that its index fits any other
    write_coded(here / "secret.mov", range(99, 104), **raw)
    film = write_coded(here / "cam1.mov", range(7, 12), **raw)
    film.write_bytes(refer_to(film.read_bytes(), str(here / "secret.mov").encode()))
    told = {"enable_drefs": "1", "use_absolute_path": "1"}
    with av.open(str(film), options=told) as container:  # the material is what it claims to be
        assert read_number(next(container.decode(video=0)).to_ndarray(format="gray")) == 99
    with pytest.raises(MediaError, match="not one picture"):
        probe(film)


def refer_to(movie: bytes, path: bytes) -> bytes:
    """``movie`` (its index last) with the data reference of its first track replaced by an alias to ``path``."""
    alias = bytes(10) + bytes([1]) + bytes(27) + bytes(12) + bytes([1]) + bytes(63) + bytes(16)
    alias += struct.pack(">HH", 0, 0) + bytes(16)
    padded = path + bytes(len(path) % 2)
    alias += struct.pack(">HH", 2, len(path)) + padded + struct.pack(">HH", 0xFFFF, 0)
    entry = struct.pack(">I4sI", 12 + len(alias), b"alis", 0) + alias
    at = movie.index(b"dref") - 4
    (size,) = struct.unpack_from(">I", movie, at)
    made = struct.pack(">I4sII", 16 + len(entry), b"dref", 0, 1) + entry
    grown = bytearray(movie[:at] + made + movie[at + size :])
    for parent in (b"moov", b"trak", b"mdia", b"minf", b"dinf"):
        begin = movie.rindex(parent, 0, at) - 4
        struct.pack_into(">I", grown, begin, struct.unpack_from(">I", grown, begin)[0] + len(made) - size)
    return bytes(grown)


def test_what_is_no_regular_file_is_refused_and_not_waited_for(here):
    os.mkfifo(here / "cam1.mp4")
    for path in (here / "cam1.mp4", Path("/dev/zero")):
        with pytest.raises(MediaError, match="no regular file"):
            open_file(path)


def test_a_link_to_a_film_opens(here):
    write_coded(here / "film.mp4", range(7, 12))
    (here / "cam1.mp4").symlink_to(here / "film.mp4")
    assert shown_number(here / "cam1.mp4") == 7
