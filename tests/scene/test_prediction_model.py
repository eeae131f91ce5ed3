import numpy as np
from physics_fixtures import make_model
from recording_fixtures import SCENES

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import MakePredictionModel

UPRIGHT = quaternions.from_rotation_vector(
    np.deg2rad(120.0) * np.array([-1, -1, -1]) / np.sqrt(3)
)


def test_nominal_poses_are_the_scenes():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    (pose,) = model.nominal_poses
    np.testing.assert_allclose(pose[4:], [0.4, 0.0868, 0.08])
    assert quaternions.angle_between(pose[:4], UPRIGHT) < 1e-9


def test_joint_names_are_in_the_order_of_the_positions():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    plant, names = model.diagram.plant(), model.joint_names
    assert names[:2] == ("panda_joint1", "panda_joint2")
    assert len(names) == len(model.robot_q) == 9
    for name, row in zip(names, model.robot_q, strict=True):
        assert plant.GetJointByName(name).position_start() == row


def test_links_are_what_can_touch():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    plant = model.diagram.plant()
    names = [plant.get_body(link).name() for link in model.links]
    # The flange, link 8, has no shape.
    arm = [f"panda_link{i}" for i in range(8)]
    hand = ["panda_hand", "panda_leftfinger", "panda_rightfinger"]
    assert names == arm + hand
    block = make_model("block")
    (probe,) = block.links
    assert block.diagram.plant().get_body(probe).name() == "pusher_probe"
    assert len(block.geometries(probe)) == 1
