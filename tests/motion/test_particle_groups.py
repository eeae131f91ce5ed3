import numpy as np
import pytest

from pbpf_drake.motion.particle_groups import (
    ParticleGroup,
    deal_out,
    group_by_links,
)

# From five particles to three links.
FAR = np.inf
DISTANCES = np.array(
    [
        [FAR, FAR, FAR],
        [FAR, FAR, 0.01],
        [FAR, FAR, FAR],
        [-0.002, FAR, FAR],
        [0.0, FAR, 0.02],
    ]
)


def _as_lists(groups):
    return [(g.link_set, g.members.tolist()) for g in groups]


def test_all_that_any_link_comes_near_get_the_same_links():
    groups = group_by_links(DISTANCES, np.ones(5, dtype=bool))
    assert _as_lists(groups) == [((0, 2), [1, 3, 4]), ((), [0, 2])]


def test_only_links_that_come_near_the_chosen_are_taken():
    groups = group_by_links(DISTANCES, np.array([1, 0, 0, 1, 0], dtype=bool))
    assert _as_lists(groups) == [((0,), [3]), ((), [0])]


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [([], []), ([0, 2], [((), [0, 2])]), ([1], [((2,), [1])])],
)
def test_no_group_is_empty(chosen, expected):
    mask = np.isin(np.arange(5), chosen)
    assert _as_lists(group_by_links(DISTANCES, mask)) == expected


def test_every_particle_is_dealt_to_the_process_of_its_key():
    groups = [
        ParticleGroup((1,), np.array([5, 0, 3])),
        ParticleGroup((), np.array([1, 2, 4])),
    ]
    keys = np.array([7, 0, 3, 1, 0, 4])
    shares = deal_out(groups, keys, 3)
    assert [_as_lists(share) for share in shares] == [
        [((), [1, 2, 4])],
        [((1,), [5, 0, 3])],
        [],
    ]


def test_one_process_gets_all_groups_as_they_are():
    groups = group_by_links(DISTANCES, np.ones(5, dtype=bool))
    (share,) = deal_out(groups, np.arange(5), 1)
    assert _as_lists(share) == _as_lists(groups)
