from dataclasses import fields

import numpy as np

from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState

NOMINAL = np.array([[1.0, 0, 0, 0, 0.1, 0.2, 0.3], [0, 1.0, 0, 0, 4, 5, 6]])


def test_before_the_first_detection_everything_is_at_its_nominal_pose():
    state = MakeInitialState(5, NOMINAL)
    for pose in [*state.poses, *state.estimates]:
        np.testing.assert_array_equal(pose, NOMINAL)
    np.testing.assert_allclose(state.weights, 0.2)
    assert not np.any(state.num_estimates)


def test_any_stamp_is_newer_than_that_of_no_detection():
    assert np.all(MakeInitialState(1, NOMINAL).detection_times < -1e300)


def test_all_of_the_state_is_numbers_that_a_discrete_state_can_hold():
    state = MakeInitialState(3, NOMINAL)
    for field in fields(FilterState):
        assert getattr(state, field.name).dtype == np.float64, field.name
