import csv
import dataclasses
import json

import numpy as np
import pytest
from track_fixtures import make_record, make_truth

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.results.report import (
    FormatTable,
    MakeReport,
    WriteErrors,
    WriteReport,
)


def _refuse(constant):
    raise AssertionError(f"{constant} is no JSON")


def _write_and_read(report, tmp_path):
    filename = tmp_path / "report.json"
    WriteReport(report, filename)
    return json.loads(filename.read_text("utf-8"), parse_constant=_refuse)


def test_statistics_match_their_closed_forms(tmp_path):
    # Errors are 5 cm and 0.13 rad times 1, 2, …, 10.
    record = make_record(growth=1.0)
    record.detected[:3] = False
    report = MakeReport([record], {"box": make_truth()}, ["No camera."])
    report = _write_and_read(report, tmp_path)
    assert report["warnings"] == ["No camera."]
    (run,) = report["runs"]
    assert (run["method"], run["seed"]) == ("pbpf", 7)
    assert (run["steps"], run["particles"]) == (10, 4)
    assert run["config"] == {"num_particles": 4}
    update = {"median": 5.5, "p95": 9.55, "max": 10.0}
    assert run["update_time_ms"] == pytest.approx(update)
    # The period is 8.5 ms.
    assert run["late_updates"] == 2
    assert run["particles_used"] == 4
    box = run["objects"]["box"]
    assert box["detected_share"] == pytest.approx(0.7)
    assert box["compared_steps"] == 10
    factors = {"mean": 5.5, "std": np.sqrt(8.25), "median": 5.5, "end": 10}
    for key, unit in (
        ("position_error_m", 0.05),
        ("rotation_error_rad", 0.13),
    ):
        expected = {k: unit * f for k, f in factors.items()}
        assert box[key] == pytest.approx(expected)


def test_end_is_the_last_step_that_can_be_compared():
    record = make_record(growth=1.0)
    report = MakeReport([record], {"box": make_truth(end=4.2)})
    box = report["runs"][0]["objects"]["box"]
    assert box["compared_steps"] == 4
    assert box["position_error_m"]["end"] == pytest.approx(4 * 0.05)


def test_unknown_numbers_are_null(tmp_path):
    record = make_record()
    record.update_ms[:] = np.nan
    report = _write_and_read(MakeReport([record], {}), tmp_path)
    (run,) = report["runs"]
    assert set(run["update_time_ms"].values()) == {None}
    assert run["late_updates"] == 0
    box = run["objects"]["box"]
    assert set(box["position_error_m"].values()) == {None}
    assert set(box["rotation_error_rad"].values()) == {None}
    assert box["compared_steps"] == 0
    assert box["detected_share"] == 1.0


def test_a_run_without_updates_can_be_reported(tmp_path):
    records = [make_record(num_steps=0)]
    report = MakeReport(records, {"box": make_truth()})
    (run,) = _write_and_read(report, tmp_path)["runs"]
    assert run["steps"] == 0
    assert run["objects"]["box"]["detected_share"] is None
    assert FormatTable(report).splitlines()[3].split()[:3] == [
        "box",
        "pbpf",
        "-",
    ]


def test_any_config_becomes_json(tmp_path):
    config = {
        "filter": ParticleFilterConfig(),
        "numbers": (np.float32(0.5), np.arange(3), float("inf")),
        "path": tmp_path,
    }
    record = dataclasses.replace(make_record(), config=config)
    report = _write_and_read(MakeReport([record], {}), tmp_path)
    found = report["runs"][0]["config"]
    assert found["filter"] == dataclasses.asdict(ParticleFilterConfig())
    assert found["numbers"] == [0.5, [0, 1, 2], None]
    assert found["path"] == str(tmp_path)


def test_errors_csv_has_a_row_for_each_run_object_and_update(tmp_path):
    pbpf = make_record(names=("box", "can"))
    pbpf.detected[4, 0] = False
    dope = make_record(method="dope", num_particles=0)
    truth = {"box": make_truth(end=6.0)}
    WriteErrors([pbpf, dope], truth, tmp_path / "errors.csv")
    with open(tmp_path / "errors.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(r["method"], r["object"]) for r in rows[::10]] == [
        ("pbpf", "box"),
        ("pbpf", "can"),
        ("dope", "box"),
    ]
    assert rows[4] == {
        "time": "5.000000",
        "object": "box",
        "method": "pbpf",
        "position_error_m": "0.050000",
        "rotation_error_rad": "0.130000",
        "detected": "0",
        "effective_sample_size": "2.000",
        "position_stddev_m": "0.007000",
    }
    # The truth ends at 6 s, and there is none of the can.
    assert {r["position_error_m"] for r in rows[6:20]} == {""}
    # The detector has neither particles nor a spread.
    assert {r["effective_sample_size"] for r in rows[20:]} == {""}
    assert {r["position_stddev_m"] for r in rows[20:]} == {""}


def test_table_shows_every_object_and_method_in_aligned_columns():
    names = ("box", "a_rather_long_name")
    records = [
        make_record(names=names),
        make_record(method="dope", names=names, growth=1.0, num_particles=0),
    ]
    report = MakeReport(records, {"box": make_truth()})
    lines = FormatTable(report).splitlines()
    header, rule, *rows = lines[1:]
    assert [r.split()[:2] for r in rows] == [
        ["box", "pbpf"],
        ["box", "dope"],
        ["a_rather_long_name", "pbpf"],
        ["a_rather_long_name", "dope"],
    ]
    # mean, std, median, end of position, then of rotation; detected; update.
    numbers = "0.050 0.000 0.050 0.050 0.130 0.000 0.130 0.130 100% 5.5 9.5"
    assert rows[0].split()[2:] == [*numbers.split(), "10.0", "2"]
    assert rows[1].split()[2:6] == ["0.275", "0.144", "0.275", "0.500"]
    assert rows[2].split()[2:10] == ["-"] * 8
    assert {len(line) for line in lines[1:]} == {len(rule)}
    gaps = [i for i, c in enumerate(rule) if c == " "]
    for row in [header, *rows]:
        assert all(row[i] == " " for i in gaps)
    for title in ("position error [m]", "rotation error [rad]"):
        assert title in lines[0]
