import subprocess
import sys

from matplotlib.colors import to_hex
from matplotlib.image import imread
import numpy as np
import pytest
from track_fixtures import make_record, make_truth

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.results.error_plot import MakeErrorFigure, PlotErrors

GREEN = "#009e73"
YELLOW = "#e69f00"


def _line(ax, color):
    """Returns the thick line of a color: (N,) times, (N,) values."""
    (line,) = [
        x
        for x in ax.get_lines()
        if to_hex(x.get_color()) == color and x.get_linewidth() > 1
    ]
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def _count_green_pixels(filename):
    pixels = imread(filename)[:, :, :3]
    assert pixels.shape == (720, 960, 3)
    green = np.array([0, 158, 115]) / 255
    return np.all(np.abs(pixels - green) < 0.01, axis=-1).sum()


def test_lines_are_the_errors_in_the_units_of_the_axes():
    dope = make_record(method="dope", growth=1.0, num_particles=0)
    truth = {"box": make_truth()}
    figure = MakeErrorFigure([make_record(), dope], truth)
    above, below = figure.axes
    assert above.get_ylabel() == "position error [cm]"
    assert below.get_ylabel() == "rotation error [rad]"
    assert below.get_xlabel() == "time [s]"
    times, errors = _line(above, GREEN)
    np.testing.assert_array_equal(times, np.arange(1.0, 11.0))
    np.testing.assert_allclose(errors, 5.0)
    np.testing.assert_allclose(_line(above, YELLOW)[1], 5.0 * times)
    np.testing.assert_allclose(_line(below, YELLOW)[1], 0.13 * times)


def test_of_a_symmetric_object_the_thick_line_is_the_error_up_to_symmetry():
    """The estimate is turned by 0.12 rad about y and by 0.05 rad about z."""
    record, truth = make_record(), {"box": make_truth()}
    can = {"box": SymmetryConfig(axis=[0.0, 1.0, 0.0])}
    _, below = MakeErrorFigure([record], truth, can).axes
    np.testing.assert_allclose(_line(below, GREEN)[1], 0.05, atol=1e-3)
    (thin,) = [x for x in below.get_lines() if x.get_linewidth() == 0.6]
    np.testing.assert_allclose(thin.get_ydata(), 0.13)
    assert "up to its symmetry" in below.get_title()
    assert below.get_ylim()[1] > 0.13


def test_there_is_a_column_for_each_object_and_one_legend():
    records = [make_record(names=("box", "can")), make_record(method="cvpf")]
    figure = MakeErrorFigure(records, {"box": make_truth()})
    assert [ax.get_title() for ax in figure.axes] == ["box", "can", "", ""]
    (legend,) = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == [
        "PBPF",
        "CVPF",
        "2σ of the particles",
        "no detection",
    ]
    texts = [t.get_text() for t in figure.axes[1].texts]
    assert texts == ["the log has no ground truth"]


def test_grey_spans_end_with_the_updates_without_a_detection():
    record = make_record()
    record.detected[[0, 4, 5, 6, 9]] = False
    figure = MakeErrorFigure([record], {"box": make_truth()})
    for ax in figure.axes:
        spans = [p.get_extents() for p in ax.patches]
        spans = [ax.transData.inverted().transform(s)[:, 0] for s in spans]
        np.testing.assert_allclose(spans, [[0, 1], [4, 7], [9, 10]])


def test_band_ends_at_two_standard_deviations_of_the_particles():
    figure = MakeErrorFigure([make_record()], {"box": make_truth()})
    # The square roots of 2² + 3² + 6² and of 1² + 2² + 2².
    for ax, expected in zip(figure.axes, (1.4, 0.06), strict=True):
        (band,) = ax.collections
        points = band.get_paths()[0].vertices
        assert points[:, 1].max() == pytest.approx(expected)
        assert points[:, 1].min() == 0.0


def test_a_method_that_diverges_does_not_flatten_the_others():
    diverged = make_record(method="cvpf", growth=50.0)
    records = [make_record(), diverged]
    figure = MakeErrorFigure(records, {"box": make_truth()})
    above, below = figure.axes
    # The object moves by 1 m.
    assert above.get_ylim() == pytest.approx((0.0, 1.08 * 150.0))
    (text,) = [t.get_text() for t in above.texts]
    assert text == f"off the scale: CVPF up to {5 * 451} cm"
    assert below.get_ylim()[1] <= 1.08 * np.pi


def test_a_band_is_shown_where_the_errors_are_much_smaller():
    record = make_record()
    record.covariances[:] *= 1e4
    figure = MakeErrorFigure([record], {"box": make_truth()})
    assert figure.axes[0].get_ylim()[1] == pytest.approx(1.08 * 1.5 * 5.0)


@pytest.mark.parametrize(
    ("num_steps", "truth"), [(0, {}), (1, {"box": make_truth()}), (10, {})]
)
def test_a_record_without_errors_can_be_drawn(tmp_path, num_steps, truth):
    PlotErrors([make_record(num_steps=num_steps)], truth, tmp_path / "e.png")
    assert _count_green_pixels(tmp_path / "e.png") < 1000


def test_picture_shows_the_lines(tmp_path):
    truth = {"box": make_truth()}
    PlotErrors([make_record()], truth, tmp_path / "e.png")
    assert _count_green_pixels(tmp_path / "e.png") > 2000


def test_pyplots_global_state_is_not_used():
    code = (
        "import sys, pbpf_drake.results.error_plot; "
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    subprocess.run([sys.executable, "-P", "-c", code], check=True)
