import logging
import os
import sys
import urllib.request

import pytest
from socket_fixtures import listening

from pbpf_drake.views import local_meshcat
from pbpf_drake.views.local_meshcat import MakeLocalMeshcat, ShortLivedMeshcat

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="looks into /proc"
)


def test_only_this_machine_can_reach_it(caplog):
    caplog.set_level(logging.INFO, logger="drake")
    before = listening(os.getpid())
    meshcat = MakeLocalMeshcat()
    (address,) = set(listening(os.getpid())) - set(before)
    # 127.0.0.1, with the lowest byte first.
    assert address == f"0100007F:{meshcat.port():04X}"
    assert meshcat.web_url() in caplog.text
    with urllib.request.urlopen(meshcat.web_url(), timeout=10) as page:
        assert b"meshcat" in page.read().lower()


def test_one_for_a_short_time_is_gone_whoever_still_has_it(caplog):
    caplog.set_level(logging.INFO, logger="drake")
    before = listening(os.getpid())
    kept = []
    with pytest.raises(ZeroDivisionError), ShortLivedMeshcat() as meshcat:
        kept.append(meshcat)
        meshcat.SetProperty("a/b", "visible", True)
        (address,) = set(listening(os.getpid())) - set(before)
        assert address.startswith("0100007F:")
        raise ZeroDivisionError
    assert set(listening(os.getpid())) <= set(before)
    assert "listening" not in caplog.text


def test_that_no_port_is_free_is_a_sentence(monkeypatch):
    def refuse(*_args):
        raise RuntimeError("Meshcat failed to open a websocket port.")

    monkeypatch.setattr(local_meshcat, "Meshcat", refuse)
    with pytest.raises(OSError, match="no free port from 7000 to 7999"):
        MakeLocalMeshcat()
