"""The row that holds a volume larger than its memory against one in memory. Standard library only."""

import os
import subprocess
import time
from pathlib import Path

from kit.bench_measure import Bench, Series
from kit.bench_volumes import Store
from kit.bench_worker import Failed
from kit.program import PROJECT

PIECE = 1 << 24
"""Bytes read at a time to have a file in the page cache."""


def measured(command: list[str | Path]) -> dict:
    """Wall time and peak memory of a whole command; raises `Failed` if it fails."""
    start = time.perf_counter()
    process = subprocess.Popen(list(map(str, command)))
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise Failed(f"exit {process.returncode}")
    return {"seconds": seconds, "rss": usage.ru_maxrss * 1024}


def warm(path: Path) -> None:
    """Reads a file once, so that later readers find it in memory."""
    with path.open("rb", buffering=0) as file:
        while file.read(PIECE):
            pass


def slabs(bench: Bench, store: Store) -> None:
    """A whole command with `--max-memory` against the same without, from a file in the page cache."""
    dims, limit = ((256, 256, 512), 96) if bench.quick else ((1024, 1024, 2048), 512)
    volume = store.shell(dims)
    assert volume.path is not None
    out = store.folder / "slabs.ply"
    words = [PROJECT / "target/release/isokit", "extract", volume.path, "-q", "-o", out]
    words += ["--dims", ",".join(map(str, dims)), "--dtype", volume.dtype, "--iso", volume.iso]
    words += ["--topology", "table", "--placement", "linear", "--boundary", "open"]
    commands = {"slabs": [*words, "--max-memory", f"{limit}MiB"], "whole": words}
    taken = {name: Series(name, volume.name, {"op": "command"}) for name in commands}
    warm(volume.path)
    for round_ in range(bench.rounds + 1):
        for name, command in commands.items():
            out.unlink(missing_ok=True)
            try:
                answer = measured(command)
            except Failed as failure:
                bench.skip(f"slabs, {name}", failure)
                bench.failed = True
                return
            if round_ > 0:  # the first reads the program from disk
                taken[name].answers.append(answer)
    size = out.stat().st_size
    out.unlink()
    bench.series += taken.values()
    ours, whole = taken["slabs"], taken["whole"]
    what = f"{volume.name} {volume.dtype}, {volume.count * 2 / 2**30:.2g} GiB, to PLY"
    bench.compare(
        ours,
        whole,
        row="slabs",
        work=f"{what}, --max-memory {limit}MiB vs all in memory",
        at_least=False,
        must=1.6,
        aim=1.2,
        remark=f"{size / 2**20:.0f} MiB written",
    )
    peaks = [[answer["rss"] for answer in one.answers] for one in (ours, whole)]
    bench.add(
        [peak / (limit << 20) for peak in peaks[0]],
        f"{max(peaks[0]) / 2**20:.0f} MiB",
        f"limit {limit} MiB",
        row="slabs",
        work=f"{what}, peak memory as a share of --max-memory",
        at_least=False,
        must=1.0,
        remark=f"{max(peaks[1]) / 2**20:.0f} MiB without",
    )
