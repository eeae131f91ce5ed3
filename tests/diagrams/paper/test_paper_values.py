"""The paper's numbers, against what its text says of them."""

import pytest

from pbpf_drake.config.particle_filter_config import METHODS
from pbpf_drake.diagrams.paper.paper_values import (
    METHOD_TITLES,
    OBJECT_TITLES,
    PAPER,
    SCENES,
    paper_methods,
    paper_runs_and_repeats,
)


def _ratio(scene: str, name: str, method: str) -> float:
    mine, dope = (PAPER[scene, name, m] for m in (method, "dope"))
    return mine.pos_mean / dope.pos_mean


def test_every_entry_has_known_names():
    assert {s for s, _, _ in PAPER} == set(SCENES)
    assert {o for _, o, _ in PAPER} == set(OBJECT_TITLES)
    assert {m for _, _, m in PAPER} == set(METHODS) == set(METHOD_TITLES)
    assert len(PAPER) == 4 * 4 + 3 * 4 - 3 + 3 * 2


@pytest.mark.parametrize(
    "scene, name, method, expected",
    [
        ("cheezit_1", "cracker", "pbpf-v", 0.22),
        ("cheezit_2", "cracker", "pbpf-v", 0.20),
        ("cheezit_3", "cracker", "pbpf", 0.37),
        ("cheezit_4", "cracker", "pbpf", 1.06),
        ("soup_1", "soup", "pbpf-v", 0.21),
        ("soup_2", "soup", "pbpf-v", 0.22),
        ("soup_3", "soup", "pbpf", 0.37),
        ("scene_5", "cracker", "pbpf-v", 0.53),
        ("scene_5", "gelatin", "pbpf-v", 0.17),
        ("scene_5", "soup", "pbpf-v", 0.60),
    ],
)
def test_ratios_to_dope_are_the_known_ones(scene, name, method, expected):
    assert _ratio(scene, name, method) == pytest.approx(expected, abs=0.0051)


def test_the_protocol_is_the_papers():
    assert paper_runs_and_repeats("cheezit_4") == (10, 10)
    assert paper_runs_and_repeats("scene_5") == (1, 20)
    assert set(paper_methods("soup_1")) == set(METHODS)
    # With a clear view there is nothing for PBPF-V to do.
    assert set(paper_methods("soup_3")) == {"pbpf", "cvpf", "dope"}
    assert set(paper_methods("scene_5")) == {"pbpf-v", "dope"}
    assert paper_methods("my_scene") == ()
