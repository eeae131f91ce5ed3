from matplotlib.colors import to_hex
from matplotlib.image import imread
import numpy as np
import pytest
from track_fixtures import make_record, make_truth

from pbpf_drake.results.diagnostic_plot import (
    MakeDiagnosticFigure,
    PlotDiagnostics,
    running_mean,
)
from pbpf_drake.results.track_diagnostics import Diagnostics, ParameterTrace

GREEN = "#009e73"
BLACK = "#222222"
TRUTH = {"box": make_truth()}


def _diagnostics(record, physics: bool = True) -> Diagnostics:
    num_steps, num_objects = record.tracked.shape
    trace = ParameterTrace(
        np.tile([0.1, 0.3, 0.6], (num_steps, num_objects, 1)),
        np.tile([0.0, 0.2, 0.5], (num_objects, 1)),
    )
    known = trace if physics else None
    return Diagnostics(np.full(record.tracked.shape, 0.75), known, known)


def _lines(ax, color) -> list[np.ndarray]:
    return [
        np.asarray(line.get_ydata())
        for line in ax.get_lines()
        if to_hex(line.get_color()) == color
    ]


def _texts(ax) -> str:
    return " ".join(text.get_text() for text in ax.texts)


def test_lines_are_what_the_axes_say():
    record = make_record()
    figure = MakeDiagnosticFigure(record, _diagnostics(record), TRUTH)
    errors, size, visibility, friction, mass = figure.axes
    assert errors.get_ylabel() == "error and spread\n[cm]"
    np.testing.assert_allclose(_lines(errors, BLACK)[0], 5.0)
    # The square root of 2² + 3² + 6² is 7.
    np.testing.assert_allclose(_lines(errors, GREEN)[0], 0.7)
    np.testing.assert_allclose(_lines(size, GREEN)[0], 50.0)
    assert "M = 4" in _texts(size)
    np.testing.assert_allclose(_lines(visibility, GREEN)[0], 0.75)
    for ax in friction, mass:
        np.testing.assert_allclose(_lines(ax, GREEN)[0], 0.3)
        (band,) = ax.collections
        heights = band.get_paths()[0].vertices[:, 1]
        assert (heights.min(), heights.max()) == pytest.approx((0.1, 0.6))
        drawn = [line[0] for line in _lines(ax, "#777777")]
        assert drawn == pytest.approx([0.0, 0.2, 0.5])


def test_there_is_a_column_for_each_object():
    record = make_record(names=("box", "can"))
    figure = MakeDiagnosticFigure(record, _diagnostics(record), TRUTH)
    assert len(figure.axes) == 10
    assert [ax.get_title() for ax in figure.axes[:2]] == ["box", "can"]
    # Only the box has a ground truth.
    assert [len(_lines(ax, BLACK)) for ax in figure.axes[:2]] == [1, 0]


def test_what_an_estimator_does_not_have_is_said():
    record = make_record(method="dope", num_particles=0)
    figure = MakeDiagnosticFigure(record, _diagnostics(record, False), {})
    errors, size, _, friction, mass = figure.axes
    assert "not known" in _texts(errors)
    assert "DOPE has no particles" in _texts(size)
    assert "no physics" in _texts(friction)
    assert "no physics" in _texts(mass)


def test_grey_spans_end_with_the_updates_without_a_detection():
    record = make_record()
    record.detected[4:7] = False
    figure = MakeDiagnosticFigure(record, _diagnostics(record), TRUTH)
    for ax in figure.axes:
        (span,) = [p for p in ax.patches if p.get_facecolor()[0] > 0.8]
        edges = ax.transData.inverted().transform(span.get_extents())[:, 0]
        np.testing.assert_allclose(edges, [4, 7])


def test_a_mean_is_that_of_the_rows_around():
    values = np.arange(6.0)[:, None] ** 2
    means = running_mean(values, 3)[:, 0]
    expected = [0.5, 5 / 3, 14 / 3, 29 / 3, 50 / 3, 20.5]
    np.testing.assert_allclose(means, expected)


def test_rows_that_are_not_known_do_not_count_and_stay_so():
    values = np.array([[1.0], [np.nan], [5.0], [7.0]])
    means = running_mean(values, 3)[:, 0]
    np.testing.assert_allclose(means, [1.0, np.nan, 6.0, 6.0])


@pytest.mark.parametrize("num_steps", [0, 1, 10])
def test_any_length_can_be_drawn(tmp_path, num_steps):
    record = make_record(num_steps=num_steps)
    path = tmp_path / "diagnostics.png"
    PlotDiagnostics(record, _diagnostics(record), TRUTH, path)
    assert imread(path).shape == (1200, 960, 4)
