from concurrent.futures import ThreadPoolExecutor
from functools import partial
import re

import pytest

from pbpf_drake.diagrams.jobs.job_queue import Failure, Job
from pbpf_drake.diagrams.jobs.result_store import ResultStore
from pbpf_drake.diagrams.jobs.stored_jobs import RunStoredJobs, StoredJob

POOL = partial(ThreadPoolExecutor, 1)


def _jobs(compute, costs=(1.0, 2.0, 7.0)) -> list[StoredJob]:
    return [
        StoredJob(Job(f"job_{i}", compute, (i,), cost=cost), {"i": i})
        for i, cost in enumerate(costs)
    ]


def _text(i: int) -> bytes:
    return f"result {i}".encode()


def _refuse(i: int) -> bytes:
    raise AssertionError(f"job {i} is stored")


def _run(jobs, folder, pool=POOL):
    store = ResultStore(folder, suffix=".txt")
    return RunStoredJobs(jobs, store, pool, ahead=1, title="test")


def test_results_are_those_of_the_jobs_and_stay(tmp_path):
    expected = {f"job_{i}": _text(i) for i in range(3)}
    assert _run(_jobs(_text), tmp_path) == (expected, [])
    assert _run(_jobs(_refuse), tmp_path) == (expected, [])


def test_a_result_is_stored_before_the_next_job_is_done(tmp_path):
    def compute(i: int) -> bytes:
        assert len(list(tmp_path.glob("*.txt"))) >= i - 1
        return _text(i)

    _, failures = _run(_jobs(compute), tmp_path)
    assert failures == []


def test_what_failed_is_not_stored_and_is_tried_again(tmp_path):
    def compute(i: int) -> bytes:
        if i == 1:
            raise ValueError("no truth")
        return _text(i)

    results, failures = _run(_jobs(compute), tmp_path)
    assert set(results) == {"job_0", "job_2"}
    assert failures == [Failure("job_1", "ValueError: no truth")]
    results, failures = _run(_jobs(_text), tmp_path)
    assert results["job_1"] == b"result 1" and failures == []


def test_an_interruption_loses_nothing_that_was_done(tmp_path):
    def compute(i: int) -> bytes:
        if i == 2:
            raise KeyboardInterrupt
        return _text(i)

    with pytest.raises(KeyboardInterrupt):
        _run(_jobs(compute), tmp_path)
    assert len(list(tmp_path.glob("*.txt"))) == 2


def test_the_bar_goes_by_cost_and_starts_with_what_is_stored(tmp_path, capsys):
    _run(_jobs(_text, costs=(1.0, 2.0)), tmp_path)
    capsys.readouterr()
    _run(_jobs(_text), tmp_path)
    shown = re.split(r"[\r\n]+", capsys.readouterr().err.strip())
    # 1 and 2 of a cost of 10 are stored.
    assert any(x.startswith("test:  30%") and "2 of 3" in x for x in shown)
    assert shown[-1].startswith("test: 100%") and "3 of 3" in shown[-1]
    assert shown[-1].endswith("left]")


def test_a_damaged_file_is_said_beside_the_bar(tmp_path, capsys):
    _run(_jobs(_text), tmp_path)
    path = next(tmp_path.glob("job_1-*"))
    path.write_bytes(b"resul")
    results, _ = _run(_jobs(_text), tmp_path)
    assert results["job_1"] == b"result 1"
    assert f"{path} is damaged; it is made again" in capsys.readouterr().err


# The order in which these are added decides what their sum is; and the sum()
# of CPython 3.12 is exact.
@pytest.mark.parametrize(
    "costs", [(0.1, 0.1, 0.2, 0.3), (0.1, 0.2, 0.3, 0.1), (0.7, 0.1, 0.3)]
)
@pytest.mark.parametrize("late", range(3))
def test_the_bar_never_passes_its_end(costs, late, tmp_path, capsys):
    def compute(i: int) -> bytes:
        if i == late:
            raise ValueError("later")
        return _text(i)

    _run(_jobs(compute, costs), tmp_path)
    _run(_jobs(_text, costs), tmp_path)
    assert "100%" in capsys.readouterr().err.split("\r")[-1]
