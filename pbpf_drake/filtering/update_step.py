"""What one update of the filter is about, and what follows from that."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.filtering.filter_state import FilterState, StampedPose
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.random_streams import MakeGenerator, Stream


@dataclass(frozen=True)
class UpdateStep:
    """One update: when, what the robot did, and what the detector saw.

    Attributes:
        number: count of updates, with this one.
        seed: the filter's. Randomness is a function of number and seed.
        path: u_t, what the robot did since the last update.
        detections: DOPE(z_t): by object index, the detections that no update
            has used yet, the latest last; no empty ones. They may be older
            than the path.
        active: (K,) whether an object was tracked before this update.
        known: (K,) whether it is active, or detected now. The particles of
            all other objects mean nothing.
    """

    number: int
    seed: int
    path: ControlPath
    detections: Mapping[int, Sequence[StampedPose]]
    active: np.ndarray
    known: np.ndarray

    def MakeGenerator(self, stream: Stream) -> np.random.Generator:
        """Returns the random numbers of this update for one purpose."""
        return MakeGenerator(seed=self.seed, step=self.number, stream=stream)


def make_update_step(
    state: FilterState,
    *,
    seed: int,
    path: ControlPath,
    detections: Mapping[int, Sequence[StampedPose]],
) -> UpdateStep:
    """Returns the step that follows a state.

    Args:
        state: the state after the last update.
        seed: the filter's.
        path: u_t, what the robot did since then.
        detections: those that no update has used yet; see UpdateStep.
    """
    active = state.num_estimates > 0
    return UpdateStep(
        number=int(state.step[0]) + 1,
        seed=seed,
        path=path,
        detections=detections,
        active=active,
        known=active | index_mask(detections, len(active)),
    )


def index_mask(indices: Mapping[int, object], length: int) -> np.ndarray:
    """Returns (length,) True at the keys of a mapping."""
    mask = np.zeros(length, dtype=bool)
    mask[list(indices)] = True
    return mask
