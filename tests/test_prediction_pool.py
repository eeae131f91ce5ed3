import copy
import threading

import numpy as np
from physics_fixtures import FLAT, make_model
import pytest

from pbpf_drake.prediction_pool import (
    MakeSimulator,
    PredictionPool,
    ResetIntegrator,
)


@pytest.fixture(scope="module")
def model():
    return make_model("block")


def _make_pool(num_threads: int) -> tuple[PredictionPool, list[int]]:
    """Returns a pool of strings, and the indices that it has made."""
    made: list[int] = []

    def make(index: int) -> str:
        made.append(index)
        return f"simulator {index}"

    return PredictionPool(make=make, num_threads=num_threads), made


def test_a_simulator_is_made_when_it_is_first_used_and_kept():
    pool, made = _make_pool(1)
    assert made == []
    assert pool.Simulator(3) == "simulator 3"
    assert pool.Simulator(1) == "simulator 1"
    assert pool.Simulator(3) is pool.Simulator(3)
    assert made == [3, 1]


def test_what_is_discarded_is_made_anew():
    pool, made = _make_pool(1)
    pool.Simulator(2)
    pool.Discard(2)
    pool.Discard(5)
    pool.Simulator(2)
    assert made == [2, 2]


def test_a_copy_is_empty_and_makes_its_own():
    pool, made = _make_pool(2)
    pool.Simulator(0)
    pool.Run(lambda index: None, range(4))  # Its threads can't be copied.
    twin = copy.deepcopy(pool)
    twin.Simulator(0)
    assert made == [0, 0]


@pytest.mark.parametrize("num_threads", [1, 2, 5])
def test_all_indices_are_worked_on_once(num_threads):
    pool, _ = _make_pool(num_threads)
    done = []
    for _ in range(3):
        done.clear()
        pool.Run(done.append, [4, 2, 7, 0])
        assert sorted(done) == [0, 2, 4, 7]


def test_one_thread_is_the_callers_own_and_keeps_the_order():
    pool, _ = _make_pool(1)
    done = []
    pool.Run(lambda i: done.append((i, threading.get_ident())), [2, 0, 1])
    assert done == [(i, threading.get_ident()) for i in (2, 0, 1)]


def test_threads_work_at_the_same_time():
    pool, _ = _make_pool(2)
    barrier = threading.Barrier(2, timeout=10)
    pool.Run(lambda index: barrier.wait(), range(2))


@pytest.mark.parametrize("num_threads", [1, 2])
def test_an_error_of_the_work_is_raised(num_threads):
    pool, _ = _make_pool(num_threads)
    with pytest.raises(ZeroDivisionError):
        pool.Run(lambda index: 1 / index, [1, 0, 2])


@pytest.mark.parametrize(
    ("time_step", "steps"), [(0.01, 16), (0.02, 8), (0.16, 1), (0.03, 6)]
)
def test_steps_are_as_long_as_they_are_said_to_be(model, time_step, steps):
    simulator = MakeSimulator(model, time_step)
    simulator.Initialize()
    simulator.AdvanceTo(0.16, interruptible=False)
    assert simulator.get_num_steps_taken() == steps
    assert simulator.get_context().get_time() == 0.16


def test_simulators_share_the_model_and_have_contexts_of_their_own(model):
    one, two = (MakeSimulator(model, 0.01) for _ in range(2))
    assert one.get_system() is two.get_system() is model.diagram
    start = two.get_context().get_continuous_state_vector().CopyToVector()
    one.Initialize()
    one.AdvanceTo(0.05, interruptible=False)
    end = two.get_context().get_continuous_state_vector().CopyToVector()
    np.testing.assert_array_equal(start, end)


def test_an_integrator_that_was_reset_has_forgotten_its_only_step(model):
    """Without that, a second first step at time 0 repeats the first."""
    simulator = MakeSimulator(model, 0.01)
    context = simulator.get_mutable_context()
    plant = model.diagram.plant()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    v = np.zeros(plant.num_velocities())
    q = plant.GetPositions(plant_context)
    q[model.object_q[0]] = [*FLAT, 0.0, 0.0, 1.0]
    for speed in (0.5, -0.3, 0.2):
        v[model.object_v[0, 3]] = speed
        plant.SetPositions(plant_context, q)
        plant.SetVelocities(plant_context, v)
        context.SetTime(0.0)
        ResetIntegrator(simulator, 0.01)
        simulator.Initialize()
        simulator.AdvanceTo(0.01, interruptible=False)
        x = plant.GetPositions(plant_context)[model.object_q[0, 4]]
        assert x == pytest.approx(0.01 * speed)
