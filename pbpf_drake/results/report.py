"""What came out of a run, in numbers: report.json and errors.csv.

Errors are those of Section 2 of the paper, against the log's ground truth,
over the updates where the object is tracked and its truth is known.
"""

from collections.abc import Callable, Mapping, Sequence
import csv
import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.results.input_usage import UsageRow, usage_entries
from pbpf_drake.results.pose_errors import (
    ErrorTrace,
    compute_errors,
    position_stddev,
)
from pbpf_drake.results.track_record import TrackRecord

# Symmetries of objects, by their names.
Symmetries = Mapping[str, SymmetryConfig]
NO_SYMMETRIES: Symmetries = {}

_CSV_COLUMNS = (
    "time",
    "object",
    "method",
    "position_error_m",
    "rotation_error_rad",
    "detected",
    "effective_sample_size",
    "position_stddev_m",
    "rotation_error_up_to_symmetry_rad",
)


def MakeReport(
    records: Sequence[TrackRecord],
    ground_truth: Mapping[str, PoseRecord],
    warnings: Sequence[str] = (),
    *,
    symmetries: Symmetries = NO_SYMMETRIES,
    usage: Sequence[UsageRow] = (),
    interrupted: bool = False,
) -> dict[str, Any]:
    """Summarizes the runs of one or more methods on one log.

    Args:
        records: one per run; methods may repeat with other seeds.
        ground_truth: by name of the tracked model; may lack some or all.
        warnings: sentences on what of the log was left out.
        symmetries: of objects, by name; others have none.
        usage: how much of the input was used, see input_usage.
        interrupted: whether only a part of the log was tracked.

    Returns:
        What report.json holds: ``warnings``, ``interrupted``, ``input``, a list
        with ``source``, ``object``, ``read``, ``used`` and ``left_out`` (by
        reason), and a list ``runs``. A run has
        ``method``, ``seed``, ``steps``, ``particles``, ``particles_used`` (the
        mean), ``update_time_ms`` (median, p95, max), ``late_updates`` (that
        took longer than the period), ``config`` and, by name of the object,
        ``objects``:
        ``position_error_m``, ``rotation_error_rad`` and
        ``rotation_error_up_to_symmetry_rad`` (mean, std, median, end: that of
        the last compared step), ``symmetry`` (axis and order; None without
        one), ``compared_steps`` and ``detected_share`` (of all steps). Unknown
        numbers are None.
    """
    return {
        "runs": [_summarize_run(r, ground_truth, symmetries) for r in records],
        "input": usage_entries(usage),
        "warnings": list(warnings),
        "interrupted": interrupted,
    }


def WriteReport(report: Mapping[str, Any], filename: str | Path) -> None:
    """Writes what MakeReport returned as report.json.

    Where there is one already, it is replaced at once: at no time is there half
    a report.
    """
    text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False)
    path = Path(filename)
    part = path.with_name(f"{path.name}.part")
    part.write_text(text + "\n", encoding="utf-8")
    part.replace(path)


def WriteErrors(
    records: Sequence[TrackRecord],
    ground_truth: Mapping[str, PoseRecord],
    filename: str | Path,
    symmetries: Symmetries = NO_SYMMETRIES,
) -> None:
    """Writes errors.csv: one row per run, object and update.

    The columns are time (in seconds), object, method, position_error_m,
    rotation_error_rad, detected (0 or 1), effective_sample_size,
    position_stddev_m, the spread of the particles, and
    rotation_error_up_to_symmetry_rad. A cell is empty where the number is
    unknown.

    Args:
        records, ground_truth, symmetries: see MakeReport.
        filename: the file to write.
    """
    with open(filename, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_CSV_COLUMNS)
        for record in records:
            for name in record.object_names:
                errors = compute_errors(
                    record, name, ground_truth.get(name), symmetries.get(name)
                )
                writer.writerows(_error_rows(record, name, errors))


def _summarize_run(
    record: TrackRecord,
    ground_truth: Mapping[str, PoseRecord],
    symmetries: Symmetries,
) -> dict[str, Any]:
    milliseconds = np.asarray(record.update_ms, dtype=float)
    return {
        "method": record.method,
        "seed": int(record.seed),
        "steps": len(record.times),
        "particles": int(record.particles.shape[1]),
        "particles_used": _number(record.particles_used, np.mean),
        "update_time_ms": {
            "median": _number(milliseconds, np.median),
            "p95": _number(milliseconds, lambda x: np.percentile(x, 95)),
            "max": _number(milliseconds, np.max),
        },
        "late_updates": int(np.sum(milliseconds > 1e3 * record.period)),
        "objects": {
            name: _summarize_object(
                record, name, ground_truth.get(name), symmetries.get(name)
            )
            for name in record.object_names
        },
        "config": _plain(record.config),
    }


def _summarize_object(
    record: TrackRecord,
    name: str,
    truth: PoseRecord | None,
    symmetry: SymmetryConfig | None,
) -> dict[str, Any]:
    errors = compute_errors(record, name, truth, symmetry)
    detected = record.detected[:, record.object_names.index(name)]
    return {
        "position_error_m": _statistics(errors.position),
        "rotation_error_rad": _statistics(errors.rotation),
        "rotation_error_up_to_symmetry_rad": _statistics(
            errors.symmetric_rotation
        ),
        "symmetry": _plain(symmetry) if symmetry and symmetry.axis else None,
        "compared_steps": int(np.isfinite(errors.position).sum()),
        "detected_share": _number(detected.astype(float), np.mean),
    }


def _statistics(errors: np.ndarray) -> dict[str, float | None]:
    return {
        "mean": _number(errors, np.mean),
        "std": _number(errors, np.std),
        "median": _number(errors, np.median),
        "end": _number(errors, lambda x: x[-1]),
    }


def _number(
    values: np.ndarray, function: Callable[[np.ndarray], float]
) -> float | None:
    """Applies a statistic to what is finite; None where nothing is."""
    finite = values[np.isfinite(values)]
    return float(function(finite)) if finite.size else None


def _plain(value: Any) -> Any:
    """Returns a configuration as what JSON can hold, None for NaN."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = dataclasses.asdict(value)
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return str(value)


def _error_rows(
    record: TrackRecord, name: str, errors: ErrorTrace
) -> list[list[str]]:
    detected = record.detected[:, record.object_names.index(name)]
    spread = position_stddev(record, name)
    sample_size = np.where(
        record.particles.shape[1] > 0, record.effective_sample_size, np.nan
    )
    return [
        [
            f"{record.times[i]:.6f}",
            name,
            record.method,
            _cell(errors.position[i], ".6f"),
            _cell(errors.rotation[i], ".6f"),
            str(int(detected[i])),
            _cell(sample_size[i], ".3f"),
            _cell(spread[i], ".6f"),
            _cell(errors.symmetric_rotation[i], ".6f"),
        ]
        for i in range(len(record.times))
    ]


def _cell(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else ""
