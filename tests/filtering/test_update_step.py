import numpy as np
from update_fixtures import NOMINAL, see

from pbpf_drake.filtering.filter_state import MakeInitialState
from pbpf_drake.filtering.update_step import index_mask, make_update_step
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.random_streams import Stream

PATH = ControlPath(np.array([0.2, 0.3, 0.6]), np.zeros((3, 1)))


def _step(seed: int = 0, **changes):
    state = MakeInitialState(4, np.repeat(NOMINAL, 3, axis=0))
    state.num_estimates[:2] = 1, 2
    detections = {2: [see(state, [0.0, 0.0, 0.0])]}
    return make_update_step(state, seed=seed, path=PATH, detections=detections)


def test_known_is_what_was_tracked_and_what_is_detected_now():
    step = _step()
    np.testing.assert_array_equal(step.active, [True, True, False])
    np.testing.assert_array_equal(step.known, [True, True, True])


def test_the_first_update_has_the_number_one():
    assert _step().number == 1


def test_random_numbers_depend_on_seed_and_purpose_alone():
    def draw(seed, stream):
        return _step(seed).MakeGenerator(stream).random(3).tolist()

    first = draw(0, Stream.RESAMPLING)
    assert draw(0, Stream.RESAMPLING) == first
    assert draw(1, Stream.RESAMPLING) != first
    assert draw(0, Stream.PROCESS_NOISE) != first


def test_a_mask_is_true_at_the_keys():
    np.testing.assert_array_equal(
        index_mask({0: "a", 2: "b"}, 3), [True, False, True]
    )
