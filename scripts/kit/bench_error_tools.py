"""The contenders of `scripts/bench_error`: the program in each of its modes, and peers from Python.

Each takes a volume, gives its mesh back once, and then runs on request and says how long it took.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import numpy as np

from kit.bench_error_mesh import Mesh, from_ply
from kit.bench_peers import PEERS
from kit.bench_volumes import Volume
from kit.bench_worker import COLD, Failed, Worker
from kit.program import PROJECT

CHOSEN = (
    "vtk Flying Edges",
    "vtk SurfaceNets",
    "vtk SurfaceNets smoothed",
    "scikit-image",
    "PyMCubes",
    "libigl",
    "meshlib",
)
"""The peers that take part, by their names in `PEERS`."""

OWN = "isokit"


class Tool(Protocol):
    """A contender with a volume."""

    def mesh(self, out: Path) -> Mesh:
        """Its surface; `out` is a file it may write, without suffix."""

    def seconds(self) -> float:
        """The time of one cold run."""

    def close(self) -> None:
        """Lets go of everything."""


class Program:
    """isokit as a program: extraction as its report has it, without reading and writing."""

    def __init__(self, volume: Volume, options: list[str], program: Path, threads: int) -> None:
        """`options` say the mode."""
        self.volume = volume
        size = ",".join(map(str, volume.dims))
        self.command = [str(program), "extract", str(volume.path), "--dims", size]
        self.command += ["--dtype", volume.dtype, "--iso", str(volume.iso), "--quiet"]
        self.command += [
            "--boundary",
            "open",
            "--nan",
            "outside",
            "--threads",
            str(threads),
            *options,
        ]

    def mesh(self, out: Path) -> Mesh:
        """By way of a PLY file."""
        path = out.with_suffix(".ply")
        self._run("--output", str(path))
        mesh = from_ply(path, self.volume.dims[0])
        path.unlink()
        return mesh

    def seconds(self) -> float:
        """The second of two runs in one process, as peers have run before too."""
        report = self.volume.path.with_suffix(".json")
        self._run("--output", "-", "--format", "ply", "--repeat", "2", "--report", str(report))
        return json.loads(report.read_text())["timings_s"]["extract_all"][-1]

    def close(self) -> None:
        """Nothing is kept."""

    def _run(self, *more: str) -> None:
        done = subprocess.run(
            [*self.command, *more],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env=os.environ | COLD,
            check=False,
        )
        if done.returncode != 0:
            raise Failed(done.stderr.decode(errors="replace").strip()[-200:])


class Remote:
    """A peer in a process of its own."""

    def __init__(self, volume: Volume, name: str, threads: int) -> None:
        """Starts it and hands it the volume."""
        peer = PEERS[name]
        self.volume = volume
        count = threads if threads in peer.threads else peer.threads[-1]
        self.request = {"normals": peer.normals[-1], "threads": count, "warm": False}
        self.worker = Worker([sys.executable, str(PROJECT / "scripts/bench_peer.py"), name])
        try:
            self.worker.ask(volume.request())
        except Failed:
            self.worker.close()
            raise

    def mesh(self, out: Path) -> Mesh:
        """By way of a file of numpy's."""
        path = out.with_suffix(".npz")
        self.worker.ask(self.request | {"op": "save", "out": str(path)})
        with np.load(path) as made:
            mesh = Mesh.from_samples(
                made["vertices"], made["triangles"], made.get("normals"), self.volume.dims[0]
            )
        path.unlink()
        return mesh

    def seconds(self) -> float:
        """One run."""
        return self.worker.ask(self.request | {"op": "extract"})["seconds"]

    def close(self) -> None:
        """Ends the process."""
        self.worker.close()


def modes(program: Path, extra: list[str]) -> dict[str, list[str]]:
    """Every mode of the program by name, with its options.

    All placements with all topologies, as its help lists them. Vertices that keep a thousandth of
    an edge from samples matter beside an error of higher order, so those placements also go
    without. `extra` are more modes, each a line of options.
    """
    help_ = subprocess.run(
        [str(program), "extract", "--help"], capture_output=True, text=True, check=True
    )
    found = {}
    for placement in values(help_.stdout, "--placement"):
        for topology in values(help_.stdout, "--topology"):
            name = f"{OWN} {placement} {topology}"
            options = ["--placement", placement, "--topology", topology]
            found[name] = options
            if placement != "linear":
                found[f"{name} exact"] = [*options, "--degenerate", "exact"]
    for line in extra:
        found[f"{OWN} {line.replace('--', '')}"] = line.split()
    return found


def values(text: str, option: str) -> list[str]:
    """The values that a help text lists for an option, in either of clap's two forms."""
    block = re.search(rf"^ +{option} .*\n((?:\s*\n|          .*\n)*)", text, re.MULTILINE)
    if not block:
        return []
    short = re.search(r"\[possible values: (.+?)\]", block[1], re.DOTALL)
    if short:
        return re.split(r",\s+", short[1])
    return re.findall(r"^ +- ([\w-]+)", block[1], re.MULTILINE)


def tools(
    volume: Volume, program: Path, own: dict[str, list[str]], absent: dict[str, str], threads: int
) -> Iterator[tuple[str, Tool | Failed]]:
    """Every contender with the volume in its hands, or why it has not."""
    for name, options in own.items():
        yield name, Program(volume, options, program, threads)
    for name in CHOSEN:
        if name in absent:
            continue
        try:
            yield name, Remote(volume, name, threads)
        except Failed as failure:
            yield name, failure
