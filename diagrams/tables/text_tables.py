"""Numbers as cells, and cells as tables: plain text, Markdown and CSV."""

from collections.abc import Iterable, Sequence
import csv
import io

import numpy as np


def format_number(value: float, digits: int, unknown: str = "-") -> str:
    """Returns a number with so many digits behind the point."""
    return f"{value:.{digits}f}" if np.isfinite(value) else unknown


def format_pair(mean: float, stddev: float) -> str:
    """Returns a mean and its standard deviation, or - where unknown."""
    return f"{mean:.3f} ± {stddev:.3f}" if np.isfinite(mean) else "-"


def format_quantiles(values: np.ndarray, digits: int) -> str:
    """Returns the median and the 90th percentile."""
    middle, high = np.median(values), np.percentile(values, 90)
    return f"{middle:.{digits}f} / {high:.{digits}f}"


def markdown_line(cells: Iterable[str]) -> str:
    """Returns one line of a Markdown table."""
    return f"| {' | '.join(cells)} |"


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Returns a Markdown table; its cells are not padded."""
    return "\n".join(map(markdown_line, [head, ["---"] * len(head), *rows]))


def format_grid(grid: Sequence[Sequence[str]], *, markdown: bool) -> str:
    """Returns lines of equally wide cells.

    Args:
        grid: rows of cells; the first row is the head.
        markdown: else plain text.
    """
    widths = [max(map(len, column)) for column in zip(*grid, strict=True)]
    lines = [
        [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        for row in grid
    ]
    if not markdown:
        return "\n".join("  ".join(line).rstrip() for line in lines)
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(map(markdown_line, lines))


def format_csv(table: Sequence[Sequence[object]]) -> str:
    """Returns the rows as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(table)
    return text.getvalue()
