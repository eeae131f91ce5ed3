"""Figures of the errors over time, with 95 % confidence bands.

A line is the mean over runs, and the error of a run is the mean over its
repeats. The band says where the mean of many more runs would be. Where there is
only one run, line and band are over its repeats. The range is chosen without
CVPF, which doesn't follow the object and would flatten all other lines.
"""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
import numpy as np

from pbpf_drake.diagrams.paper.evaluation import Result
from pbpf_drake.diagrams.paper.paper_statistics import confidence_band
from pbpf_drake.diagrams.paper.paper_values import METHOD_TITLES, OBJECT_TITLES
from pbpf_drake.results.plot_style import draw_grid, style_of

_METRICS = (
    ("position", 100.0, "position error [cm]"),
    ("rotation", 1.0, "rotation error [rad]"),
)


def PlotBands(results: Sequence[Result], filename: str | Path) -> None:
    """Writes what MakeBandFigure draws; the file's ending is the format."""
    MakeBandFigure(results).savefig(filename)


def MakeBandFigure(results: Sequence[Result]) -> Figure:
    """Draws a column per object: position above, rotation below.

    Args:
        results: of one scene, of any methods.
    """
    names = list(results[0].errors)
    figure = Figure(figsize=(max(7.0, 4.5 * len(names)), 5.5), dpi=110)
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained")
    axes = figure.subplots(2, len(names), sharex=True, squeeze=False)
    for column, name in enumerate(names):
        axes[0, column].set_title(OBJECT_TITLES.get(name, name))
        axes[1, column].set_xlabel("time [s]")
        for ax, (metric, scale, _) in zip(
            axes[:, column], _METRICS, strict=True
        ):
            _draw(ax, results, name, metric, scale)
    for ax, (_, _, label) in zip(axes[:, 0], _METRICS, strict=True):
        ax.set_ylabel(label)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=len(labels),
        frameon=False,
    )
    return figure


def stack_samples(
    results: Sequence[Result], name: str, metric: str
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the errors over time of each run, or of each repeat of one run.

    Args:
        results: of one scene and one method.
        name: of the object.
        metric: one of METRICS.

    Returns:
        The times (T,) of the longest result, and the errors (R, T), which are
        means over repeats; NaN where no repeat has a known error.
    """
    times = max((r.times for r in results), key=len)
    single = len({r.run for r in results}) == 1
    groups: dict[int, list[np.ndarray]] = {}
    for r in results:
        padded = np.full(len(times), np.nan)
        padded[: len(r.times)] = r.errors[name][metric]
        groups.setdefault(r.repeat if single else r.run, []).append(padded)
    return times, np.array([_known_mean(g) for g in groups.values()])


def _known_mean(rows: Sequence[np.ndarray]) -> np.ndarray:
    stacked = np.array(rows)
    known = np.isfinite(stacked)
    total = np.where(known, stacked, 0.0).sum(axis=0)
    count = known.sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _draw(
    ax: Axes,
    results: Sequence[Result],
    name: str,
    metric: str,
    scale: float,
) -> None:
    top = 0.0
    methods = {r.method for r in results}
    for method in (m for m in METHOD_TITLES if m in methods):
        mine = [r for r in results if r.method == method]
        times, samples = stack_samples(mine, name, metric)
        mean, low, high = confidence_band(samples, np.random.default_rng(0))
        color, dashes = style_of(method)
        ax.plot(
            times,
            scale * mean,
            color=color,
            linestyle=dashes,
            label=METHOD_TITLES[method],
        )
        ax.fill_between(
            times, scale * low, scale * high, color=color, alpha=0.2, lw=0
        )
        if method != "cvpf" or methods == {"cvpf"}:
            top = max(top, scale * float(np.nanmax(high, initial=0.0)))
    ax.set_ylim(0.0, 1.05 * top if top > 0 else 1.0)
    draw_grid(ax)
