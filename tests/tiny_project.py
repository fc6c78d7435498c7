"""A tiny project with our dev.py and noxfile, and a machine of stand-ins around it; see test_dev.py."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).parents[1]
BACKEND = f'''
"""The least that pip asks of a build backend: an editable wheel that points at the project's folder, then at nox's."""
import os, zipfile

def build_editable(folder, config_settings=None, metadata_directory=None):
    name = "mcsl-0.0-py3-none-any.whl"
    info = "mcsl-0.0.dist-info"
    with zipfile.ZipFile(os.path.join(folder, name), "w") as wheel:
        wheel.writestr("mcsl.pth", os.getcwd() + "\\n{sysconfig.get_path("purelib")}\\n")
        wheel.writestr(info + "/METADATA", "Metadata-Version: 2.1\\nName: mcsl\\nVersion: 0.0\\n")
        wheel.writestr(info + "/WHEEL", "Wheel-Version: 1.0\\nRoot-Is-Purelib: true\\nTag: py3-none-any\\n")
        programs = ["[console_scripts]", "mcsl = mcsl_core.cli:main", "lint-imports = lint_imports:main", ""]
        wheel.writestr(info + "/entry_points.txt", "\\n".join(programs))
        wheel.writestr(info + "/RECORD", "")
    return name

build_wheel = build_editable
'''
PYPROJECT = """
[build-system]
requires = []
build-backend = "backend"
backend-path = ["."]
[project]
name = "mcsl"
version = "0.0"
"""
MODULES = {
    "errors": "class BlenderError(Exception): pass\n",
    "blender/installation": (
        "import os\nfrom ..errors import BlenderError\n"
        "PACKAGES = {'libmcsl-surely-missing.so.1': 'libmcsl1'}\n"
        "class Found: kind = 'module'\n"
        "def find():\n"
        "    if not os.path.exists(os.environ['MCSL_HOME']): raise BlenderError\n"
        "    return Found\n"
    ),
    "cli": (
        "import os, sys, time\n"
        "def main():\n"
        "    try:\n"
        "        print('mcsl', *sys.argv[1:], 'in', os.getcwd(), flush=True)\n"
        "        time.sleep(60 * ('wait' in sys.argv))\n"
        "    except KeyboardInterrupt:\n"
        "        time.sleep(1); print('ended well', flush=True); return 5\n"
        "    if sys.argv[1:] == ['blender', 'install']: os.mkdir(os.environ['MCSL_HOME'])\n"
        "    return 7 if 'fail' in sys.argv else 0\n"
    ),
    "__init__": "",
}


class Project:
    """A tiny project with our dev.py, and a machine whose system programs are stand-ins."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "project with space"
        self.log = folder / "system.log"
        self.bin = folder / "bin"
        self.venv = folder / "venv"
        self.home = folder / "home"
        (self.root / "mcsl_core" / "blender").mkdir(parents=True)
        self.bin.mkdir()
        (self.root / "tools").mkdir()
        for name in ("dev.py", "noxfile.py", "tools/bring_blender.py"):
            shutil.copy(ROOT / name, self.root / name)
        (self.root / "requirements.lock").touch()
        (self.root / "backend.py").write_text(BACKEND)
        (self.root / "pyproject.toml").write_text(PYPROJECT)
        for name, text in MODULES.items():
            (self.root / "mcsl_core" / f"{name}.py").write_text(text)
        self.stand_in("apt-get")

    def stand_in(self, name: str, code: str = "exit 0") -> None:
        """A program first on PATH that writes its call into the log and then does ``code``."""
        path = self.bin / name
        path.write_text(f'#!/bin/sh\necho "{name} $*" >> "{self.log}"\n{code}\n')
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    @property
    def system_calls(self) -> list[str]:
        return self.log.read_text().splitlines() if self.log.exists() else []

    def start(self, *arguments: str, **variables: str) -> subprocess.Popen[str]:
        environment = {
            "PATH": f"{self.bin}{os.pathsep}/usr/bin{os.pathsep}/bin",
            "HOME": str(self.root.parent),
            "MCSL_VENV": str(self.venv),
            "MCSL_HOME": str(self.home),
            "MCSL_BLENDER_OLDEST": "given",
            **variables,
        }
        return subprocess.Popen(
            [sys.executable, str(self.root / "dev.py"), *arguments],
            env=environment,
            cwd=self.root.parent,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def dev(self, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
        child = self.start(*arguments, **variables)
        out, err = child.communicate()
        return subprocess.CompletedProcess(child.args, child.returncode, out, err)
