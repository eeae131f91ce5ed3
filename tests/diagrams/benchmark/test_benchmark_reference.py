from dataclasses import replace

import numpy as np
import pytest
from recording_fixtures import SCENES
from sliding_fixtures import GRAVITY, slide

from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.benchmark.benchmark_reference import (
    PredictReference,
    PredictSamples,
    Sample,
    compare_predictions,
    make_samples,
    pushed_share,
)
from pbpf_drake.motion.motion_model import MotionResult
from pbpf_drake.motion.physical_parameters import (
    PhysicalParameters,
    SamplePhysicalParameters,
)
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import MakePredictionModel

FRICTION, SPEED = 0.3, 0.3


@pytest.fixture(scope="module")
def scene():
    return LoadScene(SCENES / "cheezit_1.yaml")


@pytest.fixture(scope="module")
def motion(scene):
    return slide(MakePredictionModel(scene), [SPEED, 0.0, 0.0], 3)


def test_samples_are_spread_over_updates_and_parameters(motion):
    motions = [replace(motion, step=i) for i in range(40)]
    config = PhysicalParametersConfig()
    samples = make_samples(motions, config, 20)
    assert [s.update for s in samples] == list(range(1, 40, 2))
    assert [s.motion.step for s in samples] == list(range(1, 40, 2))
    many = SamplePhysicalParameters(
        config, (100_000,), np.random.default_rng(1)
    )
    for name in ("friction", "mass", "dissipation"):
        found = np.sort([getattr(s.parameters, name) for s in samples])
        drawn = np.quantile(getattr(many, name), (np.arange(20) + 0.5) / 20)
        np.testing.assert_allclose(found, drawn, rtol=0.02, atol=0.005)


def test_there_are_no_more_samples_than_updates(motion):
    config = PhysicalParametersConfig()
    assert len(make_samples([motion] * 3, config, 10)) == 3


def test_draws_are_not_below_their_minima():
    config = PhysicalParametersConfig()
    drawn = SamplePhysicalParameters(config, (50, 3), np.random.default_rng(0))
    for name in ("friction", "mass", "dissipation"):
        values = getattr(drawn, name)
        assert values.shape == (50, 3)
        assert np.min(values) == getattr(config, name).min or np.all(
            values > getattr(config, name).min
        )
        assert len(np.unique(values)) > 50


def test_a_sliding_object_is_slowed_by_the_friction_of_its_sample(
    scene, motion
):
    """v²/2μg until it rests, or vt - μgt²/2."""
    model = MakePredictionModel(scene)
    frictions = (FRICTION, FRICTION / 2)
    samples = [
        Sample(0, motion, PhysicalParameters(friction, 0.4, 50.0))
        for friction in frictions
    ]
    results = PredictReference(
        model=model, config=scene.filter, samples=samples
    )
    for result, friction in zip(results, frictions, strict=True):
        time = min(0.16, SPEED / (friction * GRAVITY))
        expected = SPEED * time - friction * GRAVITY * time**2 / 2
        moved = result.poses[:, 0, 4] - motion.poses[:, 0, 4]
        np.testing.assert_allclose(moved, expected, rtol=0.02)


def test_the_filters_own_step_comes_near_the_reference(scene, motion):
    model = MakePredictionModel(scene)
    samples = [Sample(0, motion, PhysicalParameters(FRICTION, 0.4, 50.0))]
    arguments = {"model": model, "config": scene.filter, "samples": samples}
    references = list(PredictReference(**arguments))
    poses = [result.poses for result in PredictSamples(**arguments)]
    errors = compare_predictions(poses, references)
    assert 0 < np.max(errors.position) < 2e-3
    assert np.max(errors.rotation) < 0.02


def _result(poses: np.ndarray, failed: list[bool]) -> MotionResult:
    shape = poses.shape[:2]
    return MotionResult(
        poses, np.zeros((*shape, 6)), np.zeros((*shape, 3)), np.array(failed)
    )


def _poses() -> np.ndarray:
    rng = np.random.default_rng(3)
    q = quaternions.normalize(rng.standard_normal((4, 2, 4)))
    return np.concatenate([q, rng.standard_normal((4, 2, 3))], axis=-1)


def test_errors_are_distances_and_angles_without_failed_particles():
    reference, moved = _poses(), _poses()
    moved[..., 4:] += [0.0, 0.003, -0.004]
    turn = quaternions.from_rotation_vector(np.array([0.0, 0.02, 0.0]))
    moved[..., :4] = quaternions.multiply(turn, moved[..., :4])
    moved[2] = 1e3
    result = _result(reference, [False, False, True, False])
    errors = compare_predictions([moved], [result])
    np.testing.assert_allclose(errors.position, np.full(6, 0.005))
    np.testing.assert_allclose(errors.rotation, np.full(6, 0.02))


def test_the_share_of_pushed_objects_is_of_those_that_move(motion):
    poses = np.tile(motion.poses[:1], (4, 1, 1))
    start = replace(motion, poses=poses)
    end = poses.copy()
    end[1, 0, 4] += 1e-3
    sample = Sample(0, start, PhysicalParameters(0.1, 0.1, 10.0))
    assert pushed_share([sample], [_result(end, [False] * 4)]) == 0.25
