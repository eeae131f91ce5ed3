import numpy as np
import pytest
from update_fixtures import NOMINAL, make_config, see

from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState
from pbpf_drake.filtering.particle_redraw import (
    draw_from_detections,
    redraw_particles,
)
from pbpf_drake.filtering.update_step import UpdateStep, make_update_step
from pbpf_drake.motion.control_path import ControlPath

PATH = ControlPath(np.array([0.0, 0.16]), np.zeros((2, 1)))
CONFIG = make_config()


def _state(active: list[bool]) -> FilterState:
    state = MakeInitialState(10, np.repeat(NOMINAL, len(active), axis=0))
    state.num_estimates[:] = active
    return state


def _step(state: FilterState, *detected: int) -> UpdateStep:
    detections = {k: [see(state, [0.5, 0.1, 0.2])] for k in detected}
    return make_update_step(state, seed=3, path=PATH, detections=detections)


def _redraw(active: list[bool], lost: list[bool], *detected: int):
    state = _state(active)
    return redraw_particles(
        state.poses, np.array(lost), _step(state, *detected), CONFIG
    )


def test_all_particles_of_a_new_track_are_drawn_near_the_detection():
    redrawn = _redraw([False], [False], 0)
    assert redrawn.is_new.all()
    distance = np.linalg.norm(redrawn.poses[:, 0, 4:] - [0.5, 0.1, 0.2], axis=1)
    assert np.all(distance < 4 * CONFIG.detection_noise.position)


def test_every_other_particle_of_a_lost_track_is_kept():
    redrawn = _redraw([True], [True], 0)
    np.testing.assert_array_equal(redrawn.is_new[:, 0], [True, False] * 5)
    np.testing.assert_array_equal(redrawn.poses[1::2, 0], [NOMINAL[0]] * 5)


@pytest.mark.parametrize(
    "active, detected",
    [
        pytest.param([True, True], [0, 1], id="tracked and not lost"),
        pytest.param([False, False], [], id="not detected"),
    ],
)
def test_otherwise_nothing_is_drawn(active, detected):
    redrawn = _redraw(active, [False, False], *detected)
    assert not redrawn.is_new.any()
    np.testing.assert_array_equal(redrawn.poses, _state(active).poses)


def test_what_is_drawn_does_not_depend_on_other_objects():
    alone = _redraw([True, False], [False, False], 1)
    together = _redraw([False, False], [False, False], 0, 1)
    np.testing.assert_array_equal(alone.poses[:, 1], together.poses[:, 1])
    assert not np.array_equal(together.poses[:, 0], together.poses[:, 1])


def test_particles_are_chosen_by_all_detections():
    """Of two detections that are equally sure, particles are in the middle."""
    state = _state([False])
    seen = [see(state, [0.50, 0.1, 0.2]), see(state, [0.54, 0.1, 0.2])]
    poses = draw_from_detections(seen, 4000, CONFIG, np.random.default_rng(0))
    # The candidates' own spread about the last one pulls the mean to it, by
    # 2 mm of the 20 (a Gaussian of 0.113 m, times one of 0.0141 m).
    assert np.mean(poses[:, 4]) == pytest.approx(0.52, abs=3e-3)
    assert np.std(poses[:, 4]) == pytest.approx(0.02 / np.sqrt(2), rel=0.1)
