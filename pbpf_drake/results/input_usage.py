"""How much of the input was used: as text, and for report.json.

A row says it of one source and one object: the source (a topic, or a part of
the tracker), the object (empty if it is of none), how many were read and used,
and how many were left out, by the reason as a clause.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from pbpf_drake.results.text_columns import align_columns

UsageRow = tuple[str, str, int, int, Mapping[str, int]]

_COLUMNS = ("input", "object", "read", "used", "left out")


def FormatUsage(rows: Sequence[UsageRow]) -> str:
    """Returns a table of what was read and used, with reasons below.

    Args:
        rows: see above. Without any, the text is empty.
    """
    if not rows:
        return ""
    cells = [
        [source, name or "-", str(read), str(used), str(sum(reasons.values()))]
        for source, name, read, used, reasons in rows
    ]
    table = align_columns([("", len(_COLUMNS))], _COLUMNS, cells)
    return "\n".join([table.lstrip("\n"), *_reasons(rows)])


def usage_entries(rows: Sequence[UsageRow]) -> list[dict[str, Any]]:
    """Returns rows as report.json has them, by the names of their parts."""
    return [
        {
            "source": source,
            "object": name,
            "read": int(read),
            "used": int(used),
            "left_out": {why: int(count) for why, count in reasons.items()},
        }
        for source, name, read, used, reasons in rows
    ]


def _reasons(rows: Sequence[UsageRow]) -> list[str]:
    """Returns a line for everything that was left out, and why."""
    return [
        f"{source}{f' ({name})' if name else ''}: left out {count} {why}"
        for source, name, _, _, reasons in rows
        for why, count in reasons.items()
        if count
    ]
