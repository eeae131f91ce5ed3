import pytest
from track_fixtures import make_record, make_truth

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.results.report import MakeReport
from pbpf_drake.results.report_table import FormatTable


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


def test_errors_up_to_symmetry_have_columns_where_an_object_has_one():
    """The estimate is turned by 0.12 rad about y and by 0.05 rad about z."""
    names = ("box", "can")
    truth = dict.fromkeys(names, make_truth())
    can = {"can": SymmetryConfig(axis=[0.0, 1.0, 0.0])}
    report = MakeReport([make_record(names=names)], truth, symmetries=can)
    titles, header, rule, box, row = FormatTable(report).splitlines()
    assert "up to symmetry" in titles
    assert header.split().count("end") == 3
    assert [float(x) for x in row.split()[10:12]] == pytest.approx(
        [0.05, 0.05], abs=1e-3
    )
    assert row.split()[12] == "100%"
    assert box.split()[10:12] == ["0.130", "0.130"]
    assert len(box) == len(row) == len(header) == len(rule)
    report = MakeReport([make_record(names=names)], truth)
    assert "symmetry" not in FormatTable(report)
