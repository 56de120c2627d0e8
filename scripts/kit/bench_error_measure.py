"""How far a mesh is from the surface of a field, and back. Needs numpy and scipy.

From the mesh: at vertices and at seven points in each triangle, weighted as for integrals of
polynomials of degree 5 (Radon 1948). From the surface: points spread over it, each against the
triangles around the vertices nearest to it; that distance can only come out too large, and does
where none of those triangles is the nearest. Lengths are in units of which the cube has two.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.spatial import cKDTree

from kit.bench_error_fields import Field, Smooth, dot, length, unit
from kit.bench_error_mesh import Mesh, topology

ROOT = np.sqrt(15)
CORNERS = np.array(
    [[1 / 3] * 3]
    + [np.roll([1 - 2 * a, a, a], k) for a in ((6 - ROOT) / 21, (6 + ROOT) / 21) for k in range(3)]
)
WEIGHTS = np.array([9 / 40] + [(155 - ROOT) / 1200] * 3 + [(155 + ROOT) / 1200] * 3)

CHUNK = 1 << 17
"""Points that are worked on at a time."""

MOST_THREADS = 16
"""Each has arrays of its own, of some 60 MB."""

NEAREST = 4
"""Vertices whose triangles are tried."""

AGAIN = 24
"""The same for the tenth of all points that seems farthest.

Where thin triangles meet, the vertices nearest to a point are all theirs, and none is of the large
triangle under it.
"""

DOUBTED = 0.02
"""Distance from which on a nearest point is compared with that found from the cloud."""


def errors(mesh: Mesh, field: Field, cloud: np.ndarray, spacing: float) -> dict:
    """All figures of one mesh; lengths of the field's cube, angles in degrees."""
    counts = {"vertices": len(mesh.vertices), "triangles": len(mesh.triangles)}
    if mesh.bound:
        counts |= {"bound": mesh.bound[0], "unbounded": mesh.bound[1]}
    if not np.isfinite(mesh.vertices).all():
        return counts | {"faults": ["not finite"]}
    found = topology(mesh, spacing, field.closed)
    figures = counts | vars(found)
    figures["faults"] = found.faults(field.euler, field.components)
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a) / 2
    if field.closed:
        volume = abs(dot(a, np.cross(b, c)).sum()) / 6
        figures["area_error"] = length(across).sum() / field.area - 1 if field.area else None
        figures["volume_error"] = volume / field.volume - 1 if field.volume else None
    counted = judged(mesh, field)
    if not counted.any():
        return figures | {"faults": ["nothing"]}
    square, most, face_angle = of_triangles(field, cloud, a[counted], b[counted], c[counted])
    away, angle = of_vertices(mesh, field, cloud)
    back = to_mesh(mesh, cloud)
    figures |= together([(away, angle)])
    figures |= {
        "forward_rms": np.sqrt(square),
        "forward_max": max(most, away.max()),
        "reverse_rms": rms(back),
        "reverse_max": back.max(),
        "face_angle": face_angle,
    }
    for kind in ("rms", "max"):
        figures[kind] = max(figures[f"forward_{kind}"], figures[f"reverse_{kind}"])
    return {name: float(v) if isinstance(v, np.floating) else v for name, v in figures.items()}


def of_vertices(
    mesh: Mesh, field: Field, cloud: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """The distance of each vertex of triangles that count, and the angle of its normal, if it has one."""
    kept = np.zeros(len(mesh.vertices), bool)
    kept[mesh.triangles[judged(mesh, field)]] = True
    foot, normal = nearest(field, mesh.vertices[kept], cloud)
    away = length(mesh.vertices[kept] - foot)
    if mesh.normals is None:
        return away, None
    return away, degrees(sign_of(mesh.normals[kept], normal) * mesh.normals[kept], normal)


def together(parts: list[tuple[np.ndarray, np.ndarray | None]]) -> dict[str, float]:
    """The figures of the vertices of several meshes."""
    aways, angles = zip(*parts, strict=True)
    figures = {"vertex_rms": float(rms(np.concatenate(aways)))}
    if all(angle is not None for angle in angles):
        figures["vertex_angle"] = float(rms(np.concatenate(angles)))
    return figures


def judged(mesh: Mesh, field: Field) -> np.ndarray:
    """Which triangles count."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return field.judged((a + b + c) / 3)


def of_triangles(
    field: Field, cloud: np.ndarray, *corners: np.ndarray
) -> tuple[float, float, float]:
    """Mean square of the distance, the greatest, RMS angle of faces."""
    a, b, c = corners
    across = np.cross(b - a, c - a)
    area = length(across)
    squares, most = 0.0, 0.0
    for weight, (u, v, w) in zip(WEIGHTS, CORNERS, strict=True):
        points = u * a + v * b + w * c
        foot, normal = nearest(field, points, cloud)
        distance = length(points - foot)
        squares += weight * (area * distance**2).sum()
        most = max(most, distance.max())
        if u == v == w:
            middle = normal
    faces = area > 0
    angle = degrees(sign_of(across, middle) * across[faces], middle[faces])
    square = (area[faces] * angle**2).sum() / area.sum()
    return squares / area.sum(), most, np.sqrt(square)


def nearest(field: Field, points: np.ndarray, cloud: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest points of the surface, with normals; in doubt also from the cloud."""
    foot, normal = np.empty_like(points), np.empty_like(points)

    def fill(low: int) -> None:
        part = slice(low, low + CHUNK)
        foot[part], normal[part] = field.nearest(points[part])

    in_threads(fill, range(0, len(points), CHUNK))
    if isinstance(field, Smooth):
        away = length(points - foot)
        doubtful = np.flatnonzero(~(away < DOUBTED))
        if len(doubtful):
            start = cloud[cKDTree(cloud).query(points[doubtful])[1]]
            other, other_normal = field.nearest_from(points[doubtful], start)
            better = ~(length(points[doubtful] - other) >= away[doubtful])
            foot[doubtful[better]] = other[better]
            normal[doubtful[better]] = other_normal[better]
    return foot, normal


def in_threads(work: Callable[[int], None], starts: range) -> None:
    """Does the work from each start: numpy lets other threads go on while it works on arrays.

    Nothing is timed meanwhile.
    """
    with ThreadPoolExecutor(min(os.cpu_count() or 1, MOST_THREADS)) as pool:
        list(pool.map(work, starts))


def to_mesh(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """The distance of each point from the triangles around the vertices nearest to it."""
    around = Around(mesh)
    result = around.distances(points, NEAREST)
    far = np.flatnonzero(result > np.quantile(result, 0.9))
    result[far] = np.minimum(result[far], around.distances(points[far], AGAIN))
    return result


class Around:
    """Vertices that triangles use, and the triangles around each."""

    def __init__(self, mesh: Mesh) -> None:
        """Sorts both."""
        self.mesh, corner = mesh, mesh.triangles.ravel()
        self.by_vertex = np.argsort(corner, kind="stable")
        used, self.starts, self.counts = np.unique(
            corner[self.by_vertex], return_index=True, return_counts=True
        )
        self.vertices = cKDTree(mesh.vertices[used])

    def distances(self, points: np.ndarray, count: int) -> np.ndarray:
        """The least distance of each point from a triangle around one of `count` vertices near it."""
        count = min(count, self.vertices.n)
        result = np.empty(len(points))
        step = max(CHUNK * NEAREST // (16 * count), 1)

        def fill(low: int) -> None:
            part = points[low : low + step]
            near = self.vertices.query(part, count)[1].ravel()
            many = self.counts[near]
            faces = self.by_vertex[spread(self.starts[near], many)] // 3
            owner = np.repeat(np.repeat(np.arange(len(part)), count), many)
            corners = (self.mesh.vertices[self.mesh.triangles[faces, k]] for k in range(3))
            least = np.full(len(part), np.inf)
            np.minimum.at(least, owner, to_triangles(part[owner], *corners))
            result[low : low + len(part)] = least

        in_threads(fill, range(0, len(points), step))
        return result


def spread(starts: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """All numbers of all ranges, one range after the other."""
    before = np.cumsum(counts) - counts
    return np.arange(counts.sum()) - np.repeat(before - starts, counts)


def to_triangles(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Row by row the distance of a point from a triangle: from its plane, or its nearest side."""
    across = unit(np.cross(b - a, c - a))
    inside = length(across) > 0
    least = np.full(len(p), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        along = np.clip(dot(p - start, side) / np.maximum(dot(side, side), 1e-300), 0, 1)
        least = np.minimum(least, length(p - start - along[:, None] * side))
        inside &= dot(np.cross(side, p - start), across) >= 0
    return np.where(inside, np.abs(dot(p - a, across)), least)


def sign_of(vectors: np.ndarray, normals: np.ndarray) -> float:
    """1 if most point as the normals do, else -1: every tool has its own idea of the inside."""
    return 1.0 if np.nansum(dot(vectors, normals)) >= 0 else -1.0


def degrees(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """The angles between them, row by row; of vectors of any length."""
    return np.degrees(np.arctan2(length(np.cross(vectors, normals)), dot(vectors, normals)))


def rms(values: np.ndarray) -> float:
    """The root of the mean square."""
    return np.sqrt(np.mean(values**2))
