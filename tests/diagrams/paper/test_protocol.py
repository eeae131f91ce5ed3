from collections import Counter
from dataclasses import replace

import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.jobs.scene_run import SceneRun
from pbpf_drake.diagrams.paper.evaluation import Evaluation, evaluation_config
from pbpf_drake.diagrams.paper.paper_values import SCENES
from pbpf_drake.diagrams.paper.protocol import (
    Protocol,
    evaluation_cost,
    evaluations,
    recording_cost,
    scene_runs,
)
from pbpf_drake.scene.scene_models import data_folder

FOLDER = data_folder("diagrams") / "scenes"


def test_by_default_it_is_the_papers():
    dut = Protocol(scenes=SCENES)
    assert len(scene_runs(dut)) == 71  # As Section 6 counts them.
    count = Counter(
        (e.scene_run.scene, e.scene_run.run, e.method) for e in evaluations(dut)
    )
    assert count["cheezit_1", 9, "pbpf-v"] == count["soup_3", 0, "cvpf"] == 10
    assert count["scene_5", 0, "pbpf-v"] == 20
    # Nothing in it is random.
    assert count["cheezit_1", 0, "dope"] == 1
    assert ("cheezit_4", 0, "pbpf-v") not in count
    assert ("scene_5", 0, "pbpf") not in count


def test_options_hold_for_all_scenes():
    dut = Protocol(
        scenes=["cheezit_4", "scene_5"], methods=["pbpf-v"], runs=2, repeats=3
    )
    found = evaluations(dut)
    assert len(found) == 2 * 2 * 3
    assert {e.method for e in found} == {"pbpf-v"}
    assert len({e.name() for e in found}) == len(found)


def test_a_scene_of_ones_own_is_evaluated_with_every_method():
    found = evaluations(Protocol(scenes=["my/scene.yaml"], runs=1, repeats=1))
    assert [e.method for e in found] == ["pbpf", "pbpf-v", "cvpf", "dope"]
    assert found[0].scene_run.name() == "scene-run_0"


@pytest.mark.parametrize(
    "change, said",
    [
        ({"runs": 0}, "--runs is 0; expected"),
        ({"repeats": 1001}, "--repeats is 1001; expected"),
        ({"particles": -1}, "--particles is -1; expected"),
        ({"duration": 0.0}, "--duration is 0; expected"),
        ({"duration": float("nan")}, "--duration is nan; expected"),
        ({"scenes": ["my/soup_1.yaml"]}, "called as the paper's scene soup_1"),
        ({"scenes": ["a/x.yaml", "b/x.yaml"]}, "--scenes has two .*'x', 'x'"),
    ],
)
def test_what_cannot_be_done_is_said(change, said):
    dut = replace(Protocol(scenes=["cheezit_1"]), **change)
    with pytest.raises(ValueError, match=said):
        dut.ValidateOrThrow()


def test_no_two_evaluations_of_a_method_have_the_same_seed():
    scene = LoadScene(FOLDER / "cheezit_1.yaml")
    found = evaluations(Protocol(scenes=["cheezit_1"], methods=["pbpf"]))
    seeds = {evaluation_config(e, scene).seed for e in found}
    assert len(seeds) == len(found) == 100


def test_the_filters_are_the_scenes_with_one_thread():
    scene = LoadScene(FOLDER / "cheezit_gelatin_soup.yaml")
    scene.filter.parallelism = 4

    def config(method: str, particles: int | None = None):
        run = SceneRun("cheezit_gelatin_soup", 0)
        return evaluation_config(Evaluation(run, method, 0, particles), scene)

    assert config("pbpf-v").num_particles == 150
    assert config("pbpf-v").use_visibility
    assert config("cvpf").motion == "constant_velocity"
    assert config("cvpf", 7).num_particles == 7
    assert config("pbpf").parallelism == 1


def test_costs_grow_with_the_work():
    def cost(method: str, scene: str = "cheezit_1", **options) -> float:
        run = SceneRun(scene, 0, options.pop("duration", None))
        return evaluation_cost(Evaluation(run, method, 0, **options))

    assert cost("dope") < cost("cvpf") < cost("pbpf") == cost("pbpf-v")
    assert cost("pbpf", duration=5.0) < cost("pbpf")
    assert cost("pbpf", particles=10) < cost("pbpf")
    assert cost("pbpf") < cost("pbpf", "cheezit_gelatin_soup")
    assert recording_cost(SceneRun("cheezit_1", 0)) == 28.0
    assert recording_cost(SceneRun("cheezit_1", 0, 2.0)) == 2.0
