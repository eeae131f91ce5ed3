import re

import numpy as np
import pytest

from pbpf_drake.diagrams.benchmark.benchmark_filter import STAGES
from pbpf_drake.diagrams.benchmark.benchmark_reference import PredictionErrors
from pbpf_drake.diagrams.benchmark.benchmark_table import (
    OWN,
    Measurement,
    engine_table,
    error_table,
    growth_table,
    json_rows,
    update_line,
    update_table,
)

ERRORS = PredictionErrors(
    np.array([1e-3, 2e-3, 6e-3]), np.array([0.01, 0.02, 0.06])
)


def _measurement(m, k, threads, milliseconds, engine=OWN) -> Measurement:
    stages = STAGES if engine == OWN else ("motion",)
    seconds = {stage: np.full(3, 1e-3) for stage in stages}
    whole = 1e-3 * milliseconds * np.array([0.5, 1.0, 2.0])
    seconds["total" if engine == OWN else "motion"] = whole
    return Measurement(engine, m, k, threads, seconds, ERRORS, 5e5)


def _cells(table: str) -> list[list[str]]:
    head, line, *rows = table.splitlines()
    assert re.fullmatch(r"(\| --- )+\|", line)
    lines = [[c.strip() for c in x[1:-1].split("|")] for x in (head, *rows)]
    assert len({len(cells) for cells in lines}) == 1
    return lines


def test_rows_have_every_stage_and_these_keys_only():
    own, other = (
        _measurement(70, 1, 2, 40.0),
        _measurement(70, 1, 2, 50.0, "mujoco"),
    )
    rows = json_rows([own, other])
    assert [row["stage"] for row in rows] == [*STAGES, "motion"]
    assert rows[-2] == {
        "engine": "pbpf",
        "particles": 70,
        "objects": 1,
        "threads": 2,
        "stage": "total",
        "median_ms": pytest.approx(40.0),
        "p95_ms": pytest.approx(76.0),
        "max_ms": pytest.approx(80.0),
        "error_mm": pytest.approx(3.0),
        "error_rad": pytest.approx(0.03),
    }
    assert rows[-1]["engine"] == "mujoco"
    assert all(row.keys() == rows[0].keys() for row in rows)


def test_the_real_time_factor_is_the_period_over_the_median():
    measurement = _measurement(70, 1, 2, 40.0)
    table = update_table([measurement], 0.16)
    head, row = _cells(table)
    assert table.endswith(update_line(measurement, 0.16))
    found = dict(zip(head, row, strict=True))
    assert found["real-time factor"] == "4.00"
    assert (found["total"], found["p95"], found["max"]) == (
        "40.00",
        "76.00",
        "80.00",
    )
    assert found["motion"] == "1.00"
    assert found["MB/particle"] == "0.50"


def test_growth_is_relative_to_the_smallest_case():
    table = growth_table(
        [
            _measurement(70, 1, 1, 70.0),
            _measurement(70, 1, 2, 40.0),
            _measurement(140, 3, 1, 420.0),
            _measurement(140, 3, 2, 200.0),
            _measurement(140, 1, 1, 154.0),
            _measurement(140, 1, 2, 80.0),
            _measurement(70, 3, 1, 210.0),
            _measurement(70, 3, 2, 100.0),
        ],
        process_speedup=1.75,
    )
    _, *rows = _cells(table)
    found = {tuple(map(int, row[:3])): row[3:] for row in rows}
    assert found[70, 1, 1] == ["1.000", "1.00", "1.00", "1.00", "-"]
    assert found[70, 1, 2] == ["0.571", "1.00", "1.00", "1.75", "1.00"]
    assert found[140, 1, 1] == ["1.100", "1.10", "1.00", "1.00", "-"]
    assert found[140, 3, 1] == ["3.000", "1.00", "2.73", "1.00", "-"]
    assert found[140, 3, 2] == ["1.429", "1.00", "2.50", "2.10", "1.20"]


def test_growth_of_one_case_is_known():
    _, row = _cells(growth_table([_measurement(70, 3, 2, 40.0)], 1.5))
    assert row[4:] == ["1.00", "1.00", "1.00", "-"]


def test_errors_stand_once_per_engine_and_number_of_objects():
    found = [
        _measurement(70, 1, 1, 40.0),
        _measurement(70, 1, 2, 40.0),
        _measurement(70, 1, 2, 40.0, "pybullet"),
    ]
    _, *rows = _cells(error_table(found))
    assert [row[:2] for row in rows] == [["pbpf", "1"], ["pybullet", "1"]]
    assert rows[0][2:] == ["3.000", "2.000", "0.0300", "0.0200"]


def test_engines_stand_side_by_side_per_particle():
    found = [
        _measurement(100, 1, 2, 50.0),
        _measurement(100, 1, 2, 200.0, "pybullet"),
        _measurement(100, 1, 2, 25.0, "mujoco"),
        _measurement(400, 1, 2, 200.0),
        _measurement(400, 1, 2, 100.0, "mujoco"),
    ]
    head, small, large = _cells(engine_table(found))
    assert head[5::3] == ["mujoco", "pybullet"]
    # Of the filter: 50 ms with 1 ms of motion.
    assert small[3:5] == ["0.500", "0.010"]
    assert small[5:8] == ["0.250", "25.000", "0.500"]
    assert small[8:] == ["2.000", "200.000", "4.000"]
    assert large[8:] == ["-", "-", "-"]
