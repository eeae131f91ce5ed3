"""Processes here, and a real cluster of two workers, one of which is killed."""

from contextlib import contextmanager
from functools import partial
import os
from pathlib import Path
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings

import job_functions
from paths import ROOT
import pytest

from pbpf_drake.diagrams.jobs.executors import ClusterExecutor, LocalExecutor
from pbpf_drake.diagrams.jobs.job_queue import Job
from pbpf_drake.diagrams.jobs.result_store import ResultStore
from pbpf_drake.diagrams.jobs.stored_jobs import RunStoredJobs, StoredJob

FIXTURES = ROOT / "tests" / "fixtures"


def _is_alive(pid: int) -> bool:
    """Whether a process runs; a zombie doesn't."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return status.rsplit(")", 1)[1].split()[0] != "Z"


def _wait_until(condition, seconds: float = 120.0) -> bool:
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


def test_local_jobs_run_in_other_processes_with_one_thread_each():
    with LocalExecutor(2) as executor:
        future = executor.submit(
            job_functions.environment, "OPENBLAS_NUM_THREADS"
        )
        pid, threads = future.result()
    assert pid != os.getpid() and threads == "1"


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc")
def test_local_processes_end_when_their_parent_is_killed(tmp_path):
    code = f"""
    import sys
    sys.path.insert(0, {str(FIXTURES)!r})
    import job_functions
    from pbpf_drake.diagrams.jobs.executors import LocalExecutor

    if __name__ == "__main__":
        with LocalExecutor(1) as executor:
            executor.submit(
                job_functions.announce_and_wait, {str(tmp_path)!r}, 1
            ).result()
    """
    script = tmp_path / "script.py"
    script.write_text(textwrap.dedent(code))
    with subprocess.Popen([sys.executable, str(script)]) as parent:
        assert _wait_until(lambda: list(tmp_path.glob("1-*")))
        (marker,) = tmp_path.glob("1-*")
        parent.send_signal(signal.SIGKILL)
    child = int(marker.name.split("-")[1])
    assert _wait_until(lambda: not _is_alive(child))


@contextmanager
def _cluster(num_workers: int):
    """A scheduler and workers, one process each; yields its address."""
    pytest.importorskip(
        "distributed", reason="the extra 'cluster' is not installed"
    )
    # Dask warns of what this machine has too little of, or none.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from distributed import LocalCluster

        with LocalCluster(
            n_workers=num_workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",
            silence_logs=50,
        ) as cluster:
            yield cluster.scheduler_address


@pytest.mark.slow
def test_a_cluster_loses_nothing_when_a_worker_is_killed(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(FIXTURES), prepend=os.pathsep)
    marks = tmp_path / "marks"
    marks.mkdir()
    jobs = [
        StoredJob(
            Job(
                f"job_{i}",
                job_functions.announce_and_wait,
                (str(marks), i),
            ),
            {"i": i},
        )
        for i in range(12)
    ]
    killed = []

    def kill_one() -> None:
        """One of the workers, while both are at a job."""
        if _wait_until(lambda: len(list(marks.iterdir())) == 2):
            job, pid = min(marks.iterdir()).name.split("-")
            os.kill(int(pid), signal.SIGKILL)
            killed.append((job, int(pid)))
        (marks / "go").touch()

    with _cluster(2) as address:
        killer = threading.Thread(target=kill_one)
        killer.start()
        results, failures = RunStoredJobs(
            jobs,
            ResultStore(tmp_path / "store", suffix=".txt"),
            partial(ClusterExecutor, address),
            ahead=12,
            title="test",
        )
        killer.join()
    ((job, pid),) = killed
    assert pid != os.getpid()
    assert failures == []
    assert results == {f"job_{i}": str(i).encode() for i in range(12)}
    # The job of the dead worker was run a second time, by another process.
    pids = {int(p.name.split("-")[1]) for p in marks.glob(f"{job}-*")}
    assert len(pids) == 2 and pid in pids
    assert len(list((tmp_path / "store").glob("*.txt"))) == 12


def test_a_scheduler_that_does_not_answer_is_said(monkeypatch):
    pytest.importorskip("distributed", reason="needs the extra 'cluster'")
    monkeypatch.setattr(
        "pbpf_drake.diagrams.jobs.executors._CONNECT_SECONDS", 0.2
    )
    with (
        pytest.raises(ValueError, match="no scheduler answers at 'tcp://127"),
        ClusterExecutor("tcp://127.0.0.1:9"),
    ):
        pass


def test_without_dask_it_is_said_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(ValueError, match=r"pbpf_drake\[cluster\]"),
        ClusterExecutor("tcp://127.0.0.1:9"),
    ):
        pass
