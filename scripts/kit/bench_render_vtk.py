"""VTK as a contender of `scripts/bench_render`: ray casting, and surfaces by software OpenGL.

Needs numpy and vtk. Colours are given in linear light, and taken back so: VTK mixes what it is
given.
"""

import time

import numpy as np
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkObject
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkVolumeProperty,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper

import vtkmodules.vtkInteractionStyle  # noqa: F401, I001 (registers what windows need)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401

from .bench_volumes import Volume

TYPES = {"u8": np.uint8, "i16": np.int16, "u16": np.uint16, "f32": np.float32}


def image_of(volume: Volume) -> vtkImageData:
    """The samples, 1 apart."""
    samples = np.fromfile(volume.path, TYPES[volume.dtype])
    image = vtkImageData()
    image.SetDimensions(volume.dims)
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(samples, deep=True))
    return image


class Window:
    """A window that nobody sees."""

    def __init__(self, view: dict) -> None:
        """With a camera, before black."""
        vtkObject.GlobalWarningDisplayOff()
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetSize(view["size"])
        self.window.SetMultiSamples(0)
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(0, 0, 0)
        self.window.AddRenderer(self.renderer)
        camera = self.renderer.GetActiveCamera()
        camera.SetPosition(view["from"])
        camera.SetFocalPoint(view["at"])
        camera.SetViewUp(view["up"])
        camera.SetViewAngle(view["fov"])

    def seconds(self) -> float:
        """The wall time of one picture."""
        # Without a change nothing would be drawn.
        self.renderer.GetActiveCamera().Modified()
        start = time.perf_counter()
        self.window.Render()
        self.window.WaitForCompletion()
        return time.perf_counter() - start

    def picture(self) -> np.ndarray:
        """Red, green and blue from 0 to 1, row by row from the top."""
        grab = vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.Update()
        image = grab.GetOutput()
        width, height, _ = image.GetDimensions()
        parts = numpy_support.vtk_to_numpy(image.GetPointData().GetScalars())
        return parts.reshape(height, width, -1)[::-1, :, :3] / 255.0


class Caster(Window):
    """vtkFixedPointVolumeRayCastMapper."""

    def __init__(self, volume: Volume, view: dict, transfer: list, step: float) -> None:
        """With the same transfer function, step and light."""
        super().__init__(view)
        mapper = vtkFixedPointVolumeRayCastMapper()
        mapper.SetInputData(image_of(volume))
        mapper.SetNumberOfThreads(view["threads"])
        mapper.AutoAdjustSampleDistancesOff()
        mapper.SetImageSampleDistance(1.0)
        mapper.SetSampleDistance(step)
        mapper.SetInteractiveSampleDistance(step)
        mapper.IntermixIntersectingGeometryOff()
        color, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
        for value, red, green, blue, alpha in transfer:
            color.AddRGBPoint(value, red, green, blue)
            opacity.AddPoint(value, alpha)
        look = vtkVolumeProperty()
        look.SetColor(color)
        look.SetScalarOpacity(opacity)
        look.SetScalarOpacityUnitDistance(1.0)
        look.SetInterpolationTypeToLinear()
        if view["lit"]:
            look.ShadeOn()
            look.SetAmbient(0.25)
            look.SetDiffuse(0.75)
            look.SetSpecular(0.15)
            look.SetSpecularPower(32)
        actor = vtkVolume()
        actor.SetMapper(mapper)
        actor.SetProperty(look)
        self.renderer.AddVolume(actor)
        self.renderer.ResetCameraClippingRange()


class Drawer(Window):
    """Meshes by OpenGL, translucent ones by depth peeling until nothing is left."""

    def __init__(self, volume: Volume, view: dict, surfaces: list[dict]) -> None:
        """Extracts, by Flying Edges, and moves the triangles to where OpenGL has them."""
        super().__init__(view)
        image = image_of(volume)
        self.triangles = 0
        for surface in surfaces:
            edges = vtkFlyingEdges3D()
            edges.SetInputData(image)
            edges.SetValue(0, surface["iso"])
            edges.ComputeNormalsOn()
            edges.Update()
            mesh = edges.GetOutput()
            mesh.GetPointData().SetActiveScalars(None)
            self.triangles += mesh.GetNumberOfPolys()
            mapper = vtkPolyDataMapper()
            mapper.SetInputData(mesh)
            mapper.ScalarVisibilityOff()
            actor = vtkActor()
            actor.SetMapper(mapper)
            look = actor.GetProperty()
            look.SetColor(surface["color"])
            look.SetOpacity(surface["opacity"])
            look.SetAmbient(0.25)
            look.SetDiffuse(0.75)
            look.SetSpecular(0.15)
            look.SetSpecularPower(32)
            self.renderer.AddActor(actor)
        self.window.SetAlphaBitPlanes(1)
        self.renderer.SetUseDepthPeeling(1)
        self.renderer.SetMaximumNumberOfPeels(100)
        self.renderer.SetOcclusionRatio(0.0)
        self.renderer.ResetCameraClippingRange()
