"""Mimic joints are found in the robot's model."""

import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.model_facts import MimicJoint
from pbpf_drake.scene.mimic_joints import parse_mimic_joints
from pbpf_drake.scene.prediction_model import MakePredictionModel

_LINK = """
<link name="{name}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1"
izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>
<box size="0.1 0.02 0.02"/></geometry></collision></link>"""
_JOINT = """
<joint name="{name}" type="prismatic"><parent link="base"/><child link="{name}"
/><axis xyz="0 1 0"/><limit lower="0" upper="1" effort="1" velocity="1"/>
{mimic}</joint>"""
_HAND = (
    '<robot name="hand"><link name="base"/>'
    + "".join(_LINK.format(name=n) for n in ("f1", "f2"))
    + _JOINT.format(name="f1", mimic="")
    + _JOINT.format(
        name="f2", mimic='<mimic joint="f1" multiplier="-2" offset="0.1"/>'
    )
    + "</robot>"
)
_SCENE = """
directives:
- add_model: {name: hand, file: "package://scene/hand.urdf"}
- add_weld: {parent: world, child: "hand::base"}
- add_model:
    name: box
    file: package://pbpf_drake/cracker/cracker.sdf
    default_free_body_pose: {cracker: {translation: [0.5, 0.2, 0.1]}}
robot: hand
tracked: {box: {}}
"""


def test_the_prediction_model_knows_the_robot_s_mimic_joints(tmp_path):
    (tmp_path / "hand.urdf").write_text(_HAND)
    (tmp_path / "scene.yaml").write_text(_SCENE)
    model = MakePredictionModel(LoadScene(tmp_path / "scene.yaml"))
    assert model.joint_names == ("f1", "f2")
    assert model.facts.mimics == {"f2": MimicJoint("f1", -2.0, 0.1)}
    assert model.facts.nominal["box"].tolist() == [0.5, 0.2, 0.1]


def test_what_urdf_leaves_out_has_its_default():
    text = b'<robot><joint name="b"><mimic joint="a"/></joint></robot>'
    assert parse_mimic_joints(text) == {"b": MimicJoint("a", 1.0, 0.0)}


def test_sdf_has_a_reference_as_well():
    text = b"""<sdf><model><joint name="b"><axis><mimic joint="a">
        <multiplier>2</multiplier><offset>0.5</offset>
        <reference>0.1</reference></mimic></axis></joint></model></sdf>"""
    (found,) = parse_mimic_joints(text).values()
    assert (found.leader, found.multiplier) == ("a", 2.0)
    assert found.offset == pytest.approx(0.3)


def test_a_file_that_is_no_xml_has_none():
    assert parse_mimic_joints(b"v 0 0 0\n") == parse_mimic_joints(b"") == {}


def test_a_number_that_is_none_is_named():
    text = (
        b'<robot><joint name="b"><mimic joint="a" multiplier="${m}"/></joint>'
        b"</robot>"
    )
    with pytest.raises(ValueError, match="joint 'b': mimic's multiplier is"):
        parse_mimic_joints(text)
