"""A programme's document written to its file, which others may have written meanwhile."""

from __future__ import annotations

from pathlib import Path

from mcsl_core import edl as edls
from mcsl_core.edl import Edl
from mcsl_core.edl.edits import merged, rebased
from mcsl_core.outputs.claim import check_place, claim, is_same_file
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.locks import changing
from mcsl_core.outputs.manifest import Manifest


def write_edl(edl: Edl, before: Edl | None, path: Path, target: Path, *, force: bool) -> Edl:
    """Writes ``edl`` to ``target`` and returns it as it is there: with what others wrote, paths counting from there.

    Parameters
    ----------
    edl
        The document; its paths count from the folder of ``path``.
    before
        As it was when it was read from ``path`` or written there; None where it never was.
    path, target
        Its file so far, and the file to write: the same one is merged with what others wrote into it.
    force
        Write over whatever is there, but for the programme's own media.
    """
    check_place(target)
    made = rebased(edl, path.parent, target.parent)
    own = before is not None and is_same_file(path, target)
    if not own:
        inputs = [file for file in inputs_of(edl, path) if not is_same_file(file, path) or before is not None]
        output = claim(target, inputs=inputs, manifest=Manifest.beside(path), force=force)
        with changing(_with_folder(target)):
            output.write(edls.dumps(made).encode())
    else:
        with changing(_with_folder(target)):
            if before is not None and not force and target.exists():
                made = merged(before, made, edls.read(target))
            edls.save(made, target)
    edls.remember(made, target)
    return edls.read(target)


def _with_folder(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    return path
