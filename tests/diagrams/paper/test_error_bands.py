import numpy as np
import pytest
from result_fixtures import make_result

from pbpf_drake.diagrams.paper.error_bands import (
    MakeBandFigure,
    PlotBands,
    stack_samples,
)


def _results(method: str, size: float, runs: int = 3):
    return [
        make_result(
            method=method,
            run=run,
            repeat=repeat,
            errors={"position": size * (run + 1), "rotation": 0.1 * size},
            names=("cracker", "soup"),
        )
        for run in range(runs)
        for repeat in range(2)
    ]


def test_a_sample_is_a_run_averaged_over_its_repeats():
    first, second = np.array([1, 2, np.nan, np.nan, 5]), np.full(5, 3.0)
    results = [
        make_result(run=0, repeat=0, errors={"position": first}),
        make_result(run=0, repeat=1, errors={"position": second}),
        make_result(run=1, repeat=0, errors={"position": 7.0}, num_steps=3),
    ]
    times, samples = stack_samples(results, "cracker", "position")
    np.testing.assert_allclose(times, 0.16 * np.arange(1, 6))
    nan = np.nan
    np.testing.assert_array_equal(
        samples, [[2, 2.5, 3, 3, 4], [7, 7, 7, nan, nan]]
    )


def test_with_one_run_a_sample_is_a_repeat():
    _, samples = stack_samples(_results("pbpf", 1.0, 1), "soup", "position")
    assert samples.shape == (2, 5)


def test_lines_are_means_over_runs_with_bands_around_them():
    results = _results("pbpf", 0.01) + _results("dope", 0.05)
    figure = MakeBandFigure(results)
    assert len(figure.axes) == 4
    position = figure.axes[0]
    lines = {line.get_label(): line for line in position.get_lines()}
    assert set(lines) == {"PBPF", "DOPE"}
    np.testing.assert_allclose(lines["PBPF"].get_ydata(), 2.0)  # cm
    np.testing.assert_allclose(lines["DOPE"].get_ydata(), 10.0)
    band = position.collections[list(lines).index("PBPF")]
    y = band.get_paths()[0].vertices[:, 1]
    assert 1.0 <= y.min() < 1.5 and 2.5 < y.max() <= 3.0
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(
        lines
    )


def test_cvpf_does_not_flatten_the_others():
    figure = MakeBandFigure(_results("pbpf", 0.01) + _results("cvpf", 50.0))
    assert figure.axes[0].get_ylim()[1] == pytest.approx(3.15)
    alone = MakeBandFigure(_results("cvpf", 50.0))
    assert alone.axes[0].get_ylim()[1] > 10_000


def test_a_picture_is_written(tmp_path):
    PlotBands(_results("pbpf", 0.01), tmp_path / "errors.png")
    assert (tmp_path / "errors.png").read_bytes().startswith(b"\x89PNG")
