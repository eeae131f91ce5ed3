"""Connects systems by the names of their ports."""

from collections.abc import Mapping

from pydrake.systems.framework import DiagramBuilder, OutputPort, System


def ConnectByName(
    *,
    builder: DiagramBuilder,
    sources: Mapping[str, OutputPort],
    target: System,
) -> None:
    """Connects outputs to those inputs of a system that have their names.

    A source whose name the system has no input for is left out, so that the
    same sources fit systems that need more or less of them.

    Args:
        builder: the systems were added to it.
        sources: output ports by the names of inputs.
        target: has the inputs; none of them is connected yet.
    """
    for name, port in sources.items():
        if target.HasInputPort(name):
            builder.Connect(port, target.GetInputPort(name))
