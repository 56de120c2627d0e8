#!/usr/bin/env python3
"""Halves real volumes and measures which placement comes nearest to the surface of the whole ones.

Each axis is low-passed by a half-band filter (a sinc of 23 taps in a Kaiser window, reflected at
the border) and every second sample is kept, as f32. The surface of the half, by each placement, is
compared with that of the whole by the same isovalue, both ways: points spread over one by area
against the triangles of the other. Detail that the half cannot hold is missed by every placement
alike; so beside the root mean square stand the median, and the mean square of the better nine
tenths. The whole is placed linearly and by the cubic in turn, so that no placement is judged by
itself alone. Lengths are in samples of the whole. Started by `scripts/bench_halving`.
"""

import argparse
import datetime
import sys
import tempfile
from pathlib import Path

import numpy as np
from kit import bench_machine
from kit.bench_error_measure import rms, to_mesh
from kit.bench_error_mesh import Mesh, from_ply
from kit.data import as_json
from kit.manifest import raw_options, references
from kit.program import PROJECT, Failed, Isokit

PLACEMENTS = ("linear", "cubic", "quintic")
JUDGES = ("linear", "cubic")
TAPS = 11
"""On each side."""
SIZE = 1024
"""Samples that count as 1 where distances are measured, of which no volume has many."""
POINTS = 20_000
LEAST = 24
"""Samples along the shortest axis of a half that is worth a look."""


def kernel() -> np.ndarray:
    """Passes what half as many samples can hold, and keeps constants."""
    n = np.arange(-TAPS, TAPS + 1)
    taps = np.sinc(n / 2) * np.kaiser(len(n), 5)
    return taps / taps.sum()


def halved(samples: np.ndarray) -> np.ndarray:
    """Every second sample along each axis, of what is left below half the rate."""
    taps = kernel()
    for axis in range(3):
        width = [(TAPS, TAPS) if n == axis else (0, 0) for n in range(3)]
        wide = np.pad(samples, width, mode="reflect")
        size = samples.shape[axis]
        slices = [np.take(wide, np.arange(k, k + size, 2), axis) for k in range(len(taps))]
        samples = sum(tap * part for tap, part in zip(taps, slices, strict=True))
    return samples


def surface(program: Isokit, volume: Path, iso: float, placement: str, spacing: int) -> Mesh:
    """Of one volume by one placement, in so many samples of the whole."""
    out = volume.with_name(f"{volume.stem}_{placement}.ply")
    options = ["--iso", iso, "--placement", placement, "--boundary", "open"]
    step = ",".join([str(spacing)] * 3)
    program.extract(volume, out, *options, "--spacing", step, "--origin", "0,0,0")
    mesh = from_ply(out, 3)  # of three samples one is 1 long
    mesh.vertices /= SIZE
    return mesh


def spread(mesh: Mesh, count: int) -> np.ndarray:
    """So many points on its triangles, by area; the same ones each time."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chance = np.random.default_rng(1)
    n = np.searchsorted(np.cumsum(area), chance.random(count) * area.sum()).clip(0, len(area) - 1)
    u, v = chance.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[n] + u * (b[n] - a[n]) + v * (c[n] - a[n])


def distances(half: Mesh, whole: Mesh) -> dict[str, float]:
    """Both ways, as one set of numbers."""
    there = to_mesh(whole, spread(half, POINTS))
    back = to_mesh(half, spread(whole, POINTS))
    both = SIZE * np.sort(np.concatenate([there, back]))
    return {
        "rms": float(rms(both)),
        "median": float(np.median(both)),
        "rms_of_nine_tenths": float(rms(both[: len(both) * 9 // 10])),
    }


def judged(program: Isokit, path: Path, options: list[str], iso: float, scratch: Path) -> dict:
    """All placements of the half, by all judges."""
    whole, half = scratch / "whole.npy", scratch / "half.npy"
    done = program.run("convert", path, *options, "-o", whole)
    if done.returncode:
        raise Failed(done.stderr.strip()[-300:])
    samples = np.load(whole).astype(np.float64)
    np.save(whole, samples.astype(np.float32))
    small = halved(samples).astype(np.float32)
    if min(small.shape) < LEAST:
        raise Failed(f"its half has {min(small.shape)} samples along an axis")
    np.save(half, small)
    judges = {name: surface(program, whole, iso, name, 1) for name in JUDGES}
    halves = {name: surface(program, half, iso, name, 2) for name in PLACEMENTS}
    return {
        judge: {name: distances(mesh, of_whole) for name, mesh in halves.items()}
        for judge, of_whole in judges.items()
    }


def best(figures: dict[str, dict[str, float]], kind: str) -> str:
    """The placement with the least."""
    return min(figures, key=lambda name: figures[name][kind])


def table(data: dict) -> str:
    """For people."""
    kinds = ("rms", "median", "rms_of_nine_tenths")
    lines = [
        f"# Placements on halved volumes, {data['date']}",
        "",
        f"Printed by `scripts/bench_halving`, isokit {data['versions']['isokit']}. "
        + " ".join((__doc__ or "").split("\n\n")[1].split()),
        "",
        "| volume | iso | whole | " + " | ".join(f"{k.replace('_', ' ')}" for k in kinds) + " |",
        "| --- | --- | --- |" + " --- |" * len(kinds),
    ]
    wins: dict[str, dict[str, int]] = {kind: dict.fromkeys(PLACEMENTS, 0) for kind in kinds}
    for one in data["volumes"]:
        for judge, figures in one["judges"].items():
            cells = []
            for kind in kinds:
                winner = best(figures, kind)
                wins[kind][winner] += 1
                numbers = [
                    f"**{figures[name][kind]:.4f}**" if name == winner else f"{figures[name][kind]:.4f}"
                    for name in PLACEMENTS
                ]
                cells.append(" ".join(numbers))
            lines.append(f"| {one['path']} | {one['iso']:g} | {judge} | {' | '.join(cells)} |")
    lines += ["", f"Each cell: {', '.join(PLACEMENTS)}. Least most often:", ""]
    for kind in kinds:
        counts = ", ".join(f"{name} {count}" for name, count in wins[kind].items())
        lines.append(f"- {kind.replace('_', ' ')}: {counts}")
    lines += [""] + [f"Not measured: {line}" for line in data["skipped"]]
    return "\n".join(lines).rstrip() + "\n"


def main() -> int:
    """Measures and writes."""
    parser = argparse.ArgumentParser(
        prog="scripts/bench_halving",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--data", type=Path, default=PROJECT.parent / "shared/data")
    parser.add_argument("--only", action="append", help="a volume of the data folder; repeat it")
    parser.add_argument("--out", type=Path, help="the folder to write to")
    parser.add_argument("--program", type=Path, default=PROJECT / "target/release/isokit")
    parser.add_argument("--from", dest="base", type=Path, default=Path(), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    manifest = arguments.data / "MANIFEST.md"
    if not manifest.exists():
        print(f"there is no {manifest}: nothing is measured", file=sys.stderr)
        return 2
    known, _ = references(manifest.read_text())
    date, program = datetime.date.today().isoformat(), Isokit(arguments.program.absolute())
    volumes, skipped = [], []
    for one in known:
        if arguments.only and one.path not in arguments.only:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            path, options = arguments.data / one.path, raw_options(one.path)
            try:
                judges = judged(program, path, options, one.iso, Path(scratch))
            except Failed as failure:
                skipped.append(f"{one.path} at {one.iso:g}: {failure}")
                print(f"skip {skipped[-1]}", flush=True)
                continue
        volumes.append({"path": one.path, "iso": one.iso, "judges": judges})
        said = ", ".join(f"{name} {v['rms']:.4f}" for name, v in judges["cubic"].items())
        print(f"{one.path} at {one.iso:g}: RMS {said}", flush=True)
    machine = bench_machine.short(str(bench_machine.facts()["cpu"]))
    folder = PROJECT / f"scripts/results/{date}-{machine}/halving"
    if arguments.out:
        folder = arguments.base / arguments.out
    folder.mkdir(parents=True, exist_ok=True)
    data = {"schema": "isokit.bench-halving/1", "date": date, "versions": bench_machine.versions()}
    data |= {"volumes": volumes, "skipped": skipped}
    (folder / "results.json").write_text(as_json(data))
    (folder / "results.md").write_text(table(data))
    print(f"wrote {folder}/results.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
