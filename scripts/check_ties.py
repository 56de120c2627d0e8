#!/usr/bin/env python3
"""Extracts random volumes full of ties and asks whether every surface is closed, or ends only where it may.

Small integers around the isovalue put samples exactly on it all the time, which is where
extractors leave holes, edges of four faces and triangles without area. Each volume is 7 samples
wide and holds random integers from -3 to 3; the isovalue is 0. The written mesh, of each format, by
each mode and in each place in turn, is looked at with trimesh, as stored and again after merging
equal positions; the counters of isokit's own report must be zero as well. A glTF rounds positions
twice, being in metres.
"""

import argparse
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from kit.program import Failed, Isokit
from kit.surface import faces_per_edge, merged, parts_of
from kit.tally import Tally

COUNTERS = ("nonmanifold_edges", "degenerate_triangles")
"""What is 0 of every surface; of one that is closed the edges at its border too."""

ENDINGS = ("ply", "stl", "obj", "glb", "gltf")

MODES = (
    (),
    ("--topology", "table", "--placement", "linear"),
    ("--placement", "cubic", "--diagonals", "fitted"),
    ("--refine", "1", "--balance"),
    ("--topology", "trilinear", "--placement", "linear", "--normals", "matching"),
    ("--topology", "trilinear", "--placement", "cubic"),
    ("--max-error", "0.05", "--balance"),
    ("--clip", "middle"),
    ("--boundary", "open"),
    ("--boundary", "open", "--refine", "1", "--balance"),
    ("--normals", "matching", "--refine", "2"),
)
"""As many as have no factor in common with the endings: seeds in a row try every pair.

A plane is given the middle of its volume.
"""


@dataclass
class Place:
    """Where the samples lie, in a unit."""

    directions: tuple
    origin: tuple
    unit: str

    @property
    def middle(self) -> np.ndarray:
        """The place of the sample in the middle."""
        return np.array(self.origin) + 3 * np.sum(self.directions, axis=0)


TURNED = ((0.3, 0.4, 0.0), (0.4, -0.3, 0.0), (0.0, 0.1, 1.2))
PLACES = (
    None,
    Place(np.diag((0.7, 0.7, 2.5)), (-179.3, 80.1, 1200.7), "mm"),
    Place(TURNED, (10_000.0, -7000.0, 333.3), "mm"),
    # A fortieth farther out, vertices are kept in f64.
    Place(np.diag((1.0, 1.0, 1.0)), (255_500.0, -130_000.0, 7.0), "mm"),
    Place(np.diag((0.1, 0.1, 0.3)), (0.0, 50.0, -25.0), "um"),
)
"""Every pair of format and mode meets the next one in turn."""

ALL = len(ENDINGS) * len(MODES) * len(PLACES)
"""Seeds in which every format meets every mode in every place."""


def faults_of(isokit: Isokit, folder: Path, seed: int) -> list[str]:
    """Everything that is wrong with the surface of one volume."""
    samples = np.random.default_rng(seed).integers(-3, 4, (7, 7, 7), dtype=np.int8)
    place = PLACES[seed // (len(ENDINGS) * len(MODES)) % len(PLACES)]
    volume = folder / f"{seed}.{'nrrd' if place else 'npy'}"
    if place:
        volume.write_bytes(nrrd(place) + samples.tobytes())
    else:
        np.save(volume, samples)
    written = folder / f"{seed}.{ENDINGS[seed % len(ENDINGS)]}"
    mode = MODES[seed % len(MODES)]
    options = [plane(place) if option == "middle" else option for option in mode]
    try:
        report = isokit.extract(volume, written, "--iso", "0", "--threads", "1", *options)
    except Failed as failure:
        return [str(failure)]
    surface = report["surfaces"][0]
    is_open = "open" in mode
    counters = COUNTERS if is_open else ("boundary_edges", *COUNTERS)
    faults = [f"report: {key} {surface[key]}" for key in counters if surface[key] != 0]
    if report["merged_vertices"] != 0:
        faults.append(f"report: {report['merged_vertices']} vertices merged")
    (part,) = parts_of(written)
    if len(part.mesh.faces) != surface["triangles"]:
        faults.append(f"{len(part.mesh.faces)} triangles of {surface['triangles']}")
    faults += mesh_faults(part.mesh, "as stored", is_open)
    return faults + mesh_faults(merged(part.mesh), "merged", is_open)


def plane(place: Place | None) -> str:
    """One through the middle of a volume, along no axis."""
    normal = np.array((0.6, -0.3, 0.7))
    middle = place.middle if place else np.full(3, 3.0)
    return ",".join(map(str, (*normal, normal @ middle)))


def nrrd(place: Place) -> bytes:
    """The header of a file with the samples of a volume in this place."""

    def vector(numbers: Sequence[float]) -> str:
        return f"({','.join(map(str, numbers))})"

    lines = (
        "NRRD0005",
        "type: int8",
        "dimension: 3",
        "space dimension: 3",
        "sizes: 7 7 7",
        f"space directions: {' '.join(map(vector, place.directions))}",
        f"space origin: {vector(place.origin)}",
        "space units:" + f' "{place.unit}"' * 3,
        "encoding: raw",
    )
    return "\n".join((*lines, "", "")).encode()


def mesh_faults(mesh, state: str, is_open: bool = False) -> list[str]:
    """What trimesh finds wrong with a mesh, which may end somewhere if it is open."""
    shared = faces_per_edge(mesh.faces)
    flat = int((mesh.area_faces <= 0).sum())
    claims = {
        "winding differs": not mesh.is_winding_consistent,
        f"{(shared > 2).sum()} edges of more than two faces": (shared > 2).any(),
        f"{flat} triangles without area": flat > 0,
    }
    if not is_open:
        claims |= {
            "not watertight": not mesh.is_watertight,
            f"{(shared < 2).sum()} edges of one face": (shared < 2).any(),
            f"volume {mesh.volume}": mesh.volume <= 0,
        }
    return [f"{state}: {claim}" for claim, wrong in claims.items() if wrong]


def main() -> int:
    """Tries the seeds from 0 on."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("isokit", type=Path, help="the program to try")
    parser.add_argument("--count", type=int, default=ALL, help=f"volumes; default: {ALL}")
    arguments = parser.parse_args()
    tally = Tally("check_ties", quiet=True)
    claim = "closed but where it may end, manifold, no flat triangle"
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(2) as processes:
        try_seed = partial(faults_of, Isokit(arguments.isokit), Path(folder))
        for seed, faults in enumerate(processes.map(try_seed, range(arguments.count))):
            tally.check(f"seed {seed}", claim, not faults, faults)
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
