"""Fixtures that several tests of reading logs use."""

from mcap_fixtures import FaultyLog
import pytest


@pytest.fixture
def path(tmp_path):
    return tmp_path / "log.mcap"


@pytest.fixture
def faulty(path):
    """A log to which a test adds messages, with faults or without."""
    with FaultyLog(path) as log:
        yield log
