"""Records and evaluates what a protocol says, as far as it isn't stored."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from pbpf_drake.diagrams.evaluation import (
    Evaluation,
    Result,
    SceneRun,
    evaluate,
    evaluation_code,
    read_result,
    record,
)
from pbpf_drake.diagrams.evaluation_keys import evaluation_key, recording_key
from pbpf_drake.diagrams.job_queue import ExecutorFactory, Failure, Job
from pbpf_drake.diagrams.protocol import (
    Protocol,
    evaluation_cost,
    evaluations,
    recording_cost,
    scene_runs,
)
from pbpf_drake.diagrams.result_store import ResultStore
from pbpf_drake.diagrams.stored_jobs import RunStoredJobs, StoredJob


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
    code = evaluation_code()
    records = [
        StoredJob(
            Job(
                scene_run.name(),
                record,
                partial(_recording, scene_run, code),
                cost=recording_cost(scene_run),
            ),
            recording_key(scene_run),
        )
        for scene_run in scene_runs(protocol)
    ]
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
    data, failed = RunStoredJobs(
        [
            StoredJob(
                Job(
                    name,
                    evaluate,
                    partial(_evaluation, e, logs, code),
                    cost=evaluation_cost(e),
                ),
                evaluation_key(e, logs[e.scene_run.name()]),
            )
            for name, e in todo.items()
        ],
        ResultStore(folder / "evaluations", suffix=".json"),
        make_executor,
        ahead=ahead,
        title="evaluate",
    )
    results = [read_result(e, data[n]) for n, e in todo.items() if n in data]
    return results, failures + failed


def _recording(scene_run: SceneRun, code: str) -> tuple[SceneRun, str]:
    """Returns the arguments of record."""
    return scene_run, code


def _evaluation(
    evaluation: Evaluation, logs: Mapping[str, bytes], code: str
) -> tuple[Evaluation, bytes, str]:
    """Returns the arguments of evaluate; the log is read only then."""
    return evaluation, logs[evaluation.scene_run.name()], code
