"""The outcomes of runs as a table."""

from closed_loop_fixtures import make_outcome

from pbpf_drake.diagrams.closed_loop.closed_loop_table import format_outcomes


def test_the_table_counts_what_is_within_40_mm():
    outcomes = [make_outcome("dope", x) for x in (0.039, 0.041, 0.2)]
    lines = format_outcomes(
        [*outcomes, make_outcome("truth", 0.01)]
    ).splitlines()
    assert lines[2] == "| dope | 1 of 3 | 41 / 168 |"
    assert lines[3] == "| truth | 1 of 1 | 10 / 10 |"
