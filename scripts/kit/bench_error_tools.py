"""The contenders of `scripts/bench_error`: isokit in each of its modes, and peers from Python.

Each takes a volume, gives its mesh back once, and then runs on request and says how long it took.
"""

import sys
from pathlib import Path
from typing import Protocol

import numpy as np

from kit.bench_error_mesh import Mesh, from_arrays
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

NO_DUAL = (
    "dual contouring: CGAL's is in no registry of packages, that of the crate `isosurface` 0.1 "
    "contours means of opposite corners over the middles of cells, not the samples, and fidget's "
    "needs a formula, for which `scripts/bench_fields` measures it"
)
"""Why none that contours duals takes part."""

OWN = "isokit"

DOUBLE = "f64"
"""The word of modes that get samples as f64 and give positions as f64: orders are seen on them."""

MODES = (
    "linear",
    "linear trilinear",
    "linear fitted",
    "cubic",
    "cubic fitted",
    "quintic trilinear",
    "cubic exact",
    "quintic exact",
    "quintic exact matching",
    "cubic balance",
    "cubic fitted balance",
    "cubic refine=1",
    "cubic refine=1 balance",
    "cubic refine=2 balance",
    "cubic max-error=0.01",
    f"linear exact {DOUBLE}",
    f"cubic exact matching {DOUBLE}",
    f"quintic exact matching {DOUBLE}",
)
"""The modes of isokit; *quintic trilinear* is its default.

With *exact* vertices may lie on samples; without, they keep a thousandth of an edge from them, which
matters beside an error of higher order. With *matching* normals are of the placement's order; without,
from central differences, but where triangles are divided or balanced. With *fitted* diagonals are chosen by
normals; without, by the table. *refine=N* divides every edge so often, *max-error=E* those of triangles
that leave the surface by more than E samples.
"""

DRIVER = PROJECT / "target/release/examples/bench_error"
"""isokit on request, built from the example of that name in the crate `isokit`."""


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


class Own:
    """isokit in a process of its own: in memory, as the peers."""

    def __init__(self, mode: str, threads: int) -> None:
        """`mode` in words."""
        self.making = making(mode) | {"threads": threads}
        self.command = [str(DRIVER)]
        self.worker: Worker | None = None

    def take(self, volume: Volume) -> None:
        """Hands it over."""
        self.volume = volume
        self._ask(volume.request())

    def mesh(self, out: Path) -> Mesh:
        """By way of a file of plain arrays."""
        path = out.with_suffix(".bin")
        made = self._ask({"op": "save", "out": str(path), "making": self.making})
        n = self.volume.dims[0]
        mesh = from_arrays(path, made["vertices"], made["triangles"], n)
        if "bound" in made:
            bound, unbounded = made["bound"]
            mesh.bound = (None if bound is None else bound * 2 / (n - 1), unbounded)
        path.unlink()
        return mesh

    def seconds(self) -> float:
        """One run."""
        return self._ask({"op": "extract"} | self.making)["seconds"]

    def close(self) -> None:
        """Ends the process."""
        if self.worker:
            self.worker.close()
        self.worker = None

    def _ask(self, request: dict) -> dict:
        if self.worker is None:
            self.worker = Worker(self.command, COLD)
        try:
            return self.worker.ask(request)
        except Failed:
            self.close()
            raise


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


def making(mode: str) -> dict:
    """What the words of a mode ask of the driver."""
    asked = {
        "placement": "linear",
        "topology": "table",
        "matching": False,
        "fitted": False,
        "exact": False,
        "double": False,
        "refine": 0,
        "max_error": None,
        "balance": False,
    }
    for word in mode.split():
        name, _, value = word.partition("=")
        if word in ("linear", "cubic", "quintic"):
            asked["placement"] = word
        elif word in ("table", "trilinear"):
            asked["topology"] = word
        elif word in ("matching", "fitted", "exact", "balance"):
            asked[word] = True
        elif word == DOUBLE:
            asked["double"] = True
        elif name == "refine" and value.isdigit():
            asked["refine"] = int(value)
        elif name == "max-error":
            asked["max_error"] = float(value)
        else:
            raise ValueError(f"{word!r} is no word of a mode")
    return asked


def is_double(tool: str) -> bool:
    """Whether it gets samples as f64 whatever the others get, and gives positions as f64."""
    return DOUBLE in tool.split()


def tools(modes: list[str], absent: dict[str, str], threads: int) -> dict[str, Tool]:
    """Every contender by its name."""
    found: dict[str, Tool] = {f"{OWN} {mode}": Own(mode, threads) for mode in modes}
    for name in CHOSEN:
        if name not in absent:
            found[name] = Remote(name, threads)
    return found


def divided(tool: str, found: dict[str, dict]) -> int:
    """About as many triangles as a mode of isokit makes by dividing; 0 if it does not.

    Each is divided into four as often as the mode says. How many there are before is read off the
    figures of another mode; 0 if there is none.
    """

    def fold(name: str) -> int:
        asked = making(name.removeprefix(OWN)) if name.startswith(OWN) else None
        return 4 ** asked["refine"] if asked and asked["max_error"] is None else 0

    if fold(tool) < 4:
        return 0
    whole = (figures["triangles"] // fold(name) for name, figures in found.items() if fold(name))
    return fold(tool) * next(whole, 0)
