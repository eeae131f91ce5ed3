"""Arrays of any shape in the discrete state of a Drake system."""

from collections.abc import Callable, Mapping

import numpy as np
from pydrake.systems.framework import (
    DiscreteStateIndex,
    DiscreteValues,
)


class DiscreteArrays:
    """Named arrays, each of which is one group of a system's discrete state.

    Args:
        declare: the system's DeclareDiscreteState.
        initial: their values in a default context, which give their shapes.
    """

    def __init__(
        self,
        declare: Callable[[np.ndarray], DiscreteStateIndex],
        initial: Mapping[str, np.ndarray],
    ) -> None:
        self._shapes = {name: np.shape(x) for name, x in initial.items()}
        self._indices = {
            name: declare(np.ravel(x)) for name, x in initial.items()
        }

    def index(self, name: str) -> DiscreteStateIndex:
        """Returns the group that an array is in."""
        return self._indices[name]

    def Read(self, values: DiscreteValues, name: str) -> np.ndarray:
        """Returns an array; a view, which must not be written to."""
        value = values.value(self._indices[name])
        return value.reshape(self._shapes[name])

    def Write(
        self, values: DiscreteValues, name: str, array: np.ndarray
    ) -> None:
        """Writes an array of the same shape."""
        values.get_mutable_value(self._indices[name])[:] = np.ravel(array)
