"""Times whole updates of the filter, and shows where the time goes.

The updates are those of PBPF-V on pushes in contact, of one object and of
three. Speed can't be bought with wrong physics: beside it stands the error of
the predicted poses against a fine-step reference. Particles are predicted one
by one, so the error is measured once per number of objects, with the smallest
number of particles.
"""

import argparse
import itertools
import json
import os
from pathlib import Path
import sys

import numpy as np
from tqdm import tqdm

from pbpf_drake.diagrams.benchmark.benchmark_cases import (
    Benchmark,
    BenchmarkOptions,
    Case,
    MakeFilterBenchmark,
)
from pbpf_drake.diagrams.benchmark.benchmark_memory import (
    MemoryInUse,
    memory_growth,
)
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
from pbpf_drake.diagrams.benchmark.benchmark_workload import (
    WORKLOADS,
    LoadWorkload,
)
from pbpf_drake.diagrams.benchmark.other_engines import CheckPeerPackages
from pbpf_drake.diagrams.jobs.run_command import RunCommand

# How often the memory in use is printed.
_MEMORY_ROWS = 20


def _parse(argv: list[str] | None) -> argparse.Namespace:
    cores = os.cpu_count() or 1
    parser = argparse.ArgumentParser(
        description="Times whole updates of PBPF-V on pushes in contact, and "
        "compares the predicted poses with a fine-step reference.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--particles", type=_positive, nargs="+", metavar="M",
        default=[70, 150, 300, 1000], help="numbers of particles")  # fmt: skip
    add("--objects", type=int, nargs="+", choices=WORKLOADS, metavar="K",
        default=list(WORKLOADS), help="numbers of objects, 1 or 3")  # fmt: skip
    add("--threads", type=_positive, nargs="+", metavar="N",
        default=sorted({1, cores}), help="numbers of threads, "
        "or of the filter's processes")  # fmt: skip
    add("--updates", type=_positive, default=150, metavar="N",
        help="timed updates of each case")  # fmt: skip
    add("--samples", type=_positive, default=10, metavar="N",
        help="updates whose predictions are compared with the "
        "reference's")  # fmt: skip
    add("--peers", action="store_true",
        help="let PyBullet and MuJoCo make the same predictions")  # fmt: skip
    add("--json", type=Path, metavar="FILE", help="to write all rows to")
    add("--endurance", type=_positive, metavar="N",
        help="print the memory in use over N updates of the first case "
        "with the most threads, and nothing else")  # fmt: skip
    return parser.parse_args(argv)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{value} is not at least 1")
    return value


def run(args: argparse.Namespace) -> None:
    """Measures and prints; see _parse for the arguments.

    Raises:
        ValueError: an argument can't be used; the message says why.
    """
    if args.peers:
        CheckPeerPackages()
    if args.json and not args.json.parent.is_dir():
        raise ValueError(f"--json: there is no folder {args.json.parent}")
    # Numpy's own threads would compete with the filter's.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    period = LoadWorkload(min(args.objects)).scene.filter.period
    print("Updates, in ms: medians; of the total also 95th percentile and max")
    print(update_table([], period), flush=True)

    def show(measurement: Measurement) -> None:
        """Prints and writes what is known so far: a run may take long."""
        if measurement.engine == OWN:
            print(update_line(measurement, period), flush=True)
        if args.json:
            rows = json_rows(benchmark.measurements)
            args.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")

    options = BenchmarkOptions(
        particles=args.particles,
        objects=args.objects,
        threads=args.threads,
        updates=args.updates,
        samples=args.samples,
        peers=args.peers,
    )
    benchmark = Benchmark(options, on_measured=show)
    benchmark.Run()
    _print_comparisons(benchmark)
    if args.json:
        print(f"Written to {args.json.resolve()}")


def _print_comparisons(benchmark: Benchmark) -> None:
    found = benchmark.measurements
    own = [m for m in found if m.engine == OWN]
    print("\nGrowth with M, K and threads")
    speedup = float(np.median(benchmark.speedups or [1.0]))
    print(growth_table(own, speedup))
    if benchmark.speedups:
        print(f"Independent processes, as many: {speedup:.2f} times one")
    print("\nErrors of the predicted poses against the fine-step reference")
    print(error_table(found))
    if found != own:
        print("\nEngines, in ms per particle and update")
        print(engine_table(found))
    for note in benchmark.notes:
        print(note)


def run_endurance(args: argparse.Namespace) -> None:
    """Prints the memory in use over many updates.

    Raises:
        ValueError: an argument can't be used; the message says why.
    """
    if args.endurance < _MEMORY_ROWS:
        raise ValueError(
            f"--endurance is {args.endurance}; expected {_MEMORY_ROWS} or more"
        )
    case = Case(args.particles[0], args.objects[0], max(args.threads))
    play = MakeFilterBenchmark(case).Pass
    steps = itertools.chain.from_iterable(p() for p in itertools.repeat(play))
    updates, memory = [], []
    with tqdm(total=args.endurance, desc=str(case), unit="update") as bar:
        for count, _ in enumerate(itertools.islice(steps, args.endurance), 1):
            bar.update()
            if count % (args.endurance // _MEMORY_ROWS) == 0:
                updates.append(count)
                memory.append(MemoryInUse())
                bar.write(f"{count:8d} updates {memory[-1] / 1e6:9.1f} MB")
    growth = memory_growth(updates, memory)
    print(f"{growth / 1e3:.2f} kB per update in the second half")


def main(argv: list[str] | None = None) -> int:
    """Runs the script; returns its exit code."""
    args = _parse(argv)
    chosen = run_endurance if args.endurance else run
    return RunCommand("benchmark_update", lambda: chosen(args))


if __name__ == "__main__":
    sys.exit(main())
