"""VTK's vtkFixedPointVolumeRayCastMapper over the views of scene.py: pictures, and the time of each frame without that of
bringing the picture to the window. To be run under a display (xvfb-run)."""

import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import (vtkColorTransferFunction, vtkLight, vtkRenderer, vtkRenderWindow, vtkVolume,
                                         vtkVolumeProperty, vtkWindowToImageFilter)
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 the window
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401 shows a picture of rays

import scene

OPAQUE_AT = 1 - 255 / 32767  # its rays end when so much is opaque: in its fixed point, less than 255 of 32767 is left


def _image(volume):
    image = vtkImageData()
    image.SetDimensions(*volume.dims)
    image.SetSpacing(*volume.spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(volume.voxels.ravel(), deep=False))
    return image


def _property(points, shaded):
    colors, opacities = vtkColorTransferFunction(), vtkPiecewiseFunction()
    for value, opacity, color in points:
        colors.AddRGBPoint(value, *color)
        opacities.AddPoint(value, opacity)
    out = vtkVolumeProperty()
    out.SetColor(colors)
    out.SetScalarOpacity(opacities)
    out.SetScalarOpacityUnitDistance(1.0)
    out.SetInterpolationTypeToLinear()
    out.SetShade(1 if shaded else 0)
    out.SetAmbient(scene.SHADING["ambient"])
    out.SetDiffuse(scene.SHADING["diffuse"])
    out.SetSpecular(scene.SHADING["specular"])
    out.SetSpecularPower(scene.SHADING["power"])
    return out


def _headlight():
    """A light that VTK makes by itself has no ambient part, so that a volume's ambient coefficient counts for nothing."""
    light = vtkLight()
    light.SetLightTypeToHeadlight()
    light.SetAmbientColor(1, 1, 1)
    return light


def _aim(camera, view):
    camera.SetFocalPoint(*view.target)
    camera.SetPosition(*view.eye)
    camera.SetViewUp(*view.up)
    camera.SetParallelProjection(1 if view.projection == "orthographic" else 0)
    camera.SetParallelScale(view.height / 2)
    camera.SetViewAngle(view.fov_deg)
    camera.SetClippingRange(0.1 * view.distance, 10 * view.distance)


class Renderer:
    def __init__(self, volume, size, threads):
        self._mapper = vtkFixedPointVolumeRayCastMapper()
        self._image = _image(volume)
        self._mapper.SetInputData(self._image)
        self._mapper.AutoAdjustSampleDistancesOff()
        self._mapper.SetImageSampleDistance(1.0)
        self._mapper.SetSampleDistance(min(volume.spacing))
        self._mapper.SetNumberOfThreads(threads)
        self._actor = vtkVolume()
        self._actor.SetMapper(self._mapper)
        self._renderer = vtkRenderer()
        self._renderer.SetBackground(0, 0, 0)
        self._renderer.AddVolume(self._actor)
        self._renderer.AutomaticLightCreationOff()
        self._renderer.AddLight(_headlight())
        self._window = vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)
        self._window.SetSize(size, size)
        self._window.AddRenderer(self._renderer)

    def draw(self, views, points, shaded):
        """Seconds of each view after a first that is not counted, the seconds of that one, and the middle picture in
        0 to 1, the first row on top."""
        self._actor.SetProperty(_property(points, shaded))
        seconds, picture, first = [], None, None
        for i, view in enumerate([views[0]] + list(views)):
            _aim(self._renderer.GetActiveCamera(), view)
            begin = time.perf_counter()
            self._window.Render()
            frame = time.perf_counter() - begin
            begin = time.perf_counter()
            self._mapper.DisplayRenderedImage(self._renderer, self._actor)
            shown = time.perf_counter() - begin
            if i == 0:
                first = frame
                continue
            seconds.append(max(frame - shown, 0))
            if i == 1 + len(views) // 2:
                picture = self._grab()
        return seconds, first, picture

    def truth(self, view, points):
        """The same in steps of a fifth of a voxel: what the others' pictures are held against."""
        step = self._mapper.GetSampleDistance()
        self._mapper.SetSampleDistance(step / 5)
        self._actor.SetProperty(_property(points, True))
        _aim(self._renderer.GetActiveCamera(), view)
        picture = self._grab()
        self._mapper.SetSampleDistance(step)
        return picture

    def _grab(self):
        self._window.Render()
        grabber = vtkWindowToImageFilter()
        grabber.SetInput(self._window)
        grabber.ReadFrontBufferOff()
        grabber.Update()
        image = grabber.GetOutput()
        width, height, _ = image.GetDimensions()
        pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)
        return pixels[::-1].astype(np.float32) / 255
