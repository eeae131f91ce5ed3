"""errors.png: the errors of one or more methods over the time of a log.

There is a column per object, with the position error above and the rotation
error below. Grey spans have no detection. The band in a line's color ends at
two standard deviations of the particles: where a line leaves its band, the
error is larger than its filter believes. Position errors beyond one and a half
times the extent of the true motion are cut off, and their peaks are written
out: a pose that never changes would do better. Of an object with a symmetry,
the thick line is the rotation error up to it, and the thin one the raw error.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
import numpy as np

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.results.plot_style import (
    HIDDEN_COLOR,
    decorate,
    shade_hidden,
    style_of,
)
from pbpf_drake.results.pose_errors import (
    compute_errors,
    position_stddev,
    rotation_stddev,
)
from pbpf_drake.results.report import NO_SYMMETRIES, Symmetries
from pbpf_drake.results.track_record import TrackRecord


def PlotErrors(
    records: Sequence[TrackRecord],
    ground_truth: Mapping[str, PoseRecord],
    filename: str | Path,
    symmetries: Symmetries = NO_SYMMETRIES,
) -> None:
    """Writes what MakeErrorFigure draws; the file's ending is the format."""
    MakeErrorFigure(records, ground_truth, symmetries).savefig(filename)


def MakeErrorFigure(
    records: Sequence[TrackRecord],
    ground_truth: Mapping[str, PoseRecord],
    symmetries: Symmetries = NO_SYMMETRIES,
) -> Figure:
    """Draws the errors of all records.

    Args:
        records: one per run on the same log; methods may repeat.
        ground_truth: by name of the tracked model; may lack some or all.
        symmetries: of objects, by name; others have none.

    Returns:
        The figure, with axes in rows of a column per object.
    """
    names = list(dict.fromkeys(n for r in records for n in r.object_names))
    figure = Figure(figsize=(max(8.0, 5.0 * len(names)), 6.0), dpi=120)
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained")
    axes = figure.subplots(2, len(names), sharex=True, squeeze=False)
    for column, name in enumerate(names):
        _draw_object(
            axes[:, column],
            [r for r in records if name in r.object_names],
            name,
            ground_truth.get(name),
            symmetries.get(name),
        )
    axes[0, 0].set_ylabel("position error [cm]")
    axes[1, 0].set_ylabel("rotation error [rad]")
    _add_legend(figure, records)
    return figure


def _draw_object(
    axes: np.ndarray,
    records: Sequence[TrackRecord],
    name: str,
    truth: PoseRecord | None,
    symmetry: SymmetryConfig | None,
) -> None:
    """Fills one column: position error above, rotation error below."""
    axes[0].set_title(name, fontweight="bold")
    axes[1].set_xlabel("time [s]")
    axes[1].set_xlim(0.0, max(np.max(r.times, initial=0.1) for r in records))
    errors = [compute_errors(r, name, truth, symmetry) for r in records]
    extent = 0.0
    if truth is not None:
        extent = float(np.linalg.norm(np.ptp(truth.p_WO, axis=0)))
    rows = (
        ([100 * e.position for e in errors], 100, position_stddev),
        ([e.symmetric_rotation for e in errors], 1, rotation_stddev),
    )
    raw = [e.rotation for e in errors]
    if symmetry is not None and symmetry.axis:
        _draw_raw_lines(axes[1], records, raw)
    for ax, (lines, scale, stddev) in zip(axes, rows, strict=True):
        bands = [2 * scale * stddev(r, name) for r in records]
        for record, line, band in zip(records, lines, bands, strict=True):
            _draw_line(ax, record, line, band)
        shade_hidden(ax, records[0], name)
        decorate(ax, "the log has no ground truth" if truth is None else "")
        shown = raw if ax is axes[1] else lines
        peaks = np.array([np.nanmax(x, initial=0.0) for x in shown])
        limit = max(1.5 * scale * extent, 4 * peaks.min())
        _limit_axis(ax, peaks, bands, np.pi if ax is axes[1] else limit)
        if ax is axes[0]:
            _name_cut_lines(ax, [r.method for r in records], peaks)


def _draw_raw_lines(
    ax: Axes, records: Sequence[TrackRecord], errors: Sequence[np.ndarray]
) -> None:
    """Draws rotation errors that don't respect the object's symmetry."""
    for record, line in zip(records, errors, strict=True):
        color, dashes = style_of(record.method)
        ax.plot(record.times, line, color=color, linestyle=dashes, lw=0.6)
    ax.set_title("thick: up to its symmetry, thin: raw", fontsize="small")


def _draw_line(
    ax: Axes, record: TrackRecord, errors: np.ndarray, band: np.ndarray
) -> None:
    color, dashes = style_of(record.method)
    times = record.times
    ax.plot(times, errors, color=color, linestyle=dashes, lw=1.8, zorder=3)
    ax.fill_between(
        times,
        0.0,
        band,
        where=np.isfinite(band),
        color=color,
        alpha=0.12,
        lw=0,
        zorder=2,
    )
    ax.plot(times, band, color=color, lw=0.7, alpha=0.7, zorder=2)


def _limit_axis(
    ax: Axes, peaks: np.ndarray, bands: Sequence[np.ndarray], limit: float
) -> None:
    """Sets the range, so that no line or band flattens all others."""
    band = max(np.nanmax(b, initial=0.0) for b in bands)
    top = min(peaks.max(), limit)
    top = max(top, min(band, 1.5 * top)) if top > 0 else band
    ax.set_ylim(0.0, 1.08 * top if top > 0 else 1.0)


def _name_cut_lines(
    ax: Axes, methods: Sequence[str], peaks: np.ndarray
) -> None:
    """Writes out which methods' errors are beyond the range."""
    top = ax.get_ylim()[1]
    beyond = {m: p for m, p in zip(methods, peaks, strict=True) if p > top}
    if beyond:
        text = ", ".join(
            f"{m.upper()} up to {p:.0f} cm" for m, p in beyond.items()
        )
        ax.text(
            0.99,
            0.98,
            f"off the scale: {text}",
            transform=ax.transAxes,
            ha="right",
            va="top",
            fontsize="small",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8},
            zorder=4,
        )


def _add_legend(figure: Figure, records: Sequence[TrackRecord]) -> None:
    handles: list[Artist] = []
    band = None
    for record in records:
        color, dashes = style_of(record.method)
        label = record.method.upper()
        if label not in [h.get_label() for h in handles]:
            handles.append(
                Line2D([], [], color=color, ls=dashes, lw=2, label=label)
            )
        if record.particles.shape[1] and band is None:
            band = Patch(fc=to_rgba(color, 0.15), ec=color, lw=0.7)
            band.set_label("2σ of the particles")
    handles += [band] if band else []
    handles.append(Patch(color=HIDDEN_COLOR, lw=0, label="no detection"))
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=len(handles),
        frameon=False,
    )
