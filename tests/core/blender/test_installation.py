"""Finding a Blender, and saying what one lacks. Programs here are small shell scripts that answer as the real ones."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from mcsl_core.blender import installation as blender
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import ReadRequest
from mcsl_core.errors import BlenderError, Cancelled, UsageError
from mcsl_core.progress import Silent
from mcsl_core.temporary import temporary_beside

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the stand-ins are shell scripts")


def program(path, text, code=0):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\ncat <<'END'\n{text}\nEND\nexit {code}\n")
    path.chmod(0o755)
    return path


def python_with_bpy(path, number="5.0.1"):
    """Answers --version as Python, -c as the question for bpy's version."""
    path.parent.mkdir(parents=True, exist_ok=True)
    answer = f"echo bpy {number}" if number else "echo PackageNotFoundError >&2; exit 1"
    path.write_text(f'#!/bin/sh\nif [ "$1" = --version ]; then echo Python 3.11.9; else {answer}; fi\n')
    path.chmod(0o755)
    return path


@pytest.fixture(autouse=True)
def bare(monkeypatch, tmp_path):
    """A machine without Blender: empty PATH but for the shell's tools, no variable, an empty MCSL_HOME."""
    monkeypatch.delenv("MCSL_BLENDER", raising=False)
    monkeypatch.setenv("MCSL_HOME", str(tmp_path / "home"))
    tools = tmp_path / "tools"
    tools.mkdir()
    for name in ("sh", "cat", "ldd"):
        for folder in ("/bin", "/usr/bin"):
            if os.path.exists(f"{folder}/{name}") and not (tools / name).exists():
                (tools / name).symlink_to(f"{folder}/{name}")
    monkeypatch.setenv("PATH", f"{tmp_path / 'path'}{os.pathsep}{tools}")
    monkeypatch.setattr(sys, "path", [p for p in sys.path if not os.path.isdir(os.path.join(p, "bpy"))])


def test_the_order(tmp_path, monkeypatch):
    with pytest.raises(BlenderError, match=r"no Blender was found.*mcsl blender install"):
        blender.find()
    private = python_with_bpy(tmp_path / "home" / "blender-env" / "bin" / "python")
    assert blender.find().command == (str(private),)
    assert "private environment" in blender.find().why
    on_path = program(tmp_path / "path" / "blender", "Blender 5.2.2 LTS")
    assert blender.find() == blender.Blender("binary", (str(on_path),), "5.2.2", "`blender` on PATH")
    named = program(tmp_path / "named" / "blender", "Blender 4.5.15 LTS")
    monkeypatch.setenv("MCSL_BLENDER", str(named))
    assert blender.find().version == "4.5.15"
    given = python_with_bpy(tmp_path / "given" / "python")
    assert blender.find(str(given)) == blender.Blender("module", (str(given),), "5.0.1", "given by --blender")


def test_bpy_in_this_python_is_seen_without_importing_it(tmp_path, monkeypatch):
    package = tmp_path / "site" / "bpy"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("raise RuntimeError('imported')")
    info = tmp_path / "site" / "bpy-5.0.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: bpy\nVersion: 5.0.1\n")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    python_with_bpy(tmp_path / "home" / "blender-env" / "bin" / "python", "5.2.3")
    assert blender.find() == blender.Blender("module", (sys.executable,), "5.0.1", "bpy in this Python")


@pytest.mark.parametrize("number", ["4.2.1", "5.1.0", "6.0.0", "2.93.0"])
def test_other_versions_are_refused_by_number(tmp_path, number):
    given = program(tmp_path / "blender", f"Blender {number}")
    with pytest.raises(BlenderError, match=rf"Blender {number} .*not supported.*4\.5 LTS, 5\.0 or 5\.2 LTS"):
        blender.find(str(given))


def test_an_unfit_blender_on_path_is_passed_over_but_named(tmp_path):
    program(tmp_path / "path" / "blender", "Blender 4.3.2")
    with pytest.raises(BlenderError, match=r"no Blender was found \(passed over: .*4\.3\.2"):
        blender.find()
    private = python_with_bpy(tmp_path / "home" / "blender-env" / "bin" / "python")
    assert blender.find().command == (str(private),)


def test_what_is_named_and_unfit_is_an_error_not_passed_over(tmp_path, monkeypatch):
    python_with_bpy(tmp_path / "home" / "blender-env" / "bin" / "python")
    monkeypatch.setenv("MCSL_BLENDER", str(tmp_path / "none"))
    with pytest.raises(BlenderError, match=r"named by MCSL_BLENDER.*is not a program"):
        blender.find()
    monkeypatch.setenv("MCSL_BLENDER", str(python_with_bpy(tmp_path / "python", "")))
    with pytest.raises(BlenderError, match="a Python without bpy"):
        blender.find()
    with pytest.raises(BlenderError, match="neither a Blender nor a Python"):
        blender.find(str(program(tmp_path / "ls", "ls (GNU coreutils) 9.1")))


LDD = """\
\tlinux-vdso.so.1 (0x00007ffd)
\tlibX11.so.6 => not found
\tlibXi.so.6 => not found
\tlibGL.so.1 => /usr/lib/x86_64-linux-gnu/libGL.so.1 (0x00007f)
\tlibSM.so.6 => not found
\tlibX11.so.6 => not found
"""


def test_missing_libraries_become_one_line():
    missing = blender.not_found(LDD)
    assert missing == ["libX11.so.6", "libXi.so.6", "libSM.so.6"]
    assert blender.install_line(missing) == "apt-get install -y libsm6 libx11-6 libxi6"
    said = "ImportError: libXrender.so.1: cannot open shared object file: No such file or directory"
    assert blender.named_by_loader(said) == ["libXrender.so.1"]
    assert blender.install_line(["libodd.so.3"]) == "# and the packages that hold libodd.so.3"
    assert blender.install_line([]) == ""


def test_every_library_that_facts_names_is_known():
    named = {"libx11-6", "libxrender1", "libxfixes3", "libxi6", "libxkbcommon0", "libsm6", "libgl1"}
    assert named <= set(blender.PACKAGES.values())


def test_a_blender_that_cannot_start_says_why(tmp_path):
    said = "ImportError: libX11.so.6: cannot open shared object file: No such file or directory"
    broken = blender.Blender("module", (str(program(tmp_path / "python", said, 1)),), "5.0.1", "a test")
    found = blender.diagnose(broken)
    assert not found.starts
    assert found.missing == ("libX11.so.6",)
    assert found.install == "apt-get install -y libx11-6"
    error = blender.explain_missing(broken, said)
    assert error is not None
    assert "lacks libX11.so.6. Run: apt-get install -y libx11-6" in str(error)
    assert blender.explain_missing(broken, "Segmentation fault") is None


def test_a_child_that_lacks_a_library_is_told_apart_from_a_crash(tmp_path):
    said = "ImportError: libXi.so.6: cannot open shared object file: No such file or directory"
    broken = blender.Blender("module", (str(program(tmp_path / "python", said, 1)),), "5.0.1", "a test")
    with pytest.raises(BlenderError, match=r"lacks libXi\.so\.6\. Run: apt-get install -y libxi6"):
        run_task(broken, ReadRequest(tmp_path / "edit.blend"))
    other = blender.Blender("module", (str(program(tmp_path / "other", "boom", 3)),), "5.0.1", "a test")
    with pytest.raises(BlenderError, match=r"ended with code 3 and no answer; its last words:\nboom"):
        run_task(other, ReadRequest(tmp_path / "edit.blend"))


def test_a_cancel_ends_a_silent_child_and_what_it_started(tmp_path):
    lazy = tmp_path / "lazy"
    saving = temporary_beside(tmp_path / "a.blend", ".blend").name.replace(str(os.getpid()), "$$")
    lazy.write_text(f"#!/bin/sh\n: > {tmp_path}/{saving}\n/bin/sleep 30 &\necho $! > {tmp_path / 'pid'}\nwait\n")
    lazy.chmod(0o755)
    progress = Silent()

    def cancel_when_started():
        while not (tmp_path / "pid").exists() or not (tmp_path / "pid").read_text().strip():
            time.sleep(0.02)
        progress.token.cancel()

    threading.Thread(target=cancel_when_started, daemon=True).start()
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        run_task(
            blender.Blender("module", (str(lazy),), "5.0.1", "a test"), ReadRequest(tmp_path / "a.blend"), progress
        )
    assert time.monotonic() - begun < 20
    assert not list(tmp_path.glob(".mcsl-*")), "the timeline that it was saving"
    grandchild = Path("/proc") / (tmp_path / "pid").read_text().strip() / "stat"
    for _ in range(100):  # killed, it may wait a moment to be buried
        if not grandchild.exists() or grandchild.read_text().split()[2] == "Z":
            break
        time.sleep(0.02)
    else:
        pytest.fail("the grandchild still runs")


def test_another_version_has_an_environment_of_its_own(tmp_path, monkeypatch):
    monkeypatch.setenv("MCSL_HOME", str(tmp_path))
    assert blender.private_python("4.5").parents[1] == tmp_path / "blender-env-4.5"
    assert blender.private_python().parents[1] == tmp_path / "blender-env"
    with pytest.raises(UsageError, match=r"no Blender 3.6 to install.*4.5, 5.0, 5.2"):
        blender.install(version="3.6")


def test_a_failed_install_leaves_nothing(tmp_path, monkeypatch):
    fake = tmp_path / "python"
    fake.write_text("#!/bin/sh\necho pip has no network >&2\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(fake))
    monkeypatch.setattr(blender, "WHEELS", {"5.0": (f"{sys.version_info.major}.{sys.version_info.minor}", "bpy")})
    with pytest.raises(BlenderError, match="pip has no network"):
        blender.install(version="5.0")
    assert list((tmp_path / "home").iterdir()) == []


def test_the_next_install_removes_what_a_killed_one_left(tmp_path):
    home = tmp_path / "home"
    dead = "import sys; from pathlib import Path; from mcsl_core.temporary import temporary_beside"
    lines = f"{dead}; (temporary_beside(Path({str(home / 'blender-env')!r})) / 'bin').mkdir(parents=True)"
    subprocess.run(
        [sys.executable, "-c", lines], check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    )
    long_ago, now = (
        home / "blender-env.part-a_b1c2d3",
        home / "blender-env.part-a_b1c2d4",
    )  # as earlier versions named them
    for folder in (long_ago, now, temporary_beside(home / "blender-env"), home / "blender-env-4.5"):
        folder.mkdir()
    os.utime(long_ago, (0, 0))
    python_with_bpy(blender.private_python())
    blender.install()
    ours = [path.name for path in home.iterdir() if path.name.startswith(".mcsl-")]
    assert len(ours) == 1, "another install is at work on it"
    assert f"-{os.getpid()}-" in ours[0]
    assert {path.name for path in home.iterdir()} - set(ours) == {"blender-env", "blender-env-4.5", now.name}
