"""Numbers as cells, and cells as tables."""

import numpy as np
import pytest

from pbpf_drake.diagrams.tables.text_tables import (
    format_csv,
    format_grid,
    format_number,
    format_pair,
    format_quantiles,
    markdown_line,
    markdown_table,
)

GRID = [["", "mean"], ["box", "0.1"], ["gelatin", "-"]]


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_known_is_not_a_number(value):
    assert format_number(value, 2) == "-"
    assert format_number(value, 2, "") == ""
    assert format_pair(value, 0.1) == "-"


def test_numbers_have_as_many_digits_as_were_asked_for():
    assert format_number(1.2345, 2) == "1.23"
    assert format_pair(0.1, 0.02) == "0.100 ± 0.020"


def test_quantiles_are_the_median_and_the_90th_percentile():
    assert format_quantiles(np.arange(11.0), 0) == "5 / 9"
    assert format_quantiles(np.arange(0.0, 11.0), 1) == "5.0 / 9.0"


def test_cells_of_a_grid_are_equally_wide():
    plain = format_grid(GRID, markdown=False)
    assert plain == "         mean\nbox      0.1\ngelatin  -"
    lines = format_grid(GRID, markdown=True).splitlines()
    assert lines[1] == "| ------- | ---- |"
    assert {len(line) for line in lines} == {len(lines[0])}


def test_a_markdown_table_has_a_rule_below_its_head():
    table = markdown_table(["M", "ms"], [["70", "1.5"], ["150", "3"]])
    assert table == "| M | ms |\n| --- | --- |\n| 70 | 1.5 |\n| 150 | 3 |"
    assert markdown_line(["70", "1.5"]) in table


def test_csv_has_a_line_per_row():
    assert format_csv([["a", "b"], [1, "x, y"]]) == 'a,b\n1,"x, y"\n'
