"""Meshes that become distances: beside MeshLib and, at some samples, beside trimesh."""

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from kit.bench_turns import interleaved
from kit.bench_volumes import Absent
from kit.bench_worker import Worker
from kit.program import PROJECT

OWN = PROJECT / "target/release/examples/bench_fields"
MUST = 2.0
"""Times faster than the fastest."""
FEW = 200
"""Samples that trimesh is asked about; it takes so long that its time is scaled."""


@contextmanager
def processors(count: int) -> Iterator[None]:
    """As many for all that is started within; MeshLib takes a thread for each that it sees."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[:count])
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class MeshLib:
    """Distances to a mesh, and sides by one of its rules."""

    def __init__(self, path: Path, lattice: dict, rule: str) -> None:
        """Reads the mesh. Its samples are the middles of cells."""
        from meshlib import mrmeshpy

        self.library, self.mesh = mrmeshpy, mrmeshpy.loadMesh(path)
        self.parameters = mrmeshpy.MeshToDistanceVolumeParams()
        step = lattice["spacing"]
        self.parameters.vol.dimensions = mrmeshpy.Vector3i(*lattice["dims"])
        self.parameters.vol.voxelSize = mrmeshpy.Vector3f(step, step, step)
        self.parameters.vol.origin = mrmeshpy.Vector3f(*(c - step / 2 for c in lattice["origin"]))
        self.parameters.dist.signMode = getattr(mrmeshpy.SignDetectionMode, rule)

    def volume(self) -> object:
        """All samples."""
        part = self.library.MeshPart(self.mesh)
        return self.library.meshToDistanceVolume(part, self.parameters)

    def seconds(self) -> float:
        """That this takes, the tree over the triangles included once."""
        self.mesh.invalidateCaches()
        start = time.perf_counter()
        self.volume()
        return time.perf_counter() - start

    def samples(self) -> np.ndarray:
        """Along x, y, z."""
        from meshlib import mrmeshnumpy

        return mrmeshnumpy.getNumpy3Darray(self.volume())


class Trimesh:
    """Signed distances at some of the samples, by one thread."""

    def __init__(self, path: Path, lattice: dict) -> None:
        """Reads the mesh and chooses samples."""
        import trimesh

        self.library, self.mesh = trimesh, trimesh.load(path, process=True)
        choice = np.random.default_rng(1).integers(0, lattice["dims"][0], (FEW, 3))
        self.points = np.array(lattice["origin"]) + choice * lattice["spacing"]
        self.share = FEW / np.prod(lattice["dims"], dtype=float)

    def seconds(self) -> float:
        """Of all samples, if each takes as long as one of the few."""
        start = time.perf_counter()
        self.library.proximity.signed_distance(self.mesh, self.points)
        return (time.perf_counter() - start) / self.share


def around(path: Path, n: int) -> dict:
    """A cube of samples with the mesh in its middle, two samples beyond it along its longest side."""
    from meshlib import mrmeshpy

    bounds = mrmeshpy.loadMesh(path).computeBoundingBox()
    low, high = (np.array([c.x, c.y, c.z], np.float64) for c in (bounds.min, bounds.max))
    spacing = float((high - low).max()) / (n - 5)
    origin = (low + high) / 2 - spacing * (n - 1) / 2
    return {"dims": [n] * 3, "spacing": spacing, "origin": origin.tolist()}


def voxelize(data: Path, rounds: int, n: int, threads: int) -> list[dict]:
    """The bunny's distances: everywhere, and in a band of four samples."""
    path = data / "meshes/bunny.ply"
    if not path.exists():
        raise Absent(f"{path} is absent")
    with processors(threads):
        return beside_others(path, rounds, around(path, n), threads)


def beside_others(path: Path, rounds: int, lattice: dict, threads: int) -> list[dict]:
    """All contenders, in turns."""
    peers = {f"MeshLib, {rule}": MeshLib(path, lattice, rule) for rule in ("ProjectionNormal", "WindingRule")}
    request = {"op": "voxelize", "threads": threads} | lattice
    with Worker([str(OWN)]) as own, tempfile.TemporaryDirectory() as folder:
        own.ask({"op": "mesh", "path": str(path)})
        contenders = {"isokit": lambda: own.ask(request)["seconds"]}
        contenders |= {name: peer.seconds for name, peer in peers.items()}
        contenders[f"trimesh, scaled from {FEW} samples, 1 thread"] = Trimesh(path, lattice).seconds
        seconds = interleaved(rounds, contenders)
        band = request | {"band": 4 * lattice["spacing"]}
        seconds |= interleaved(rounds, {"isokit, --band 4 samples": lambda: own.ask(band)["seconds"]})
        out = Path(folder, "own.raw")
        own.ask(request | {"out": str(out)})
        ours = np.fromfile(out, np.float32).reshape(lattice["dims"]).T
    fastest = min(took for name, took in seconds.items() if not name.startswith("isokit"))
    n = lattice["dims"][0]
    rows = []
    for name, took in seconds.items():
        row = {"what": f"bunny, 69 451 faces, to {n}³: {name}", "ms": 1e3 * took}
        row["isokit is times faster"] = took / seconds["isokit"]
        if name == "isokit":
            row["the fastest other / isokit"], row["must"] = fastest / took, MUST
        if name in peers:
            theirs = peers[name].samples()
            row["sizes differ by samples"] = float(
                np.abs(np.abs(theirs) - np.abs(ours)).max() / lattice["spacing"]
            )
        rows.append(row)
    return rows
