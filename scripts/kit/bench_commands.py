"""The rows of whole commands, from file to file, the start of the programs included. Standard library only."""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from kit.bench_measure import Bench, Series
from kit.bench_rows import EDGES
from kit.bench_volumes import Absent, Store, Volume
from kit.bench_worker import Failed
from kit.program import PROJECT

ISOKIT = PROJECT / "target/release/isokit"
TABLE = ["--topology", "table", "--placement", "linear", "--boundary", "open"]
"""As most others do it."""
PIECE = 1 << 24
"""Bytes read at a time to have a file in the page cache."""


def measured(command: list[str | Path]) -> dict:
    """Wall time and peak memory of a whole command; raises `Failed` if it fails."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=log)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            log.seek(0)
            said = log.read().decode(errors="replace").strip()[-200:]
            raise Failed(f"exit {process.returncode}: {said}")
    return {"seconds": seconds, "rss": usage.ru_maxrss * 1024}


def warm(path: Path) -> None:
    """Reads a file once, so that later readers find it in memory."""
    with path.open("rb", buffering=0) as file:
        while file.read(PIECE):
            pass


def in_turn(
    bench: Bench, row: str, of: str, commands: dict[str, list[str | Path]], out: Path
) -> dict[str, Series] | None:
    """Commands that write `out`, one after another, round by round; none if one fails, which is a fault of ours."""
    taken = {name: Series(name, of, {"op": "command"}) for name in commands}
    for round_ in range(bench.rounds + 1):
        for name, words in commands.items():
            out.unlink(missing_ok=True)
            try:
                answer = measured(words)
            except Failed as failure:
                bench.skip(f"{row}, {name}", failure)
                bench.failed |= words[0] == ISOKIT
                return None
            if round_ > 0:  # the first reads programs and files from disk
                taken[name].answers.append(answer | {"size": out.stat().st_size})
    out.unlink()
    bench.series += taken.values()
    return taken


def extract_raw(volume: Volume, out: Path, *more: str) -> list[str | Path]:
    """The command that extracts a volume of the store."""
    assert volume.path is not None
    words = [ISOKIT, "extract", volume.path, "-q", "-o", out, "--iso", volume.iso]
    words += ["--dims", ",".join(map(str, volume.dims)), "--dtype", volume.dtype]
    return [*words, *TABLE, *more]


def command(bench: Bench, store: Store) -> None:
    """A packed scan, against a script with VTK's reader, Flying Edges and writer."""
    volume = store.data / "nifti/mni152_t1_1mm.nii.gz"
    if not volume.exists():
        bench.skip("command", Absent("there is no nifti/mni152_t1_1mm.nii.gz in the data folder"))
        return
    if EDGES in bench.absent:
        bench.skip("command", bench.absent[EDGES])
        return
    out = store.folder / "x.ply"
    ours = [ISOKIT, "extract", volume, "--iso", "90", "-o", out, "-q"]
    commands: dict[str, list[str | Path]] = {
        "like Flying Edges": [*ours, *TABLE, "--degenerate", "never"],
        "defaults": ours,
        "vtk": [sys.executable, PROJECT / "scripts/bench_vtk.py", volume, "90", out],
    }
    taken = in_turn(bench, "command", volume.name, commands, out)
    if taken is None:
        return
    for name, wanted in (("like Flying Edges", {"must": 3.0, "aim": 5.0}), ("defaults", {})):
        bench.compare(
            taken[name],
            taken["vtk"],
            row="command",
            work=f"extract mni152_t1_1mm.nii.gz --iso 90 -o x.ply, {name}, "
            "vs VTK's reader, Flying Edges and writer",
            at_least=True,
            **wanted,
        )


def slabs(bench: Bench, store: Store) -> None:
    """With `--max-memory` against the same without, from a file in the page cache."""
    dims, limit = ((256, 256, 512), 96) if bench.quick else ((1024, 1024, 2048), 512)
    volume = store.shell(dims)
    out = store.folder / "slabs.ply"
    words = extract_raw(volume, out)
    warm(volume.path)
    commands = {"slabs": [*words, "--max-memory", f"{limit}MiB"], "whole": words}
    taken = in_turn(bench, "slabs", volume.name, commands, out)
    if taken is None:
        return
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
        remark=f"{ours.answers[-1]['size'] / 2**20:.0f} MiB written",
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


def again(bench: Bench, store: Store) -> None:
    """Another isovalue, near few bricks, of a volume whose index lies beside it, from a file in the page cache."""
    n = 128 if bench.quick else 512
    volume = replace(store.sphere(n), iso=0.3 * n)
    out = store.folder / "again.ply"
    words = extract_raw(volume, out)
    warm(volume.path)
    commands = {
        "whole": words,
        "index": [*words, "--index"],  # the round that is not counted makes it
        "slabs": [*words, "--index", "--max-memory", "1GiB"],
    }
    taken = in_turn(bench, "again", volume.name, commands, out)
    if taken is None:
        return
    for name, options in (("index", "--index"), ("slabs", "--index --max-memory 1GiB")):
        bench.compare(
            taken[name],
            taken["whole"],
            row="again",
            work=f"{volume.name} f32, a quarter of its radius, to PLY, {options} with the index kept vs without",
            at_least=True,
        )
