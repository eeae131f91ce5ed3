from dataclasses import fields, replace

from pydrake.common.yaml import yaml_load_typed
import pytest

from pbpf_drake.config.particle_filter_config import (
    METHODS,
    AdaptiveCountConfig,
    ParticleFilterConfig,
    PhysicalParametersConfig,
    PoseStddev,
    TruncatedGaussian,
    VisibilityConfig,
)

NAN, INF = float("nan"), float("inf")


def test_defaults_are_the_papers():
    config = ParticleFilterConfig()
    assert (config.num_particles, config.period) == (70, 0.16)
    assert config.process_noise == PoseStddev(position=0.005, rotation=0.05)
    assert config.detection_noise == PoseStddev(position=0.02, rotation=0.09)
    assert config.initial_noise == PoseStddev(position=0.16, rotation=0.43)
    physics = config.physics
    assert (physics.friction.mean, physics.friction.stddev) == (0.1, 0.3)
    assert (physics.mass.mean, physics.mass.stddev) == (0.38, 0.5)
    visibility = VisibilityConfig()
    assert (visibility.high_weight, visibility.low_weight) == (0.75, 0.25)
    assert visibility.high_visibility == 0.95
    assert visibility.low_visibility == 0.5
    assert visibility.penalty == 0.33
    config.ValidateOrThrow()
    visibility.ValidateOrThrow("visibility")
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
    ],
)
def test_a_bad_value_is_named_with_its_field(field, bad):
    config = replace(ParticleFilterConfig(), **{field: bad})
    with pytest.raises(ValueError, match=rf"^{field} is {bad!r}; expected "):
        config.ValidateOrThrow()


@pytest.mark.parametrize(
    "part, bad",
    [
        ("min_particles", 0),
        ("max_divergence", 0.0),
        ("max_divergence", NAN),
        ("confidence", 0.0),
        ("confidence", 1.0),
        ("confidence", NAN),
        ("bin_position", 0.0),
        ("bin_position", INF),
        ("bin_rotation", -0.1),
    ],
)
def test_a_bad_value_of_the_count_is_named_with_its_field(part, bad):
    count = replace(AdaptiveCountConfig(), **{part: bad})
    config = ParticleFilterConfig(adaptive_count=count)
    expected = rf"^adaptive_count\.{part} is {bad!r}; expected "
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()


def test_the_count_does_not_adapt_by_default():
    count = ParticleFilterConfig().adaptive_count
    assert not (count.to_belief or count.to_period)


@pytest.mark.parametrize(
    "field", ["process_noise", "detection_noise", "initial_noise"]
)
@pytest.mark.parametrize("part", ["position", "rotation"])
@pytest.mark.parametrize("bad", [-0.1, NAN, INF])
def test_a_bad_deviation_is_named_with_its_field(field, part, bad):
    stddev = replace(PoseStddev(position=0.1, rotation=0.1), **{part: bad})
    config = replace(ParticleFilterConfig(), **{field: stddev})
    with pytest.raises(ValueError, match=rf"^{field}\.{part} is {bad!r}; exp"):
        config.ValidateOrThrow()


def test_only_detections_need_a_deviation():
    none = PoseStddev()
    config = ParticleFilterConfig(process_noise=none, initial_noise=none)
    config.ValidateOrThrow()
    config = ParticleFilterConfig(detection_noise=none)
    with pytest.raises(ValueError, match="detection_noise.position is 0.0"):
        config.ValidateOrThrow()


@pytest.mark.parametrize("field", ["friction", "mass", "dissipation"])
@pytest.mark.parametrize(
    "part, bad",
    [
        ("mean", NAN),
        ("mean", INF),
        ("stddev", -0.1),
        ("stddev", NAN),
        ("min", 0.0),
        ("min", -1.0),
        ("min", NAN),
    ],
)
def test_a_bad_distribution_is_named_with_its_field(field, part, bad):
    gaussian = replace(
        TruncatedGaussian(mean=1.0, stddev=1.0, min=0.1), **{part: bad}
    )
    physics = replace(PhysicalParametersConfig(), **{field: gaussian})
    config = ParticleFilterConfig(physics=physics)
    expected = rf"^physics\.{field}\.{part} is {bad!r}; expected "
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()


@pytest.mark.parametrize("field", [f.name for f in fields(VisibilityConfig)])
@pytest.mark.parametrize("bad", [-0.1, 1.1, NAN])
def test_a_bad_threshold_is_named_with_its_field(field, bad):
    config = replace(VisibilityConfig(), **{field: bad})
    with pytest.raises(ValueError, match=rf"^here\.{field} is {bad!r}; exp"):
        config.ValidateOrThrow("here")


@pytest.mark.parametrize("field", ["high_weight", "low_weight", "penalty"])
def test_a_factor_of_zero_would_kill_particles_for_good(field):
    with pytest.raises(ValueError, match=rf"{field} is 0\.0; expected in \(0"):
        replace(VisibilityConfig(), **{field: 0.0}).ValidateOrThrow("here")


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
    """How LoadScene words it is a matter of test_scene.py."""
    with pytest.raises(Exception, match=r"num_particle|'fast'|0\.1"):
        yaml_load_typed(schema=ParticleFilterConfig, data=text)
