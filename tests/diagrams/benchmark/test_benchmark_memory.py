import multiprocessing
import subprocess
import sys
import textwrap

import numpy as np
import pytest

from pbpf_drake.diagrams.benchmark.benchmark_memory import (
    MemoryInUse,
    memory_growth,
)


def test_memory_in_use_grows_with_what_is_kept():
    """In a process of its own: one that was larger has memory to use again."""
    code = """
    import numpy as np
    from pbpf_drake.diagrams.benchmark.benchmark_memory import MemoryInUse

    before = MemoryInUse()
    kept = np.ones(50_000_000 // 8)
    print(MemoryInUse() - before, kept[0])
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        check=True,
        capture_output=True,
        text=True,
    )
    assert 4e7 < float(done.stdout.split()[0]) < 2e8


def test_growth_is_the_slope_of_the_second_half():
    updates = np.arange(100, 2001, 100)
    memory = np.maximum(1e8 + 5e4 * updates, 1.4e8) + 200.0 * updates
    memory[updates >= 1000] = 1.5e8 + 200.0 * updates[updates >= 1000]
    assert memory_growth(updates, memory) == pytest.approx(200.0)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_what_children_hold_counts_and_what_is_shared_counts_once():
    kept = np.ones(50_000_000 // 8)
    before = MemoryInUse()
    context = multiprocessing.get_context("fork")
    ready, done = context.Event(), context.Event()

    def hold() -> None:
        own = kept + 1.0
        ready.set()
        done.wait(30)
        assert own[0] == 2.0

    child = context.Process(target=hold)
    child.start()
    assert ready.wait(30)
    grown = MemoryInUse() - before
    done.set()
    child.join()
    assert 4e7 < grown < 9e7
