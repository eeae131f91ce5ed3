"""How much of a log's input was used: by the reader, and by the filter."""

import numpy as np

from pbpf_drake.filtering.input_warnings import MANY_REJECTED, MAX_LEFT_OUT
from pbpf_drake.filtering.recent_detections import DETECTION_FATES
from pbpf_drake.log.log_records import Log
from pbpf_drake.results.input_usage import UsageRow
from pbpf_drake.results.track_record import TrackRecord


def usage_rows(log: Log, record: TrackRecord) -> list[UsageRow]:
    """Returns a row for each input of a log, then for each object of a filter.

    Args:
        log: what was read.
        record: of the method that tracked it; one that counts no detections
            has no rows.
    """
    rows: list[UsageRow] = [
        (row.source, row.name, row.read, row.used, row.left_out)
        for row in log.usage
    ]
    for name, counts in zip(
        record.object_names, record.detection_counts, strict=False
    ):
        reasons = {
            f"detections that are {fate}": int(count)
            for fate, count in zip(DETECTION_FATES, counts, strict=True)
            if fate != DETECTION_FATES[0] and count
        }
        read, used = int(np.sum(counts)), int(counts[0])
        rows.append((record.method, name, read, used, reasons))
    return rows


def usage_warnings(record: TrackRecord) -> tuple[str, ...]:
    """Returns a sentence for each object whose detections had little effect.

    Args:
        record: see usage_rows.
    """
    sentences = []
    for name, counts, in_a_row in zip(
        record.object_names,
        record.detection_counts,
        record.most_rejected,
        strict=False,
    ):
        read, left_out = np.sum(counts), np.sum(counts[1:])
        if left_out > MAX_LEFT_OUT * read:
            worst = DETECTION_FATES[1 + int(np.argmax(counts[1:]))]
            sentences.append(
                f"{record.method} used only {read - left_out:.0f} of "
                f"{read:.0f} detections of {name!r}: most of the others are "
                f"{worst}"
            )
        if in_a_row >= MANY_REJECTED:
            sentences.append(
                f"{record.method}: {in_a_row:.0f} detections of {name!r} in a "
                "row were far from all particles and had no effect: the track "
                "was lost, or they are wrong; see filter.recover_lost_tracks"
            )
    return tuple(sentences)
