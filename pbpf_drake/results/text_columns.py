"""Text in columns."""

from collections.abc import Sequence

import numpy as np

# So many columns, from the first on, hold names; the others hold numbers.
_NUM_NAMES = 2


def align_columns(
    titles: Sequence[tuple[str, int]],
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
) -> str:
    """Returns a table: titles, the columns' names, a rule and the rows.

    Args:
        titles: over groups of columns, from the first on, with how many columns
            each is over; empty where a group has none.
        columns: their names; the first two hold names, all others numbers.
        rows: of cells.
    """
    widths = [
        max(map(len, cells)) for cells in zip(columns, *rows, strict=True)
    ]
    lines = [_title_line(titles, widths), _align(columns, widths)]
    lines.append("  ".join("-" * width for width in widths))
    return "\n".join(lines + [_align(row, widths) for row in rows])


def _title_line(
    titles: Sequence[tuple[str, int]], widths: Sequence[int]
) -> str:
    ends = np.cumsum(np.array(widths) + 2)
    line, first = "", 0
    for title, count in titles:
        start = ends[first] - 2 - widths[first]
        last = first + count - 1
        line = line.ljust(start) + title.center(ends[last] - 2 - start)
        first += count
    return line.rstrip()


def _align(cells: Sequence[str], widths: Sequence[int]) -> str:
    """Returns one line: names to the left, numbers to the right."""
    names = zip(cells[:_NUM_NAMES], widths, strict=False)
    numbers = zip(cells[_NUM_NAMES:], widths[_NUM_NAMES:], strict=True)
    left = [cell.ljust(width) for cell, width in names]
    return "  ".join(left + [cell.rjust(width) for cell, width in numbers])
