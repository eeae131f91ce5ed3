"""The paper's tables with our numbers beside its own, as text and as CSV."""

from collections.abc import Sequence

from pbpf_drake.diagrams.paper.evaluation import METRICS
from pbpf_drake.diagrams.paper.paper_rows import PaperRow, ratio_to_dope
from pbpf_drake.diagrams.paper.paper_values import METHOD_TITLES, SCENES
from pbpf_drake.diagrams.tables.text_tables import (
    format_csv,
    format_grid,
    format_number,
    format_pair,
)

_UNITS = dict.fromkeys(METRICS, "m") | {
    "rotation": "rad",
    "symmetric_rotation": "rad",
}
_TITLES = [
    "",
    "method",
    "runs",
    "position [m]",
    "paper",
    "/ DOPE",
    "paper",
    "rotation [rad]",
    "paper",
    "/ DOPE",
    "paper",
]
_PAPER_COLUMNS = [
    "scene",
    "object",
    "method",
    "runs",
    "repeats",
    "pos_mean",
    "pos_std",
    "rot_mean",
    "rot_std",
    "paper_pos_mean",
    "paper_pos_std",
    "paper_rot_mean",
    "paper_rot_std",
]


def format_tables(rows: Sequence[PaperRow], *, markdown: bool) -> str:
    """Returns Tables 1 and 2, each number with the paper's beside it.

    Args:
        rows: from make_paper_rows.
        markdown: else plain text.
    """
    groups: dict[str, list[PaperRow]] = {
        "Table 1": [],
        "Table 2": [],
        "Scenes of one's own": [],
    }
    for row in rows:
        in_paper = "Table 2" if row.scene == "scene_5" else "Table 1"
        own = row.scene not in SCENES
        groups["Scenes of one's own" if own else in_paper].append(row)
    return "\n\n".join(
        f"{title}\n\n{_format_rows(rows, chosen, markdown=markdown)}"
        for title, chosen in groups.items()
        if chosen
    )


def _format_rows(
    rows: Sequence[PaperRow], chosen: Sequence[PaperRow], *, markdown: bool
) -> str:
    grid = [_TITLES, *(_cells(rows, row) for row in chosen)]
    return format_grid(grid, markdown=markdown)


def format_metrics(rows: Sequence[PaperRow], *, markdown: bool) -> str:
    """Returns the errors that the paper doesn't have, as a table."""
    others = [m for m in METRICS if m not in ("position", "rotation")]
    heads = [f"{m.replace('_', ' ')} [{_UNITS[m]}]" for m in others]
    grid = [["", "method", *heads, "AUC add", "AUC add s"]]
    grid += [
        [
            row.title(),
            METHOD_TITLES[row.method],
            *(format_pair(*row.metrics[m]) for m in others),
            *(format_number(row.auc[m], 2) for m in ("add", "add_s")),
        ]
        for row in rows
    ]
    return format_grid(grid, markdown=markdown)


def paper_csv(rows: Sequence[PaperRow]) -> str:
    """Returns paper_tables.csv; a cell is empty where nothing is known."""
    table: list[Sequence[object]] = [_PAPER_COLUMNS]
    for row in rows:
        ours = [format_number(x, 6, "") for x in vars(row.ours).values()]
        paper = [format_number(x, 3, "") for x in vars(row.paper).values()]
        names = [row.scene, row.object, row.method]
        table.append([*names, row.runs, row.repeats, *ours, *paper])
    return format_csv(table)


def metrics_csv(rows: Sequence[PaperRow]) -> str:
    """Returns metrics.csv: all METRICS and the areas under the curve."""
    heads = [f"{m}_{part}" for m in METRICS for part in ("mean", "std")]
    table: list[Sequence[object]] = [
        ["scene", "object", "method", *heads, "add_auc", "add_s_auc"]
    ]
    for row in rows:
        numbers = [x for m in METRICS for x in row.metrics[m]]
        numbers += [row.auc["add"], row.auc["add_s"]]
        cells = [format_number(x, 6, "") for x in numbers]
        table.append([row.scene, row.object, row.method, *cells])
    return format_csv(table)


def _cells(rows: Sequence[PaperRow], row: PaperRow) -> list[str]:
    pos, paper_pos, rot, paper_rot = (
        format_number(x, 2) for x in ratio_to_dope(rows, row)
    )
    ours, paper = row.ours, row.paper
    return [
        row.title(),
        METHOD_TITLES[row.method],
        f"{row.runs} x {row.repeats}",
        format_pair(ours.pos_mean, ours.pos_std),
        format_pair(paper.pos_mean, paper.pos_std),
        pos,
        paper_pos,
        format_pair(ours.rot_mean, ours.rot_std),
        format_pair(paper.rot_mean, paper.rot_std),
        rot,
        paper_rot,
    ]
