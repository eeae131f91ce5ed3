"""The rows of results of evaluations on recorded pushes."""

from collections.abc import Mapping, Sequence
import csv
from pathlib import Path

import numpy as np

# What tells the rows of one method apart.
_IDENTITY = ("run", "blackout", "dropout", "seed")

# A run of one method: its names, and what was measured.
Row = Mapping[str, float | str]


def WriteRows(filename: Path, rows: Sequence[Row]) -> None:
    """Writes rows of results as a CSV file, and says where."""
    with open(filename, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    print(f"Written to {filename}")


def column(rows: Sequence[Row], method: str, name: str) -> np.ndarray:
    """Returns one column of a method's rows, in the same order for all methods.

    Args:
        rows: of all methods.
        method: whose to return.
        name: the column's.
    """
    chosen = choose(rows, method=method)
    chosen.sort(key=lambda row: [row[k] for k in _IDENTITY if k in row])
    return np.array([row[name] for row in chosen], dtype=float)


def choose(rows: Sequence[Row], **values: str) -> list[Row]:
    """Returns the rows that have these values in these columns."""
    return [row for row in rows if all(row[k] == x for k, x in values.items())]


def distinct(rows: Sequence[Row], name: str) -> list[str]:
    """Returns the values of a column, each once, in their order."""
    return list(dict.fromkeys(str(row[name]) for row in rows))
