"""What the plots of a run have in common."""

from matplotlib.axes import Axes
import numpy as np

from pbpf_drake.results.track_record import TrackRecord

# Okabe and Ito's palette, told apart by the color-blind as well; the estimate
# is green and the detector yellow, as in the replay.
_STYLES: dict[str, tuple[str, str | tuple]] = {
    "dope": ("#E69F00", (0, (5, 1.5))),
    "cvpf": ("#D55E00", (0, (1, 1))),
    "pbpf": ("#009E73", "solid"),
    "pbpf-v": ("#0072B2", "solid"),
}
_OTHER_STYLE: tuple[str, str | tuple] = ("#CC79A7", "solid")
HIDDEN_COLOR = "#E4E4E4"


def style_of(method: str) -> tuple[str, str | tuple]:
    """Returns the color and the dashes of a method's lines."""
    return _STYLES.get(method, _OTHER_STYLE)


def shade_hidden(ax: Axes, record: TrackRecord, name: str) -> None:
    """Greys the spans that end with an update without a detection."""
    hidden = ~record.detected[:, record.object_names.index(name)].astype(bool)
    edges = np.flatnonzero(np.diff(np.r_[0, hidden.astype(int), 0]))
    starts = np.r_[0.0, record.times]
    for first, end in edges.reshape(-1, 2):
        ax.axvspan(
            starts[first], record.times[end - 1], color=HIDDEN_COLOR, lw=0
        )


def decorate(ax: Axes, note: str = "") -> None:
    """Draws a grid, and a note where something can't be drawn."""
    ax.grid(True, color="#CCCCCC", lw=0.5)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)
    if note:
        ax.text(0.5, 0.9, note, transform=ax.transAxes, ha="center")
