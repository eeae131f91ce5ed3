"""What the plots of a run have in common."""

from matplotlib.axes import Axes
import numpy as np

from pbpf_drake.palette import (
    METHOD_LINES,
    OTHER_LINE,
    PLOT_GRID,
    PLOT_HIDDEN,
    LineStyle,
)
from pbpf_drake.results.track_record import TrackRecord


def style_of(method: str) -> LineStyle:
    """Returns the color and the dashes of a method's lines."""
    return METHOD_LINES.get(method, OTHER_LINE)


def shade_hidden(ax: Axes, record: TrackRecord, name: str) -> None:
    """Greys the time before each update that had no detection."""
    hidden = ~record.detected[:, record.object_names.index(name)].astype(bool)
    edges = np.flatnonzero(np.diff(np.r_[0, hidden.astype(int), 0]))
    starts = np.r_[0.0, record.times]
    for first, end in edges.reshape(-1, 2):
        ax.axvspan(
            starts[first], record.times[end - 1], color=PLOT_HIDDEN, lw=0
        )


def draw_grid(ax: Axes) -> None:
    """Draws a grid, and no frame above and to the right."""
    ax.grid(True, color=PLOT_GRID, lw=0.5)
    ax.spines[["top", "right"]].set_visible(False)


def decorate(ax: Axes, note: str = "") -> None:
    """Draws a grid behind all else, and a note if it isn't empty."""
    draw_grid(ax)
    ax.set_axisbelow(True)
    if note:
        ax.text(0.5, 0.9, note, transform=ax.transAxes, ha="center")
