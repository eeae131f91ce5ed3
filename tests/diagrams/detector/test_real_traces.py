"""The authors' traces, which are no part of this project."""

from paths import DATA
import pytest

from pbpf_drake.diagrams.detector.error_statistics import describe_errors
from pbpf_drake.diagrams.detector.real_traces import ReadTrace

TRACES = DATA / "dope_error_traces"


@pytest.mark.skipif(not TRACES.exists(), reason=f"{TRACES} is absent")
@pytest.mark.parametrize(
    "scene, position, rotation, stale",
    [("cheezit_1", 0.38, 1.86, 0.65), ("cheezit_2", 0.114, 1.06, 0.30),
     ("cheezit_3", 0.036, 0.171, 0.0), ("cheezit_4", 0.031, 0.217, 0.0)],
)  # fmt: skip
def test_real_traces_are_described_as_in_the_notes(
    scene, position, rotation, stale
):
    found = describe_errors(ReadTrace(TRACES, scene))
    assert found["position: mean"] == pytest.approx(position, rel=0.05)
    assert found["rotation: mean"] == pytest.approx(rotation, rel=0.05)
    assert found["stale share"] == pytest.approx(stale, abs=0.05)
    assert ReadTrace(TRACES, "soup_1") is None
