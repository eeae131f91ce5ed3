"""Which method is better in which scene, and how sure that is."""

from collections.abc import Sequence

from pbpf_drake.diagrams.paper.evaluation import Result
from pbpf_drake.diagrams.paper.paper_rows import (
    PaperRow,
    find_row,
    make_paper_rows,
)
from pbpf_drake.diagrams.paper.paper_statistics import Comparison, compare_means
from pbpf_drake.diagrams.paper.paper_values import METHOD_TITLES
from pbpf_drake.diagrams.tables.text_tables import (
    format_csv,
    format_grid,
    format_number,
)

# Which pairs of methods are compared; the paper says that the first is better.
_PAIRS = (
    ("pbpf", "dope"),
    ("pbpf-v", "dope"),
    ("pbpf", "cvpf"),
    ("pbpf-v", "cvpf"),
    ("pbpf-v", "pbpf"),
)
_COMPARED = ("position", "rotation", "symmetric_rotation", "add_s")
_VERDICTS = {
    "smaller": "smaller",
    "larger": "LARGER",
    "not different": "no significant difference",
    "too few": "too few to say",
}


def compare_all(
    results: Sequence[Result],
) -> list[tuple[PaperRow, str, str, Comparison]]:
    """Compares all pairs of methods.

    Returns:
        For each, the first method's row, the second method, the metric, and
        how they compare.
    """
    found = []
    rows = make_paper_rows(results)
    for first in rows:
        for method in (b for a, b in _PAIRS if a == first.method):
            if not find_row(rows, first.scene, first.object, method):
                continue
            mine, others = (
                [r for r in results if (r.scene, r.method) == (first.scene, m)]
                for m in (first.method, method)
            )
            for metric in _COMPARED:
                comparison = compare_means(mine, others, first.object, metric)
                if comparison:
                    found.append((first, method, metric, comparison))
    return found


def format_comparisons(
    comparisons: Sequence[tuple[PaperRow, str, str, Comparison]],
    *,
    markdown: bool,
) -> str:
    """Returns a table with a line, and what it says, for each comparison.

    Each interval is of 95 %, and each p by itself: nothing is corrected for
    how many there are.

    Args:
        comparisons: from compare_all.
        markdown: else plain text.
    """
    grid = [
        ["", "error", "of", "against", "difference", "ratio", "", "p", "it is"]
    ]
    for row, method, metric, c in comparisons:
        unit = "rad" if "rotation" in metric else "m"
        d, r = c.difference, c.ratio
        grid.append(
            [
                row.title(),
                metric.replace("_", " "),
                METHOD_TITLES[row.method],
                METHOD_TITLES[method],
                f"{d.value:+.4f} {unit} ({d.low:+.4f} to {d.high:+.4f})",
                f"{r.value:.2f} ({r.low:.2f} to {r.high:.2f})",
                f"{c.count} {c.over}",
                format_number(c.p_value, 4),
                _VERDICTS[c.verdict()],
            ]
        )
    return format_grid(grid, markdown=markdown)


def comparisons_csv(
    comparisons: Sequence[tuple[PaperRow, str, str, Comparison]],
) -> str:
    """Returns comparisons.csv: a row for each comparison."""
    table: list[Sequence[object]] = [
        [
            *("scene", "object", "method", "other", "metric"),
            *("difference", "difference_low", "difference_high"),
            *("ratio", "ratio_low", "ratio_high"),
            *("over", "count", "p_value", "verdict"),
        ]
    ]
    for row, method, metric, c in comparisons:
        numbers = [*vars(c.difference).values(), *vars(c.ratio).values()]
        table.append(
            [
                *(row.scene, row.object, row.method, method, metric),
                *(format_number(x, 6, "") for x in numbers),
                *(c.over, c.count),
                *(format_number(c.p_value, 6, ""), c.verdict()),
            ]
        )
    return format_csv(table)
