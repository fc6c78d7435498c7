"""A real Blender in a Debian tree of its own: made once, entered with the folders it needs bound in, and left clean."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from attrs import frozen

PACKAGES = (
    *("blender", "python3-numpy", "python3-cattr", "python3-requests", "python3-zstandard"),
    *("xvfb", "xauth", "libgl1-mesa-dri", "libegl1", "libgl1", "xdotool", "imagemagick"),
)
DOOR = Path("/host")  # inside: this machine's own files, to be read


@frozen
class Bound:
    """A folder of this machine and where it is seen inside the tree; the same path where None."""

    folder: Path
    inside: Path | None = None
    writable: bool = False


def make(tree: Path, mirror: str) -> None:
    """Debian sid with Blender in ``tree`` (1.6 GB), unless it is there. Needs root, debootstrap and a Debian mirror."""
    if (tree / "usr/bin/blender").exists():
        return
    if shutil.which("debootstrap") is None:
        raise SystemExit("debootstrap is missing: apt-get install -y debootstrap")
    tree.mkdir(parents=True, exist_ok=True)
    subprocess.run(["debootstrap", "--variant=minbase", "sid", str(tree), mirror], check=True)
    for file in Path("/etc/apt/apt.conf.d").glob("*"):  # a proxy, for one
        shutil.copy(file, tree / "etc/apt/apt.conf.d")
    install = ["apt-get", "install", "-y", "--no-install-recommends", *PACKAGES]
    subprocess.run(["chroot", str(tree), *install], check=True)


def own_mirror() -> str:
    """The first Debian mirror that this machine itself installs from."""
    for path in sorted(Path("/etc/apt/sources.list.d").glob("*.sources")):
        for line in path.read_text().splitlines():
            if line.startswith("URIs:"):
                return line.split()[1]
    raise SystemExit("no mirror in /etc/apt/sources.list.d: name one with --mirror")


@contextmanager
def bound(tree: Path, folders: Sequence[Bound]) -> Iterator[None]:
    """/proc, /dev and ``folders`` are seen inside; all are unmounted at the end, whatever happens.

    Deleting a tree with these mounted would delete through them: `rm --one-file-system` is the careful way.
    """
    done: list[Path] = []
    try:
        for item in (Bound(Path("/proc"), writable=True), Bound(Path("/dev"), writable=True), *folders):
            target = tree / (item.inside or item.folder).relative_to("/")
            target.mkdir(parents=True, exist_ok=True)
            subprocess.run(["mount", "--bind", str(item.folder), str(target)], check=True)
            done.append(target)
            if not item.writable:
                subprocess.run(["mount", "-o", "remount,bind,ro", str(target)], check=True)
        yield
    finally:
        for target in reversed(done):
            subprocess.run(["umount", "--lazy", str(target)], check=True)


def blender_for_outside(tree: Path, path: Path) -> Path:
    """A program at ``path`` that is the tree's Blender: what `mcsl --blender` takes. Works inside `bound`."""
    path.write_text(f'#!/bin/sh\nexec chroot "{tree}" /usr/bin/blender "$@"\n')
    path.chmod(0o755)
    return path


def mcsl_for_inside(tree: Path, mcsl: Path) -> None:
    """`mcsl` on the tree's PATH, through the door: so the panel's buttons find it. Works inside `bound`."""
    path = tree / "usr/local/bin/mcsl"
    enter = f"""cd "$0" && exec {mcsl} "$@\""""
    path.write_text(f'#!/bin/sh\nexec /usr/sbin/chroot {DOOR} /bin/sh -c \'{enter}\' "$PWD" "$@"\n')
    path.chmod(0o755)
