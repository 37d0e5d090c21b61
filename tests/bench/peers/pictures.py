"""Pictures as arrays of linear light (rows from the top, 0 to 1): PNG, how far two are apart, and sheets of them."""

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter

# Below this a pixel shows nothing. Linear light.
DARK = 0.02


def to_linear(display):
    return np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)


def to_display(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def read_png(path, linear=False):
    """With `linear`, of a program that writes light as it is."""
    reader = vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1, :, :3]
    values = pixels.astype(np.float64) / np.iinfo(pixels.dtype).max
    return values if linear else to_linear(values)


def write_png(path, linear):
    pixels = np.ascontiguousarray((255 * to_display(linear[::-1]) + 0.5).astype(np.uint8))
    image = vtkImageData()
    image.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    image.GetPointData().SetScalars(numpy_to_vtk(pixels.reshape(-1, 3), deep=True))
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(image)
    writer.Write()


class Likeness:
    """Over the pixels where either picture shows something: PSNR in dB (linear light, peak 1), that of the pictures when
    one is made as bright as the other, the ratio of brightness, and the part of these pixels where both show something."""

    def __init__(self, ours, theirs):
        a, b = ours.max(axis=2) > DARK, theirs.max(axis=2) > DARK
        either = a | b
        self.shown = int(either.sum())
        self.coverage = float((a & b).sum() / max(self.shown, 1))
        x, y = ours[either], theirs[either]
        self.brightness = float(y.sum() / max(x.sum(), 1e-9))
        self.psnr = self._psnr(x, y)
        self.psnr_even = self._psnr(x * self.brightness, y)

    @staticmethod
    def _psnr(x, y):
        return float(-10 * np.log10(max(np.mean((x - y) ** 2), 1e-12))) if x.size else float("inf")


def sheet(rows):
    """Rows of pictures of one size side by side."""
    return np.concatenate([np.concatenate(row, axis=1) for row in rows], axis=0)
