"""Mesh files as the parts that their readers see, through trimesh.

GLB, glTF, OBJ and PLY are indexed: their vertices are taken exactly as stored, so that a vertex
written twice shows as an open edge. STL has no index: equal positions are merged, as every reader
of STL does. Needs trimesh.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from kit.units import GLTF, file_unit

Y_UP = (*GLTF, ".obj")
"""Formats whose coordinates are written y up, as (x, z, -y)."""


@dataclass
class Part:
    """One surface of a file, in the file's own coordinates."""

    name: str
    mesh: trimesh.Trimesh


def parts_of(path: Path) -> list[Part]:
    """The surfaces of a file by name, node transforms applied."""
    scene = trimesh.load_scene(path, process=False)
    parts = []
    for node in sorted(scene.graph.nodes_geometry):
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry].copy()
        # A copy loses the colours of glTF that stand beside a material; those of OBJ are where these go.
        beside = getattr(scene.geometry[geometry].visual, "vertex_attributes", {}).get("color")
        if beside is not None:
            mesh.vertex_attributes["color"] = np.array(beside)
        if not np.array_equal(transform, np.eye(4)):
            mesh.apply_transform(transform)
        if path.suffix.lower() == ".stl":
            mesh = merged(mesh)
        parts.append(Part(name=node, mesh=mesh))
    return parts


def merged(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh with one vertex in each place, as a reader makes it that merges what is equal."""
    places, numbers = np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)
    return trimesh.Trimesh(places, numbers.reshape(-1)[mesh.faces], process=False)


def to_world(points: np.ndarray, path: Path, unit: str | None) -> np.ndarray:
    """Points of a file in the world of the volume: z up, in its own unit."""
    if path.suffix.lower() in Y_UP:
        points = points[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    return points / file_unit(path.suffix, unit)


def faces_per_edge(faces: np.ndarray) -> np.ndarray:
    """How many faces share each edge, in no order."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)
    return np.unique(edges[:, 0] << 32 | edges[:, 1], return_counts=True)[1]


def euler(mesh: trimesh.Trimesh) -> int:
    """V - E + F over the vertices that faces use."""
    faces = np.asarray(mesh.faces)
    return len(np.unique(faces)) - len(faces_per_edge(faces)) + len(faces)
