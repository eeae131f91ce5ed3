"""Records and evaluates what a protocol says, as far as it isn't stored."""

from pathlib import Path

from pbpf_drake.diagrams.jobs.job_queue import ExecutorFactory, Failure, Job
from pbpf_drake.diagrams.jobs.result_store import ResultStore
from pbpf_drake.diagrams.jobs.scene_digests import ReadSceneFiles
from pbpf_drake.diagrams.jobs.scene_recording import record, recording_key
from pbpf_drake.diagrams.jobs.stored_jobs import RunStoredJobs, StoredJob
from pbpf_drake.diagrams.paper.evaluation import (
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
    records = []
    for scene_run in scene_runs(protocol):
        key = recording_key(scene_run, files[scene_run.scene])
        cost = recording_cost(scene_run)
        job = Job(scene_run.name(), record, (scene_run, key), cost)
        records.append(StoredJob(job, key))
    logs, failures = RunStoredJobs(
        records,
        ResultStore(folder / "logs", suffix=".mcap"),
        make_executor,
        ahead=ahead,
        title="record",
    )
    todo = {
        e.name(): e for e in evaluations(protocol) if e.scene_run.name() in logs
    }
    jobs = []
    for name, e in todo.items():
        log = logs[e.scene_run.name()]
        key = evaluation_key(e, log, files[e.scene_run.scene])
        job = Job(name, evaluate, (e, log, key), evaluation_cost(e))
        jobs.append(StoredJob(job, key))
    data, failed = RunStoredJobs(
        jobs,
        ResultStore(folder / "evaluations", suffix=".json"),
        make_executor,
        ahead=ahead,
        title="evaluate",
    )
    results = [read_result(e, data[n]) for n, e in todo.items() if n in data]
    return results, failures + failed
