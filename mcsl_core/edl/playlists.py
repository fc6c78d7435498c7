"""Files that hold no pictures but name other files or hosts, known by their first bytes; for Blender too."""

from __future__ import annotations

from pathlib import Path

_LISTS = {
    b"#EXTM3U": "a playlist (HLS)",
    b"ffconcat": "a list of files (ffconcat)",
    b"v=0": "a description of a network stream (SDP)",
    b"<?xml": "a description in XML (such as DASH or IMF)",
    b"<MPD": "a playlist (DASH)",
    b"<ASX": "a playlist (ASX)",
    b"[playlist]": "a playlist (PLS)",
    b"[Reference]": "a playlist (ASF)",
    b"RTSPtext": "a link to a network stream",
    b"# mpv EDL": "a list of files (EDL)",
}


def list_kind(path: Path) -> str | None:
    """What a file is called that names other files in place of holding pictures; None where it is no such list."""
    try:
        with path.open("rb") as stream:
            begin = stream.read(256).removeprefix(b"\xef\xbb\xbf").lstrip()
    except OSError:
        return None
    return next((kind for mark, kind in _LISTS.items() if begin.lower().startswith(mark.lower())), None)
