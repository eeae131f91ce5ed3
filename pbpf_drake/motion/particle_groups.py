"""Which particles are simulated with which links, and by which process."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.motion.robot_links import LinkSet


@dataclass(frozen=True)
class ParticleGroup:
    """Particles that are simulated with the same links.

    Attributes:
        link_set: the links.
        members: (m,) the indices of the particles.
    """

    link_set: LinkSet
    members: np.ndarray


def group_by_links(
    distances: np.ndarray, chosen: np.ndarray
) -> list[ParticleGroup]:
    """Returns the particles that any link comes near, and then the others.

    The first group has all links that come near any of its particles. To have
    a group for each set of links would take M more contexts for each.

    Args:
        distances: (M, L) from link_distances.
        chosen: (M,) which particles are to be in a group.

    Returns:
        At most two groups, none of them empty.
    """
    near = np.isfinite(distances) & chosen[:, None]
    link_set = tuple(int(j) for j in np.flatnonzero(near.any(axis=0)))
    reached = near.any(axis=1)
    return [
        ParticleGroup(links, np.flatnonzero(members))
        for links, members in ((link_set, reached), ((), chosen & ~reached))
        if members.any()
    ]


def deal_out(
    groups: Sequence[ParticleGroup], keys: np.ndarray, num_processes: int
) -> list[list[ParticleGroup]]:
    """Returns the part of each group that each process works on.

    Args:
        groups: what to divide.
        keys: (M,) whole numbers; particles with the same key go to the same
            process.
        num_processes: how many processes there are.

    Returns:
        The groups of each process, none of them empty.
    """
    process = keys % num_processes
    return [
        [
            ParticleGroup(group.link_set, group.members[mine])
            for group in groups
            if (mine := process[group.members] == i).any()
        ]
        for i in range(num_processes)
    ]
