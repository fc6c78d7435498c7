"""What every test lives with: any logged ERROR fails it, no colours, and real recordings where they are there."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

from mcsl_core.media.scheduling import scheduled_as_before

ROOT = Path(__file__).resolve().parent.parent

os.environ["NO_COLOR"] = "1"  # for this process and the children it starts
os.environ.pop("FORCE_COLOR", None)
os.environ["LANGUAGE"] = "en"  # messages are compared; who tests another language says so

# A shell without job control starts what runs in its background with Ctrl-C ignored, for all children: then tests that
# stop them waited in vain.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    with contextlib.suppress(ValueError):  # not the main thread
        signal.signal(signal.SIGINT, signal.default_int_handler)

# Other work on the machine must not turn a right answer into a failure. New examples are looked for at the desk: a
# change must not be refused for an example that has nothing to do with it.
hypothesis.settings.register_profile(
    "mcsl",
    deadline=None,
    print_blob=True,
    derandomize="CI" in os.environ,
    max_examples=50 if "CI" in os.environ else 100,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("mcsl")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests first, so that at the end no process works on one of them while the others are done."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(autouse=True, scope="session")
def state_of_user(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What mcsl remembers for its user lies in a folder of the tests, for the children they start as well."""
    folder = tmp_path_factory.mktemp("state")
    os.environ["MCSL_STATE"] = str(folder)
    return folder


@pytest.fixture(autouse=True)
def ordinary_scheduling() -> Iterator[None]:
    """A film that a test codes with SVT-AV1 does not make the tests after it, and their children, real-time ones."""
    with scheduled_as_before():
        yield


@pytest.fixture(autouse=True)
def logged_errors() -> Iterator[list[logging.LogRecord]]:
    """Every record of level ERROR or above that was logged during the test; what is left in it fails the test.

    A test that provokes an error asks for this fixture, checks the records and clears the list. Records are caught
    where they are made, so a logger that does not propagate, or has a handler of its own, is caught too.
    """
    records: list[logging.LogRecord] = []
    make = logging.getLogRecordFactory()

    def watch(*args, **kwargs) -> logging.LogRecord:
        record = make(*args, **kwargs)
        if record.levelno >= logging.ERROR:
            records.append(record)
        return record

    logging.setLogRecordFactory(watch)
    yield records
    logging.setLogRecordFactory(make)
    _fail_on(records)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    result = yield
    # Here rather than in the fixture's end, so that the test itself is reported as failed.
    _fail_on(getattr(item, "funcargs", {}).get("logged_errors", []))
    return result


def _fail_on(records: list[logging.LogRecord]) -> None:
    if records:
        lines = [f"{r.name}: {r.levelname}: {r.getMessage()}" for r in records]
        records.clear()
        pytest.fail("logged during the test:\n" + "\n".join(lines), pytrace=False)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings that nobody here made; the test is skipped where there is none."""
    given = os.environ.get("MCSL_SHARED_DATA")
    folder = Path(given) if given else ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        if given:
            pytest.fail(f"MCSL_SHARED_DATA names {given}, which is not a folder", pytrace=False)
        pytest.skip("no real recordings here (../shared/data; another folder: MCSL_SHARED_DATA)")
    return folder
