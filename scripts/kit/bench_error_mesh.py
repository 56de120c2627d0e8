"""A triangle mesh as its index says it is: closed, manifold, in how many pieces. Needs numpy.

Vertices are taken as they are stored: one that is written twice makes open edges.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

BORDER = 1.01
"""Samples from the border of the volume within which an edge may be open, if the field goes on.

Dual methods end half a cell before it.
"""


@dataclass
class Mesh:
    """Vertices in the cube of the fields, triangles, unit normals of vertices if there are any."""

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    bound: tuple[float | None, int] | None = None
    """By how much its maker says that triangles may leave the surface, and how many it says nothing of."""

    @classmethod
    def from_samples(
        cls, vertices: np.ndarray, triangles: np.ndarray, normals: np.ndarray | None, n: int
    ) -> "Mesh":
        """From coordinates that count samples of an n³ lattice on the cube from -1 to 1."""
        world = np.asarray(vertices, np.float64) * (2 / (n - 1)) - 1
        return cls(world, np.asarray(triangles, np.int64), normals)


def from_arrays(path: Path, vertices: int, triangles: int, n: int) -> Mesh:
    """A file of isokit's driver: positions as f64, normals as f32, triangles as u32, no header."""
    with path.open("rb") as file:
        places = np.fromfile(file, "<f8", 3 * vertices).reshape(-1, 3)
        normals = np.fromfile(file, "<f4", 3 * vertices).reshape(-1, 3).astype(np.float64)
        corners = np.fromfile(file, "<u4", 3 * triangles).reshape(-1, 3)
    return Mesh.from_samples(places, corners, normals, n)


@dataclass
class Topology:
    """What a mesh is as a surface."""

    open_edges: int
    crowded_edges: int
    """Edges of more than two triangles."""
    twisted_edges: int
    """Edges that their two triangles run through in one direction."""
    crowded_vertices: int
    """Fans of triangles more than there are vertices."""
    components: int
    euler: int

    def faults(self, euler: int | None, components: int | None) -> list[str]:
        """What is wrong with it, in words; nothing if it is as the field is known to be."""
        counted = {
            "open": self.open_edges,
            "non-manifold": self.crowded_edges + self.crowded_vertices,
            "twisted": self.twisted_edges,
        }
        found = [name for name, count in counted.items() if count]
        if components is not None and self.components != components:
            found.append(f"{self.components} components, not {components}")
        if euler is not None and self.euler != euler:
            found.append(f"χ {self.euler}, not {euler}")
        return found


def topology(mesh: Mesh, spacing: float, closed: bool) -> Topology:
    """Counts; open edges along the border of the cube only if the field is closed."""
    corners = mesh.triangles
    start, stop = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    low, high = np.minimum(start, stop), np.maximum(start, stop)
    order = np.argsort(low << 32 | high, kind="stable")
    keys = (low << 32 | high)[order]
    first = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1]])) if len(keys) else order
    count = np.diff(np.append(first, len(keys)))
    single, double = order[first[count == 1]], first[count == 2]
    one, other = order[double], order[double + 1]
    if not closed:
        limit = 1 - BORDER * spacing
        ends = np.stack([mesh.vertices[start[single]], mesh.vertices[stop[single]]])
        single = single[~(np.abs(ends).max(axis=2) >= limit).all(axis=0)]
    # A side's number is that of the corner it starts from; the next corner is where it ends.
    following = np.arange(len(start)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    pairs = []
    for end in (low, high):
        at = [np.where(start[side] == end[side], side, following[side]) for side in (one, other)]
        pairs.append(at)
    fans = joined(len(start), *np.concatenate(pairs, axis=1)) if len(start) else start
    used = np.unique(start)
    pieces = joined(len(mesh.vertices), start, stop)[used]
    return Topology(
        open_edges=len(single),
        crowded_edges=int((count > 2).sum()),
        twisted_edges=int((start[one] == start[other]).sum()),
        crowded_vertices=len(np.unique(fans)) - len(used) if (count <= 2).all() else 0,
        components=len(np.unique(pieces)),
        euler=len(used) - len(first) + len(corners),
    )


def joined(count: int, ones: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The least member of everybody's set, once each pair is in one set."""
    least = np.arange(count)
    while True:
        a, b = least[ones], least[others]
        apart = a != b
        if not apart.any():
            return least
        ones, others, a, b = ones[apart], others[apart], a[apart], b[apart]
        lower = np.minimum(a, b)
        np.minimum.at(least, np.maximum(a, b), lower)
        while True:
            jumped = least[least]
            if (jumped == least).all():
                break
            least = jumped
