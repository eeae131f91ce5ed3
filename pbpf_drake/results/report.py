"""What came out of a run, in numbers: report.json, errors.csv and a table.

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

from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.results.pose_errors import compute_errors, position_stddev
from pbpf_drake.results.track_record import TrackRecord

_CSV_COLUMNS = (
    "time",
    "object",
    "method",
    "position_error_m",
    "rotation_error_rad",
    "detected",
    "effective_sample_size",
    "position_stddev_m",
)
_ERROR_COLUMNS = ("mean", "std", "median", "end")
_TIME_COLUMNS = ("median", "p95", "max")
_COLUMNS = (
    "object",
    "method",
    *_ERROR_COLUMNS,
    *_ERROR_COLUMNS,
    "detected",
    *_TIME_COLUMNS,
    "late",
)
# Titles over groups of the table's columns, from the first to the last.
_GROUPS = (
    ("position error [m]", 2, 5),
    ("rotation error [rad]", 6, 9),
    ("update [ms]", 11, 13),
)


def MakeReport(
    records: Sequence[TrackRecord],
    ground_truth: Mapping[str, PoseRecord],
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """Summarizes the runs of one or more methods on one log.

    Args:
        records: one per run; methods may repeat with other seeds.
        ground_truth: by name of the tracked model; may lack some or all.
        warnings: sentences on what of the log was left out.

    Returns:
        What report.json holds: ``warnings`` and a list ``runs``. A run has
        ``method``, ``seed``, ``steps``, ``particles``, ``particles_used`` (the
        mean), ``update_time_ms`` (median, p95, max), ``late_updates`` (that
        took longer than the period), ``config`` and, by name of the object,
        ``objects``:
        ``position_error_m`` and ``rotation_error_rad`` (mean, std, median,
        end: that of the last compared step), ``compared_steps`` and
        ``detected_share`` (of all steps). Unknown numbers are None.
    """
    return {
        "runs": [_summarize_run(r, ground_truth) for r in records],
        "warnings": list(warnings),
    }


def WriteReport(report: Mapping[str, Any], filename: str | Path) -> None:
    """Writes what MakeReport returned as report.json."""
    text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False)
    Path(filename).write_text(text + "\n", encoding="utf-8")


def WriteErrors(
    records: Sequence[TrackRecord],
    ground_truth: Mapping[str, PoseRecord],
    filename: str | Path,
) -> None:
    """Writes errors.csv: one row per run, object and update.

    The columns are time (in seconds), object, method, position_error_m,
    rotation_error_rad, detected (0 or 1), effective_sample_size and
    position_stddev_m, the spread of the particles. A cell is empty where the
    number is unknown.
    """
    with open(filename, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_CSV_COLUMNS)
        for record in records:
            for name in record.object_names:
                writer.writerows(_error_rows(record, name, ground_truth))


def FormatTable(report: Mapping[str, Any]) -> str:
    """Returns the report as a plain-text table, grouped by object.

    Args:
        report: what MakeReport returned.
    """
    names = dict.fromkeys(n for r in report["runs"] for n in r["objects"])
    rows = [
        _table_row(name, run)
        for name in names
        for run in report["runs"]
        if name in run["objects"]
    ]
    widths = [
        max(map(len, cells)) for cells in zip(_COLUMNS, *rows, strict=True)
    ]
    lines = [_group_titles(widths), _align(_COLUMNS, widths)]
    lines.append("  ".join("-" * width for width in widths))
    return "\n".join(lines + [_align(row, widths) for row in rows])


def _summarize_run(
    record: TrackRecord, ground_truth: Mapping[str, PoseRecord]
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
            name: _summarize_object(record, name, ground_truth.get(name))
            for name in record.object_names
        },
        "config": _plain(record.config),
    }


def _summarize_object(
    record: TrackRecord, name: str, truth: PoseRecord | None
) -> dict[str, Any]:
    errors = compute_errors(record, name, truth)
    detected = record.detected[:, record.object_names.index(name)]
    return {
        "position_error_m": _statistics(errors.position),
        "rotation_error_rad": _statistics(errors.rotation),
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
    record: TrackRecord, name: str, ground_truth: Mapping[str, PoseRecord]
) -> list[list[str]]:
    errors = compute_errors(record, name, ground_truth.get(name))
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
        ]
        for i in range(len(record.times))
    ]


def _group_titles(widths: Sequence[int]) -> str:
    """Returns the line above the columns' names: a title over each group."""
    ends = np.cumsum(np.array(widths) + 2)
    line = ""
    for title, first, last in _GROUPS:
        start = ends[first] - 2 - widths[first]
        line = line.ljust(start) + title.center(ends[last] - 2 - start)
    return line.rstrip()


def _align(cells: Sequence[str], widths: Sequence[int]) -> str:
    """Returns one line: names to the left, numbers to the right."""
    names = [c.ljust(w) for c, w in zip(cells[:2], widths, strict=False)]
    numbers = zip(cells[2:], widths[2:], strict=True)
    return "  ".join(names + [c.rjust(w) for c, w in numbers])


def _table_row(name: str, run: Mapping[str, Any]) -> list[str]:
    summary, update = run["objects"][name], run["update_time_ms"]
    position = summary["position_error_m"]
    rotation = summary["rotation_error_rad"]
    return [
        name,
        run["method"],
        *(_cell(position[k], ".3f", "-") for k in _ERROR_COLUMNS),
        *(_cell(rotation[k], ".3f", "-") for k in _ERROR_COLUMNS),
        _cell(summary["detected_share"], ".0%", "-"),
        *(_cell(update[k], ".1f", "-") for k in _TIME_COLUMNS),
        str(run["late_updates"]),
    ]


def _cell(value: float | None, form: str, unknown: str = "") -> str:
    known = value is not None and np.isfinite(value)
    return format(value, form) if known else unknown
