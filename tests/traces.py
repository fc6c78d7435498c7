"""What of a recording, a machine and its encoders stands in a file's bytes; searched for without a reader of ours."""

from __future__ import annotations

import getpass
import re
import socket
from pathlib import Path

MARK = "Kasparov-op-4711"
BANNERS = rb"x264 - core|x265 \(build|Lav[cf]\d|Lavc|videolan|Multicoreware|GCC|cpuid|encoder|HandBrake"


def traces(path: Path) -> list[bytes]:
    """What of the recording, the machine and the encoders stands in a file's bytes, in ASCII or UTF-16."""
    data = path.read_bytes()
    names = [MARK, str(Path.home()), getpass.getuser() * (len(getpass.getuser()) > 4), socket.gethostname(), "/tmp/"]
    words = [name.encode(code) for name in names if len(name) > 4 for code in ("utf-8", "utf-16-le", "utf-16-be")]
    return [word for word in words if word in data] + re.findall(BANNERS, data)
