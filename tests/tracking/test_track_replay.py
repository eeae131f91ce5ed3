"""The replay of a run, made from its record."""

import os
from pathlib import Path
import sys

from filter_fixtures import PERIOD, make_push_log, planar_scene
import numpy as np
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.poses.pose_conversion import pose_array
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.track_replay import TrackRecordSource, WriteReplay
from pbpf_drake.tracking.tracking_diagram import Track

SCENE = planar_scene()
LOG = make_push_log(duration=1.0)
CONFIG = ParticleFilterConfig(num_particles=5, period=PERIOD, seed=1)


@pytest.fixture(scope="module", params=["pbpf", "dope"])
def record(request):
    return Track(scene=SCENE, log=LOG, method=request.param, config=CONFIG)


def test_the_source_gives_what_the_estimator_gave(record):
    nominal = MakePredictionModel(SCENE).nominal_poses
    source = TrackRecordSource(record=record, nominal_poses=nominal)
    context = source.CreateDefaultContext()
    times = [0.0, *(record.times + 0.001)]
    for time, expected in zip(times, [nominal, *record.poses], strict=True):
        context.SetTime(time)
        (X_WO,) = source.GetOutputPort("estimated_poses").Eval(context)
        np.testing.assert_allclose(pose_array(X_WO), expected[0], atol=1e-12)
    assert source.HasOutputPort("particles") == (record.method == "pbpf")
    if record.method == "pbpf":
        particles = source.GetOutputPort("particles").Eval(context)
        np.testing.assert_array_equal(particles, record.particles[-1].ravel())


def _sockets() -> set[str]:
    """The sockets that this process has open."""
    links = set()
    for link in Path("/proc/self/fd").iterdir():
        try:
            links.add(os.readlink(link))
        except OSError:
            continue
    return {link for link in links if link.startswith("socket:")}


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_the_replay_is_one_file_and_its_server_is_gone(record, tmp_path):
    before = _sockets()
    path = tmp_path / "replay.html"
    WriteReplay(scene=SCENE, log=LOG, record=record, filename=path)
    text = path.read_text("utf-8")
    assert text.lstrip().lower().startswith("<!doctype html>")
    assert _sockets() <= before
