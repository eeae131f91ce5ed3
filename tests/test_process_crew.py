"""Crews of real processes, some of which die."""

from dataclasses import dataclass
from functools import partial
import gc
import logging
import multiprocessing
import os
import platform
import signal
import subprocess
import sys
import time

import pytest

from pbpf_drake import process_crew
from pbpf_drake.process_crew import Crew


class Counter:
    """Counts how often it was asked."""

    def __init__(self) -> None:
        self.count = 0


@dataclass(frozen=True)
class Add:
    x: int

    def RunOn(self, counter: Counter) -> tuple[int, int, int]:
        counter.count += 1
        return os.getpid(), counter.count, self.x


@dataclass(frozen=True)
class Fail:
    x: int

    def RunOn(self, counter: Counter) -> float:
        return 1 / self.x


@dataclass(frozen=True)
class Die:
    only_in: int

    def RunOn(self, counter: Counter) -> int:
        if os.getpid() != self.only_in:
            os._exit(1)
        return self.only_in


@dataclass(frozen=True)
class Return:
    x: int

    def RunOn(self, counter: Counter) -> object:
        return (lambda: self.x) if self.x else 0  # A function can't be sent.


@dataclass(frozen=True)
class Sleep:
    seconds: float

    def RunOn(self, counter: Counter) -> int:
        time.sleep(self.seconds)
        return os.getpid()


def test_each_process_does_its_own_share_in_order():
    crew = Crew(Counter(), 3)
    shares = [[Add(1), Add(2)], [Add(3), Add(4), Add(5)], [Add(6)]]
    results = crew.Run(shares)
    assert [[x for _, _, x in r] for r in results] == [[1, 2], [3, 4, 5], [6]]
    pids = [{pid for pid, _, _ in r} for r in results]
    assert all(len(p) == 1 for p in pids)
    assert pids[0] == {os.getpid()}
    assert len(set.union(*pids)) == 3


def test_processes_are_kept_and_have_workers_of_their_own():
    crew = Crew(Counter(), 2)
    first = crew.Run([[Add(0)], [Add(0), Add(0)]])
    second = crew.Run([[Add(0)], [Add(0)]])
    assert first[1][0][0] == second[1][0][0]
    assert [count for _, count, _ in first[0] + second[0]] == [1, 2]
    assert [count for _, count, _ in first[1] + second[1]] == [1, 2, 3]


def test_nobody_is_made_who_has_nothing_to_do():
    crew = Crew(Counter(), 4)
    before = multiprocessing.active_children()
    assert crew.Run([[Add(1)], [], [], []])[1:] == [[]] * 3
    assert multiprocessing.active_children() == before


def test_processes_work_at_the_same_time():
    crew = Crew(Counter(), 3)
    crew.Run([[Sleep(0.0)]] * 3)
    start = time.monotonic()
    crew.Run([[Sleep(0.3)]] * 3)
    assert time.monotonic() - start < 0.75


@pytest.mark.parametrize("shares", [[[0], [1]], [[1], [0]], [[0], [0]]])
def test_what_goes_wrong_anywhere_is_raised_and_the_crew_goes_on(shares):
    crew = Crew(Counter(), 2)
    with pytest.raises(ZeroDivisionError):
        crew.Run([[Fail(x) for x in share] for share in shares])
    assert crew.Run([[Fail(1)], [Fail(2)]]) == [
        [1.0],
        [0.5],
    ]


def test_the_share_of_one_that_dies_is_done_here_and_it_is_replaced(caplog):
    crew, here = Crew(Counter(), 3), os.getpid()
    with caplog.at_level(logging.WARNING):
        results = crew.Run([[Die(here)]] * 3)
    assert results == [[here]] * 3
    assert len(caplog.records) == 2
    again = crew.Run([[Add(7)]] * 3)
    assert len({pid for ((pid, _, _),) in again}) == 3


def test_one_that_was_killed_in_between_is_replaced():
    crew = Crew(Counter(), 2)
    ((_, ((victim, _, _),))) = crew.Run([[Add(1)]] * 2)
    os.kill(victim, signal.SIGKILL)
    time.sleep(0.2)
    _, ((pid, _, x),) = crew.Run([[Add(1)], [Add(5)]])
    assert (pid, x) == (os.getpid(), 5)
    _, ((pid, _, _),) = crew.Run([[Add(1)]] * 2)
    assert pid not in (os.getpid(), victim)


@dataclass(frozen=True)
class Measure:
    data: bytes

    def RunOn(self, counter: Counter) -> tuple[int, int]:
        return os.getpid(), len(self.data)


@pytest.mark.parametrize("size", [8, 10_000_000], ids=["short", "long"])
def test_the_share_of_one_that_is_stopped_is_done_here(
    size, caplog, monkeypatch
):
    """A long job doesn't fit into the pipe, so that sending it blocks."""
    monkeypatch.setattr(process_crew, "_PATIENCE", 0.5)
    crew, job = Crew(Counter(), 2), Measure(bytes(size))
    ((first, _),) = crew.Run([[], [job]])[1]
    os.kill(first, signal.SIGSTOP)
    assert crew.Run([[], [job]])[1] == [(os.getpid(), size)]
    assert "didn't answer" in caplog.text
    ((second, _),) = crew.Run([[], [job]])[1]
    assert second not in (first, os.getpid())


def test_a_crew_with_one_that_is_stopped_ends(monkeypatch):
    crew = Crew(Counter(), 2)
    ((pid, _, _),) = crew.Run([[], [Add(1)]])[1]
    os.kill(pid, signal.SIGSTOP)
    del crew
    gc.collect()
    end = time.monotonic() + 10
    while os.path.exists(f"/proc/{pid}") and time.monotonic() < end:
        multiprocessing.active_children()  # Those that ended are cleaned up.
        time.sleep(0.01)
    assert not os.path.exists(f"/proc/{pid}")


def test_an_answer_that_cannot_be_sent_is_made_here():
    _, (answer,) = Crew(Counter(), 2).Run([[Return(0)], [Return(3)]])
    assert answer() == 3


def test_an_interrupt_leaves_no_answer_behind():
    crew = Crew(Counter(), 2)
    crew.Run([[Add(1)], [Add(1)]])
    helper = crew._helpers[1]
    helper.Send([Add(41)])  # Nobody waits for it.
    _, ((_, _, x),) = crew.Run([[Add(1)], [Add(42)]])
    assert x == 42


def test_processes_end_with_their_crew():
    crew, other = Crew(Counter(), 2), Crew(Counter(), 2)
    for each in crew, other:
        each.Run([[Add(1)]] * 2)
    (process,) = [
        p
        for p in multiprocessing.active_children()
        if p.pid == crew.Run([[Add(1)]] * 2)[1][0][0]
    ]
    del crew, each
    gc.collect()
    process.join(timeout=5.0)
    assert process.exitcode == 0
    assert len(other.Run([[Add(1)]] * 2)) == 2


_SCRIPT = """
import time
import crew_jobs
from pbpf_drake import process_crew
from pbpf_drake.process_crew import Crew
crew = Crew(None, 3)
pids = crew.Run([[crew_jobs.Pid()]] * 3)
print(*(pid for (pid,) in pids), flush=True)
time.sleep(60)
"""


def _is_alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_process_outlives_the_one_it_works_for(how, tmp_path):
    (tmp_path / "crew_jobs.py").write_text(
        "import os\n\n\nclass Pid:\n"
        "    def RunOn(self, worker):\n        return os.getpid()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", _SCRIPT],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    ) as script:
        pids = [int(pid) for pid in script.stdout.readline().split()]
        assert len(set(pids)) == 3
        script.send_signal(how)
    end = time.monotonic() + 10
    while any(map(_is_alive, pids)) and time.monotonic() < end:
        time.sleep(0.05)
    assert not any(map(_is_alive, pids))


def test_a_daemonic_process_does_everything_itself():
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    process = context.Process(
        target=partial(_run_in_daemon, queue), daemon=True
    )
    process.start()
    pid, pids = queue.get(timeout=30)
    process.join()
    assert pids == {pid}


def _run_in_daemon(queue) -> None:
    results = Crew(Counter(), 2).Run([[Add(1)]] * 2)
    queue.put((os.getpid(), {pid for part in results for pid, _, _ in part}))


_FAULTS_AFTER_CREW = """
import resource
import numpy as np
from pbpf_drake import process_crew
from pbpf_drake.process_crew import Crew
if {with_crew}:
    Crew(None, 1)
def make_arrays():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    arrays = [np.ones(2**17) for _ in range(20)]
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
print([make_arrays() for _ in range(5)][-1])
"""


@pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc", reason="it is glibc that gives it back"
)
def test_memory_of_large_arrays_is_got_from_the_system_only_once():
    # Without what Dask's nannies set for the processes that they start.
    environment = {k: v for k, v in os.environ.items() if "MALLOC" not in k}
    faults = {
        with_crew: int(
            subprocess.run(
                [sys.executable, "-c", script],
                check=True,
                capture_output=True,
                env=environment,
                text=True,
            ).stdout
        )
        for with_crew in (False, True)
        if (script := _FAULTS_AFTER_CREW.format(with_crew=with_crew))
    }
    assert faults[False] > 1000  # 20 MiB have 5120 pages.
    assert faults[True] < 100
