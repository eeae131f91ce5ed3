"""Synthetic results of evaluations, for tests that need some."""

from collections.abc import Mapping

import numpy as np

from pbpf_drake.diagrams.evaluation import METRICS, Result


def make_result(
    *,
    scene: str = "cheezit_1",
    method: str = "pbpf",
    run: int = 0,
    repeat: int = 0,
    errors: Mapping[str, np.ndarray | float] | float = 0.1,
    names: tuple[str, ...] = ("cracker",),
    num_steps: int = 5,
) -> Result:
    """Returns a result whose errors are constant, or as they are given.

    Args:
        scene, method, run, repeat: of the evaluation.
        errors: by metric; those left out are 0. One number is for all.
        names: of the objects; all have the same errors.
        num_steps: N; updates are at 0.16 s, 0.32 s, …
    """
    given = errors if isinstance(errors, Mapping) else {}
    default = 0.0 if given or not isinstance(errors, float) else errors
    of_object = {
        m: np.broadcast_to(given.get(m, default), num_steps).astype(float)
        for m in METRICS
    }
    return Result(
        scene=scene,
        run=run,
        method=method,
        repeat=repeat,
        times=0.16 * np.arange(1, num_steps + 1),
        errors=dict.fromkeys(names, of_object),
    )
