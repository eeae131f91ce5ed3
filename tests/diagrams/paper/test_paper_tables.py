"""Rows, tables and comparisons of synthetic results."""

import csv
import io

import numpy as np
import pytest
from result_fixtures import make_result

from pbpf_drake.diagrams.paper.evaluation import METRICS
from pbpf_drake.diagrams.paper.paper_comparisons import (
    compare_all,
    comparisons_csv,
    format_comparisons,
)
from pbpf_drake.diagrams.paper.paper_rows import (
    find_row,
    make_paper_rows,
    ratio_to_dope,
)
from pbpf_drake.diagrams.paper.paper_tables import (
    format_metrics,
    format_tables,
    metrics_csv,
    paper_csv,
)
from pbpf_drake.diagrams.paper.paper_values import PAPER


@pytest.fixture(scope="module")
def results():
    """Cheezit 1 by three methods, one object of Scene 5, and a user's."""
    rng = np.random.default_rng(1)
    found = []
    for method, size in ("dope", 0.4), ("pbpf", 0.1), ("pbpf-v", 0.05):
        for run in range(7):
            for repeat in range(1 if method == "dope" else 3):
                noise = 1 + 0.1 * rng.normal(size=5)
                errors = {m: size * noise for m in METRICS}
                found.append(
                    make_result(
                        method=method, run=run, repeat=repeat, errors=errors
                    )
                )
    for scene, names in ("scene_5", ("soup", "cracker")), ("mine", ("mug",)):
        found.append(
            make_result(scene=scene, method="dope", names=names, errors=0.2)
        )
    return found


def _read(text: str) -> list[dict]:
    return list(csv.DictReader(io.StringIO(text)))


def test_there_is_a_row_per_scene_object_and_method_in_the_papers_order(
    results,
):
    rows = make_paper_rows(results)
    assert [(r.scene, r.object, r.method) for r in rows] == [
        ("cheezit_1", "cracker", "pbpf"),
        ("cheezit_1", "cracker", "pbpf-v"),
        ("cheezit_1", "cracker", "dope"),
        ("scene_5", "cracker", "dope"),
        ("scene_5", "soup", "dope"),
        ("mine", "mug", "dope"),
    ]
    assert [(r.runs, r.repeats) for r in rows[:3]] == [(7, 3), (7, 3), (7, 1)]
    assert rows[0].title() == "Cheezit Scene 1"
    assert rows[-1].title() == "mug, mine"


def test_where_an_evaluation_is_missing_the_row_does_not_say_it_is_there(
    results,
):
    pbpf = [r for r in results if r.method == "pbpf"]
    (row,) = make_paper_rows(pbpf[1:])
    assert (row.runs, row.repeats) == (7, 2)


def test_a_row_holds_pooled_errors_beside_the_papers(results):
    row = make_paper_rows(results)[0]
    mine = [r for r in results if (r.scene, r.method) == ("cheezit_1", "pbpf")]
    values = np.concatenate([r.errors["cracker"]["rotation"] for r in mine])
    assert row.ours.rot_mean == pytest.approx(values.mean())
    assert row.ours.rot_std == pytest.approx(values.std())
    assert row.paper == PAPER["cheezit_1", "cracker", "pbpf"]
    add = np.concatenate([r.errors["cracker"]["add"] for r in mine])
    expected = np.mean(np.maximum(0, 1 - add / 0.1))
    assert row.auc["add"] == pytest.approx(expected)


def test_ratios_to_dope_are_of_means_and_beside_the_papers(results):
    rows = make_paper_rows(results)
    pbpf, dope = rows[0], rows[2]
    found = ratio_to_dope(rows, pbpf)
    expected = (
        pbpf.ours.pos_mean / dope.ours.pos_mean,
        0.081 / 0.289,
        pbpf.ours.rot_mean / dope.ours.rot_mean,
        0.484 / 1.345,
    )
    assert found == pytest.approx(expected)
    # The paper has no DOPE of a user's own scene.
    ours, paper, _, _ = ratio_to_dope(rows, rows[-1])
    assert ours == 1 and np.isnan(paper)


def test_without_dope_there_is_no_ratio():
    rows = make_paper_rows([make_result(method="pbpf", scene="mine")])
    assert np.isnan(ratio_to_dope(rows, rows[0])).all()
    assert find_row(rows, "mine", "cracker", "dope") is None


def test_the_csv_has_the_columns_asked_for_and_reads_back(results):
    rows = make_paper_rows(results)
    table = _read(paper_csv(rows))
    errors = [f"{e}_{part}" for e in ("pos", "rot") for part in ("mean", "std")]
    assert list(table[0]) == [
        *("scene", "object", "method", "runs", "repeats"),
        *errors,
        *(f"paper_{error}" for error in errors),
    ]
    assert len(table) == len(rows)
    for cells, row in zip(table, rows, strict=True):
        assert float(cells["pos_mean"]) == pytest.approx(
            row.ours.pos_mean, abs=1e-6
        )
    first, last = table[0], table[-1]
    assert (first["runs"], first["repeats"]) == ("7", "3")
    assert float(first["paper_rot_std"]) == 0.272
    assert last["paper_pos_mean"] == ""


def test_metrics_are_in_a_csv_of_their_own(results):
    table = _read(metrics_csv(make_paper_rows(results)))
    assert float(table[-1]["mssd_mean"]) == pytest.approx(0.2)
    assert float(table[-1]["add_s_auc"]) == 0.0
    assert float(table[-1]["symmetric_rotation_std"]) == pytest.approx(0)


@pytest.mark.parametrize("markdown", [False, True])
def test_each_cell_of_the_tables_is_beside_the_papers(results, markdown):
    rows = make_paper_rows(results)
    text = format_tables(rows, markdown=markdown)
    assert text.index("Table 1") < text.index("Table 2")
    assert text.index("Table 2") < text.index("Scenes of one's own")
    (line,) = [
        x for x in text.splitlines() if "Cheezit Scene 1" in x and "PBPF-V" in x
    ]
    ours = f"{rows[1].ours.pos_mean:.3f} ± {rows[1].ours.pos_std:.3f}"
    cells = [
        c.strip() for c in line.strip("| ").split("|" if markdown else "  ")
    ]
    cells = [c for c in cells if c]
    assert cells[3:7] == [
        ours,
        "0.063 ± 0.020",
        f"{rows[1].ours.pos_mean / rows[2].ours.pos_mean:.2f}",
        "0.22",
    ]
    assert cells[8] == "0.396 ± 0.295"


def test_markdown_tables_are_rectangular(results):
    rows = make_paper_rows(results)
    for text in (
        format_tables(rows, markdown=True),
        format_metrics(rows, markdown=True),
    ):
        for block in text.split("\n\n"):
            lines = [x for x in block.splitlines() if x.startswith("|")]
            assert len({line.count("|") for line in lines}) <= 1


def test_every_pair_with_results_is_compared(results):
    found = compare_all(results)
    pairs = {(row.method, other) for row, other, _, _ in found}
    assert pairs == {("pbpf", "dope"), ("pbpf-v", "dope"), ("pbpf-v", "pbpf")}
    assert {c.verdict() for _, _, _, c in found} == {"smaller"}
    # One run of one method can't be compared.
    assert {row.scene for row, _, _, _ in found} == {"cheezit_1"}


def test_comparisons_say_the_direction_in_words_and_in_a_csv(results):
    found = compare_all(results)
    text = format_comparisons(found, markdown=False)
    (line,) = [
        x
        for x in text.splitlines()
        if "position" in x and "PBPF  " in x and "DOPE" in x
    ]
    assert "-0.3" in line and "7 runs" in line and line.endswith("smaller")
    table = _read(comparisons_csv(found))
    assert len(table) == len(found)
    for row in table:
        assert float(row["difference_low"]) <= float(row["difference"])
        assert float(row["ratio"]) < 1 and row["verdict"] == "smaller"
