"""Ctrl-C, SIGTERM and SIGHUP: the work ends in order, or where it hears nothing, without it; once more, at once.

The first signal raises KeyboardInterrupt in the main thread, which leaves every file whole and every child ended. But
Python hears a signal only between two of its own steps, and other threads not at all: preparing a fill, fitting poses
or opening a file on a sleeping disk can take ten seconds. So a thread of its own hears it too, leaves the orderly way
1.5 s, and then ends the children, removes what is half-written, and ends the process.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

STOPPED = 130  # the exit code, whatever the signal
PATIENCE_S = 1.5
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


def _say() -> None:
    os.write(2, b"mcsl: stopped\n")


class _Stop:
    """What a process knows of being stopped."""

    def __init__(self) -> None:
        self.installed = self.asked = self.working = False
        self.numbers: set[int] = set()
        self.told = False
        self.tell: Callable[[], object] = _say
        self.telling = threading.RLock()


_stop = _Stop()


def install() -> None:
    """Has this process stopped by signals. To be called before anything is imported that takes long."""
    if _stop.installed or threading.current_thread() is not threading.main_thread():
        return  # elsewhere nobody sends us signals
    numbers = {getattr(signal, name) for name in _NAMES if hasattr(signal, name)}
    # What is ignored stays ignored: `nohup`, or a script's job in the background.
    numbers = {number for number in numbers if signal.getsignal(number) is not signal.SIG_IGN}
    hear, called = os.pipe()
    os.set_blocking(called, False)
    _stop.installed, _stop.numbers = True, numbers
    sys.unraisablehook = _quiet(sys.unraisablehook)
    threading.Thread(target=_watch, args=(hear,), name="stopping", daemon=True).start()
    signal.set_wakeup_fd(called, warn_on_full_buffer=False)
    for number in numbers:
        signal.signal(number, _raise)


def begin(tell: Callable[[], object]) -> None:
    """Work begins: from now on a stop is told by ``tell``, and the work is left the time to end in order."""
    _stop.tell, _stop.told, _stop.working = tell, False, True


def finish(code: int) -> None:
    """The work has ended with the exit code ``code``: no signal changes that any more, and no thread that lingers."""
    _stop.working = False
    for number in _stop.numbers:
        signal.signal(number, signal.SIG_IGN)
    if _stop.asked:
        # Where a library ran Python from C meanwhile, Python would end by SIGINT in place of the code.
        with contextlib.suppress(Exception):
            sys.stdout.flush()
        os._exit(code)
    last = threading.Timer(PATIENCE_S, os._exit, (code,))
    last.daemon = True
    last.start()


def was_asked() -> bool:
    """Whether a signal to stop has come: what fails then fails because of it."""
    return _stop.asked


def tell_once() -> None:
    """Tells the person that the work was stopped, unless that was told already."""
    if not _stop.telling.acquire(timeout=PATIENCE_S):
        return
    try:
        if not _stop.told:
            _stop.told = True
            _stop.tell()
    except Exception:  # a closed terminal
        return
    finally:
        _stop.telling.release()


def _raise(_number: int, _frame: FrameType | None) -> None:
    _stop.asked = True
    if _stop.working:
        raise KeyboardInterrupt
    _leave()


def _leave() -> None:
    """Ends a process in which nothing is open: it still imports."""
    tell_once()
    os._exit(STOPPED)


def _quiet(hook: Callable[[Any], object]) -> Callable[[Any], object]:
    """Without the traceback of a KeyboardInterrupt that came where it cannot be raised; the watch ends it then."""

    def unraisable(found: Any) -> None:
        if not (_stop.asked and issubclass(found.exc_type, KeyboardInterrupt)):
            hook(found)

    return unraisable


def _watch(hear: int) -> None:
    while os.read(hear, 1)[0] not in _stop.numbers:
        pass
    _stop.asked = True
    if not _stop.working:
        _leave()
    while select.select([hear], [], [], PATIENCE_S)[0]:
        if os.read(hear, 1)[0] in _stop.numbers:
            break  # a second one
    _end()


def _end() -> None:
    # Not above: what is imported before signals are heard is little. Children first: they write into our files.
    from mcsl_core.children import end_all
    from mcsl_core.temporary import remove_own

    for ending in (end_all, remove_own):
        with contextlib.suppress(Exception):
            ending()
    if sys.stderr is not None and sys.stderr.isatty():
        os.write(2, b"\r\x1b[?25h\n")  # the bar hid the cursor
    tell_once()
    os._exit(STOPPED)
