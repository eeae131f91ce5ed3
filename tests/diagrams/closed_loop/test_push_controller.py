import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
import pytest

from pbpf_drake.diagrams.closed_loop.push_controller import (
    PushController,
    PushControllerConfig,
    push_direction,
)

CENTER, GOAL = np.array([0.4, 0.1]), np.array([0.4, 0.4])


@pytest.mark.parametrize("distance", [0.05, 0.2])
def test_behind_the_object_the_way_is_straight_to_the_goal(distance):
    behind = CENTER - [0.0, distance]
    np.testing.assert_allclose(
        push_direction(behind, CENTER, GOAL), [0, 1], atol=1e-12
    )


@pytest.mark.parametrize("side", [-1, 1])
def test_beside_the_object_the_fingertip_goes_back(side):
    beside = CENTER + [side * 0.085, 0.0]
    np.testing.assert_allclose(
        push_direction(beside, CENTER, GOAL), [0, -1], atol=1e-12
    )


def test_too_near_it_goes_outwards_and_too_far_inwards():
    for distance, sign in (0.05, 1), (0.2, -1):
        direction = push_direction(CENTER + [distance, 0.0], CENTER, GOAL)
        assert np.sign(direction[0]) == sign


def test_the_direction_turns_and_mirrors_with_everything_else():
    rng = np.random.default_rng(0)
    for _ in range(50):
        tip, center, goal = rng.standard_normal((3, 2)) * 0.1
        direction = push_direction(tip, center, goal)
        assert np.linalg.norm(direction) == pytest.approx(1)
        c, s = np.cos(1.0), np.sin(1.0)
        for M in np.array([[c, -s], [s, c]]), np.diag([1.0, -1.0]):
            actual = push_direction(M @ tip, M @ center, M @ goal)
            np.testing.assert_allclose(actual, M @ direction, atol=1e-9)


@pytest.mark.parametrize("angle", np.linspace(-3, 3, 7))
def test_from_wherever_it_is_it_gets_behind_a_round_object(angle):
    """The object is a disc that moves as it is pushed."""
    center, radius = CENTER.copy(), 0.05
    tip = center + 0.12 * np.array([np.cos(angle), np.sin(angle)])
    for _ in range(1500):
        tip = tip + 1e-3 * push_direction(tip, center, GOAL)
        offset = center - tip
        if np.linalg.norm(offset) < radius:
            center = tip + radius * offset / np.linalg.norm(offset)
        if np.linalg.norm(center - GOAL) < 0.01:
            return
    raise AssertionError(f"the object ended at {center}")


def _simulate(center, duration: float = 1.0, **changes) -> np.ndarray:
    config = PushControllerConfig(goal=GOAL, **changes)
    dut = PushController(config=config, start=np.array([0.4, 0.0]))
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    poses = [RigidTransform([*center, 0.0])]
    dut.get_input_port().FixValue(context, Value(poses))
    simulator.AdvanceTo(duration)
    return dut.get_output_port().Eval(context)


def test_the_fingertip_moves_with_its_speed():
    p = _simulate(CENTER, speed=0.05)
    # 50 periods of 20 ms; the update at the end is still to come.
    np.testing.assert_allclose(p, [0.4, 0.05, 0.012], atol=1e-9)


def test_at_the_goal_the_fingertip_rests():
    np.testing.assert_allclose(_simulate(GOAL - [0.0, 0.01])[:2], [0.4, 0.0])


def test_the_fingertip_stays_in_its_place_whatever_the_estimate_says():
    p = _simulate([5.0, 5.0], duration=20.0)
    config = PushControllerConfig(goal=GOAL)
    assert np.all(p[:2] >= config.lower) and np.all(p[:2] <= config.upper)
