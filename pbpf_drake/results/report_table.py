"""The report of a run as a table to print."""

from collections.abc import Mapping, Sequence
from typing import Any

from pbpf_drake.results.text_columns import align_columns

_ERROR_COLUMNS = ("mean", "std", "median", "end")
# Of the error up to symmetry, where an object has a symmetry.
_SYMMETRIC_COLUMNS = ("median", "end")
_TIME_COLUMNS = ("median", "p95", "max")


def FormatTable(report: Mapping[str, Any]) -> str:
    """Returns the report as a plain-text table, grouped by object.

    Args:
        report: what MakeReport returned.
    """
    names = dict.fromkeys(n for r in report["runs"] for n in r["objects"])
    symmetric = any(
        o["symmetry"] for r in report["runs"] for o in r["objects"].values()
    )
    rows = [
        _table_row(name, run, symmetric)
        for name in names
        for run in report["runs"]
        if name in run["objects"]
    ]
    return align_columns(*_columns(symmetric), rows)


def _columns(
    symmetric: bool,
) -> tuple[list[tuple[str, int]], list[str]]:
    """Returns titles over columns, with how many each is over, and names."""
    groups = [
        ("", ["object", "method"]),
        ("position error [m]", [*_ERROR_COLUMNS]),
        ("rotation error [rad]", [*_ERROR_COLUMNS]),
        ("up to symmetry", [*_SYMMETRIC_COLUMNS] if symmetric else []),
        ("", ["detected"]),
        ("update [ms]", [*_TIME_COLUMNS]),
        ("", ["late"]),
    ]
    titles = [(title, len(names)) for title, names in groups if names]
    return titles, [name for _, names in groups for name in names]


def _table_row(name: str, run: Mapping[str, Any], symmetric: bool) -> list[str]:
    summary, update = run["objects"][name], run["update_time_ms"]
    turned = summary["rotation_error_up_to_symmetry_rad"]
    return [
        name,
        run["method"],
        *_cells(summary["position_error_m"], _ERROR_COLUMNS),
        *_cells(summary["rotation_error_rad"], _ERROR_COLUMNS),
        *(_cells(turned, _SYMMETRIC_COLUMNS) if symmetric else ()),
        _cell(summary["detected_share"], ".0%"),
        *(_cell(update[k], ".1f") for k in _TIME_COLUMNS),
        str(run["late_updates"]),
    ]


def _cells(
    values: Mapping[str, float | None], keys: Sequence[str]
) -> list[str]:
    return [_cell(values[key], ".3f") for key in keys]


def _cell(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)
