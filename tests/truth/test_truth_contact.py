from dataclasses import replace
from itertools import combinations

from pydrake.systems.analysis import Simulator
import pytest
from recording_fixtures import SCENES, make_parameters, make_planar_scene

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.truth.truth_model import MakeTruth, MakeTruthContext

FRICTION, ROBOT_FRICTION = 0.3, 0.25


@pytest.fixture(scope="module")
def truth_and_context():
    scene = make_planar_scene()
    scene.recording.dissipation = 7.0
    parameters = make_parameters(scene, friction=FRICTION)
    parameters = replace(parameters, robot_friction=ROBOT_FRICTION)
    truth = MakeTruth(scene=scene, parameters=parameters)
    context = MakeTruthContext(truth=truth, parameters=parameters)
    return truth, context


def _properties(truth, name: str):
    """The proximity properties of a body's only collision geometry."""
    plant = truth.diagram.plant()
    body = plant.GetBodyByName(name)
    (geometry,) = plant.GetCollisionGeometriesForBody(body)
    inspector = truth.diagram.scene_graph().model_inspector()
    return inspector.GetProximityProperties(geometry)


def test_contact_is_hydroelastic(truth_and_context):
    truth, context = truth_and_context
    Simulator(truth.diagram, context).AdvanceTo(0.1)
    plant = truth.diagram.plant()
    results = plant.get_contact_results_output_port().Eval(
        truth.diagram.plant_context(context)
    )
    assert results.num_hydroelastic_contacts() == 2  # With table and probe.
    assert results.num_point_pair_contacts() == 0


def test_only_tracked_objects_are_compliant(truth_and_context):
    def modulus(model: str) -> float | None:
        properties = _properties(truth_and_context[0], model)
        name = ("hydroelastic", "hydroelastic_modulus")
        has_one = properties.HasProperty(*name)
        return properties.GetProperty(*name) if has_one else None

    assert modulus("block") == 1e7
    assert modulus("table") is None
    assert modulus("pusher_probe") is None


@pytest.mark.parametrize(
    "name, expected",
    [
        ("block", FRICTION),
        ("table", FRICTION),
        ("pusher_probe", ROBOT_FRICTION),
    ],
)
def test_friction_and_dissipation_are_the_truths(
    truth_and_context, name, expected
):
    properties = _properties(truth_and_context[0], name)
    friction = properties.GetProperty("material", "coulomb_friction")
    assert friction.static_friction() == expected
    assert friction.dynamic_friction() == expected
    dissipation = properties.GetProperty(
        "material", "hunt_crossley_dissipation"
    )
    assert dissipation == 7.0


def test_links_of_the_robot_dont_touch_each_other():
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    truth = MakeTruth(scene=scene, parameters=make_parameters(scene))
    plant = truth.diagram.plant()
    inspector = truth.diagram.scene_graph().model_inspector()
    links, block = (
        [
            geometry
            for body in bodies
            for geometry in plant.GetCollisionGeometriesForBody(
                plant.get_body(body)
            )
        ]
        for bodies in (
            plant.GetBodyIndices(truth.models.robot),
            truth.models.objects,
        )
    )
    for a, b in combinations(links, 2):
        assert inspector.CollisionFiltered(a, b)
    for link in links:
        assert not inspector.CollisionFiltered(link, block[0])
