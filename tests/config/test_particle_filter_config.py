from dataclasses import replace
import re

from pydrake.common.yaml import yaml_load_typed
import pytest

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.particle_filter_config import (
    METHODS,
    ParticleFilterConfig,
)

NAN, INF = float("nan"), float("inf")


def test_defaults_are_the_papers():
    config = ParticleFilterConfig()
    assert (config.num_particles, config.period) == (70, 0.16)
    assert config.process_noise == PoseStddev(position=0.005, rotation=0.05)
    assert config.detection_noise == PoseStddev(position=0.02, rotation=0.09)
    assert config.initial_noise == PoseStddev(position=0.16, rotation=0.43)
    config.ValidateOrThrow()
    assert METHODS == ("pbpf", "pbpf-v", "cvpf", "dope")


@pytest.mark.parametrize(
    "field, bad",
    [
        ("num_particles", 0),
        ("num_particles", -3),
        ("control_samples", 0),
        ("num_rays", 0),
        ("period", 0.0),
        ("period", -0.16),
        ("period", NAN),
        ("period", INF),
        ("max_detection_age", 0.0),
        ("max_detection_age", NAN),
        ("max_speed", 0.0),
        ("max_speed", INF),
        ("time_step", 0.0),
        ("time_step", NAN),
        ("motion", "magic"),
        ("motion", ""),
        ("seed", -1),
        ("parallelism", 0),
        # What would take gigabytes or hours.
        ("num_particles", 10**9),
        ("num_particles", 10**400),
        ("num_rays", 10**9),
        ("control_samples", 10**9),
        ("parallelism", 10**9),
        ("seed", 10**30),
        ("time_step", 1e-12),
        ("max_travel", 1e-12),
        ("max_travel", NAN),
        ("period", 1e200),
        ("period", 1e-12),
        ("max_detection_age", 1e200),
        ("max_speed", 1e200),
    ],
)
def test_a_bad_value_is_named_with_its_field(field, bad):
    config = replace(ParticleFilterConfig(), **{field: bad})
    shown = re.escape(repr(bad)[:60])
    with pytest.raises(ValueError, match=rf"^{field} is {shown}…?; expected "):
        config.ValidateOrThrow()


@pytest.mark.parametrize(
    "field", ["process_noise", "detection_noise", "initial_noise"]
)
@pytest.mark.parametrize("part", ["position", "rotation"])
@pytest.mark.parametrize("bad", [-0.1, NAN, INF, 1e200])
def test_a_bad_deviation_is_named_with_its_field(field, part, bad):
    stddev = replace(PoseStddev(position=0.1, rotation=0.1), **{part: bad})
    config = replace(ParticleFilterConfig(), **{field: stddev})
    with pytest.raises(ValueError, match=rf"^{field}\.{part} is .*; expected"):
        config.ValidateOrThrow()


def test_rays_of_all_particles_are_limited():
    config = ParticleFilterConfig(num_particles=10_000, num_rays=1_000)
    config.ValidateOrThrow()
    config = replace(config, num_rays=1_001)
    expected = "num_rays is 1001; expected at most 1,000 with .* 10,000"
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()


def test_only_detections_need_a_deviation():
    none = PoseStddev()
    config = ParticleFilterConfig(process_noise=none, initial_noise=none)
    config.ValidateOrThrow()
    config = ParticleFilterConfig(detection_noise=none)
    with pytest.raises(ValueError, match="detection_noise.position is 0.0"):
        config.ValidateOrThrow()


def test_defaults_stay_where_a_file_says_nothing():
    config = yaml_load_typed(
        schema=ParticleFilterConfig,
        data="{num_particles: 10, process_noise: {position: 0.001}}",
    )
    assert config == replace(
        ParticleFilterConfig(),
        num_particles=10,
        process_noise=PoseStddev(position=0.001, rotation=0.05),
    )


@pytest.mark.parametrize(
    "text",
    [
        "{num_particle: 10}",
        "{num_particles: 1.5}",
        "{period: fast}",
        "{process_noise: 0.1}",
    ],
)
def test_what_does_not_fit_the_schema_is_refused(text):
    """How LoadScene words it is a matter of test_scene_config.py."""
    with pytest.raises(Exception, match=r"num_particle|'fast'|0\.1"):
        yaml_load_typed(schema=ParticleFilterConfig, data=text)
