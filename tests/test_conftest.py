"""The guards in conftest.py guard: each is tripped here on purpose, in a pytest run of its own."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]


@pytest.fixture
def guarded(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makeconftest((Path(__file__).parent / "conftest.py").read_text("utf-8"))
    return pytester


def test_a_logged_error_fails_the_test_that_logged_it_and_no_other(guarded):
    guarded.makepyfile(
        """
        import logging
        import pytest

        def test_error():
            logging.getLogger("mcsl").error("the %s broke", "lamp")

        def test_quiet_logger():
            log = logging.getLogger("alone")
            log.propagate = False
            log.addHandler(logging.NullHandler())
            log.critical("nobody hears me")

        def test_warning():
            logging.getLogger("mcsl").warning("fine")

        def test_provoked(logged_errors):
            logging.getLogger("mcsl").error("expected")
            assert [r.getMessage() for r in logged_errors] == ["expected"]
            logged_errors.clear()

        @pytest.fixture
        def untidy():
            yield
            logging.getLogger("mcsl").error("while tidying up")

        def test_fixture(untidy):
            pass

        def test_after():
            pass
        """
    )
    result = guarded.runpytest_subprocess("-p", "no:logging")
    result.assert_outcomes(passed=4, failed=2, errors=1)
    result.stdout.fnmatch_lines(["*mcsl: ERROR: the lamp broke*", "*alone: CRITICAL: nobody hears me*"])
    result.stdout.fnmatch_lines(["*mcsl: ERROR: while tidying up*"])


def test_a_test_that_fails_by_itself_still_says_why(guarded):
    guarded.makepyfile(
        """
        import logging

        def test_both():
            logging.error("a hint")
            assert 1 == 2
        """
    )
    result = guarded.runpytest_subprocess()
    result.stdout.fnmatch_lines(["*assert 1 == 2*"])
    assert result.ret == 1


def test_real_recordings_are_found_skipped_plainly_or_a_wrong_name_is_told(guarded, monkeypatch, tmp_path):
    guarded.makepyfile("def test_data(shared_data):\n    assert shared_data.is_dir()\n")
    monkeypatch.delenv("MCSL_SHARED_DATA", raising=False)
    result = guarded.runpytest_subprocess("-rs")
    result.assert_outcomes(skipped=1)
    result.stdout.fnmatch_lines(["*no real recordings here*MCSL_SHARED_DATA*"])
    monkeypatch.setenv("MCSL_SHARED_DATA", str(tmp_path))
    guarded.runpytest_subprocess().assert_outcomes(passed=1)
    monkeypatch.setenv("MCSL_SHARED_DATA", str(tmp_path / "gone"))
    result = guarded.runpytest_subprocess()
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*MCSL_SHARED_DATA names*gone, which is not a folder*"])


def test_colours_are_off_for_tests_and_their_children():
    assert os.environ["NO_COLOR"] == "1"
    assert "FORCE_COLOR" not in os.environ
