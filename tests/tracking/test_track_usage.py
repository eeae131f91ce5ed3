from dataclasses import replace

import numpy as np
from track_fixtures import make_record

from pbpf_drake.log.input_usage import InputUsage
from pbpf_drake.log.log_records import JointRecord, Log
from pbpf_drake.tracking.track_usage import usage_rows, usage_warnings

LOG = Log(
    joints=JointRecord(("a",), np.zeros(1), np.zeros((1, 1))),
    detections=(),
    usage=(InputUsage("/seen", "box", "detection", 9, 8, {"damaged": 1}),),
)


def _record(counts: list[int], in_a_row: int = 0):
    return replace(
        make_record(),
        method="pbpf",
        object_names=("box",),
        detection_counts=np.array([counts], dtype=float),
        most_rejected=np.array([float(in_a_row)]),
    )


def test_what_was_read_comes_before_what_the_filter_used():
    rows = usage_rows(LOG, _record([5, 2, 0, 1, 0]))
    assert rows == [
        ("/seen", "box", 9, 8, {"damaged": 1}),
        (
            "pbpf",
            "box",
            8,
            5,
            {
                "detections that are too old": 2,
                "detections that are older than the one before": 1,
            },
        ),
    ]


def test_an_estimator_that_counts_nothing_has_no_rows():
    record = replace(make_record(), method="dope")
    assert usage_rows(LOG, record) == usage_rows(LOG, record)[:1]
    assert usage_warnings(record) == ()


def test_a_tenth_may_be_left_out_without_a_warning():
    assert usage_warnings(_record([9, 1, 0, 0, 0])) == ()
    (sentence,) = usage_warnings(_record([8, 2, 0, 0, 0]))
    assert "only 8 of 10 detections of 'box'" in sentence
    assert "too old" in sentence


def test_many_rejected_in_a_row_are_said():
    assert usage_warnings(_record([9, 0, 0, 0, 0], in_a_row=4)) == ()
    (sentence,) = usage_warnings(_record([9, 0, 0, 0, 0], in_a_row=7))
    assert "7 detections of 'box' in a row" in sentence
