"""PyBullet as a motion model; left out where it isn't installed."""

from importlib.util import find_spec
from xml.etree import ElementTree as xml

import numpy as np
from pydrake.math import RigidTransform
import pytest
from recording_fixtures import SCENES
from sliding_fixtures import GRAVITY, resting_robot, slide

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.benchmark.peer_scene import PeerShape, ReadPeerScene
from pbpf_drake.diagrams.benchmark.pybullet_peer import PyBulletPeer, make_urdf
from pbpf_drake.motion.physical_parameters import PhysicalParameters
from pbpf_drake.scene.prediction_model import MakePredictionModel

needs_pybullet = pytest.mark.skipif(
    find_spec("pybullet") is None,
    reason='needs PyBullet: pip install "pbpf_drake[peers]"',
)


def test_urdf_has_every_shape_with_its_pose():
    X = RigidTransform([0.1, 0.2, 0.3])
    shapes = [
        PeerShape("box", (1.0, 2.0, 3.0), X),
        PeerShape("capsule", (0.1, 0.4), X),
        PeerShape("sphere", (0.2,), X),
    ]
    link = xml.fromstring(make_urdf("thing", shapes, mass=0.5)).find("link")
    assert link.find("inertial/mass").get("value") == "0.5"
    origins = [o.attrib for o in link.findall("collision/origin")]
    assert origins == [{"xyz": "0.1 0.2 0.3", "rpy": "0.0 0.0 0.0"}] * 3
    geometry = [(g[0].tag, g[0].attrib) for g in link.iter("geometry")]
    assert geometry == [
        ("box", {"size": "1.0 2.0 3.0"}),
        ("capsule", {"radius": "0.1", "length": "0.4"}),
        ("sphere", {"radius": "0.2"}),
    ]


@needs_pybullet
def test_an_object_slides_and_particles_keep_their_order():
    """The authors' 14 steps of 1/90 s; friction is the table's times theirs.

    Their rolling friction, which is random, makes it a little slower.
    """
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    model = MakePredictionModel(scene)
    friction, speed, time = np.array([0.05, 0.1, 0.3]), 0.3, 14 / 90
    motion = slide(model, [speed, 0.0, 0.0], 3)
    dut = PyBulletPeer(
        scene=ReadPeerScene(scene),
        joint_names=model.joint_names,
        num_particles=3,
        num_processes=2,
    )
    try:
        dut.Reset(resting_robot(model))
        dut.Prepare(PhysicalParameters(friction[:, None], 0.4, 50.0))
        poses = dut.Update(motion)
    finally:
        dut.Close()
    time = np.minimum(time, speed / (friction * GRAVITY))
    expected = speed * time - friction * GRAVITY * time**2 / 2
    moved = poses[:, 0, 4] - motion.poses[:, 0, 4]
    np.testing.assert_allclose(moved, expected, rtol=0.15)
    norms = np.linalg.norm(poses[..., :4], axis=-1)
    np.testing.assert_allclose(norms, 1.0, atol=1e-6)
