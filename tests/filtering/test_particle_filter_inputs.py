"""What the filter does with joints, and all else, that can't be right."""

from filter_fixtures import (
    BLOCK,
    PERIOD,
    PROBE,
    FilterRun,
    assert_same,
    detections,
    planar_scene,
    run_tracking,
    small_config,
)
import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
import pytest

from pbpf_drake.dope_measurement import Detection, DopeMeasurement

MOTIONS = ("physics", "constant_velocity")
AWAY = [0.4, 0.1, 0.0065]


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _make(scene, **changes) -> FilterRun:
    return FilterRun(scene, small_config(scene, **changes))


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_joint_that_is_not_finite_is_held(scene, motion, bad):
    run, other = (_make(scene, motion=motion) for _ in range(2))
    path = [PROBE, (0.16, 0.01), (bad, 0.02), (bad, bad), (0.18, 0.03)]
    held = [PROBE, (0.16, 0.01), (0.16, 0.02), (0.16, 0.02), (0.18, 0.03)]
    for i, (q, expected) in enumerate(zip(path, held, strict=True), start=1):
        for each, joints in ((run, q), (other, expected)):
            each.set_joints(joints)
            each.measure(detections(PERIOD * i - 0.01, block=BLOCK))
            each.update(i)
    assert_same(run.ports(), other.ports())


def test_velocities_that_are_not_finite_are_held(scene):
    runs = [_make(scene, motion="physics") for _ in range(2)]
    for run, bad in zip(runs, (np.nan, 0.1), strict=True):
        port = run.filter.GetInputPort("joint_velocities")
        for i, v in enumerate((0.1, bad, 0.2), start=1):
            port.FixValue(run.context, [v, 0.0])
            run.measure(detections(PERIOD * i - 0.01, block=BLOCK))
            run.update(i)
    assert_same(*(run.ports() for run in runs))


@pytest.mark.parametrize("size", [1.0, 1e3, 1e9])
def test_joints_that_jump_do_not_stop_the_filter(scene, size):
    run = run_tracking(scene, motion="physics")
    for i, q in enumerate(([size, 0.0], PROBE, [size, -size], PROBE), start=2):
        run.set_joints(q)
        run.update(i)
        _assert_finite(run, i)
    run.measure(detections(6 * PERIOD - 0.01, block=BLOCK))
    run.update(6)
    np.testing.assert_allclose(
        run["estimated_poses"][0, 4:6], BLOCK[:2], atol=0.05
    )


def test_the_filter_goes_on_where_all_particles_fail(scene):
    """None is slow enough; the motion is unknown, the block is not."""
    run = run_tracking(
        scene, motion="physics", max_speed=1e-12, recover_lost_tracks=True
    )
    for i in range(2, 6):
        run.measure(detections(PERIOD * i - 0.01, block=AWAY))
        run.update(i)
        _assert_finite(run, i)
        np.testing.assert_array_equal(run["detected"], [1])
    np.testing.assert_allclose(
        run["estimated_poses"][0, 4:6], AWAY[:2], atol=0.05
    )


def _assert_finite(run: FilterRun, update: int) -> None:
    for name, value in run.ports().items():
        assert np.all(np.isfinite(value)), (name, update)
    q = run["particles"].reshape(-1, 7)[:, :4]
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1, atol=1e-12)
    assert np.sum(run["weights"]) == pytest.approx(1)
    assert np.all(run["weights"] >= 0)


def _bad_number(rng: np.random.Generator, good: float) -> float:
    bad = [np.nan, np.inf, -np.inf, 1e300, -1e6, 900.0, 0.0]
    return float(rng.choice(bad)) if rng.random() < 0.15 else good


def _bad_pose(rng: np.random.Generator, p) -> RigidTransform:
    p = [_bad_number(rng, x + 0.02 * rng.standard_normal()) for x in p]
    kind = rng.random()
    if kind < 0.1:
        return RigidTransform(RotationMatrix(np.full((3, 3), np.nan)), p)
    if kind < 0.2:  # Tilted, into the table.
        return RigidTransform(
            RotationMatrix.MakeXRotation(rng.uniform(-3, 3)), p
        )
    return RigidTransform(p)


def _disturb(run: FilterRun, rng: np.random.Generator, update: int) -> None:
    """Puts something good or bad on every port."""
    wobble = 0.02 * rng.standard_normal(2)
    run.set_joints([_bad_number(rng, x) for x in PROBE + wobble])
    speeds = [_bad_number(rng, x) for x in wobble]
    run.filter.GetInputPort("joint_velocities").FixValue(run.context, speeds)
    if rng.random() < 0.8:
        stamp = _bad_number(rng, update * PERIOD - rng.uniform(-0.1, 0.3))
        pose = _bad_pose(rng, BLOCK)
        run.measure(DopeMeasurement({"block": Detection(pose, stamp)}))


@pytest.mark.filterwarnings("ignore:(overflow|invalid value) encountered")
@pytest.mark.parametrize(
    "motion, updates", [("constant_velocity", 40), ("physics", 12)]
)
@pytest.mark.parametrize("seed", [0, 1])
def test_whatever_comes_in_what_goes_out_is_finite(
    scene, motion, updates, seed
):
    rng = np.random.default_rng(seed)
    run = _make(
        scene,
        motion=motion,
        num_particles=6,
        use_visibility=True,
        recover_lost_tracks=motion == "physics",
    )
    for i in range(1, updates + 1):
        for part in (0.3, 0.6):
            _disturb(run, rng, i)
            run.simulator.AdvanceTo((i - 0.5 + part) * PERIOD)
        _disturb(run, rng, i)
        run.update(i)
        _assert_finite(run, i)
    if motion == "constant_velocity":
        return  # To this model, jumps are velocities.
    # It goes on as if nothing had been.
    run.set_joints([0.1, 0.3])
    run.filter.GetInputPort("joint_velocities").FixValue(run.context, [0, 0])
    for i in range(updates + 1, updates + 9):
        run.measure(detections(PERIOD * i - 0.01, block=AWAY))
        run.update(i)
    np.testing.assert_allclose(
        run["estimated_poses"][0, 4:6], AWAY[:2], atol=0.05
    )


def test_nothing_is_tracked_before_every_joint_has_a_position(scene, caplog):
    run = FilterRun(scene, small_config(scene), joints=(np.nan, PROBE[1]))
    run.measure(detections(0.1, block=BLOCK))
    run.update(2)
    assert run["tracked"] == [0]
    assert caplog.text.count("['pusher_x'] have no finite position") == 1
    run.set_joints(PROBE)
    run.measure(detections(2.6 * PERIOD, block=BLOCK))
    run.update(3)
    assert run["tracked"] == [1]
    assert all(np.isfinite(value).all() for value in run.ports().values())
