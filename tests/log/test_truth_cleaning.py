"""True poses that can't be used are left out and counted."""

import math

from mcap_fixtures import SECOND, T0


def test_bad_ground_truth_is_left_out(faulty):
    faulty.joints(0.0)
    faulty.detection(0.0)
    faulty.truth(0.1, q=(0, 0, 0, 0))
    faulty.truth(0.3, p=(3, 0, 0))
    faulty.truth(0.5, p=(2, 0, 0), stamp=T0 + SECOND // 5)
    faulty.truth(0.6, p=(math.nan, 0, 0))
    faulty.truth(0.7, p=(4, 0, 0), stamp=T0 + 3 * SECOND // 10)
    log = faulty.read()
    truth = log.ground_truth["box"]
    assert truth.times.tolist() == [0.2, 0.3]
    assert truth.p_WO[:, 0].tolist() == [2.0, 3.0]
    assert len(log.warnings) == 4
