from dataclasses import replace

from filter_fixtures import (
    PERIOD,
    FilterRun,
    make_push_log,
    planar_scene,
    small_config,
)
import numpy as np
from pydrake.geometry import Meshcat
import pytest

from pbpf_drake.config.particle_filter_config import (
    METHODS,
    ParticleFilterConfig,
)
from pbpf_drake.filtering.add_particle_filter import ConfigForMethod
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.tracking import tracking_diagram
from pbpf_drake.tracking.tracking_diagram import (
    DefaultConfig,
    MakeTrackingDiagram,
    NumSteps,
    Track,
    TrackInterrupted,
)

# 1.5 s: nine updates, the last of which is before the end.
LOG = make_push_log(duration=1.5, speed=0.1)
STEPS = 9


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _config(scene, method) -> ParticleFilterConfig:
    return replace(DefaultConfig(scene, method), num_particles=6)


def _track(scene, method, log=LOG, **options):
    config = options.pop("config", None) or _config(scene, method)
    return Track(scene=scene, log=log, method=method, config=config, **options)


@pytest.mark.parametrize("method", METHODS)
def test_a_record_has_one_row_per_update(scene, method):
    steps = []
    record = _track(scene, method, on_step=lambda: steps.append(1))
    particles = 0 if method == "dope" else 6
    assert record.method == method
    assert record.object_names == ("block",)
    np.testing.assert_allclose(record.times, PERIOD * np.arange(1, STEPS + 1))
    assert len(steps) == STEPS
    for name, shape in {
        "poses": (1, 7),
        "tracked": (1,),
        "detected": (1,),
        "covariances": (1, 6, 6),
        "effective_sample_size": (),
        "particles": (particles, 1, 7),
        "weights": (particles,),
        "particles_used": (),
        "update_ms": (),
    }.items():
        value = getattr(record, name)
        assert value.shape == (STEPS, *shape), name
        assert np.all(np.isfinite(value)), name
    assert record.tracked.dtype == record.detected.dtype == bool
    assert np.all(record.tracked)
    assert np.all(record.update_ms > 0)
    assert record.period == PERIOD
    np.testing.assert_array_equal(record.particles_used, particles)
    assert (record.config.get("num_particles", 0)) == particles


def test_detected_says_when_detections_came_in(scene):
    record = _track(scene, "dope")
    received = np.array([d.received for d in LOG.detections])
    for time, detected in zip(record.times, record.detected, strict=True):
        new = np.any((received > time - PERIOD) & (received <= time))
        assert detected[0] == new
    assert 0 < np.mean(record.detected) < 1
    np.testing.assert_array_equal(
        _track(scene, "pbpf").detected, record.detected
    )


def test_dope_holds_what_was_received_last(scene):
    record, X_WC = _track(scene, "dope"), scene.camera.pose()
    for time, pose in zip(record.times, record.poses, strict=True):
        last = [d for d in LOG.detections if d.received <= time][-1]
        X_WO = X_WC @ last.X_CO
        np.testing.assert_allclose(pose[0, 4:], X_WO.translation(), atol=1e-12)


def test_physics_follows_what_is_hidden_and_dope_does_not(scene):
    truth = LOG.ground_truth["block"]
    config = replace(_config(scene, "pbpf"), num_particles=30)
    errors = {
        method: compute_errors(
            _track(scene, method, config=config), "block", truth
        ).position
        for method in ("pbpf", "dope")
    }
    hidden = slice(5, 7)  # 0.96 s and 1.12 s.
    assert np.mean(errors["pbpf"][hidden]) < np.mean(errors["dope"][hidden])


def test_the_filter_gives_what_it_gives_without_a_log(scene):
    """The same inputs, set by hand whenever they are sampled."""
    record = _track(scene, "pbpf-v")
    run = FilterRun(scene, _config(scene, "pbpf-v"))
    source = DopeLogSource(detections=LOG.detections, X_WC=scene.camera.pose())
    context = source.CreateDefaultContext()
    joints, port = LOG.joints, source.GetOutputPort("dope_measurement")
    for step in range(1, 6):
        for sample in range(1, 9):
            time = (step - 1 + sample / 8) * PERIOD
            run.set_joints(
                [np.interp(time, joints.times, q) for q in joints.positions.T]
            )
            context.SetTime(time)
            run.measure(port.Eval(context))
            run.simulator.AdvanceTo(time + PERIOD / 16)
        # Their times differ in the last bits, and contact amplifies that.
        np.testing.assert_allclose(
            run["estimated_poses"], record.poses[step - 1], atol=3e-3
        )


def test_watching_changes_nothing(scene):
    meshcat = Meshcat()
    watched = _track(scene, "pbpf-v", meshcat=meshcat)
    meshcat.Delete()
    alone = _track(scene, "pbpf-v")
    for name in ("times", "poses", "particles", "covariances", "detected"):
        np.testing.assert_array_equal(
            getattr(watched, name), getattr(alone, name)
        )


def test_default_configs_are_the_scenes_for_the_method(scene):
    scene = replace(scene, filter=small_config(scene, seed=7))
    assert DefaultConfig(scene, "dope") == scene.filter
    for method in ("pbpf", "pbpf-v", "cvpf"):
        expected = ConfigForMethod(scene.filter, method)
        assert DefaultConfig(scene, method) == expected
    record = Track(scene=scene, log=LOG, method="dope")
    assert record.seed == 7


def test_a_diagram_names_its_parts(scene):
    tracking = MakeTrackingDiagram(
        scene=scene,
        log=LOG,
        method="pbpf",
        config=_config(scene, "pbpf"),
    )
    names = {s.get_name() for s in tracking.diagram.GetSystems()}
    assert names == {"joint_log_source", "dope_log_source", "particle_filter"}
    assert tracking.update_seconds == []


@pytest.mark.parametrize(
    "duration, steps", [(0.15, 0), (0.16, 1), (0.32, 2), (1.5, 9), (1.6, 10)]
)
def test_only_updates_within_the_log_are_made(scene, duration, steps):
    log = make_push_log(duration=duration)
    assert NumSteps(log, scene.filter) == steps


def test_a_log_that_is_too_short_is_refused(scene):
    with pytest.raises(ValueError, match="0.15 s long; expected .* 0.16 s"):
        _track(scene, "pbpf", log=make_push_log(duration=0.15))


def test_a_log_without_detections_leaves_the_nominal_pose(scene):
    record = _track(scene, "pbpf", log=replace(LOG, detections=()))
    assert not np.any(record.tracked) and not np.any(record.detected)
    np.testing.assert_allclose(
        record.poses[:, 0], [[1, 0, 0, 0, 0.2, 0, 0.0065]] * STEPS
    )


def test_a_log_without_ground_truth_is_tracked_and_drawn(scene):
    meshcat = Meshcat()
    record = _track(
        scene, "pbpf", log=replace(LOG, ground_truth={}), meshcat=meshcat
    )
    assert len(record.times) == STEPS
    meshcat.Delete()


def test_an_unknown_method_is_named(scene):
    with pytest.raises(ValueError, match="'magic'"):
        Track(scene=scene, log=LOG, method="magic")


def test_an_interruption_has_what_there_was_by_then(scene):
    steps = []

    def interrupt():
        steps.append(1)
        if len(steps) == 4:
            raise KeyboardInterrupt

    with pytest.raises(TrackInterrupted) as error:
        _track(scene, "pbpf", on_step=interrupt)
    part, whole = error.value.record, _track(scene, "pbpf")
    assert len(part.times) == len(part.update_ms) == 4
    np.testing.assert_array_equal(part.poses, whole.poses[:4])


def test_an_interruption_before_the_first_update_has_nothing(
    scene, monkeypatch
):
    def interrupt(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr(tracking_diagram, "Simulator", interrupt)
    with pytest.raises(KeyboardInterrupt) as error:
        _track(scene, "dope")
    assert not isinstance(error.value, TrackInterrupted)
