"""Reads the authors' traces of their real detector.

A trace holds the errors of the last detection at every update of one run. It is
in two files, cracker_scene<N>_early_DOPE_pos_<repeat>.csv and the same with
_ang_, of the columns step, time [s], error [m or rad], name, without a header.
"""

from pathlib import Path

import numpy as np


def ReadTrace(folder: Path, scene: str) -> np.ndarray | None:
    """Returns a real run's errors, (N, 2) [m, rad], if there is a trace."""
    name = f"cracker_scene{scene.removeprefix('cheezit_')}_early_DOPE"
    files = [sorted(folder.glob(f"{name}_{k}_*.csv")) for k in ("pos", "ang")]
    if not all(files):
        return None
    # All repeats of a scene are of the same recording.
    position, angle = (
        np.loadtxt(found[-1], delimiter=",", usecols=(1, 2)) for found in files
    )
    nearest = np.abs(position[:, :1] - angle[:, 0]).argmin(axis=1)
    return np.column_stack([position[:, 1], angle[nearest, 1]])
