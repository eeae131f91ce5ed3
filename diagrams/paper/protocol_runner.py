"""Records and evaluates what a protocol says, as far as it isn't stored."""

from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

from pbpf_drake.diagrams.jobs.job_queue import ExecutorFactory, Failure, Job
from pbpf_drake.diagrams.jobs.result_store import ResultStore
from pbpf_drake.diagrams.jobs.scene_digests import ReadSceneFiles, SceneFiles
from pbpf_drake.diagrams.jobs.scene_recording import record, recording_key
from pbpf_drake.diagrams.jobs.stored_jobs import RunStoredJobs, StoredJob
from pbpf_drake.diagrams.paper.evaluation import (
    Evaluation,
    Result,
    evaluate,
    evaluation_key,
    read_result,
)
from pbpf_drake.diagrams.paper.protocol import (
    Protocol,
    evaluation_cost,
    evaluations,
    recording_cost,
    scene_runs,
)


def RunProtocol(
    protocol: Protocol,
    folder: Path,
    make_executor: ExecutorFactory,
    *,
    ahead: int,
) -> tuple[list[Result], list[Failure]]:
    """Records and evaluates what isn't stored in a folder yet.

    Args:
        protocol: what to evaluate.
        folder: holds logs and results.
        make_executor: makes what the jobs run on, any executor in the manner
            of concurrent.futures; see job_queue.
        ahead: how many jobs it is given at a time.

    Raises:
        ValueError, FileNotFoundError: a scene or an option can't be used.
    """
    protocol.ValidateOrThrow()
    files = {scene: ReadSceneFiles(scene) for scene in protocol.scenes}
    run = partial(RunStoredJobs, make_executor=make_executor, ahead=ahead)
    logs, unrecorded = run(
        _recording_jobs(protocol, files),
        ResultStore(folder / "logs", suffix=".mcap"),
        title="record",
    )
    # By name: a method that is asked for twice is evaluated once.
    todo = {
        e.name(): e for e in evaluations(protocol) if e.scene_run.name() in logs
    }
    data, unevaluated = run(
        _evaluation_jobs(todo.values(), logs, files),
        ResultStore(folder / "evaluations", suffix=".json"),
        title="evaluate",
    )
    results = [read_result(e, data[n]) for n, e in todo.items() if n in data]
    return results, unrecorded + unevaluated


def _recording_jobs(
    protocol: Protocol, files: Mapping[str, SceneFiles]
) -> list[StoredJob]:
    jobs = []
    for run in scene_runs(protocol):
        key = recording_key(run, files[run.scene])
        job = Job(run.name(), record, (run, key), recording_cost(run))
        jobs.append(StoredJob(job, key))
    return jobs


def _evaluation_jobs(
    todo: Iterable[Evaluation],
    logs: Mapping[str, bytes],
    files: Mapping[str, SceneFiles],
) -> list[StoredJob]:
    jobs = []
    for e in todo:
        log = logs[e.scene_run.name()]
        key = evaluation_key(e, log, files[e.scene_run.scene])
        job = Job(e.name(), evaluate, (e, log, key), evaluation_cost(e))
        jobs.append(StoredJob(job, key))
    return jobs
