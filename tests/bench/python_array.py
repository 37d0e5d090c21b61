#!/usr/bin/env python3
"""A NumPy array of 512^3 voxels to a picture of 1024 x 1024 pixels: Kiln beside VTK, each in a process of its own.

    PYTHONPATH=build/release/tools/lib/python3.11/dist-packages xvfb-run -a -s "-screen 0 1280x1024x24" \
      /usr/bin/python3 tests/bench/python_array.py [--edge 512] [--size 1024] [--out FOLDER]

VTK draws as PyVista's `add_volume` has it draw: by vtkSmartVolumeMapper, which takes the OpenGL renderer (by software where
there is no GPU), or by the ray caster on the processor. Camera, colours and opacities are equal. Times are from the array to
pixels in memory: of the first picture, and of the next from another side; the time of the processor is comparable on a
busy machine. Memory is the peak of the process beyond the
array. VTK steps one voxel; Kiln has its defaults, half a voxel and 2 or more samples a pixel, or one voxel and one sample.
It takes a minute, wants a quiet machine, and is not part of CI.
"""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import time

import numpy

BLUE, ORANGE, WHITE = (0.3, 0.6, 1.0), (1.0, 0.6, 0.2), (1.0, 1.0, 1.0)
POINTS = [(300, 0.0, BLUE), (500, 0.03, BLUE), (700, 0.4, ORANGE), (1000, 0.9, WHITE)]
FOV, AZIMUTHS = 30, (30, 75)


def array_of(edge):
    """A ball with waves, as uint16."""
    at = numpy.linspace(-1, 1, edge, dtype="float32")
    out = numpy.empty((edge, edge, edge), "uint16")
    y, x = at[:, None], at[None, :]
    for k, z in enumerate(at):
        radius = numpy.sqrt(x * x + y * y + z * z)
        wave = numpy.sin(11 * x + 3 * z) * numpy.sin(11 * y) * numpy.sin(11 * z)
        out[k] = numpy.clip(1000 * (1.1 - radius) + 250 * wave, 0, 2000)
    return out


def camera_of(edge, azimuth):
    middle, distance, angle = (edge - 1) / 2, 2.2 * edge, math.radians(azimuth)
    return (middle - distance * math.sin(angle), middle - distance * math.cos(angle), middle), (middle,) * 3


def draw_kiln(array, size, words):
    import kiln

    tf = kiln.transfer_function(POINTS)
    volume = kiln.open(array)
    for azimuth in AZIMUTHS:
        eye, target = camera_of(array.shape[0], azimuth)
        camera = {"eye": eye, "target": target, "up": (0, 0, 1), "fov": FOV}
        image = volume.render(tf=tf, camera=camera, size=(size, size), background="black", **words)
        numpy.asarray(image)
        yield image.srgb8()


def draw_vtk(array, size, mapper):
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
    from vtkmodules.vtkRenderingCore import (vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume,
                                             vtkWindowToImageFilter)
    from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
    from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

    edge = array.shape[0]
    grid = vtkImageData()
    grid.SetDimensions(edge, edge, edge)
    grid.GetPointData().SetScalars(numpy_to_vtk(array.ravel(), deep=False))
    draws = vtkSmartVolumeMapper() if mapper == "smart" else vtkFixedPointVolumeRayCastMapper()
    draws.SetInputData(grid)
    draws.SetAutoAdjustSampleDistances(0)
    draws.SetSampleDistance(1.0)
    colors, opacities = vtkColorTransferFunction(), vtkPiecewiseFunction()
    for value, opacity, color in POINTS:
        colors.AddRGBPoint(value, *color)
        opacities.AddPoint(value, opacity)
    actor = vtkVolume()
    actor.SetMapper(draws)
    look = actor.GetProperty()
    look.SetColor(colors)
    look.SetScalarOpacity(opacities)
    look.SetInterpolationTypeToLinear()
    look.ShadeOn()
    renderer, window = vtkRenderer(), vtkRenderWindow()
    renderer.AddVolume(actor)
    window.SetOffScreenRendering(1)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    for azimuth in AZIMUTHS:
        eye, target = camera_of(edge, azimuth)
        camera = renderer.GetActiveCamera()
        camera.SetPosition(*eye)
        camera.SetFocalPoint(*target)
        camera.SetViewUp(0, 0, 1)
        camera.SetViewAngle(FOV)
        renderer.ResetCameraClippingRange()
        window.Render()
        grabber = vtkWindowToImageFilter()
        grabber.SetInput(window)
        grabber.ReadFrontBufferOff()
        grabber.Update()
        pixels = vtk_to_numpy(grabber.GetOutput().GetPointData().GetScalars()).reshape(size, size, 3)[::-1]
        yield numpy.dstack([pixels, numpy.full((size, size), 255, "uint8")])


WAYS = {
    "Kiln, its defaults": lambda array, size: draw_kiln(array, size, {}),
    "Kiln, steps of a voxel, 1 sample": lambda array, size: draw_kiln(array, size, {"sample_distance": 1, "samples": 1}),
    "VTK, smart mapper (add_volume)": lambda array, size: draw_vtk(array, size, "smart"),
    "VTK, ray caster on the processor": lambda array, size: draw_vtk(array, size, "rays"),
}


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def peak_bytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def measure(name, edge, size, out):
    array = array_of(edge)
    before, begin, worked = peak_bytes(), time.perf_counter(), processor_seconds()
    seconds, processor = [], []
    for i, pixels in enumerate(WAYS[name](array, size)):
        seconds.append(time.perf_counter() - begin)
        processor.append(processor_seconds() - worked)
        if out:
            header = f"P6 {size} {size} 255\n".encode()
            with open(f"{out}/{list(WAYS).index(name)}_{i}.ppm", "wb") as file:
                file.write(header + numpy.ascontiguousarray(pixels[..., :3]).tobytes())
        begin, worked = time.perf_counter(), processor_seconds()
    print(json.dumps({"seconds": seconds, "processor": processor, "beyond_bytes": peak_bytes() - before, "array_bytes": array.nbytes}))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--edge", type=int, default=512)
    parser.add_argument("--size", type=int, default=1024)
    parser.add_argument("--out", default="")
    parser.add_argument("--way")
    a = parser.parse_args()
    if a.way:
        return measure(a.way, a.edge, a.size, a.out)
    if a.out:
        os.makedirs(a.out, exist_ok=True)
    print(f"{a.edge}^3 uint16 to {a.size} x {a.size} pixels")
    print("| | first picture (processor) | next picture (processor) | memory beyond the array |\n| --- | --- | --- | --- |")
    for name in WAYS:
        arguments = ["--edge", str(a.edge), "--size", str(a.size), "--out", a.out, "--way", name]
        done = subprocess.run([sys.executable, __file__, *arguments], capture_output=True, text=True)
        if done.returncode != 0:
            print(f"| {name} | failed ({done.returncode}): {done.stderr.strip()[-200:]} | | |")
            continue
        found = json.loads(done.stdout.splitlines()[-1])
        cells = [f"{wall:.2f} s ({work:.2f} s)" for wall, work in zip(found["seconds"], found["processor"])]
        print(f"| {name} | {' | '.join(cells)} | {found['beyond_bytes'] / 2**20:.0f} MiB |", flush=True)


if __name__ == "__main__":
    main()
