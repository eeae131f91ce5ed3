from dataclasses import replace

from filter_fixtures import (
    BLOCK,
    PERIOD,
    FilterRun,
    detections,
    planar_scene,
    small_config,
    write_blocks_scene,
)
import numpy as np
from pydrake.systems.framework import DiagramBuilder
import pytest

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.filtering.add_particle_filter import (
    AddParticleFilter,
    ConfigForMethod,
    MakeParticleFilter,
)


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


COMMON = ParticleFilterConfig(
    num_particles=33, seed=4, motion="constant_velocity", use_visibility=True
)


@pytest.mark.parametrize(
    "method, changes",
    [
        ("pbpf", {"motion": "physics", "use_visibility": False}),
        ("pbpf-v", {"motion": "physics", "use_visibility": True}),
        (
            "cvpf",
            {
                "motion": "constant_velocity",
                "use_visibility": False,
                "num_particles": 150,
                "recover_lost_tracks": False,
            },
        ),
    ],
)
def test_a_method_sets_its_models_and_keeps_the_rest(method, changes):
    assert ConfigForMethod(COMMON, method) == replace(COMMON, **changes)
    assert COMMON.num_particles == 33


@pytest.mark.parametrize("method", ["dope", "PBPF", ""])
def test_what_is_no_particle_filter_is_refused(method):
    expected = f"method is {method!r}; expected one of .*'pbpf-v'"
    with pytest.raises(ValueError, match=expected):
        ConfigForMethod(COMMON, method)


def test_the_scenes_config_is_the_default(scene):
    scene = replace(scene, filter=small_config(scene, num_particles=9))
    assert MakeParticleFilter(scene=scene).GetOutputPort("weights").size() == 9
    config = small_config(scene, num_particles=3)
    dut = MakeParticleFilter(scene=scene, config=config)
    assert dut.GetOutputPort("weights").size() == 3


def test_ports_have_the_sizes_of_the_scene(tmp_path):
    scene = write_blocks_scene(
        tmp_path, {"one": BLOCK, "two": [0.4, 0.1, 0.0065]}
    )
    dut = MakeParticleFilter(scene=scene, config=small_config(scene))
    assert dut.GetInputPort("joint_positions").size() == 2
    assert dut.GetInputPort("joint_velocities").size() == 2
    sizes = {
        "particles": 8 * 2 * 7,
        "weights": 8,
        "effective_sample_size": 1,
        "covariances": 2 * 36,
        "tracked": 2,
        "detected": 2,
        "update_time": 1,
    }
    for name, size in sizes.items():
        assert dut.GetOutputPort(name).size() == size


def test_the_filter_is_added_under_its_name(scene):
    builder = DiagramBuilder()
    dut = AddParticleFilter(
        builder=builder, scene=scene, config=small_config(scene)
    )
    other = AddParticleFilter(
        builder=builder, scene=scene, config=small_config(scene), name="other"
    )
    assert builder.GetSubsystemByName("particle_filter") is dut
    assert builder.GetSubsystemByName("other") is other


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"num_particles": 0}, "num_particles is 0"),
        ({"motion": "magic"}, "motion is 'magic'"),
        (
            {"detection_noise": PoseStddev(position=0.0, rotation=0.1)},
            "detection_noise.position is 0.0",
        ),
    ],
)
def test_a_config_that_is_out_of_range_is_refused(scene, changes, message):
    with pytest.raises(ValueError, match=message):
        MakeParticleFilter(scene=scene, config=small_config(scene, **changes))


def test_objects_have_their_own_visibility_thresholds(scene):
    """What is in sight but not detected loses weight, or doesn't."""
    sizes = []
    for low in (0.75, 0.01):
        thresholds = VisibilityConfig(high_weight=0.75, low_weight=low)
        block = replace(scene.tracked["block"], visibility=thresholds)
        config = small_config(scene, use_visibility=True, num_particles=20)
        run = FilterRun(replace(scene, tracked={"block": block}), config)
        # Half of the particles are outside the image, which ends at 0.88.
        run.measure(detections(0.1, block=[0.88, 0.0, 0.0065]))
        run.update(1)
        run.measure(detections(0.0, block=[0.88, 0.0, 0.0065]))
        run.update(2)
        assert run["detected"] == [0]
        sizes.append(run["effective_sample_size"][0])
    assert sizes[0] == pytest.approx(20)
    assert sizes[1] < 18


def test_a_filter_without_visibility_does_not_need_a_camera_that_sees(scene):
    config = small_config(scene)
    run = FilterRun(scene, config)
    run.measure(detections(0.1, block=BLOCK))
    run.update(2)
    assert run["update_time"] == pytest.approx([2 * PERIOD])
    np.testing.assert_array_equal(run["weights"], [1 / 8] * 8)
