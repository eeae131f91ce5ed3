"""All that a filter remembers, in the discrete state of its system."""

from collections.abc import Callable
from dataclasses import fields
import math

import numpy as np
from pydrake.systems.framework import (
    Context,
    DiscreteStateIndex,
    DiscreteValues,
)

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.filtering.discrete_arrays import DiscreteArrays
from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState
from pbpf_drake.filtering.joint_samples import make_empty_rows
from pbpf_drake.filtering.recent_detections import (
    RecentDetections,
    make_no_detections,
)

# More updates are not remembered (2 s of 30 updates per second).
_LONGEST_HISTORY = 60
_SAMPLES = "joint_samples"
_UPDATE_TIME = "update_time"


class FilterMemory:
    """The state of the algorithm, and the inputs since the last update.

    Args:
        declare: the system's DeclareDiscreteState.
        config: the filter's.
        nominal_poses: (K, 7) the objects' before they are detected.
        num_joints: n.
    """

    def __init__(
        self,
        declare: Callable[[np.ndarray], DiscreteStateIndex],
        *,
        config: ParticleFilterConfig,
        nominal_poses: np.ndarray,
        num_joints: int,
    ) -> None:
        state = MakeInitialState(
            config.num_particles, nominal_poses, history_length(config)
        )
        num_rows = config.control_samples + 1
        detections = make_no_detections(len(nominal_poses), num_rows)
        self._arrays = DiscreteArrays(
            declare,
            {
                **vars(state),
                _SAMPLES: make_empty_rows(num_rows, num_joints),
                **vars(detections),
                _UPDATE_TIME: np.array([-1.0]),
            },
        )

    def index(self, name: str) -> DiscreteStateIndex:
        """Returns the group of a field of FilterState or RecentDetections.

        Also of the ``update_time``.
        """
        return self._arrays.index(name)

    def State(self, context: Context) -> FilterState:
        """Returns the state of the algorithm after the last update."""
        values = context.get_discrete_state()
        return FilterState(**self._Fields(values, FilterState))

    def WriteState(self, values: DiscreteValues, state: FilterState) -> None:
        """Writes the state of the algorithm."""
        self._WriteFields(values, state)

    def Samples(self, values: DiscreteValues) -> np.ndarray:
        """Returns the samples of the joints; see joint_samples."""
        return self._arrays.Read(values, _SAMPLES)

    def WriteSamples(self, values: DiscreteValues, samples: np.ndarray) -> None:
        """Writes the samples of the joints."""
        self._arrays.Write(values, _SAMPLES, samples)

    def Detections(self, values: DiscreteValues) -> RecentDetections:
        """Returns the detections since the last update, and before it."""
        return RecentDetections(**self._Fields(values, RecentDetections))

    def WriteDetections(
        self, values: DiscreteValues, detections: RecentDetections
    ) -> None:
        """Writes the detections."""
        self._WriteFields(values, detections)

    def UpdateTime(self, values: DiscreteValues) -> float:
        """Returns when the last update was (in seconds), or -1."""
        return float(self._arrays.Read(values, _UPDATE_TIME)[0])

    def WriteUpdateTime(self, values: DiscreteValues, time: float) -> None:
        """Writes when the last update was (in seconds)."""
        self._arrays.Write(values, _UPDATE_TIME, np.array([time]))

    def _Fields(
        self, values: DiscreteValues, kind: type
    ) -> dict[str, np.ndarray]:
        return {
            field.name: self._arrays.Read(values, field.name)
            for field in fields(kind)
        }

    def _WriteFields(
        self, values: DiscreteValues, record: FilterState | RecentDetections
    ) -> None:
        for name, array in vars(record).items():
            self._arrays.Write(values, name, array)


def history_length(config: ParticleFilterConfig) -> int:
    """Returns how many earlier updates are remembered for late detections.

    An update itself knows where its particles were one period ago. What is
    older than all that is remembered weighs the oldest.
    """
    periods = config.max_detection_age / config.period
    return min(max(0, math.ceil(periods - 1 - 1e-9)), _LONGEST_HISTORY)
