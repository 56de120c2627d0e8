"""The peers of the stress list: those of the benchmark, with their meshes as arrays. Needs numpy.

VTK's SurfaceNets are not among them: they take labels, and what is hard in a value is gone from these.

A peer that has no setting for spacing, origin or orientation refuses a volume that needs it. What
is refused with an exception is listed as "cannot"; what ends the process is a failure.
"""

import numpy as np

from kit import bench_peers
from kit.stress_case import Case
from kit.stress_check import Mesh


MEMORY = 8 << 30
"""Bytes of address space that a peer may have."""


class Refused(Exception):
    """The peer has no setting for this; the message says for what."""


def spacing(case: Case) -> tuple[float, float, float]:
    """The spacing of a volume whose axes are those of the world; refuses others."""
    matrix = np.array(case.directions)
    if np.count_nonzero(matrix - np.diag(np.diagonal(matrix))):
        raise Refused("no setting for orientation")
    return tuple(map(float, np.diagonal(matrix)))


def refuse_origin(case: Case) -> None:
    """For a peer that puts the first sample at 0."""
    if any(case.origin):
        raise Refused("no setting for the origin")


class Vtk:
    """A filter of VTK. Samples are made contiguous for it, as VTK holds no others."""

    settings = "no normals, gradients or scalars; one thread"

    def __init__(self, peer: bench_peers.Vtk) -> None:
        """Takes the filter's adapter."""
        self.peer = peer

    def mesh(self, samples: np.ndarray, case: Case) -> Mesh:
        """Points and polygons of a new filter."""
        self.peer.prepare(np.ascontiguousarray(samples), case.iso)
        self.place(self.peer.image, case)
        vertices, triangles, made = self.peer.extract(False, 1, False)
        if vertices == 0 or triangles == 0:
            return Mesh(np.zeros((vertices, 3)), np.zeros((0, 3), np.int64))
        return Mesh(*self.peer.arrays(made)[:2])

    def place(self, image: object, case: Case) -> None:
        """Spacing with its sign where that is enough, a matrix of directions where it is not."""
        image.SetOrigin(*case.origin)
        matrix = np.array(case.directions)
        try:
            image.SetSpacing(*spacing(case))
        except Refused:
            lengths = np.linalg.norm(matrix, axis=1)
            image.SetSpacing(*lengths)
            image.SetDirectionMatrix(*(matrix / lengths[:, None]).T.ravel())


class ScikitImage:
    """Lewiner's method."""

    settings = "`marching_cubes(method='lewiner')`, its default, with `spacing`"

    def mesh(self, samples: np.ndarray, case: Case) -> Mesh:
        """Coordinates come in the order of the array's axes."""
        from skimage.measure import marching_cubes

        refuse_origin(case)
        steps = spacing(case)[::-1]
        vertices, faces, _, _ = marching_cubes(samples, case.iso, spacing=steps)
        return Mesh(vertices[:, ::-1], faces)


class PyMCubes:
    """It knows samples and nothing else."""

    settings = "`marching_cubes(samples, iso)`"

    def mesh(self, samples: np.ndarray, case: Case) -> Mesh:
        """Coordinates come in the order of the array's axes."""
        import mcubes

        if case.placed:
            raise Refused("no setting for spacing, origin or orientation")
        vertices, faces = mcubes.marching_cubes(samples, case.iso)
        return Mesh(vertices[:, ::-1], faces)


class Splashsurf:
    """Its cells are cubes."""

    settings = "`marching_cubes(samples, iso_surface_threshold, cube_size)`; samples converted to f32 for it"

    def mesh(self, samples: np.ndarray, case: Case) -> Mesh:
        """Vertices and faces."""
        refuse_origin(case)
        peer = bench_peers.Splashsurf()
        peer.step, *others = spacing(case)
        if peer.step <= 0 or any(other != peer.step for other in others):
            raise Refused("no setting for other cells than cubes")
        peer.prepare(samples, case.iso)
        _, _, found = peer.extract(False, 1, False)
        return Mesh(*peer.arrays(found)[:2])


class Libigl:
    """It takes any points, so every place can be had; samples are converted to f64 for it."""

    settings = "`marching_cubes(S, GV, nx, ny, nz, iso)` in f64, points placed by us"

    def mesh(self, samples: np.ndarray, case: Case) -> Mesh:
        """Vertices and faces."""
        peer = bench_peers.Libigl()
        peer.prepare(samples, case.iso)
        if case.placed:
            peer.points = peer.points @ np.array(case.directions) + case.origin
        _, _, found = peer.extract(False, 1, False)
        return Mesh(np.asarray(found[0]).reshape(-1, 3), np.asarray(found[1]).reshape(-1, 3))


class Meshlib:
    """Its samples lie in the middle of voxels: half a spacing is taken off."""

    settings = (
        "`marchingCubes` with its defaults, all threads; whole numbers converted to f64 for it; "
        "packed before it is looked at"
    )

    def mesh(self, samples: np.ndarray, case: Case) -> Mesh:
        """Vertices and faces without those that it has deleted."""
        from meshlib import mrmeshnumpy, mrmeshpy

        refuse_origin(case)
        steps = spacing(case)
        if min(steps) <= 0:
            raise Refused("no setting for orientation")
        if samples.dtype.kind != "f":
            samples = samples.astype(np.float64)
        peer = bench_peers.Meshlib()
        # Its axes are x, y, z in the order of the array's.
        peer.prepare(samples.transpose(2, 1, 0), case.iso)
        peer.volume.voxelSize = mrmeshpy.Vector3f(*steps)
        _, _, found = peer.extract(False, 2, False)
        found.pack()
        vertices = np.asarray(mrmeshnumpy.getNumpyVerts(found)).reshape(-1, 3)
        faces = np.asarray(mrmeshnumpy.getNumpyFaces(found.topology)).reshape(-1, 3)
        return Mesh(vertices - 0.5 * np.array(steps), faces)


PEERS = {
    "vtk Flying Edges": lambda: Vtk(bench_peers.FlyingEdges()),
    "vtk contour filter": lambda: Vtk(bench_peers.Contour()),
    "scikit-image": ScikitImage,
    "PyMCubes": PyMCubes,
    "pysplashsurf": Splashsurf,
    "libigl": Libigl,
    "meshlib": Meshlib,
}
"""All of them by the names that the table gives them."""

SETTINGS = {name: make().settings for name, make in PEERS.items()}
"""What each is told."""
