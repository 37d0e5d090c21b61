#!/usr/bin/env python3
"""A cloud of OpenVDB beside Cycles and vdb_render: one camera, one medium, one light, light that is scattered once.

    /usr/bin/python3 tests/bench/peers/cloud.py CLOUD.vdb --kiln build/release/tools/kiln/kiln --out out/cloud
        [--blender blender] [--vdb-render vdb_render] [--anisotropy 0] [--size 512] [--samples 128]

Needs oiiotool and tifffile (Debian: openimageio-tools, python3-tifffile), and of blender and vdb_render (libopenvdb-tools) those that are there. Prints, for
each, Kiln's mean brightness over the other's, and over the pixels where either shows something PSNR in dB (linear light,
peak 1) and the correlation of means of 4 x 4 pixels, which have less of Cycles' noise. OUT holds the pictures and a sheet."""

import argparse
import json
import math
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy
import tifffile

EXTINCTION_OF_VOXEL = 1 / 6  # of a value of 1, per edge of a voxel
FOV_DEG = 32
LIGHT = (-1, 0.8, 0.6)
PHASE_AND_SUN = 4  # Cycles' sun and phase against Kiln's (cycles_cloud.py)


def run(*command):
    begin = time.perf_counter()
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: exit code {done.returncode}\n{done.stdout[-500:]}{done.stderr[-500:]}")
    return done.stdout, time.perf_counter() - begin


def words(numbers):
    return ",".join(f"{number:.9g}" for number in numbers)


def read(path, scale=1.0):
    """Green of an EXR, rows from the top."""
    raw = path.with_suffix(".tif")
    run("oiiotool", path, "--ch", "G", "-d", "float", "--compression", "none", "-o", raw)
    pixels = scale * tifffile.imread(raw)
    raw.unlink()
    return pixels


def likeness(ours, theirs):
    shown = (ours > 0) | (theirs > 0)
    psnr = -10 * math.log10(numpy.mean((ours - theirs)[shown] ** 2))
    edge = len(ours) // 4
    a, b = (picture.reshape(edge, 4, edge, 4).mean((1, 3)) for picture in (ours, theirs))
    coarse = (a > 0) | (b > 0)
    return (f"brightness {ours[shown].mean() / theirs[shown].mean():.4f}, {psnr:.1f} dB, "
            f"correlation {numpy.corrcoef(a[coarse], b[coarse])[0, 1]:.4f}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cloud", type=Path)
    parser.add_argument("--kiln", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--blender", default="blender", help="a command, words apart")
    parser.add_argument("--vdb-render", default="vdb_render", help="likewise")
    parser.add_argument("--grid", default="density")
    parser.add_argument("--anisotropy", type=float, default=0)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--samples", type=int, default=128, help="of Cycles, a pixel")
    a = parser.parse_args()
    a.out.mkdir(parents=True, exist_ok=True)

    store = a.out / "cloud.kiln"
    run(a.kiln, "convert", a.cloud, store, "--overwrite")
    info = json.loads(run(a.kiln, "info", store, "--json")[0])
    affine = numpy.array(info["affine"], float).reshape(-1, 4)[:3]
    dims = numpy.array(info["dimensions"], float)
    voxel = numpy.linalg.norm(affine[:, :3], axis=0)
    extinction = EXTINCTION_OF_VOXEL / float(voxel.mean())
    target = affine[:, :3] @ ((dims - 1) / 2) + affine[:, 3]
    distance = 0.4 * float(numpy.linalg.norm(dims * voxel)) / math.sin(math.radians(FOV_DEG / 2))
    eye = target + distance * numpy.array([0, 0.05, 0.9987])
    scene = {"cloud": str(a.cloud.resolve()), "grid": a.grid, "voxel": voxel.tolist(), "extinction": extinction,
             "anisotropy": a.anisotropy, "light": LIGHT, "eye": eye.tolist(), "target": target.tolist(), "up": [0, 1, 0],
             "fov": FOV_DEG, "size": a.size, "samples": a.samples}
    scene_path, function_path = a.out / "scene.json", a.out / "function.json"
    scene_path.write_text(json.dumps(scene))
    top = info["range"][1]
    points = [{"value": top * i / 128, "color": "white", "opacity": 1 - math.exp(-extinction * top * i / 128)}
              for i in range(129)]
    function_path.write_text(json.dumps({"kiln": 2, "unit": 1.0, "points": points,
                                         "scattering": {"albedo": 1, "anisotropy": a.anisotropy}}))

    ours = a.out / "kiln.exr"
    _, seconds = run(a.kiln, "render", store, "-o", ours, "--size", f"{a.size}x{a.size}", "--tf", function_path,
                     f"--eye={words(eye)}", f"--target={words(target)}", "--up=0,1,0", "--fov", FOV_DEG,
                     f"--light=dir:{words(LIGHT)}", "--shadows", "--ambient", 0, "--diffuse", 1, "--specular", 0)
    print(f"Kiln: {seconds:.1f} s")
    pictures = [read(ours)]
    if shutil.which(a.blender.split()[0]):
        theirs = a.out / "cycles.exr"
        script = Path(__file__).with_name("cycles_cloud.py")
        _, seconds = run(*a.blender.split(), "-b", "-P", script.resolve(), "--", scene_path.resolve(), theirs.resolve())
        pictures.append(read(theirs, PHASE_AND_SUN))
        print(f"Cycles: {seconds:.1f} s; {likeness(pictures[0], pictures[-1])}")
    if shutil.which(a.vdb_render.split()[0]) and a.anisotropy == 0:
        theirs = a.out / "vdb_render.exr"
        per_voxel = words([EXTINCTION_OF_VOXEL] * 3)
        _, seconds = run(*a.vdb_render.split(), a.cloud.resolve(), theirs.resolve(), "-res", f"{a.size}x{a.size}", "-camera", "persp", "-fov", FOV_DEG,
                         "-translate", words(eye), "-lookat", words(target), "-up", "0,1,0", "-name", a.grid,
                         "-absorb", "0,0,0", "-scatter", per_voxel, "-light", words([*LIGHT, 1, 1, 1]),
                         "-step", 0.5, "-shadowstep", 0.5, "-cutoff", 0.001, "-gain", 0)
        pictures.append(read(theirs))
        print(f"vdb_render: {seconds:.1f} s; {likeness(pictures[0], pictures[-1])}")
    if len(pictures) == 1:
        sys.exit("neither blender nor vdb_render is here: name them by --blender and --vdb-render")
    files = [a.out / name for name in ("kiln.exr", "cycles.exr", "vdb_render.exr") if (a.out / name).exists()]
    channels = []
    for file in files:
        scale = PHASE_AND_SUN if file.name == "cycles.exr" else 1
        channels += [file, "--ch", "R,G,B", "--mulc", scale]
    run("oiiotool", *channels, "--mosaic", f"{len(files)}x1", "--colorconvert", "linear", "sRGB", "-o", a.out / "sheet.png")


if __name__ == "__main__":
    main()
