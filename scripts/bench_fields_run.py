#!/usr/bin/env python3
"""Measures what isokit does with fields, beside scipy, SimpleITK and a read of the same bytes.

Times are medians of rounds in which the contenders take turns, from samples in memory to samples
in new memory. Resampling is by the interpolating cubic B-spline at half the distance; errors are
root mean squares against the function that the samples are of, of all new samples and of those
that are more than eight old ones from the border. scipy.ndimage has one thread. A read is the sum
of all 64-bit words, by as many threads. The error of the surface of a shape is the root mean square,
over the mesh, of value over slope of the shape. fidget runs with its JIT. Distances are signed, from
a mesh in memory on, trees over triangles included; MeshLib has a thread for each processor that it is
let run on, trimesh one thread and few of the samples, by which its time is scaled. Started by
`scripts/bench_fields`.
"""

import argparse
import datetime
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from kit import bench_machine, bench_meshes, bench_shapes
from kit.bench_turns import interleaved
from kit.bench_volumes import Absent, Store, Volume
from kit.bench_worker import Failed, Worker
from kit.data import as_json
from kit.program import PROJECT

DRIVER = PROJECT / "target/release/examples/bench_fields"
MUST = {"resample": 5.0, "histogram": 8.0, "spectrum": 20.0}
"""Times faster than the faster peer; and times as long as a read."""


class Own:
    """isokit, in a process of its own."""

    def __init__(self, volume: Volume) -> None:
        """With a volume in memory."""
        self.worker = Worker([str(DRIVER)])
        request = volume.request()
        del request["iso"]
        self.worker.ask(request)

    def seconds(self, op: str, **words: object) -> float:
        """Of a piece of work."""
        return self.worker.ask({"op": op} | words)["seconds"]


def timed(work: Callable[[], object]) -> float:
    """The seconds of some work."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def waves(n: int, apart: float) -> np.ndarray:
    """A function of waves of about twenty samples of a lattice of 256³, z slowest."""
    x = np.arange(n) * apart * (2 * np.pi / 20)
    along = [np.sin(x + 0.3), np.cos(0.83 * x), np.sin(1.21 * x + 1.1)]
    whole = along[2][:, None, None] + along[1][None, :, None] * along[0][None, None, :]
    return whole.astype(np.float32)


def rms(found: np.ndarray, exact: np.ndarray, border: int) -> float:
    """Of the differences, farther from the border than so many samples."""
    inner = (slice(border, -border),) * 3 if border else ...
    difference = found[inner].astype(np.float64) - exact[inner]
    return float(np.sqrt(np.mean(difference**2)))


def resample(store: Store, rounds: int, n: int, threads: int) -> list[dict]:
    """Half the distance between samples of f32, by a cubic B-spline."""
    from scipy import ndimage

    samples, fine = waves(n, 1.0), 2 * n - 1
    path = store.folder / f"waves_{n}.raw"
    samples.tofile(path)
    volume = Volume(f"waves {n}", (n, n, n), "f32", 0.0, path)
    own, exact = Own(volume), waves(fine, 0.5)
    contenders = {
        "isokit": lambda: own.seconds("resample", threads=threads, spacing=0.5),
        "scipy": lambda: timed(lambda: ndimage.zoom(samples, fine / n, order=3, mode="mirror")),
    }
    results = {
        "scipy": lambda: ndimage.zoom(samples, fine / n, order=3, mode="mirror"),
    }
    try:
        import SimpleITK

        SimpleITK.ProcessObject.SetGlobalDefaultNumberOfThreads(threads)
        image = SimpleITK.GetImageFromArray(samples)

        def finer() -> object:
            return SimpleITK.Resample(
                image,
                [fine] * 3,
                SimpleITK.Transform(),
                SimpleITK.sitkBSpline,
                [0.0] * 3,
                [0.5] * 3,
                [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0],
                0.0,
                SimpleITK.sitkFloat32,
            )

        contenders["SimpleITK"] = lambda: timed(finer)
        results["SimpleITK"] = lambda: SimpleITK.GetArrayFromImage(finer())
    except ImportError:
        print("skip SimpleITK: not installed", flush=True)
    seconds = interleaved(rounds, contenders)
    with tempfile.NamedTemporaryFile(dir=store.folder) as file:
        own.seconds("resample", threads=threads, spacing=0.5, out=file.name)
        ours = np.fromfile(file.name, np.float32).reshape(fine, fine, fine)
    results = {"isokit": lambda: ours} | results
    own.worker.close()
    rows = []
    for name, result in results.items():
        found = result()
        row = {
            "what": f"{n}³ to {fine}³: {name}",
            "ms": 1e3 * seconds[name],
            "isokit is times faster": seconds[name] / seconds["isokit"],
            "error": rms(found, exact, 0),
            "error inside": rms(found, exact, 16),
        }
        rows.append(row)
        say(row)
    return rows


def spectrum(store: Store, rounds: int, _n: int, threads: int) -> list[dict]:
    """Which values matter, of u8, beside a read of the same bytes."""
    rows = []
    volume = store.nifti("bonsai", "volvis/bonsai.nii.gz", 37.5)
    own = Own(volume)
    contenders = {
        op: (lambda op=op: own.seconds(op, threads=threads))
        for op in ("read", "histogram", "spectrum")
    }
    seconds = interleaved(rounds, contenders)
    own.worker.close()
    for op in ("histogram", "spectrum"):
        row = {
            "what": f"bonsai 256³ u8: {op}",
            "ms": 1e3 * seconds[op],
            "read ms": 1e3 * seconds["read"],
            "times a read": seconds[op] / seconds["read"],
            "must": MUST[op],
        }
        rows.append(row)
        say(row)
    return rows


def shapes(store: Store, rounds: int, n: int, threads: int) -> list[dict]:
    """The surfaces of shapes, with samples only near them, beside all samples."""
    with Worker([str(DRIVER)]) as own:
        rows = bench_shapes.sparse(own, store.folder, rounds, 4 * n, threads)
    for row in rows:
        say(row)
    return rows


def fidget(store: Store, rounds: int, n: int, threads: int) -> list[dict]:
    """The surfaces of shapes, as near to them as those of fidget."""
    with Worker([str(DRIVER)]) as own:
        rows = bench_shapes.beside_fidget(own, store.folder, rounds, n, threads)
    for row in rows:
        say(row)
    return rows


def voxelize(store: Store, rounds: int, n: int, threads: int) -> list[dict]:
    """The distances of a mesh at all samples, beside MeshLib and trimesh."""
    rows = bench_meshes.voxelize(store.data, rounds, n, threads)
    for row in rows:
        say(row)
    return rows


PARTS = {
    "resample": resample,
    "spectrum": spectrum,
    "shapes": shapes,
    "fidget": fidget,
    "voxelize": voxelize,
}


def say(row: dict) -> None:
    """One line for who waits."""
    cells = [f"{key} {cell(value)}" for key, value in row.items() if key != "what"]
    print(" · ".join([row["what"], *cells]), flush=True)


def cell(value: object) -> str:
    """A figure for people."""
    if isinstance(value, float) and value < 1000:
        return f"{value:.3g}"
    return f"{value:,.0f}" if isinstance(value, int | float) else str(value)


def table(rows: list[dict]) -> list[str]:
    """Markdown."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    lines = ["| " + " | ".join(names) + " |", "| --- |" + " ---: |" * (len(names) - 1)]
    cells = [[cell(row.get(name, "")) for name in names] for row in rows]
    return lines + [f"| {' | '.join(row)} |" for row in cells]


def report(data: dict) -> str:
    """For people."""
    facts = data["machine"]
    lines = [
        f"# Fields, {data['date']}",
        "",
        f"Printed by `scripts/bench_fields`, isokit {data['versions']['isokit']}, on {facts['cpu']}, "
        f"{data['threads']} threads, {data['rounds']} rounds. "
        + " ".join((__doc__ or "").split("\n\n")[1].split()),
        "",
    ]
    for name, rows in data["parts"].items():
        lines += [f"## {(PARTS[name].__doc__ or '').rstrip('.')}", "", *table(rows), ""]
    lines += [f"Not measured: {line}" for line in data["skipped"]]
    return "\n".join(lines).rstrip() + "\n"


def main() -> int:
    """Measures and writes."""
    parser = argparse.ArgumentParser(
        prog="scripts/bench_fields",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    quick = "small volumes, few rounds: whether it works"
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--only", action="append", choices=PARTS, help="a part; repeat it")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--data", type=Path, default=PROJECT.parent / "shared/data")
    parser.add_argument("--out", type=Path, help="the folder to write to")
    parser.add_argument("--load", type=float, default=0.0, help=argparse.SUPPRESS)
    parser.add_argument("--from", dest="base", type=Path, default=Path(), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    rounds, n = (2, 64) if arguments.quick else (arguments.rounds, 256)
    warning = bench_machine.busy(arguments.load)
    if warning:
        print(warning, file=sys.stderr)
    parts, missing = {}, []
    with tempfile.TemporaryDirectory() as scratch:
        store = Store(Path(scratch), arguments.data)
        for name, part in PARTS.items():
            if arguments.only and name not in arguments.only:
                continue
            try:
                parts[name] = part(store, rounds, n, arguments.threads)
            except (Absent, Failed, ImportError) as why:
                missing.append(f"{name}: {why}")
                print(f"skip {missing[-1]}", flush=True)
    facts, date = bench_machine.facts(), datetime.date.today().isoformat()
    folder = PROJECT / f"scripts/results/{date}-{bench_machine.short(str(facts['cpu']))}/fields"
    if arguments.out:
        folder = arguments.base / arguments.out
    folder.mkdir(parents=True, exist_ok=True)
    data = {"schema": "isokit.bench-fields/1", "date": date}
    data |= {"versions": bench_machine.versions(), "machine": facts, "warning": warning}
    data |= {"threads": arguments.threads, "rounds": rounds, "parts": parts, "skipped": missing}
    (folder / "results.json").write_text(as_json(data))
    (folder / "results.md").write_text(report(data))
    print(f"wrote {folder}/results.md")
    return 0 if parts else 2


if __name__ == "__main__":
    sys.exit(main())
