"""Jobs on real pools of threads and processes, some of which die."""

from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import partial
import time

import job_functions
import pytest

from pbpf_drake.diagrams.jobs.executors import LocalExecutor
from pbpf_drake.diagrams.jobs.job_queue import Job, RunJobs


def _job(name: str, function, *arguments) -> Job:
    return Job(name, function, arguments)


def _run(jobs, make_executor, *, ahead=4):
    done, failed = {}, {}
    RunJobs(
        jobs,
        make_executor,
        ahead=ahead,
        on_done=lambda job, result: done.update({job.name: result}),
        on_failure=lambda job, reason: failed.update({job.name: reason}),
    )
    return done, failed


@pytest.mark.parametrize("ahead", [1, 3, 100])
def test_every_job_is_done_once_on_any_executor(ahead):
    calls = []

    def square(x: int) -> int:
        calls.append(x)
        return x * x

    jobs = [_job(str(i), square, i) for i in range(20)]
    done, failed = _run(jobs, partial(ThreadPoolExecutor, 2), ahead=ahead)
    assert done == {str(i): i * i for i in range(20)}
    assert failed == {} and sorted(calls) == list(range(20))


def test_a_job_that_fails_is_named_and_the_others_go_on():
    jobs = [_job(str(i), job_functions.square, i) for i in range(4)]
    jobs.insert(1, _job("bad", job_functions.fail, "no such box"))
    done, failed = _run(jobs, partial(ThreadPoolExecutor, 1))
    assert set(done) == {"0", "1", "2", "3"}
    assert failed == {"bad": "ValueError: no such box"}


def test_no_more_jobs_are_under_way_than_asked_for():
    under_way, most = set(), []

    def work(i: int) -> None:
        under_way.add(i)
        most.append(len(under_way))
        time.sleep(0.01)
        under_way.remove(i)

    jobs = [_job(str(i), work, i) for i in range(12)]
    done, _ = _run(jobs, partial(ThreadPoolExecutor, 8), ahead=3)
    assert len(done) == 12 and max(most) <= 3


def test_of_a_dead_process_only_the_guilty_job_is_lost():
    jobs = [_job(str(i), job_functions.square, i) for i in range(6)]
    jobs.insert(2, _job("deadly", job_functions.die))
    done, failed = _run(jobs, partial(LocalExecutor, 2))
    assert done == {str(i): i * i for i in range(6)}
    assert failed == {"deadly": "the process that ran it died"}


def test_a_job_whose_process_was_killed_once_is_run_again(tmp_path):
    marker = str(tmp_path / "marker")
    jobs = [_job("unlucky", job_functions.die_once, marker)]
    done, failed = _run(jobs, partial(LocalExecutor, 1))
    assert done == {"unlucky": "done"} and failed == {}


def test_an_executor_that_never_works_is_given_up():
    made = []

    @contextmanager
    def make_executor():
        made.append(1)
        with LocalExecutor(1) as executor:
            executor.submit(job_functions.die).exception()
            yield executor

    jobs = [_job("job", job_functions.square, 1)]
    done, failed = _run(jobs, make_executor)
    assert done == {} and set(failed) == {"job"}
    assert len(made) <= 4


class _Disconnected(Executor):
    """Cancels whatever it is given, as Dask's does without its scheduler."""

    def submit(self, fn, /, *args, **kwargs) -> Future:
        future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_what_a_lost_executor_cancels_is_run_by_the_next():
    executors = iter([_Disconnected(), *(ThreadPoolExecutor(1),) * 9])
    jobs = [_job(str(i), job_functions.square, i) for i in range(3)]
    done, failed = _run(jobs, lambda: nullcontext(next(executors)))
    assert done == {str(i): i * i for i in range(3)} and failed == {}


def test_an_executor_that_takes_no_jobs_is_lost_too():
    closed = ThreadPoolExecutor(1)
    closed.shutdown()
    executors = iter([closed, ThreadPoolExecutor(1), ThreadPoolExecutor(1)])
    jobs = [_job(str(i), job_functions.square, i) for i in range(3)]
    done, failed = _run(jobs, lambda: nullcontext(next(executors)))
    assert done == {str(i): i * i for i in range(3)} and failed == {}


def test_what_goes_wrong_with_a_result_stops_everything():
    def on_done(job, result):
        raise OSError("no space left")

    with pytest.raises(OSError, match="no space left"):
        RunJobs(
            [_job(str(i), job_functions.square, i) for i in range(50)],
            partial(ThreadPoolExecutor, 1),
            ahead=2,
            on_done=on_done,
            on_failure=pytest.fail,
        )


def test_without_jobs_no_executor_is_made():
    def make_executor() -> Executor:
        raise AssertionError

    assert _run([], make_executor) == ({}, {})
