import logging

from filter_fixtures import PLANAR_SCENE
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.drake_log import EachMessageOnce
from pbpf_drake.scene.prediction_model import MakePredictionModel

# Drake warns of elements that it doesn't know.
WARNED_OF = """<robot name="own">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry>
  </collision></link>
  <joint name="none" type="fixed"><parent link="base"/><child link="top"/>
    <safety_controller k_velocity="1"/></joint>
  <link name="top"/>
</robot>
"""


@pytest.fixture
def messages(caplog):
    """What Drake has said by the time of the call."""
    caplog.set_level(logging.WARNING, logger="drake")
    return lambda: caplog.messages


def test_each_message_passes_once_inside_and_always_outside(messages):
    logger = logging.getLogger("drake")
    for _ in range(2):
        with EachMessageOnce():
            logger.warning("a test: %d", 1)
            logger.warning("a test: %d", 2)
            logger.warning("a test: %d", 1)
        logger.warning("outside")
    assert messages() == ["a test: 1", "a test: 2", "outside", "outside"]


def test_an_error_ends_it_as_well(messages):
    logger = logging.getLogger("drake")
    with pytest.raises(ValueError), EachMessageOnce():
        raise ValueError
    for _ in range(2):
        logger.warning("after an error")
    assert messages() == ["after an error"] * 2


def test_drake_warns_of_a_model_once_however_often_it_is_parsed(
    tmp_path, messages
):
    (tmp_path / "own.urdf").write_text(WARNED_OF)
    add = """
- add_model: {name: own, file: package://scene/own.urdf}
- add_weld: {parent: world, child: own::base}
robot: pusher"""
    path = tmp_path / "scene.yaml"
    path.write_text(PLANAR_SCENE.replace("\nrobot: pusher", add))
    scene = LoadScene(path)
    for _ in range(3):
        MakePredictionModel(scene)
    assert len(messages()) >= 1
    assert all("own.urdf" in m for m in messages())
    assert len(set(messages())) == len(messages())
