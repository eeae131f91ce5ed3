"""What the plots of a run have in common."""

from matplotlib.axes import Axes
import numpy as np

from pbpf_drake.results.track_record import TrackRecord

# Of a line: its color, and its dashes as matplotlib has them.
LineStyle = tuple[str, str | tuple[float, tuple[float, ...]]]

# By method. The colors are from Okabe and Ito's palette, which the color-blind
# can read, too. The estimate is green and the detector yellow, as in the
# replay.
_METHOD_LINES: dict[str, LineStyle] = {
    "dope": ("#E69F00", (0, (5, 1.5))),
    "cvpf": ("#D55E00", (0, (1, 1))),
    "pbpf": ("#009E73", "solid"),
    "pbpf-v": ("#0072B2", "solid"),
}
_OTHER_LINE: LineStyle = ("#CC79A7", "solid")
# The error, where a plot has one method only.
ERROR_COLOR = "#222222"
# What was known before: θ as it was drawn.
PRIOR_COLOR = "#777777"
# Spans of time without a detection.
HIDDEN_COLOR = "#E4E4E4"
_GRID_COLOR = "#CCCCCC"


def style_of(method: str) -> LineStyle:
    """Returns the color and the dashes of a method's lines."""
    return _METHOD_LINES.get(method, _OTHER_LINE)


def shade_hidden(ax: Axes, record: TrackRecord, name: str) -> None:
    """Greys the time before each update that had no detection."""
    hidden = ~record.detected[:, record.object_names.index(name)].astype(bool)
    edges = np.flatnonzero(np.diff(np.r_[0, hidden.astype(int), 0]))
    starts = np.r_[0.0, record.times]
    for first, end in edges.reshape(-1, 2):
        ax.axvspan(
            starts[first], record.times[end - 1], color=HIDDEN_COLOR, lw=0
        )


def draw_grid(ax: Axes) -> None:
    """Draws a grid, and no frame above and to the right."""
    ax.grid(True, color=_GRID_COLOR, lw=0.5)
    ax.spines[["top", "right"]].set_visible(False)


def decorate(ax: Axes, note: str = "") -> None:
    """Draws a grid behind all else, and a note if it isn't empty."""
    draw_grid(ax)
    ax.set_axisbelow(True)
    if note:
        ax.text(0.5, 0.9, note, transform=ax.transAxes, ha="center")
