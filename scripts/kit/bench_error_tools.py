"""The contenders of `scripts/bench_error`: the program in each of its modes, and peers from Python.

Each takes a volume, gives its mesh back once, and then runs on request and says how long it took.
"""

import json
import os
import re
import subprocess
import sys
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
    """A contender."""

    def take(self, volume: Volume) -> None:
        """Gets a volume ready, off the clock."""

    def mesh(self, out: Path) -> Mesh:
        """Its surface; `out` is a file it may write, without suffix."""

    def seconds(self) -> float:
        """The time of one cold run."""

    def close(self) -> None:
        """Lets go of everything."""


class Program:
    """isokit as a program: extraction as its report has it, without reading and writing."""

    def __init__(self, program: Path, options: list[str], threads: int) -> None:
        """`options` say the mode."""
        self.command = [str(program), "extract", "--quiet", "--threads", str(threads)]
        self.command += ["--boundary", "open", "--nan", "outside", *options]

    def take(self, volume: Volume) -> None:
        """Nothing but to remember it."""
        self.volume = volume

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
        size = ",".join(map(str, self.volume.dims))
        what = ["--dims", size, "--dtype", self.volume.dtype, "--iso", str(self.volume.iso)]
        done = subprocess.run(
            [*self.command, str(self.volume.path), *what, *more],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env=os.environ | COLD,
            check=False,
        )
        if done.returncode != 0:
            raise Failed(done.stderr.decode(errors="replace").strip()[-200:])


class Remote:
    """A peer in a process of its own."""

    def __init__(self, name: str, threads: int) -> None:
        """The process starts with the first volume, and anew after it failed."""
        peer = PEERS[name]
        count = threads if threads in peer.threads else peer.threads[-1]
        self.request = {"normals": peer.normals[-1], "threads": count, "warm": False}
        self.command = [sys.executable, str(PROJECT / "scripts/bench_peer.py"), name]
        self.worker: Worker | None = None

    def take(self, volume: Volume) -> None:
        """Hands it over."""
        self.volume = volume
        self._ask(volume.request())

    def mesh(self, out: Path) -> Mesh:
        """By way of a file of numpy's."""
        path = out.with_suffix(".npz")
        self._ask(self.request | {"op": "save", "out": str(path)})
        with np.load(path) as made:
            normals = made["normals"] if "normals" in made else None
            mesh = Mesh.from_samples(
                made["vertices"], made["triangles"], normals, self.volume.dims[0]
            )
        path.unlink()
        return mesh

    def seconds(self) -> float:
        """One run."""
        return self._ask(self.request | {"op": "extract"})["seconds"]

    def close(self) -> None:
        """Ends the process."""
        if self.worker:
            self.worker.close()
        self.worker = None

    def _ask(self, request: dict) -> dict:
        if self.worker is None:
            self.worker = Worker(self.command)
        try:
            return self.worker.ask(request)
        except Failed:
            self.close()
            raise


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
    program: Path, own: dict[str, list[str]], absent: dict[str, str], threads: int
) -> dict[str, Tool]:
    """Every contender by its name."""
    found: dict[str, Tool] = {}
    for name, options in own.items():
        found[name] = Program(program, options, threads)
    for name in CHOSEN:
        if name not in absent:
            found[name] = Remote(name, threads)
    return found
