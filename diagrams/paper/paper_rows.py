"""The rows of the paper's tables, computed from the results of evaluations."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pbpf_drake.diagrams.paper.evaluation import METRICS, Result
from pbpf_drake.diagrams.paper.paper_statistics import mean_and_stddev, pool
from pbpf_drake.diagrams.paper.paper_values import (
    METHOD_TITLES,
    OBJECT_TITLES,
    PAPER,
    SCENES,
    MeanErrors,
)
from pbpf_drake.results.pose_metrics import area_under_curve

_NONE = MeanErrors(*[float("nan")] * 4)


@dataclass(frozen=True)
class PaperRow:
    """One method's errors of one object in one scene.

    Attributes:
        scene, object, method: their names.
        runs, repeats: how many runs there are results of, and how many of
            each run at least.
        ours: what was measured, NaN where unknown.
        paper: what the paper has, NaN where it has nothing.
        metrics: mean and standard deviation of each of METRICS.
        auc: area under the curve, up to 0.1 m, of the known ADD and ADD-S.
    """

    scene: str
    object: str
    method: str
    runs: int
    repeats: int
    ours: MeanErrors
    paper: MeanErrors
    metrics: dict[str, tuple[float, float]]
    auc: dict[str, float]

    def title(self) -> str:
        """Returns scene and object, as the paper calls them."""
        number = self.scene.rsplit("_", 1)[-1]
        thing = OBJECT_TITLES.get(self.object, self.object)
        if self.scene in SCENES:
            return f"{thing} Scene {number}"
        return f"{thing}, {self.scene}"


def make_paper_rows(results: Iterable[Result]) -> list[PaperRow]:
    """Returns a row for each scene, object and method with results."""
    groups: dict[tuple[str, str, str], list[Result]] = {}
    for result in results:
        for name in result.errors:
            key = (result.scene, name, result.method)
            groups.setdefault(key, []).append(result)
    return [_make_row(*key, groups[key]) for key in sorted(groups, key=_order)]


def find_row(
    rows: Sequence[PaperRow], scene: str, object_name: str, method: str
) -> PaperRow | None:
    """Returns the row of these names, or None."""
    for row in rows:
        if (row.scene, row.object, row.method) == (scene, object_name, method):
            return row
    return None


def ratio_to_dope(rows: Sequence[PaperRow], row: PaperRow) -> tuple[float, ...]:
    """Returns mean errors over DOPE's.

    Returns:
        Of the position, ours and the paper's, and of the rotation, ours and
        the paper's; NaN where unknown.
    """
    dope = find_row(rows, row.scene, row.object, "dope")
    ours = dope.ours if dope else _NONE
    paper = PAPER.get((row.scene, row.object, "dope"), _NONE)
    return (
        _divide(row.ours.pos_mean, ours.pos_mean),
        _divide(row.paper.pos_mean, paper.pos_mean),
        _divide(row.ours.rot_mean, ours.rot_mean),
        _divide(row.paper.rot_mean, paper.rot_mean),
    )


def _make_row(
    scene: str, object_name: str, method: str, results: Sequence[Result]
) -> PaperRow:
    pooled = {m: pool(results, object_name, m) for m in METRICS}
    metrics = {m: mean_and_stddev(x) for m, x in pooled.items()}
    runs = [result.run for result in results]
    return PaperRow(
        scene=scene,
        object=object_name,
        method=method,
        runs=len(set(runs)),
        repeats=min(runs.count(run) for run in runs),
        ours=MeanErrors(*metrics["position"], *metrics["rotation"]),
        paper=PAPER.get((scene, object_name, method), _NONE),
        metrics=metrics,
        auc={m: area_under_curve(pooled[m]) for m in ("add", "add_s")},
    )


def _order(key: tuple[str, str, str]) -> tuple[int, str, int, str, int]:
    """Sorts as the paper does; what it doesn't have comes last."""
    scene, name, method = key
    scenes, names = list(SCENES), list(OBJECT_TITLES)
    known = scenes.index(scene) if scene in scenes else len(scenes)
    place = names.index(name) if name in names else len(names)
    return known, scene, place, name, list(METHOD_TITLES).index(method)


def _divide(a: float, b: float) -> float:
    return a / b if b else float("nan")
