from collections.abc import Sequence

import numpy as np
from paths import DATA
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.config.distributions import PoseStddev, Range
from pbpf_drake.truth.simulated_detector import (
    SimulatedDetector,
    add_pose_error,
    clearness,
    detection_probability,
)

UNBIASED = {"bias_position": Range(), "bias_rotation": Range()}
EXACT = PoseStddev(position=0.0, rotation=0.0)
BIASED = {
    "bias_position": Range(min=0.02, max=0.05),
    "bias_rotation": Range(min=0.1, max=0.3),
}
X_WC = RigidTransform(RollPitchYaw(-2.0, 0.1, 1.4), [1.1, 0.2, 0.4])
X_WO = RigidTransform(RollPitchYaw(0.3, -0.5, 2.0), [0.4, 0.3, 0.1])
# The real traces of the authors' detector; the tests that use them skip where
# they are absent.
TRACES = DATA / "dope_error_traces"


def _detect_all(visibility: Sequence, *, seed: int = 0, **config) -> list:
    """Returns the detections in images of that visibility, (N,) or (N, K)."""
    shares = np.reshape(visibility, (len(visibility), -1))
    detector = SimulatedDetector(
        config=DetectorConfig(**{**UNBIASED, "noise": EXACT, **config}),
        names=["box", "can"][: shares.shape[1]],
        X_WC=X_WC,
        rng=np.random.default_rng(seed),
    )
    return [
        detector.Detect(time=0.1 * i, poses=[X_WO] * len(row), visibility=row)
        for i, row in enumerate(shares)
    ]


def _detect(visibility: float, *, count: int = 1, **config) -> list:
    return _detect_all([visibility] * count, **config)


def _errors(visibility: float = 1.0, *, count: int = 2000, **config):
    """Returns errors: 3 of position, in C, and the rotation's angle."""
    X_CO = X_WC.inverse() @ X_WO
    rows = []
    for (detection,) in _detect(visibility, count=count, **config):
        R = X_CO.rotation().InvertAndCompose(detection.X_CO.rotation())
        shift = detection.X_CO.translation() - X_CO.translation()
        rows.append([*shift, R.ToAngleAxis().angle()])
    return np.array(rows)


def test_chance_of_a_detection_grows_from_hidden_to_half_way_to_clear():
    config = DetectorConfig(hidden_visibility=0.4, clear_visibility=0.8)
    shares = (0, 0.4, 0.5, 0.6, 0.8, 1)
    chances = [detection_probability(v, config) for v in shares]
    np.testing.assert_allclose(chances, [0, 0, 0.5, 1, 1, 1], atol=1e-12)


def test_clearness_grows_from_hidden_to_clear():
    config = DetectorConfig(hidden_visibility=0.4, clear_visibility=0.8)
    shares = (0, 0.4, 0.5, 0.6, 0.8, 1)
    values = [clearness(v, config) for v in shares]
    np.testing.assert_allclose(values, [0, 0, 0.25, 0.5, 1, 1], atol=1e-12)


@pytest.mark.parametrize(
    "visibility, share", [(0.49, 0.0), (0.55, 0.25), (0.65, 0.75), (0.71, 1.0)]
)
def test_detections_vanish_as_the_object_does(visibility, share):
    count = sum(len(d) for d in _detect(visibility, count=3000))
    assert count / 3000 == pytest.approx(share, abs=0.03 * (0 < share < 1))


def test_the_default_detector_finds_nothing_that_is_half_hidden():
    for visibility in np.linspace(0.0, 0.5, 11):
        assert not any(_detect(visibility, count=100))


@pytest.mark.parametrize("visibility", [0.9, 0.95, 1.0])
def test_there_are_no_outliers_in_a_clear_view(visibility):
    errors = _errors(visibility, outlier_chance=1.0)
    np.testing.assert_allclose(errors, 0.0, atol=1e-7)


@pytest.mark.parametrize("visibility, share", [(0.7, 0.5), (0.8, 0.25)])
def test_outliers_come_mixed_with_good_detections(visibility, share):
    errors = _errors(visibility, count=4000)
    for sizes in (np.linalg.norm(errors[:, :3], axis=1), errors[:, 3]):
        assert np.mean(sizes > 1e-6) == pytest.approx(share, abs=0.03)


def test_default_outliers_are_as_large_as_real_ones():
    errors = np.concatenate(
        [_errors(v, count=500) for v in np.linspace(0.7, 0.9, 5)]
    )
    distances, angles = np.linalg.norm(errors[:, :3], axis=1), errors[:, 3]
    for sizes, low, high in ((distances, 0.1, 0.7), (angles, 1.0, 3.0)):
        sizes = sizes[sizes > 1e-6]
        assert np.all((low - 1e-9 <= sizes) & (sizes <= high + 1e-9))


def test_an_outlier_comes_on_top_of_bias_and_noise():
    small = {
        "bias_position": Range(min=0.02, max=0.05),
        "noise": PoseStddev(position=0.003),
    }
    outliers = _errors(0.7, count=300)[:, :3]
    assert np.count_nonzero(np.any(outliers, axis=1)) > 100
    np.testing.assert_allclose(
        _errors(0.7, count=300, **small)[:, :3],
        outliers + _errors(1.0, count=300, **small)[:, :3],
        atol=1e-12,
    )


def test_a_detection_without_errors_is_the_pose_in_the_camera():
    ((detection,),) = _detect(1.0, latency=0.02)
    assert (X_WC @ detection.X_CO).IsNearlyEqualTo(X_WO, 1e-12)
    assert (detection.name, detection.time) == ("box", 0.0)
    assert detection.received == 0.02


def test_bias_is_the_same_in_all_detections_of_a_run():
    errors = _errors(**BIASED)
    np.testing.assert_allclose(errors, np.tile(errors[0], (2000, 1)), atol=1e-9)
    assert not np.allclose(errors[0], _errors(**BIASED, seed=1)[0])


def test_biases_of_runs_fill_their_range_in_all_directions():
    errors = np.concatenate(
        [_errors(**BIASED, count=1, seed=seed) for seed in range(1500)]
    )
    distances = np.linalg.norm(errors[:, :3], axis=1)
    for sizes, low, high in ((distances, 0.02, 0.05), (errors[:, 3], 0.1, 0.3)):
        assert low <= sizes.min() and sizes.max() <= high
        np.testing.assert_allclose(
            np.quantile(sizes, [0.01, 0.5, 0.99]),
            [low, (low + high) / 2, high],
            atol=0.05 * (high - low),
        )
    units = errors[:, :3] / distances[:, np.newaxis]
    np.testing.assert_allclose(units.mean(axis=0), 0, atol=0.05)


def test_noise_has_the_configured_spread():
    errors = _errors(noise=PoseStddev(position=0.003, rotation=0.02))
    np.testing.assert_allclose(errors[:, :3].mean(axis=0), 0, atol=3e-4)
    np.testing.assert_allclose(errors[:, :3].std(axis=0), 0.003, rtol=0.06)
    assert np.sqrt(np.mean(errors[:, 3] ** 2)) == pytest.approx(0.02, rel=0.06)


def _trace_steps(scene: int, kind: str) -> float:
    """Standard deviation of the changes from one update to the next."""
    path = TRACES / f"cracker_scene{scene}_early_DOPE_{kind}_01.csv"
    errors = np.loadtxt(path, delimiter=",", usecols=2)
    return np.diff(errors).std()


@pytest.mark.skipif(not TRACES.exists(), reason=f"{TRACES} is absent")
def test_noise_in_a_clear_view_is_that_of_the_real_detector():
    errors = _errors(
        seed=1,
        bias_position=Range(min=0.05, max=0.05),
        bias_rotation=Range(min=0.2, max=0.2),
        noise=DetectorConfig().noise,
    )
    distances, angles = np.linalg.norm(errors[:, :3], axis=1), errors[:, 3]
    assert distances.mean() > 0.01 and angles.mean() > 0.05
    step = np.diff(distances).std()
    assert _trace_steps(4, "pos") < step < _trace_steps(3, "pos")
    for scene in (3, 4):
        expected = _trace_steps(scene, "ang")
        assert np.diff(angles).std() == pytest.approx(expected, rel=0.15)


def test_a_missed_detection_changes_no_other():
    noise = PoseStddev(position=0.003, rotation=0.02)
    visibility = np.full((60, 2), 0.75)
    everything = _detect_all(visibility, noise=noise)
    visibility[10:50:3, 0] = 0.1
    some = _detect_all(visibility, noise=noise)
    for i, (expected, got) in enumerate(zip(everything, some, strict=True)):
        assert len(expected) == 2
        if visibility[i, 0] < 0.5:
            expected = expected[1:]
        assert [d.name for d in got] == [d.name for d in expected]
        for a, b in zip(expected, got, strict=True):
            assert a.X_CO.IsExactlyEqualTo(b.X_CO)


def test_detections_are_a_function_of_the_seed():
    def positions(seed: int) -> list:
        images = _detect(0.6, count=50, seed=seed)
        return [
            d.X_CO.translation().tolist() for image in images for d in image
        ]

    assert len(positions(3)) > 10
    assert positions(3) == positions(3)
    assert positions(3) != positions(4)


def test_pose_error_turns_about_the_object_itself():
    X_CO = RigidTransform([1.0, 2.0, 3.0])
    moved = add_pose_error(X_CO, np.array([0, 0, 0.5, 0.1, 0.0, -0.1]))
    np.testing.assert_allclose(moved.translation(), [1.1, 2.0, 2.9])
    expected = RollPitchYaw(0, 0, 0.5).ToRotationMatrix()
    np.testing.assert_allclose(
        moved.rotation().matrix(), expected.matrix(), atol=1e-12
    )
