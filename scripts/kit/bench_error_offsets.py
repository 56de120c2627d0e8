"""The least error that moving a mesh's vertices along normals can leave. Needs numpy.

The root of the mean square over all triangles is least where what remains is orthogonal to all that
vertices can do: one linear equation for each vertex, summed over seven points of each triangle and
solved by conjugate gradients. It takes the surface itself, which no program has that has samples
only: a limit, not a contender.
"""

from dataclasses import dataclass

import numpy as np

from kit.bench_error_fields import Field, dot, length
from kit.bench_error_measure import CORNERS, WEIGHTS
from kit.bench_error_mesh import Mesh

ENOUGH = 1e-9
"""Part of the right-hand side that may remain, as a root of squares."""

STEPS = 500
"""A mass matrix needs some dozens."""


@dataclass
class Equations:
    """A matrix and a right-hand side for each triangle."""

    triangles: np.ndarray
    matrices: np.ndarray
    sides: np.ndarray
    vertices: int

    def gathered(self, parts: np.ndarray) -> np.ndarray:
        """What triangles say of their corners, summed for each vertex."""
        return np.bincount(self.triangles.ravel(), parts.ravel(), minlength=self.vertices)

    def product(self, offsets: np.ndarray) -> np.ndarray:
        """The whole matrix by a vector."""
        return self.gathered(np.einsum("tij,tj->ti", self.matrices, offsets[self.triangles]))

    def solution(self) -> np.ndarray:
        """The offsets (Hestenes & Stiefel 1952), each row by its diagonal."""
        rest = self.gathered(self.sides)
        diagonal = self.gathered(np.einsum("tii->ti", self.matrices))
        scale = 1 / np.where(diagonal > 0, diagonal, 1)
        offsets, way = np.zeros(self.vertices), scale * rest
        left = rest @ way
        first = left
        for _ in range(STEPS):
            if left <= ENOUGH**2 * first:
                break
            image = self.product(way)
            step = left / (way @ image)
            offsets += step * way
            rest -= step * image
            scaled = scale * rest
            after = rest @ scaled
            way, left = scaled + after / left * way, after
        return offsets


def best_by_offsets(mesh: Mesh, field: Field) -> Mesh:
    """The mesh with its vertices moved along the surface's normals so that the error is least."""
    _, normals = field.nearest(mesh.vertices)
    corners = [mesh.vertices[mesh.triangles[:, k]] for k in range(3)]
    area = length(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2
    matrices, sides = np.zeros((len(area), 3, 3)), np.zeros((len(area), 3))
    for weight, shares in zip(WEIGHTS, CORNERS, strict=True):
        points = sum(share * corner for share, corner in zip(shares, corners, strict=True))
        foot, normal = field.nearest(points)
        above = dot(points - foot, normal)
        turned = [dot(normal, normals[mesh.triangles[:, k]]) for k in range(3)]
        lift = shares * np.stack(turned, axis=1)
        matrices += (weight * area)[:, None, None] * lift[:, :, None] * lift[:, None, :]
        sides -= (weight * area * above)[:, None] * lift
    offsets = Equations(mesh.triangles, matrices, sides, len(mesh.vertices)).solution()
    return Mesh(mesh.vertices + offsets[:, None] * normals, mesh.triangles, None)
