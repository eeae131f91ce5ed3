"""Samples that can only be damaged are found and left out."""

import numpy as np
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_jumps import find_jumps, find_spikes, without_jumps
from pbpf_drake.log.log_samples import Stamped

TIMES = 0.01 * np.arange(10)


def _walk():
    return np.column_stack([0.05 * np.arange(10), np.zeros(10)])


@pytest.mark.parametrize("index", [0, 1, 5, 8, 9])
def test_a_sample_far_from_its_neighbours_is_found(index):
    values = _walk()
    values[index, 1] = -3.0
    assert np.flatnonzero(find_jumps(TIMES, values)).tolist() == [index]


def test_fast_motion_is_no_jump():
    assert not np.any(find_jumps(TIMES, _walk() * 9.0))


def test_a_motion_that_jumps_and_stays_is_left_alone():
    values = _walk()
    values[4:] += 5.0
    assert not np.any(find_jumps(TIMES, values))


@pytest.mark.parametrize("count", [0, 1, 2])
def test_of_few_samples_none_is_known_to_be_wrong(count):
    values = 100.0 * np.arange(count)[:, np.newaxis]
    assert not np.any(find_jumps(TIMES[:count], values))


def test_messages_that_jump_are_left_out_and_counted():
    values, notes = _walk(), LogNotes()
    values[[2, 6]] += 7.0
    messages = [Stamped(i * 10**7, 0, i) for i in range(10)]
    kept = without_jumps(messages, values, notes.On("/a", "message"))
    assert [m.value for m in kept] == [0, 1, 3, 4, 5, 7, 8, 9]
    assert notes.Sentences() == (
        "/a: left out 2 messages that is too far from those before and after "
        "it",
    )


@pytest.mark.parametrize("index", [2, 5, 7])
@pytest.mark.parametrize("height", [0.3, -0.3, 20.0])
def test_a_joint_that_jumps_and_comes_back_is_found(index, height):
    values = 0.1 * _walk()
    values[index, 1] += height
    assert find_spikes(values) == [(index, 1)]


def test_motion_that_turns_back_is_no_spike():
    phase = np.linspace(0, 20, 40)
    values = np.column_stack([np.sin(phase), np.abs(np.sin(phase))])
    assert find_spikes(values) == []


def test_noise_and_the_steps_of_an_encoder_are_no_spikes():
    rng = np.random.default_rng(0)
    noise = 0.02 * rng.standard_normal((1000, 3))
    assert find_spikes(noise) == []
    encoder = 0.006 * (np.arange(100) % 17 == 0).astype(float)[:, np.newaxis]
    assert find_spikes(encoder) == []


@pytest.mark.parametrize("count", [0, 1, 4])
def test_of_few_samples_none_is_a_spike(count):
    assert find_spikes(np.zeros((count, 2))) == []
    values = np.zeros((count, 2))
    values[count // 2 :] = 1.0
    assert find_spikes(values) == []


def test_the_joint_that_jumps_most_is_named():
    values, notes = _walk(), LogNotes()
    values[4] += [1.0, 7.0]
    messages = [Stamped(i * 10**7, 0, i) for i in range(10)]
    without_jumps(messages, values, notes.On("/a", "message"), ["p", "q"])
    assert notes.Sentences() == (
        "/a: left out 1 message whose joint 'q' is too far from those before "
        "and after it",
    )
