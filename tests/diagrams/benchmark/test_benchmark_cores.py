from pbpf_drake.diagrams.benchmark.benchmark_cores import MeasureProcessSpeedup


def test_two_processes_are_no_slower_than_half_and_no_faster_than_twice_one():
    # Others may use the cores too: bounds are wide.
    assert 0.25 < MeasureProcessSpeedup(2, rounds=2) < 8.0
