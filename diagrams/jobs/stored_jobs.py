"""Runs the jobs whose results aren't stored yet, and stores the results."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import sys

from tqdm import tqdm

from pbpf_drake.diagrams.jobs.job_key import JobKey
from pbpf_drake.diagrams.jobs.job_queue import (
    ExecutorFactory,
    Failure,
    Job,
    RunJobs,
)
from pbpf_drake.diagrams.jobs.result_store import ResultStore


@dataclass(frozen=True, eq=False)
class StoredJob:
    """A job that makes bytes, and the key of all that they depend on."""

    job: Job[bytes]
    key: JobKey


def RunStoredJobs(
    stored_jobs: Sequence[StoredJob],
    store: ResultStore,
    make_executor: ExecutorFactory,
    *,
    ahead: int,
    title: str,
) -> tuple[dict[str, bytes], list[Failure]]:
    """Returns all results; those that aren't stored are computed, and stored.

    Each is stored as soon as it is there. A progress bar shows how many there
    are, and the time left.

    Args:
        stored_jobs: with different names.
        store: where results are, and where new ones go.
        make_executor, ahead: see RunJobs.
        title: of the progress bar.

    Returns:
        Results by the job's name, and the jobs that have none.
    """
    results, missing = _LoadStored(stored_jobs, store)
    failures: list[Failure] = []
    with _make_bar(stored_jobs, missing, title) as bar:

        def on_done(job: Job[bytes], result: bytes) -> None:
            store.Save(job.name, missing[job.name].key, result)
            results[job.name] = result
            _advance(bar, job, len(results), len(stored_jobs))

        def on_failure(job: Job[bytes], reason: str) -> None:
            failures.append(Failure(job.name, reason))
            _advance(bar, job, len(results), len(stored_jobs))

        _advance(bar, None, len(results), len(stored_jobs))
        RunJobs(
            [stored.job for stored in missing.values()],
            make_executor,
            ahead=ahead,
            on_done=on_done,
            on_failure=on_failure,
        )
    return results, failures


def _LoadStored(
    stored_jobs: Sequence[StoredJob], store: ResultStore
) -> tuple[dict[str, bytes], dict[str, StoredJob]]:
    """Returns the results that are stored, and the jobs of all others."""
    results: dict[str, bytes] = {}
    missing: dict[str, StoredJob] = {}
    for stored in stored_jobs:
        data = store.Load(stored.job.name, stored.key)
        if data is None:
            missing[stored.job.name] = stored
        else:
            results[stored.job.name] = data
    for note in store.notes:
        tqdm.write(note, file=sys.stderr)
    store.notes.clear()
    return results, missing


def _make_bar(
    stored_jobs: Sequence[StoredJob],
    missing: Mapping[str, StoredJob],
    title: str,
) -> tqdm:
    """Returns a bar that estimates the time left by the jobs' costs."""
    costs = {s.job.name: s.job.cost for s in stored_jobs}
    return tqdm(
        total=sum(costs.values()),
        initial=sum(c for name, c in costs.items() if name not in missing),
        desc=title,
        # By the mean speed so far, as jobs end in bursts.
        smoothing=0,
        bar_format="{desc}: {percentage:3.0f}%|{bar}|{postfix} "
        "[{elapsed}, {remaining} left]",
    )


def _advance(bar: tqdm, job: Job[bytes] | None, done: int, total: int) -> None:
    bar.set_postfix_str(f"{done} of {total}", refresh=job is None)
    if job is not None:
        # Rounding may make the sum of the costs exceed their total.
        bar.update(min(job.cost, bar.total - bar.n))
