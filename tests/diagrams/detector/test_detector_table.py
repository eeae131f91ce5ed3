"""Statistics side by side."""

from detector_fixtures import error_series
import numpy as np

from pbpf_drake.diagrams.detector.detector_table import make_statistic_rows
from pbpf_drake.diagrams.detector.error_statistics import describe_errors


def test_what_can_not_be_counted_is_nan_and_then_empty():
    clear = error_series()[:40]
    found = describe_errors(clear)
    assert np.isnan(found["position: outliers' median"])
    rows = make_statistic_rows("cheezit_3", "cracker", [found, found], None)
    texts = {row[2]: row[3:] for row in rows}
    assert texts["position: outliers' median"] == [""] * 5
    assert texts["position: mean"][:2] == ["", "0.0520"]
