"""The colors of all that is drawn, in plots, in Meshcat and in images.

The estimate is green and the detector yellow everywhere, as in Fig. 1 of the
paper. The values differ: a thin line in an image has to be brighter than a
solid body in Meshcat, and both than a line on white paper.
"""

# Of a line in a plot: its color, and its dashes as matplotlib has them.
LineStyle = tuple[str, str | tuple[int, tuple[float, ...]]]

# Lines of plots by method, from Okabe and Ito's palette, whose colors the
# color-blind can tell apart as well.
METHOD_LINES: dict[str, LineStyle] = {
    "dope": ("#E69F00", (0, (5, 1.5))),
    "cvpf": ("#D55E00", (0, (1, 1))),
    "pbpf": ("#009E73", "solid"),
    "pbpf-v": ("#0072B2", "solid"),
}
OTHER_LINE: LineStyle = ("#CC79A7", "solid")
# What else is in plots: the error of the only method there, θ as it was drawn,
# spans of time without a detection, and the grid.
PLOT_ERROR = "#222222"
PLOT_PRIOR = "#777777"
PLOT_HIDDEN = "#E4E4E4"
PLOT_GRID = "#CCCCCC"

# Bodies in Meshcat: red, green and blue, from 0 to 1.
MESHCAT_ESTIMATE = (0.1, 0.75, 0.3)
MESHCAT_DETECTION = (1.0, 0.8, 0.0)
MESHCAT_TRUTH = (0.1, 0.3, 1.0)

# Lines in images, and what is behind them where there is no image: blue, green
# and red, from 0 to 255, as OpenCV has them.
IMAGE_ESTIMATE = (90, 224, 25)
IMAGE_DETECTION = (0, 213, 255)
IMAGE_SURROUNDINGS = (110, 110, 110)
IMAGE_BACKGROUND = (40, 40, 40)
