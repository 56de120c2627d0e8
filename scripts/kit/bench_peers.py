"""Extractors by others, from Python, behind one interface.

Each imports its package when it takes a volume. What a peer needs in another form than it came in,
a list of all points or samples in f64, is made off the clock, in `prepare`. What it converts on its own account, in `extract`, is on the clock.
"""

from abc import ABC, abstractmethod

import numpy as np

Mesh = tuple[int, int, object]
"""Vertices and triangles, and what holds them: dropped off the clock."""

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray | None]
"""Vertices as x, y, z in samples, triangles, and normals if there are any."""


class Peer(ABC):
    """A peer with a volume in memory."""

    packages: tuple[str, ...]
    """Names of the packages that it is, for their versions."""
    normals: tuple[bool, ...] = (False,)
    """Whether it makes normals: always, never, or as one likes."""
    threads: tuple[int, ...] = (1,)
    """Numbers of threads that it can be told to use."""
    note = ""
    """What makes its work another than ours."""

    @abstractmethod
    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """Takes a volume, indexed z, y, x."""

    @abstractmethod
    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """Makes the surface."""

    @abstractmethod
    def arrays(self, made: object) -> Arrays:
        """What it made, in one form for all; off the clock."""


class Vtk(Peer):
    """A filter of VTK. It allocates its output anew in each run, warm or not."""

    packages = ("vtk",)
    normals = (False, True)
    threads = (1, 2)

    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """Wraps the samples; they are not copied."""
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonDataModel import vtkImageData

        self.samples = self.adapt(samples, iso)  # VTK keeps no reference
        self.iso = iso
        self.image = vtkImageData()
        self.image.SetDimensions(*reversed(self.samples.shape))
        self.image.GetPointData().SetScalars(numpy_to_vtk(self.samples.ravel()))
        self.kept: dict[bool, object] = {}

    def adapt(self, samples: np.ndarray, iso: float) -> np.ndarray:
        """The samples as the filter wants them."""
        return samples

    @abstractmethod
    def make(self, normals: bool) -> object:
        """The filter."""

    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """Runs a new filter, or, warm, that of the run before again."""
        from vtkmodules.vtkCommonCore import vtkSMPTools

        vtkSMPTools.SetBackend("Sequential" if threads == 1 else "STDThread")
        vtkSMPTools.Initialize(threads)
        algorithm = self.kept.get(normals) if warm else None
        if algorithm is None:
            algorithm = self.make(normals)
            algorithm.SetInputData(self.image)
            if warm:
                self.kept[normals] = algorithm
        algorithm.Modified()
        algorithm.Update()
        mesh = algorithm.GetOutput()
        return mesh.GetNumberOfPoints(), mesh.GetNumberOfPolys(), algorithm

    def arrays(self, made: object) -> Arrays:
        """Copies, since VTK owns its own."""
        from vtkmodules.util.numpy_support import vtk_to_numpy

        mesh = made.GetOutput()
        normals = mesh.GetPointData().GetNormals()
        triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        vertices = vtk_to_numpy(mesh.GetPoints().GetData())
        normals = vtk_to_numpy(normals).copy() if normals else None
        return vertices.copy(), triangles.copy(), normals


class FlyingEdges(Vtk):
    """VTK's fastest."""

    def make(self, normals: bool) -> object:
        """Points, triangles, and normals if wanted; nothing else."""
        from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

        algorithm = vtkFlyingEdges3D()
        algorithm.SetValue(0, self.iso)
        algorithm.SetComputeNormals(normals)
        algorithm.ComputeGradientsOff()
        algorithm.ComputeScalarsOff()
        return algorithm


class Contour(Vtk):
    """VTK's filter for everything."""

    threads = (1,)

    def make(self, normals: bool) -> object:
        """The same choices."""
        from vtkmodules.vtkFiltersCore import vtkContourFilter

        algorithm = vtkContourFilter()
        algorithm.SetValue(0, self.iso)
        algorithm.SetComputeNormals(normals)
        algorithm.ComputeGradientsOff()
        algorithm.ComputeScalarsOff()
        return algorithm


class SurfaceNets(Vtk):
    """VTK's filter for labels."""

    normals = (False,)
    note = "of labels, which were made off the clock; nothing is interpolated"

    def adapt(self, samples: np.ndarray, iso: float) -> np.ndarray:
        """1 inside, 0 outside."""
        return (samples >= iso).astype(np.uint8)

    def make(self, normals: bool) -> object:
        """Without the smoothing that it is known for: that is other work."""
        from vtkmodules.vtkFiltersCore import vtkSurfaceNets3D

        algorithm = vtkSurfaceNets3D()
        algorithm.SetValue(0, 1)
        algorithm.SmoothingOff()
        algorithm.SetOutputMeshTypeToTriangles()
        return algorithm


class SmoothSurfaceNets(SurfaceNets):
    """The same with its smoothing, as it comes."""

    note = "of labels, which were made off the clock; then smoothed"

    def make(self, normals: bool) -> object:
        """VTK's defaults."""
        algorithm = super().make(normals)
        algorithm.SmoothingOn()
        return algorithm


class ScikitImage(Peer):
    """The usual choice in Python: Lewiner's method."""

    packages = ("scikit-image",)
    normals = (True,)

    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """Nothing to do."""
        from skimage.measure import marching_cubes

        self.function, self.samples, self.iso = marching_cubes, samples, iso

    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """Vertices, faces, normals and values."""
        mesh = self.function(self.samples, self.iso)
        return len(mesh[0]), len(mesh[1]), mesh

    def arrays(self, made: object) -> Arrays:
        """Coordinates come in the order of the indices."""
        vertices, triangles, normals, _values = made
        return vertices[:, ::-1], triangles, normals[:, ::-1]


class PyMCubes(Peer):
    """Marching cubes in C++."""

    packages = ("PyMCubes",)

    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """Nothing to do."""
        import mcubes

        self.function, self.samples, self.iso = mcubes.marching_cubes, samples, iso

    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """Vertices in f64."""
        mesh = self.function(self.samples, self.iso)
        return len(mesh[0]), len(mesh[1]), mesh

    def arrays(self, made: object) -> Arrays:
        """Coordinates come in the order of the indices."""
        return made[0][:, ::-1], made[1], None


class Splashsurf(Peer):
    """Marching cubes in Rust, of a program for particles."""

    packages = ("pysplashsurf",)
    step = 1.0

    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """It takes floats only."""
        import pysplashsurf

        self.function, self.iso = pysplashsurf.marching_cubes, iso
        self.samples = np.ascontiguousarray(samples, np.float32)

    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """One thread, as its documentation says."""
        mesh = self.function(self.samples, iso_surface_threshold=self.iso, cube_size=self.step)
        return len(mesh.vertices), len(mesh.triangles), mesh

    def arrays(self, made: object) -> Arrays:
        """Coordinates come in the order of the indices."""
        return np.asarray(made.vertices)[:, ::-1], np.asarray(made.triangles), None


class Libigl(Peer):
    """Marching cubes over any list of points."""

    packages = ("libigl",)
    note = "also gives a Python dict of all crossed edges"

    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """It wants all points, and f64."""
        import igl

        self.function, self.iso = igl.marching_cubes, iso
        self.dims = samples.shape[::-1]
        self.samples = samples.ravel().astype(np.float64)
        axes = [np.arange(n, dtype=np.float64) for n in samples.shape]
        z, y, x = np.meshgrid(*axes, indexing="ij")
        self.points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)

    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """Vertices, faces and edges."""
        mesh = self.function(self.samples, self.points, *self.dims, self.iso)
        return len(mesh[0]), len(mesh[1]), mesh

    def arrays(self, made: object) -> Arrays:
        """As the points were given."""
        return made[0], made[1], None


class Meshlib(Peer):
    """Marching cubes into a half-edge mesh."""

    packages = ("meshlib",)
    threads = (2,)
    note = "all threads; makes a half-edge mesh"

    def prepare(self, samples: np.ndarray, iso: float) -> None:
        """Its own kind of volume."""
        from meshlib import mrmeshnumpy, mrmeshpy

        self.library = mrmeshpy
        self.volume = mrmeshnumpy.simpleVolumeFrom3Darray(samples)
        self.parameters = mrmeshpy.MarchingCubesParams()
        self.parameters.iso = iso

    def extract(self, normals: bool, threads: int, warm: bool) -> Mesh:
        """A mesh without normals."""
        mesh = self.library.marchingCubes(self.volume, self.parameters)
        topology = mesh.topology
        return topology.numValidVerts(), topology.numValidFaces(), mesh

    def arrays(self, made: object) -> Arrays:
        """Coordinates come in the order of the indices, from the corner of the first voxel."""
        from meshlib import mrmeshnumpy

        vertices = mrmeshnumpy.getNumpyVerts(made)
        return vertices[:, ::-1] - 0.5, mrmeshnumpy.getNumpyFaces(made.topology), None


PEERS: dict[str, type[Peer]] = {
    "vtk Flying Edges": FlyingEdges,
    "vtk contour filter": Contour,
    "vtk SurfaceNets": SurfaceNets,
    "vtk SurfaceNets smoothed": SmoothSurfaceNets,
    "scikit-image": ScikitImage,
    "PyMCubes": PyMCubes,
    "pysplashsurf": Splashsurf,
    "libigl": Libigl,
    "meshlib": Meshlib,
}
"""All of them by the names that the table gives them."""
