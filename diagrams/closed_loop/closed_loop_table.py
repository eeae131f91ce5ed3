"""The outcomes of runs as a table and as a CSV file."""

from collections.abc import Sequence
import csv
from pathlib import Path

import numpy as np

from pbpf_drake.diagrams.closed_loop.push_run import Outcome

_COLUMNS = (
    "feedback",
    "seed",
    "goal_x",
    "goal_y",
    "end_x",
    "end_y",
    "distance",
    "hidden_share",
    "success",
)


def format_outcomes(outcomes: Sequence[Outcome]) -> str:
    """Returns the success rates as a Markdown table."""
    lines = [
        "| feedback | successes | distance from the goal, median / 90th "
        "percentile [mm] |",
        "|---|---|---|",
    ]
    for feedback in dict.fromkeys(o.feedback for o in outcomes):
        mine = [o for o in outcomes if o.feedback == feedback]
        middle, most = np.percentile([o.distance for o in mine], [50, 90])
        count = sum(o.success for o in mine)
        lines.append(
            f"| {feedback} | {count} of {len(mine)} | {1e3 * middle:.0f} / "
            f"{1e3 * most:.0f} |"
        )
    return "\n".join(lines)


def WriteOutcomes(outcomes: Sequence[Outcome], filename: Path) -> None:
    """Writes a row per run; lengths are in meters."""
    with filename.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_COLUMNS)
        for o in outcomes:
            numbers = [*o.goal, *o.end, o.distance, o.hidden]
            texts = [f"{x:.4f}" for x in numbers]
            writer.writerow([o.feedback, o.seed, *texts, int(o.success)])
