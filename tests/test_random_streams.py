from itertools import product

import numpy as np
import pytest

from pbpf_drake.random_streams import MakeGenerator, Stream


def _draw(seed=3, step=5, stream=Stream.PROCESS_NOISE, n=4):
    return MakeGenerator(seed=seed, step=step, stream=stream).random(n)


def test_the_same_seed_step_and_stream_give_the_same_numbers():
    first = _draw()
    _draw(step=6), _draw(stream=Stream.RESAMPLING)  # Others don't matter.
    np.testing.assert_array_equal(_draw(), first)


@pytest.mark.parametrize(
    "other", [{"seed": 4}, {"step": 6}, {"stream": Stream.RESAMPLING}]
)
def test_another_seed_step_or_stream_gives_other_numbers(other):
    assert not np.any(np.isin(_draw(**other), _draw()))


def test_streams_of_a_run_have_no_number_in_common():
    keys = list(product(range(3), range(40), Stream))
    numbers = np.array([_draw(*key, n=2) for key in keys])
    assert len(np.unique(numbers)) == numbers.size


def test_seed_and_step_are_not_interchangeable():
    assert not np.any(np.isin(_draw(seed=1, step=2), _draw(seed=2, step=1)))


def test_any_size_of_seed_can_be_used():
    assert not np.array_equal(_draw(seed=2**63), _draw(seed=0))


def test_first_numbers_of_successive_steps_are_uniform_and_uncorrelated():
    u = np.array([_draw(step=i, n=1)[0] for i in range(1, 3001)])
    counts = np.histogram(u, bins=10, range=(0, 1))[0]
    # χ² with 9 degrees of freedom exceeds this once in 10⁴ times.
    assert np.sum((counts - 300) ** 2 / 300) < 33.7
    # The correlation of as many independent pairs has this deviation.
    assert abs(np.corrcoef(u[1:], u[:-1])[0, 1]) < 4 / np.sqrt(3000)


def test_streams_of_the_same_step_are_uncorrelated():
    u = np.array(
        [[_draw(step=i, stream=s, n=1)[0] for s in Stream] for i in range(800)]
    )
    correlation = np.corrcoef(u.T) - np.eye(len(Stream))
    assert np.max(np.abs(correlation)) < 4.5 / np.sqrt(800)
