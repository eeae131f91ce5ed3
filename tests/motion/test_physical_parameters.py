import numpy as np
from physics_fixtures import (
    FLAT,
    HEIGHTS,
    Simulation,
    make_model,
    make_scene,
)
from pydrake.geometry import ProximityProperties, RoleAssign
from pydrake.multibody.plant import CoulombFriction
import pytest
from scipy.stats import norm

from pbpf_drake.config.distributions import TruncatedGaussian
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.motion.physical_parameters import SamplePhysicalParameters
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.shapes.contact_points import POINT_STIFFNESS, SHAPE_STIFFNESS

NUM_DRAWS = 200_000
# Of the model (in kg m²); see cracker.sdf.
INERTIA_OF_CRACKER = np.array([0.00168776, 0.00100424, 0.00243711])
PARAMETERS = ("friction", "mass", "dissipation")


@pytest.fixture(scope="module")
def draws():
    return SamplePhysicalParameters(
        PhysicalParametersConfig(), (NUM_DRAWS,), np.random.default_rng(0)
    )


@pytest.mark.parametrize("name", PARAMETERS)
def test_draws_are_gaussian_and_raised_to_the_minimum(draws, name):
    x = getattr(draws, name)
    config = getattr(PhysicalParametersConfig(), name)
    gaussian = norm(config.mean, config.stddev)
    share = gaussian.cdf(config.min)
    assert x.min() >= config.min
    assert np.mean(x == config.min) == pytest.approx(
        share, abs=4 * np.sqrt(share * (1 - share) / NUM_DRAWS) + 1e-9
    )
    # The mean of max(X, min) in closed form.
    expected = (
        config.min * share
        + config.mean * (1 - share)
        + config.stddev**2 * gaussian.pdf(config.min)
    )
    tolerance = 4 * config.stddev / np.sqrt(NUM_DRAWS)
    assert x.mean() == pytest.approx(expected, abs=tolerance)
    for level in config.mean, config.mean + config.stddev:
        assert np.mean(x > level) == pytest.approx(gaussian.sf(level), abs=5e-3)


def test_friction_mass_and_dissipation_are_independent(draws):
    x = np.array([getattr(draws, name) for name in PARAMETERS])
    np.testing.assert_allclose(np.corrcoef(x), np.eye(3), atol=0.01)


def test_draws_have_the_shape_and_repeat_with_the_generator():
    config = PhysicalParametersConfig(
        mass=TruncatedGaussian(mean=2.0, stddev=0.0, min=0.1)
    )
    first, second = (
        SamplePhysicalParameters(config, (70, 3), np.random.default_rng(1))
        for _ in range(2)
    )
    for name in PARAMETERS:
        assert getattr(first, name).shape == (70, 3)
        np.testing.assert_array_equal(
            getattr(first, name), getattr(second, name)
        )
    np.testing.assert_array_equal(first.mass, np.full((70, 3), 2.0))


def _bake(model, *, friction: float, mass: float, dissipation: float) -> None:
    """Writes the contact of all objects into the model, not a context."""
    scene_graph = model.diagram.scene_graph()
    inspector = scene_graph.model_inspector()
    for geometry in model.owners:
        point = inspector.GetName(geometry).split("_")[-1] not in "09"
        stiffness = POINT_STIFFNESS if point else SHAPE_STIFFNESS
        properties = ProximityProperties(
            inspector.GetProximityProperties(geometry)
        )
        properties.UpdateProperty(
            "material",
            "coulomb_friction",
            CoulombFriction(friction / 2, friction / 2),
        )
        properties.UpdateProperty(
            "material", "hunt_crossley_dissipation", dissipation
        )
        properties.UpdateProperty(
            "material", "point_contact_stiffness", stiffness * mass
        )
        scene_graph.AssignRole(
            model.diagram.plant().get_source_id(),
            geometry,
            properties,
            RoleAssign.kReplace,
        )


def _write_heavier(folder, factor: float) -> None:
    """The cracker box with another mass, and an inertia that fits."""
    text = (data_folder("models") / "cracker" / "cracker.sdf").read_text()
    for name in ("mass", "ixx", "iyy", "izz"):
        head, value = text.split(f"<{name}>")
        value, tail = value.split(f"</{name}>")
        text = f"{head}<{name}>{factor * float(value)!r}</{name}>{tail}"
    (folder / "heavier.sdf").write_text(text)


def _push(simulation: Simulation) -> np.ndarray:
    """Pushes a box off its centre; returns what it does, (n, 13)."""
    simulation.set_velocity(np.zeros(6))
    simulation.set_robot([-0.5, 0.0], [0.0, 0.0])
    simulation.settle(FLAT, [0.0, 0.0, HEIGHTS["cracker"]])
    simulation.set_robot([-0.09, 0.03], [0.1, 0.02])
    trajectory = []
    for _ in range(30):
        simulation.advance(0.02)
        trajectory.append([*simulation.pose(), *simulation.velocity()])
    return np.array(trajectory)


def _difference(a: np.ndarray, b: np.ndarray) -> float:
    return np.max(np.abs(a - b))


class _Baked(Simulation):
    """Has θ in its model, and leaves the context alone."""

    def set_parameters(self, k, **parameters) -> None:
        _bake(self.contact, **parameters)
        # A context is made with what the model has then.
        self.context.SetTimeStateAndParametersFrom(
            self.contact.diagram.CreateDefaultContext()
        )


@pytest.fixture(scope="module")
def model():
    return make_model("cracker")


def test_friction_and_dissipation_are_as_if_baked_into_the_model(model):
    parameters = {"friction": 0.23, "mass": 0.411, "dissipation": 70.0}
    baked = _push(_Baked(model, **parameters))
    given = _push(Simulation(model, **parameters))
    np.testing.assert_array_equal(given, baked)
    parameters["friction"] = 0.3
    assert _difference(_push(Simulation(model, **parameters)), baked) > 1e-4


@pytest.mark.parametrize("factor", [0.5, 1.7, 3.0])
def test_mass_and_inertia_are_as_if_baked_into_the_model(
    model, tmp_path, factor
):
    _write_heavier(tmp_path, factor)
    scene = make_scene(
        {"cracker": "package://scene/heavier.sdf"}, folder=str(tmp_path)
    )
    parameters = {"friction": 0.3, "mass": factor * 0.411, "dissipation": 100.0}
    baked = _Baked(MakePredictionModel(scene), **parameters)
    given = Simulation(model, **parameters)
    assert _difference(_push(given), _push(baked)) < 1e-12
    for simulation in given, baked:
        inertia = simulation.plant.get_body(
            simulation.contact.objects[0]
        ).CalcSpatialInertiaInBodyFrame(simulation.plant_context)
        assert inertia.get_mass() == pytest.approx(factor * 0.411)
        np.testing.assert_allclose(
            inertia.CalcRotationalInertia().get_moments(),
            factor * INERTIA_OF_CRACKER,
        )


def test_a_context_with_other_parameters_is_not_touched(model):
    first = Simulation(model, friction=0.2)
    alone = _push(first)
    Simulation(model, friction=0.9, mass=2.0)
    np.testing.assert_array_equal(_push(first), alone)


def test_whole_numbers_are_numbers(model):
    given = _push(Simulation(model, friction=1, mass=1, dissipation=100))
    expected = _push(Simulation(model, friction=1.0, mass=1.0))
    np.testing.assert_array_equal(given, expected)
