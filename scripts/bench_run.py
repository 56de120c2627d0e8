#!/usr/bin/env python3
"""Measures isokit and its peers in one run, interleaved, and writes table, data and plots.

Started by `scripts/bench`, which installs the peers and builds what is measured. The files go to
scripts/results/DATE-CPU, those of a quick run to target/bench: small volumes and few rounds are for
trying the scripts, not for quoting. Real data is not part of the project: where its folder is
absent this says so and goes on.
"""

import argparse
import datetime
import sys
import tempfile
from pathlib import Path

from kit import bench_commands, bench_limits, bench_machine, bench_output, bench_rows
from kit.bench_measure import Bench
from kit.bench_volumes import Store
from kit.program import PROJECT

ROWS = {
    "machine": bench_limits.machine,
    "synthetic": bench_rows.synthetic,
    "real": bench_rows.real,
    "modes": bench_rows.modes,
    "defaults": bench_rows.defaults,
    "threads": bench_rows.threads,
    "classify": bench_limits.classify,
    "many": bench_limits.many,
    "index": bench_limits.index,
    "bound": bench_limits.bound,
    "memory": bench_limits.memory,
    "command": bench_commands.command,
    "slabs": bench_commands.slabs,
    "again": bench_commands.again,
    "growth": bench_limits.growth,
    "peers": bench_rows.peers,
}

def parse() -> argparse.Namespace:
    """The options."""
    parser = argparse.ArgumentParser(
        prog="scripts/bench",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only", action="append", choices=ROWS, help="a row to measure; repeat it; default: all"
    )
    parser.add_argument("--quick", action="store_true", help="small volumes, 3 rounds: minutes")
    parser.add_argument(
        "--full", action="store_true", help="growth up to 1024³: 16 GiB of memory, 10 of disk"
    )
    parser.add_argument("--rounds", type=int, help="least runs of each contender; default: 7")
    parser.add_argument("--out", type=Path, help="the folder to write to")
    parser.add_argument(
        "--busy", action="store_true", help="go on although the machine is; the table will say so"
    )
    parser.add_argument(
        "--data",
        type=Path,
        default=PROJECT.parent / "shared/data",
        help="the folder of real volumes; default: shared/data beside the project",
    )
    parser.add_argument("--scratch", type=Path, help="where volumes are written meanwhile")
    parser.add_argument("--load", type=float, help=argparse.SUPPRESS)
    parser.add_argument("--from", dest="base", type=Path, default=Path(), help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> int:
    """Measures and writes."""
    arguments = parse()
    load = bench_machine.load() if arguments.load is None else arguments.load
    warning = bench_machine.busy(load)
    if warning:
        print(f"warning: {warning}", file=sys.stderr)
        if not arguments.busy:
            print("nothing is measured; --busy goes on all the same", file=sys.stderr)
            return 2
    date = datetime.date.today().isoformat()
    machine = bench_machine.facts()
    facts = {"date": date, "machine": machine, "versions": bench_machine.versions()}
    absent = bench_machine.absent(PROJECT / ".venv-bench/absent")
    bench = Bench(arguments.rounds or (3 if arguments.quick else 7), arguments.quick, absent)
    for name, reason in absent.items():
        print(f"absent {name}: {reason}")
    if arguments.scratch:
        arguments.scratch.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=arguments.scratch) as scratch:
        store = Store(Path(scratch), arguments.data)
        for name in arguments.only or ROWS:
            if name == "growth":
                bench_limits.growth(bench, store, arguments.full)
            else:
                ROWS[name](bench, store)
    facts["load"] = {"start": load, "end": bench_machine.load()}
    folder = PROJECT / f"scripts/results/{date}-{bench_machine.short(machine['cpu'])}"
    if arguments.quick:
        folder = PROJECT / "target/bench"
    if arguments.out:
        folder = arguments.base / arguments.out
    bench_output.write(bench, facts, folder, warning)
    print(f"wrote {folder}/results.md")
    if not bench.results and not bench.facts:
        print("nothing was measured", file=sys.stderr)
        return 1
    return int(bench.failed)


if __name__ == "__main__":
    sys.exit(main())
