"""Damages files at random, and says what may be read of them then."""

from log_fixtures import make_small_log
import numpy as np

from pbpf_drake.log import Log

NUM_SAMPLES = 150


def damage(whole: bytes, seed: int) -> bytes:
    """Returns a file with its end cut off, or with some bytes changed."""
    rng = np.random.default_rng(seed)
    if seed % 3 == 0:
        return whole[: rng.integers(len(whole))]
    count = (1, 20)[seed % 3 - 1]
    damaged = bytearray(whole)
    for at in rng.integers(len(whole), size=count):
        damaged[at] ^= rng.integers(1, 256)
    return bytes(damaged)


def expected_log() -> Log:
    """Returns the log that all these files held."""
    return make_small_log(num_samples=NUM_SAMPLES)


def is_whole(log: Log, expected: Log) -> bool:
    """Tells if a log has as many of everything as it should have."""
    truth = log.ground_truth.get("box")
    return (
        len(log.joints.times) == len(expected.joints.times)
        and len(log.detections) == len(expected.detections)
        and truth is not None
        and len(truth.times) == len(expected.ground_truth["box"].times)
    )


def count_wrong(log: Log, expected: Log) -> int:
    """Returns how many samples are none of the expected log's."""
    start = (log.start_time - expected.start_time) / 1e9
    wrong = 0
    pairs = [(log.joints, expected.joints, ("positions",))]
    if "box" in log.ground_truth:
        truth = expected.ground_truth["box"]
        pairs.append((log.ground_truth["box"], truth, ("q_WO", "p_WO")))
    for found, whole, fields in pairs:
        times = found.times + start
        rows = np.clip(
            np.searchsorted(whole.times, times - 1e-7), 0, len(whole.times) - 1
        )
        good = np.abs(whole.times[rows] - times) < 1e-7
        for field in fields:
            close = np.isclose(
                getattr(found, field), getattr(whole, field)[rows], atol=1e-12
            )
            good &= np.all(close, axis=1)
        wrong += np.count_nonzero(~good)
    by_time = {round(d.time, 6): d for d in expected.detections}
    for detection in log.detections:
        match = by_time.get(round(detection.time + start, 6))
        wrong += match is None or not detection.X_CO.IsNearlyEqualTo(
            match.X_CO, 1e-12
        )
    return wrong
