"""Fixtures that several tests of reading logs use."""

from framed_log_fixtures import FramedLog
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


@pytest.fixture
def bag():
    """A log of joint states to which a test adds poses in frames."""
    return FramedLog()
