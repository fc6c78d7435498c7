"""Pages made of what lies elsewhere: the front door's names, notebooks, the list of decisions; see generate.py."""

from __future__ import annotations

import json
from pathlib import Path

FRONT_DOOR = """\
# The front door

<!-- Written by docs/generate.py from what mcsl_core offers in __all__; the words are its docstrings. -->

What `import mcsl_core as mcsl` offers: to analyse a recording, to look at every picture as the programme shows it, to
overrule, to deliver and to measure. [The notebook](../tutorials/notebook.md) goes through most of it. Importing the
package imports nothing heavy; the stages are loaded when they are needed.
"""
NOT_SHOWN = {"__version__"}


INHERITED = {"Programme": "    options:\n      inherited_members: true\n"}


def front_door_page() -> str:
    """A section for every public name of the package: none can be forgotten."""
    import mcsl_core

    names = [name for name in getattr(mcsl_core, "__all__", ()) if name not in NOT_SHOWN]
    return "\n".join([FRONT_DOOR, *(f"::: mcsl_core.{name}\n" + INHERITED.get(name, "") for name in names)])


def notebook_page(path: Path) -> str:
    """A notebook as a page: its text, its code, and the pictures that its cells name in their metadata.

    Links start in examples/, where notebooks are opened.
    A cell with ``{"picture": {"file": "x.png", "alt": "..."}}`` is followed by docs/images/x.png.
    """
    parts = [f"<!-- Written by docs/generate.py from examples/{path.name}; change it there. -->"]
    for cell in json.loads(path.read_text("utf-8"))["cells"]:
        text = "".join(cell["source"]).strip().replace("](../docs/", "](../")
        parts.append(f"```python\n{text}\n```" if cell["cell_type"] == "code" else text)
        if picture := cell["metadata"].get("picture"):
            parts.append(f"![{picture['alt']}](../images/{picture['file']})")
    title, rest = parts[1].partition("\n")[::2]
    return "\n\n".join([title, parts[0], rest.strip(), *parts[2:]]).strip() + "\n"


DECISIONS = """\
# Decisions

<!-- Written by docs/generate.py from the first lines of the files beside it. -->

What was decided, what was measured for it, and what was not taken. One page each; a later one that overrules an earlier
one says so in both.

"""


def decisions_page(folder: Path) -> str:
    lines = []
    for path in sorted(folder.glob("[0-9]*.md")):
        title = path.read_text("utf-8").splitlines()[0].removeprefix("# ")
        lines.append(f"- [{title}]({path.name})")
    return DECISIONS + "\n".join(lines) + "\n"
