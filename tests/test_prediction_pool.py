import copy
import threading

import pytest

from pbpf_drake.prediction_pool import PredictionPool


def _make_pool(num_threads: int) -> tuple[PredictionPool, list]:
    """Returns a pool of strings, and the indices that it has made."""
    made: list[tuple[tuple[int, ...], int]] = []

    def make(links: tuple[int, ...], index: int) -> str:
        made.append((links, index))
        return f"simulator {index} with {links}"

    return PredictionPool(make=make, num_threads=num_threads), made


def test_a_simulator_is_made_when_it_is_first_used_and_kept():
    pool, made = _make_pool(1)
    assert made == []
    assert pool.Simulators(()).Get(3) == "simulator 3 with ()"
    assert pool.Simulators((5,)).Get(3) == "simulator 3 with (5,)"
    assert pool.Simulators(()).Get(3) is pool.Simulators(()).Get(3)
    assert made == [((), 3), ((5,), 3)]


def test_what_is_discarded_is_made_anew():
    pool, made = _make_pool(1)
    simulators = pool.Simulators(())
    simulators.Get(2)
    simulators.Discard(2)
    simulators.Discard(5)
    pool.Simulators(()).Get(2)
    assert made == [((), 2), ((), 2)]


def test_the_links_that_were_not_used_the_longest_are_given_up():
    pool, made = _make_pool(1)
    for links in [(0,), (1,), (2,), (0,), (3,), (4,)]:
        pool.Simulators(links).Get(0)
    assert len(made) == 5
    for links in (0,), (2,), (3,), (4,):
        pool.Simulators(links).Get(0)
    assert len(made) == 5
    pool.Simulators((1,)).Get(0)
    assert len(made) == 6


def test_a_copy_is_empty_and_makes_its_own():
    pool, made = _make_pool(2)
    pool.Simulators(()).Get(0)
    pool.Run(lambda index: None, range(4))  # Its threads can't be copied.
    twin = copy.deepcopy(pool)
    twin.Simulators(()).Get(0)
    assert made == [((), 0), ((), 0)]


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
