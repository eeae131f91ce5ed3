import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from recording_fixtures import joint_rows, make_parameters, make_planar_scene

from pbpf_drake.truth.truth_model import MakeTruth, MakeTruthContext

RESTING = ((0.0, [0.0, 0.0, 0.0]), (1.0, [0.0, 0.0, 0.0]))


class _Run:
    """The planar pusher's truth and its block."""

    def __init__(self, scene, **parameters):
        parameters = make_parameters(scene, **parameters)
        self.truth = MakeTruth(scene=scene, parameters=parameters)
        self.context = MakeTruthContext(truth=self.truth, parameters=parameters)
        self.simulator = Simulator(self.truth.diagram, self.context)
        self.plant = self.truth.diagram.plant()
        self.plant_context = self.truth.diagram.mutable_plant_context(
            self.context
        )
        self.block = self.plant.get_body(self.truth.models.objects[0])

    def pose(self):
        return self.block.EvalPoseInWorld(self.plant_context)

    def joints(self) -> np.ndarray:
        rows = joint_rows(self.plant, self.truth.joints)
        return self.plant.GetPositions(self.plant_context)[rows]


def test_what_rests_stays_at_rest():
    run = _Run(make_planar_scene(waypoints=RESTING))
    start = run.pose()
    run.simulator.AdvanceTo(0.5)
    moved = run.pose().translation() - start.translation()
    assert np.linalg.norm(moved[:2]) < 1e-6
    assert abs(moved[2]) < 1e-4
    turned = start.rotation().InvertAndCompose(run.pose().rotation())
    assert turned.ToAngleAxis().angle() < 1e-5


@pytest.mark.parametrize("friction", [0.2, 0.4])
@pytest.mark.parametrize("mass_scale", [1.0, 1.2])
def test_block_slides_as_far_as_coulomb_says(friction, mass_scale):
    run = _Run(
        make_planar_scene(waypoints=RESTING),
        friction=friction,
        mass_scale=mass_scale,
    )
    run.simulator.AdvanceTo(0.1)
    x, speed = run.pose().translation()[0], 0.4
    velocities = run.plant.GetVelocities(run.plant_context)
    first = run.block.floating_velocities_start_in_v()
    velocities[first : first + 6] = [0.0, 0.0, 0.0, speed, 0.0, 0.0]
    run.plant.SetVelocities(run.plant_context, velocities)
    run.simulator.AdvanceTo(0.5)
    distance = run.pose().translation()[0] - x
    assert distance == pytest.approx(speed**2 / (2 * friction * 9.81), rel=0.03)


def test_mass_and_inertia_are_scaled():
    run = _Run(make_planar_scene(), mass_scale=1.2)
    nominal = run.block.default_spatial_inertia().CopyToFullMatrix6()
    actual = run.block.CalcSpatialInertiaInBodyFrame(run.plant_context)
    np.testing.assert_allclose(actual.CopyToFullMatrix6(), 1.2 * nominal)


def test_robot_follows_its_path_but_not_exactly():
    run = _Run(make_planar_scene(duration=0.5))
    errors = []
    for time in np.linspace(0.05, 0.5, 10):
        run.simulator.AdvanceTo(time)
        wanted = run.truth.trajectory.value(time)[:, 0]
        errors.append(np.max(np.abs(run.joints() - wanted)))
    assert 1e-6 < max(errors) < 2e-3


def test_pushed_block_goes_where_the_probe_goes():
    run = _Run(make_planar_scene())
    radius, half_width = 0.004745, 0.045
    run.simulator.AdvanceTo(1.0)
    x, y, _ = run.pose().translation()
    assert x == pytest.approx(run.joints()[0] + radius + half_width, abs=1e-4)
    assert abs(y) < 1e-3


def test_gains_must_match_the_actuators():
    scene = make_planar_scene()
    scene.recording.damping = [1.0, 1.0, 1.0]
    with pytest.raises(ValueError, match="recording.damping has 3 numbers"):
        _Run(scene)
