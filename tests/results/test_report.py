import csv
import dataclasses
import json

import numpy as np
import pytest
from track_fixtures import make_record, make_truth

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.results.report import MakeReport, WriteErrors, WriteReport
from pbpf_drake.results.report_table import FormatTable


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
        "rotation_error_up_to_symmetry_rad": "0.130000",
    }
    # The truth ends at 6 s, and there is none of the can.
    assert {r["position_error_m"] for r in rows[6:20]} == {""}
    # The detector has neither particles nor a spread.
    assert {r["effective_sample_size"] for r in rows[20:]} == {""}
    assert {r["position_stddev_m"] for r in rows[20:]} == {""}


CAN = SymmetryConfig(axis=[0.0, 1.0, 0.0])


def test_errors_up_to_symmetry_are_beside_the_raw_ones(tmp_path):
    """The estimate is turned by 0.12 rad about y and by 0.05 rad about z."""
    names = ("box", "can")
    record = make_record(names=names)
    truth = dict.fromkeys(names, make_truth())
    report = MakeReport([record], truth, symmetries={"can": CAN})
    objects = _write_and_read(report, tmp_path)["runs"][0]["objects"]
    for name, expected in ("box", 0.13), ("can", 0.05):
        raw = objects[name]["rotation_error_rad"]
        turned = objects[name]["rotation_error_up_to_symmetry_rad"]
        assert raw["end"] == pytest.approx(0.13)
        assert set(turned) == {"mean", "std", "median", "end"}
        assert turned["end"] == pytest.approx(expected, abs=1e-3)
    assert objects["box"]["symmetry"] is None
    assert objects["can"]["symmetry"] == {"axis": [0, 1, 0], "order": 0}
    filename = tmp_path / "errors.csv"
    WriteErrors([record], truth, filename, {"can": CAN})
    with filename.open(newline="") as file:
        last = list(csv.DictReader(file))[-1]
    assert last["rotation_error_rad"] == "0.130000"
    turned = float(last["rotation_error_up_to_symmetry_rad"])
    assert turned == pytest.approx(0.05, abs=1e-3)


def test_the_use_of_the_input_and_an_interruption_are_in_the_report(tmp_path):
    usage = [("/seen", "box", 9, 7, {"whose stamp is too old": 2})]
    report = MakeReport([make_record()], {}, usage=usage, interrupted=True)
    report = _write_and_read(report, tmp_path)
    assert report["interrupted"] is True
    assert report["input"] == [
        {
            "source": "/seen",
            "object": "box",
            "read": 9,
            "used": 7,
            "left_out": {"whose stamp is too old": 2},
        }
    ]
    whole = MakeReport([make_record()], {})
    assert whole["interrupted"] is False and whole["input"] == []


def test_a_report_is_replaced_at_once(tmp_path):
    _write_and_read(MakeReport([make_record()], {}), tmp_path)
    with pytest.raises(ValueError, match="not JSON compliant"):
        WriteReport({"runs": float("nan")}, tmp_path / "report.json")
    assert json.loads((tmp_path / "report.json").read_text())["runs"]
    assert [p.name for p in tmp_path.iterdir()] == ["report.json"]
