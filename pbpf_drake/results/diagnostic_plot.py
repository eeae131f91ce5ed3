"""diagnostics.png: how a filter came to its estimates, over the time of a log.

There is a column per object. From top to bottom, it shows:

- the position error, and the spread of the particles, which is the error that
  the filter expects
- the effective sample size and, in grey, the particles that were used, unless
  these were all
- how visible the estimate is
- friction and mass of the surviving particles, averaged over nine updates

Dashed lines are the medians of all draws of θ, and dotted lines are their first
and last tenths. Where the survivors' values are elsewhere, the detections say
something about θ. Grey spans have no detection.
"""

from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
import numpy as np

from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.results.plot_style import (
    ERROR_COLOR,
    HIDDEN_COLOR,
    PRIOR_COLOR,
    decorate,
    shade_hidden,
    style_of,
)
from pbpf_drake.results.pose_errors import compute_errors, position_stddev
from pbpf_drake.results.track_diagnostics import Diagnostics, ParameterTrace
from pbpf_drake.results.track_record import TrackRecord

# A parameter is averaged over so many updates, as a single one says little.
_WINDOW = 9
_ROWS = (
    "error and spread\n[cm]",
    "effective sample\nsize [% of M]",
    "visibility of\nthe estimate",
    "friction",
    "mass [kg]",
)


def PlotDiagnostics(
    record: TrackRecord,
    diagnostics: Diagnostics,
    ground_truth: dict[str, PoseRecord],
    filename: str | Path,
) -> None:
    """Writes what MakeDiagnosticFigure draws; the ending is the format."""
    MakeDiagnosticFigure(record, diagnostics, ground_truth).savefig(filename)


def MakeDiagnosticFigure(
    record: TrackRecord,
    diagnostics: Diagnostics,
    ground_truth: dict[str, PoseRecord],
) -> Figure:
    """Draws the diagnostics of one run.

    Args:
        record: what the run produced.
        diagnostics: of the run.
        ground_truth: by name of the tracked model; may lack some or all.

    Returns:
        The figure, with axes in rows of a column per object.
    """
    names = record.object_names
    figure = Figure(figsize=(max(8.0, 5.0 * len(names)), 10.0), dpi=120)
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained")
    axes = figure.subplots(len(_ROWS), len(names), sharex=True, squeeze=False)
    for k, name in enumerate(names):
        column = axes[:, k]
        column[0].set_title(name, fontweight="bold")
        column[-1].set_xlabel("time [s]")
        column[-1].set_xlim(0.0, np.max(record.times, initial=0.1))
        for ax in column:
            shade_hidden(ax, record, name)
            decorate(ax)
        _draw_errors(column[0], record, name, ground_truth.get(name))
        _draw_sample_size(column[1], record)
        _draw_visibility(column[2], record, diagnostics.visibility[:, k])
        for ax, trace in zip(
            column[3:], (diagnostics.friction, diagnostics.mass), strict=True
        ):
            _draw_parameter(ax, record, trace, k)
    for ax, label in zip(axes[:, 0], _ROWS, strict=True):
        ax.set_ylabel(label)
    figure.align_ylabels(axes[:, 0])
    _add_legend(figure, record)
    return figure


def _add_legend(figure: Figure, record: TrackRecord) -> None:
    color, _ = style_of(record.method)
    method = record.method.upper()
    handles: list[Artist] = [
        Line2D([], [], color=ERROR_COLOR, lw=2, label="error"),
        Line2D([], [], color=color, lw=2, label=method),
        Patch(color=color, alpha=0.2, lw=0, label="10 to 90 % of θ"),
        Line2D([], [], color=PRIOR_COLOR, ls="--", label="θ as drawn"),
        Patch(color=HIDDEN_COLOR, lw=0, label="no detection"),
    ]
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=len(handles),
        frameon=False,
        columnspacing=1.2,
    )


def _draw_errors(
    ax: Axes, record: TrackRecord, name: str, truth: PoseRecord | None
) -> None:
    color, _ = style_of(record.method)
    spread = 100 * position_stddev(record, name)
    error = 100 * compute_errors(record, name, truth).position
    if np.isfinite(error).any():
        ax.plot(record.times, error, color=ERROR_COLOR, lw=1.8)
    if np.isfinite(spread).any():
        ax.plot(record.times, spread, color=color, lw=1.8)
    if not (np.isfinite(error).any() or np.isfinite(spread).any()):
        _say(ax, "not known")
    ax.set_ylim(bottom=0)


def _draw_sample_size(ax: Axes, record: TrackRecord) -> None:
    count = record.particles.shape[1]
    if not count:
        _say(ax, f"{record.method.upper()} has no particles")
        return
    color, _ = style_of(record.method)
    share = 100 * record.effective_sample_size / count
    ax.plot(record.times, share, color=color, lw=1.2)
    used = 100 * record.particles_used / count
    if np.any(used < 100):
        ax.plot(record.times, used, color=PRIOR_COLOR, lw=1.2)
    ax.set_ylim(0, 105)
    ax.text(
        0.99, 0.05, f"M = {count}", transform=ax.transAxes, ha="right"
    )  # fmt: skip


def _draw_visibility(
    ax: Axes, record: TrackRecord, visibility: np.ndarray
) -> None:
    color, _ = style_of(record.method)
    if not np.isfinite(visibility).any():
        _say(ax, "not known")
        return
    ax.plot(record.times, visibility, color=color, lw=1.5)
    ax.set_ylim(0, 1.05)


def _draw_parameter(
    ax: Axes, record: TrackRecord, trace: ParameterTrace | None, k: int
) -> None:
    """Draws the median and where four fifths of the weight are."""
    if trace is None:
        _say(ax, f"{record.method.upper()} has no physics")
        return
    color, _ = style_of(record.method)
    low, middle, high = running_mean(trace.survivors[:, k], _WINDOW).T
    ax.fill_between(record.times, low, high, color=color, alpha=0.2, lw=0)
    ax.plot(record.times, middle, color=color, lw=1.8)
    for value, dashes in zip(trace.drawn[k], (":", "--", ":"), strict=True):
        ax.axhline(value, color=PRIOR_COLOR, lw=1.0, ls=dashes)
    ax.set_ylim(bottom=0)


def running_mean(values: np.ndarray, window: int) -> np.ndarray:
    """Returns centred means over a window of rows, (N, S).

    Args:
        values: (N, S); rows with NaN don't count.
        window: an odd number of rows; there are fewer at both ends.

    Returns:
        NaN where there is no row that counts, or the row itself is NaN.
    """
    valid = np.isfinite(values).all(axis=1)
    half = window // 2
    means = np.full(values.shape, np.nan)
    for i in np.flatnonzero(valid):
        rows = slice(max(0, i - half), i + half + 1)
        means[i] = values[rows][valid[rows]].mean(axis=0)
    return means


def _say(ax: Axes, text: str) -> None:
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center")
    ax.set_yticks([])
