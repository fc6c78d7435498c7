"""Where the files of an EDL may lie: in its own folder, and in those of the recording it was made from here.

An EDL that somebody else wrote could name any file of whoever opens it, and put its pictures into a video. So a path
that leads out of the EDL's folder is refused, unless it leads where the recording lay that this user analysed into this
EDL, or the user allowed it. Both are remembered for this user, not in the document: what comes from elsewhere cannot
say that it is to be trusted.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from mcsl_core.documents import write_atomic
from mcsl_core.errors import InputError, McslError

from .schema import Edl

ALLOW = "MCSL_ALLOW_OUTSIDE"  # set to anything: every EDL may lead anywhere
STATE = "MCSL_STATE"  # another folder for what is remembered
REMEDY = (
    "If you trust this EDL, add --allow-outside to a command once, such as `mcsl look EDL --allow-outside`: "
    "it is remembered, in Blender too. In Python: mcsl.open(..., allow_outside=True)"
)


def check_inside(edl: Edl, path: Path, *, allow: bool = False) -> None:
    """Refuses an EDL whose files lie elsewhere than they may.

    Parameters
    ----------
    edl, path
        The document, and its file.
    allow
        They may lie anywhere, now and from now on. So they may for the whole process where MCSL_ALLOW_OUTSIDE is set.

    Raises
    ------
    InputError
        Names the first of the paths, and where it leads.
    """
    base, trusted = _folder(path), [_folder(path), *_remembered(path)]
    found = [(at, _where(base, name, trusted)) for at, name in _paths(edl)]
    outside = [(at, target) for at, target in found if not _lies_in(target, trusted)]
    if not outside:
        return
    if allow or os.environ.get(ALLOW):
        remember(edl, path)
        return
    (at, target), *others = outside
    more = f" (and {len(others)} more path{'s' * (len(others) > 1)})" if others else ""
    raise InputError(f"leads out of the EDL's folder, to {target}{more}", where=f"{path} at {at}", remedy=REMEDY)


def remember(edl: Edl, path: Path) -> bool:
    """Notes for this user that the EDL at ``path`` may use the folders its files lie in; False where that fails."""
    base, targets = _folder(path), []
    for _, name in _paths(edl):
        whole = os.path.join(base, name)
        with contextlib.suppress(ValueError):  # a name that no system has, such as with a null byte
            targets += [os.path.normpath(whole), os.path.realpath(whole)]
    folders = sorted({os.path.dirname(target) for target in targets if not _lies_in(target, [base])})
    if not folders:
        return True
    record = _record(path)
    try:
        record.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomic(record, json.dumps({"edl": os.path.realpath(path), "folders": folders}).encode())
        record.chmod(0o600)  # names of recordings are nobody else's
    except (OSError, McslError):
        return False
    return True


@contextlib.contextmanager
def allowed_outside() -> Iterator[None]:
    """Within it every EDL may lead anywhere, in this process and in those it starts."""
    before = os.environ.get(ALLOW)
    os.environ[ALLOW] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[ALLOW]
        else:
            os.environ[ALLOW] = before


def _paths(edl: Edl) -> Iterator[tuple[str, str]]:
    """(where it stands, path) of every file that the document names."""
    for c, camera in enumerate(edl.cameras):
        for m, media in enumerate(camera.media):
            yield f"$.cameras[{c}].media[{m}].path", media.path
    if edl.scores is not None:
        yield "$.scores", edl.scores


def _where(base: str, name: str, trusted: list[str]) -> str:
    """Where ``name`` leads from the folder ``base``, links followed.

    The text is looked at before the file system: on Windows a mere look at ``\\\\host\\share`` reaches that host.
    """
    target = os.path.normpath(os.path.join(base, name))
    if not _lies_in(target, trusted):
        return target
    try:
        return os.path.realpath(os.path.join(base, name))
    except ValueError:  # a name that no system has: what opens it will say so
        return target


def _folder(path: Path) -> str:
    return os.path.realpath(path.parent)


def _lies_in(target: str, folders: Iterable[str]) -> bool:
    inner = Path(os.path.normcase(target))
    return any(inner.is_relative_to(os.path.normcase(folder)) for folder in folders)


def _remembered(path: Path) -> list[str]:
    try:
        value = json.loads(_record(path).read_text("utf-8"))
        return [folder for folder in value["folders"] if isinstance(folder, str) and os.path.isabs(folder)]
    except (OSError, ValueError, LookupError, TypeError):
        return []


def _record(path: Path) -> Path:
    name = os.path.normcase(os.path.realpath(path))
    return _state_folder() / "edls" / f"{hashlib.sha256(os.fsencode(name)).hexdigest()[:32]}.json"


def _state_folder() -> Path:
    """What platformdirs calls the user's data folder of mcsl; Blender's Python has no platformdirs."""
    if given := os.environ.get(STATE) or os.environ.get("MCSL_HOME"):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "mcsl" / "mcsl"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "mcsl"
    given = os.environ.get("XDG_DATA_HOME", "").strip()
    return Path(given or Path.home() / ".local" / "share") / "mcsl"
