"""Shapes that become meshes: with samples near the surface beside all samples, and beside fidget."""

import json
import math
import statistics
import tomllib
from pathlib import Path

from kit.bench_turns import interleaved
from kit.bench_worker import Failed, Worker
from kit.program import PROJECT

OWN = PROJECT / "target/release/examples/bench_fields"
FIDGET = PROJECT / "target/fidget/release/isokit-bench-fidget"
SHAPES = ("bracket", "gear", "creature")
MUST_SPARSE, MUST_FIDGET = 20.0, 1.5
"""Times less than all samples take; times what fidget takes, in time and in triangles."""
WAYS = {"sparse": "", "creases": " --creases 30", "balanced": " --creases 30 --balance"}


class Shape:
    """A shape of the fixtures, as a file that the programs read."""

    def __init__(self, own: Worker, name: str, folder: Path) -> None:
        """Writes it."""
        self.own, self.path = own, folder / f"{name}.json"
        tree = tomllib.loads((PROJECT / f"fixtures/shapes/{name}.toml").read_text())
        self.path.write_text(json.dumps(tree))

    def mesh(self, samples: int, how: str, threads: int) -> dict:
        """By isokit, on a lattice with so many samples along the longest side."""
        request = {"op": "shape", "path": str(self.path), "samples": samples}
        return self.own.ask(request | {"how": how, "threads": threads})

    def as_good(self, error: float, how: str, threads: int) -> int:
        """The fewest samples along the longest side, nearly, whose mesh is no farther from the surface."""
        low, high = 16, 1024
        while high - low > max(1, low // 32):
            middle = math.isqrt(low * high)
            if self.mesh(middle, how, threads)["rms"] <= error:
                high = middle
            else:
                low = middle + 1
        return high


def sparse(own: Worker, folder: Path, rounds: int, n: int, threads: int) -> list[dict]:
    """A surface with samples near it, beside one with all samples."""
    rows = []
    for name in SHAPES:
        shape = Shape(own, name, folder)
        dense = shape.mesh(n, "dense", threads)  # takes so long that once is enough
        all_found = [shape.mesh(n, "sparse", threads) for _ in range(rounds + 1)]
        found, seconds = all_found[0], statistics.median(one["seconds"] for one in all_found[1:])
        row = {
            "what": f"{name}, {n} samples along its longest side",
            "ms": 1e3 * seconds,
            "all samples, ms": 1e3 * dense["seconds"],
            "times faster": dense["seconds"] / seconds,
            "must": MUST_SPARSE,
            "samples made": found["samples"] / dense["samples"],
            "same triangles": found["triangles"] == dense["triangles"],
        }
        rows.append(row)
    return rows


def beside_fidget(own: Worker, folder: Path, rounds: int, n: int, threads: int) -> list[dict]:
    """As good a mesh as fidget's, whose octree has as many cells along a side as the lattice."""
    if not FIDGET.exists():
        raise Failed("fidget is not built")
    rows, peer = [], Worker([str(FIDGET)])
    for name in SHAPES:
        shape, out = Shape(own, name, folder), folder / f"{name}.ply"
        listing = folder / f"{name}.vm"
        request = {"op": "listing", "path": str(shape.path), "out": str(listing)}
        middle, half = own.ask(request)["cube"]
        request = {"listing": str(listing), "middle": middle, "half": half, "out": str(out)}
        request |= {"depth": n.bit_length() - 1, "threads": threads}
        peer.ask(request)
        theirs = own.ask({"op": "judge", "path": str(shape.path), "mesh": str(out)})
        for how, words in WAYS.items():
            samples = shape.as_good(theirs["rms"], how, threads)
            ours = shape.mesh(samples, how, threads)
            times = {
                "isokit": lambda shape=shape, samples=samples, how=how: shape.mesh(samples, how, threads)["seconds"],
                "fidget": lambda request=request: peer.ask(request)["seconds"],
            }
            seconds = interleaved(rounds, times)
            row = {
                "what": f"{name}, as good as fidget's {n}³: isokit extract{words}",
                "error": ours["rms"],
                "fidget's": theirs["rms"],
                "samples along its longest side": samples,
                "ms": 1e3 * seconds["isokit"],
                "fidget, ms": 1e3 * seconds["fidget"],
                "time": seconds["isokit"] / seconds["fidget"],
                "triangles": ours["triangles"] / theirs["triangles"],
                "must": MUST_FIDGET,
                "open or non-manifold": ours["open"] + ours["nonmanifold"],
                "fidget has": theirs["open"] + theirs["nonmanifold"],
            }
            rows.append(row)
    peer.close()
    return rows
