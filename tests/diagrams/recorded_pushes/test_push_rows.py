"""The rows of results of evaluations on recorded pushes."""

import csv

import numpy as np
import pytest

from pbpf_drake.diagrams.recorded_pushes.push_rows import (
    WriteRows,
    choose,
    column,
    distinct,
)


def _rows() -> list[dict]:
    """Two methods on two runs with two seeds, in no order."""
    return [
        {"run": run, "seed": seed, "method": method, "end_m": 10.0 * i + seed}
        for seed in (1, 0)
        for i, run in enumerate(("b", "a"))
        for method in ("dope", "pbpf")
    ]


def test_columns_of_all_methods_are_in_the_same_order():
    for method in "pbpf", "dope":
        np.testing.assert_array_equal(
            column(_rows(), method, "end_m"), [10, 11, 0, 1]
        )
        np.testing.assert_array_equal(
            column(_rows(), method, "seed"), [0, 1, 0, 1]
        )


def test_rows_are_chosen_by_all_of_the_values_and_keep_their_order():
    chosen = choose(_rows(), run="a", method="dope")
    assert [row["end_m"] for row in chosen] == [11, 10]
    assert choose(_rows(), run="a", method="cvpf") == []
    assert choose(_rows()) == _rows()


def test_each_value_is_named_once_in_the_order_of_the_rows():
    assert distinct(_rows(), "run") == ["b", "a"]


def test_a_file_has_all_rows(tmp_path, capsys):
    path = tmp_path / "rows.csv"
    WriteRows(path, _rows())
    assert capsys.readouterr().out == f"Written to {path}\n"
    with path.open(newline="") as file:
        found = list(csv.DictReader(file))
    assert [row["run"] for row in found] == [row["run"] for row in _rows()]
    assert float(found[0]["end_m"]) == pytest.approx(_rows()[0]["end_m"])
