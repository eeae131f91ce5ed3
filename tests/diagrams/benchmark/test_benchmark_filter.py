"""The timed filter: it is the real one, and its stages add up."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from pbpf_drake.diagrams.benchmark.benchmark_filter import (
    STAGES,
    WARM_UP,
    Call,
    FilterBenchmark,
    RunFilter,
    TimedModel,
    split_stages,
)
from pbpf_drake.diagrams.benchmark.benchmark_workload import LoadWorkload
from pbpf_drake.tracking.tracking_diagram import NumSteps, Track

PARTICLES = 6


def test_an_update_is_split_at_the_calls_of_its_models():
    calls = [
        Call("motion", 2.0, 10.0),
        Call("penetration", 10.5, 12.5),
        Call("visibility", 13.5, 17.0),
    ]
    seconds = split_stages((1.0, 17.25), calls, outputs=0.125)
    assert seconds == {
        "resampling": 1.0,
        "motion": 8.0,
        "noise": 0.5,
        "penetration": 2.0,
        "observation": 1.0,
        "visibility": 3.5,
        "estimate": 0.25,
        "outputs": 0.125,
        "total": 16.375,
    }
    assert tuple(seconds) == STAGES


def test_a_timed_model_hands_everything_on():
    class Model:
        size = 3

        def Score(self, x, *, y):
            return x + y

    noted = []
    dut = TimedModel(Model(), lambda call, given: noted.append((call, given)))
    assert dut.size == 3
    assert noted == []
    assert dut.Score(1, y=2) == 3
    ((call, arguments),) = noted
    assert call.stage == "visibility" and call.begin <= call.end
    assert arguments == (1, 2)


@pytest.fixture(scope="module", params=[1, 3])
def workload(request):
    """The first second of a push."""
    workload = LoadWorkload(request.param)
    joints = workload.log.joints
    keep = joints.times < 1.5
    joints = replace(
        joints,
        times=joints.times[keep],
        positions=joints.positions[keep],
        velocities=joints.velocities[keep],
    )
    return replace(workload, log=replace(workload.log, joints=joints))


@pytest.fixture(scope="module")
def benchmark(workload):
    return FilterBenchmark(workload, num_particles=PARTICLES, num_threads=1)


@pytest.fixture(scope="module")
def run(workload, benchmark):
    per_pass = NumSteps(workload.log, benchmark.config) - WARM_UP
    return RunFilter(benchmark, num_updates=2 * per_pass)


def test_stages_add_up_to_the_total_in_every_update(run):
    for stage in STAGES:
        assert np.all(run.seconds[stage] > 0)
    parts = sum(run.seconds[stage] for stage in STAGES[:-1])
    np.testing.assert_allclose(parts, run.seconds["total"], rtol=1e-9)


def test_every_update_has_the_input_of_its_prediction(run):
    assert len(run.seconds["total"]) == sum(map(len, run.passes))
    steps = [motion.step for motion in run.passes[0]]
    assert steps == [WARM_UP + 1 + i for i in range(len(steps))]
    for motion in run.passes[0]:
        assert np.all(motion.active)
        duration = motion.path.times[-1] - motion.path.times[0]
        assert duration == pytest.approx(0.16)


def test_a_second_pass_repeats_the_first(run):
    first, second = run.passes
    assert len(first) == len(second) > 1
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.poses, b.poses)
        np.testing.assert_array_equal(a.path.positions, b.path.positions)


def test_its_particles_are_those_of_the_untimed_filter(
    workload, benchmark, run
):
    """The survivors that are predicted are among those of a tracked log."""
    record = Track(
        scene=workload.scene,
        log=workload.log,
        method="pbpf-v",
        config=benchmark.config,
    )
    for motion in run.passes[0]:
        before = record.particles[motion.step - 2]
        for pose in motion.poses:
            assert np.any(np.all(before == pose, axis=(1, 2)))


def test_memory_stays_as_it_is(workload, benchmark):
    """Another ten updates take less than a context, of 0.4 MB."""
    run = RunFilter(benchmark, num_updates=10)
    assert 0 <= run.bytes_per_particle < 4e5
    updates = islice(benchmark.Pass(), 2)
    assert len(list(updates)) == 2
