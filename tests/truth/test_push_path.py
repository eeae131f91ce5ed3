import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
import pytest
from recording_fixtures import SCENES, joint_rows, make_planar_scene

from pbpf_drake.config.path_config import PathConfig, Waypoint
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.truth.push_path import (
    ActuatedJoints,
    AddMissingActuators,
    MakeJointTrajectory,
    MakeTranslation,
    draw_offsets,
)


def _make_path(*points: tuple[float, list[float]], stddev=0.01) -> PathConfig:
    return PathConfig(
        end_effector="hand",
        waypoints=[Waypoint(time=t, translation=p) for t, p in points],
        stddev=stddev,
    )


def _solve(scene: Scene):
    plant = MultibodyPlant(time_step=1e-3)
    models = AddSceneModels(plant, scene)
    plant.Finalize()
    path = scene.recording.path
    translation = MakeTranslation(path, np.zeros((len(path.waypoints), 3)))
    trajectory = MakeJointTrajectory(
        plant=plant,
        robot=models.robot,
        end_effector=path.end_effector,
        translation=translation,
    )
    rows = joint_rows(plant, ActuatedJoints(plant, models.robot))
    return plant, rows, translation, trajectory


@pytest.fixture(scope="module")
def cheezit():
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    return scene.recording.path, *_solve(scene)


def test_hand_follows_the_path_and_keeps_its_orientation(cheezit):
    path, plant, rows, translation, trajectory = cheezit
    context = plant.CreateDefaultContext()
    hand = plant.GetFrameByName(path.end_effector)
    start = hand.CalcPoseInWorld(context)
    positions = plant.GetPositions(context)
    times = np.random.default_rng(0).uniform(0, trajectory.end_time(), 200)
    for time in [*times, *(w.time for w in path.waypoints)]:
        positions[rows] = trajectory.value(time)[:, 0]
        plant.SetPositions(context, positions)
        X_WE = hand.CalcPoseInWorld(context)
        wanted = start.translation() + translation.value(time)[:, 0]
        assert np.linalg.norm(X_WE.translation() - wanted) < 1e-3
        turn = start.rotation().InvertAndCompose(X_WE.rotation())
        assert turn.ToAngleAxis().angle() < 2e-3


def test_hand_is_at_every_waypoint_of_the_shipped_scene_in_time(cheezit):
    path, _, _, translation, _ = cheezit
    for waypoint in path.waypoints:
        at = translation.value(waypoint.time)[:, 0]
        np.testing.assert_allclose(at, waypoint.translation, atol=1e-12)


def test_joints_start_at_their_defaults_and_rest_at_both_ends(cheezit):
    _, plant, rows, _, trajectory = cheezit
    start = plant.GetPositions(plant.CreateDefaultContext())[rows]
    np.testing.assert_allclose(trajectory.value(0.0)[:, 0], start, atol=1e-4)
    for time in 0.0, trajectory.end_time():
        rate = trajectory.EvalDerivative(time, 1)
        np.testing.assert_allclose(rate, 0.0, atol=1e-9)


def test_joints_stay_within_their_limits(cheezit):
    _, plant, rows, _, trajectory = cheezit
    times = np.linspace(0, trajectory.end_time(), 500)
    q = np.hstack([trajectory.value(time) for time in times]).T
    v = np.hstack([trajectory.EvalDerivative(time, 1) for time in times]).T
    assert np.all(q >= plant.GetPositionLowerLimits()[rows] - 1e-9)
    assert np.all(q <= plant.GetPositionUpperLimits()[rows] + 1e-9)
    assert np.all(np.abs(v) < plant.GetVelocityUpperLimits()[rows])


def test_a_pusher_of_two_joints_moves_as_its_path_says():
    scene = make_planar_scene(
        waypoints=[(0.0, [0, 0, 0]), (1.0, [0.2, 0.1, 0]), (2.0, [0.3, 0, 0])]
    )
    _, _, translation, trajectory = _solve(scene)
    for time in np.linspace(0, 2, 33):
        wanted = [0.15, 0.0] + translation.value(time)[:2, 0]
        got = trajectory.value(time)[:, 0]
        np.testing.assert_allclose(got, wanted, atol=2e-4)


def test_what_can_not_be_reached_is_named():
    scene = make_planar_scene(waypoints=[(0, [0, 0, 0]), (1, [0, 0, 0.1])])
    with pytest.raises(ValueError, match="recording.path at .*pusher_probe"):
        _solve(scene)


def test_an_unknown_end_effector_is_named():
    scene = make_planar_scene()
    scene.recording.path.end_effector = "gripper"
    with pytest.raises(ValueError, match="end_effector is 'gripper'"):
        _solve(scene)


def test_a_joint_without_actuator_is_named():
    plant = MultibodyPlant(time_step=1e-3)
    (robot,) = Parser(plant).AddModelsFromString(
        "<robot name='r'><link name='a'/><link name='b'/>"
        "<joint name='free_wheel' type='continuous'><parent link='a'/>"
        "<child link='b'/><axis xyz='0 0 1'/></joint></robot>",
        "urdf",
    )
    with pytest.raises(ValueError, match="'free_wheel' .* no actuator"):
        ActuatedJoints(plant, robot)


def test_joints_without_actuators_get_them_after_the_others():
    link = "<link name='{}'/>"
    joint = (
        "<joint name='{1}' type='continuous'><parent link='{0}'/>"
        "<child link='{1}'/><axis xyz='0 0 1'/></joint>"
    )
    plant = MultibodyPlant(time_step=1e-3)
    (robot,) = Parser(plant).AddModelsFromString(
        "<robot name='r'>"
        + "".join(link.format(name) for name in "abcd")
        + "".join(joint.format(*pair) for pair in ("ab", "bc", "cd"))
        + "<transmission name='t'><type>SimpleTransmission</type>"
        "<joint name='c'/><actuator name='own'/></transmission></robot>",
        "urdf",
    )
    AddMissingActuators(plant, robot)
    joints = [plant.get_joint(j).name() for j in ActuatedJoints(plant, robot)]
    assert joints == ["c", "b", "d"]


def test_path_does_not_overshoot():
    path = _make_path((0, [0, 0, 0]), (1, [0, 0.1, 0]), (3, [0, 0.1, 0.2]))
    translation = MakeTranslation(path, np.zeros((3, 3)))
    values = np.hstack([translation.value(t) for t in np.linspace(0, 3, 99)])
    assert np.all(values >= -1e-12)
    assert np.all(values <= np.array([[0.0], [0.1], [0.2]]) + 1e-12)


def test_offsets_are_added_to_waypoints():
    path = _make_path((0, [0, 0, 0]), (1, [0.1, 0.2, 0]), (2, [0.3, 0.2, 0]))
    offsets = np.array([[0, 0, 0], [0.01, -0.02, 0], [0.03, 0.04, 0]])
    translation = MakeTranslation(path, offsets)
    np.testing.assert_allclose(translation.value(1.0)[:, 0], [0.11, 0.18, 0])
    np.testing.assert_allclose(translation.value(2.0)[:, 0], [0.33, 0.24, 0])


def test_offsets_are_horizontal_with_the_configured_spread():
    points = [(float(i), [0.1 * i, 0.0, 0.0]) for i in range(2001)]
    offsets = draw_offsets(
        _make_path(*points, stddev=0.01), np.random.default_rng(1)
    )
    assert not offsets[0].any() and not offsets[:, 2].any()
    np.testing.assert_allclose(offsets[1:, :2].std(axis=0), 0.01, rtol=0.1)
    np.testing.assert_allclose(offsets[1:, :2].mean(axis=0), 0, atol=1e-3)


def test_robot_rests_where_a_waypoint_repeats():
    points = [(0, [0, 0, 0]), (1, [0, 0, 0]), (2, [1, 0, 0]), (3, [1, 0, 0])]
    offsets = draw_offsets(_make_path(*points), np.random.default_rng(2))
    assert not offsets[1].any()
    assert offsets[2].any()
    np.testing.assert_array_equal(offsets[2], offsets[3])
