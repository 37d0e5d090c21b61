#!/usr/bin/env python3
"""Makes the volumes of the manual's page of pictures that no package has: pictures_data.py TEMPLATES FOLDER.

TEMPLATES is the folder of mricron-data's brain templates. FOLDER receives NRRD files: four channels of cells, a cloud,
a brain's uptake in the manner of a PET; and names of the atlas' regions in ITK-SNAP's format. All are computed, with
fixed seeds, so that each run writes equal bytes.
"""

import gzip
import pathlib
import sys

import numpy


def write_nrrd(path, voxels, spacing, origin, unit, space):
    """Writes voxels[z, y, x]; spacing and origin are along x, y, z, in `unit`."""
    size = " ".join(str(n) for n in reversed(voxels.shape))
    directions = " ".join(
        "(" + ",".join(str(spacing[a]) if a == b else "0" for b in range(3)) + ")" for a in range(3)
    )
    names = {"uint8": "uint8", "uint16": "uint16", "float32": "float"}
    header = (
        f"NRRD0005\ntype: {names[voxels.dtype.name]}\ndimension: 3\nsizes: {size}\nencoding: raw\nendian: little\n"
        f"{space}\nspace directions: {directions}\nspace origin: ({','.join(map(str, origin))})\n"
        f'space units: "{unit}" "{unit}" "{unit}"\n\n'
    )
    path.write_bytes(header.encode() + voxels.tobytes())


def frequencies(shape):
    """Returns the length of each frequency of rfftn, in cycles per voxel."""
    z, y = (numpy.fft.fftfreq(n) for n in shape[:2])
    x = numpy.fft.rfftfreq(shape[2])
    return numpy.sqrt(z[:, None, None] ** 2 + y[None, :, None] ** 2 + x[None, None, :] ** 2)


def blurred(values, sigma):
    """Convolves with a Gauss function of `sigma` voxels; the volume is periodic."""
    weight = numpy.exp(-2 * (numpy.pi * sigma * frequencies(values.shape)) ** 2)
    return numpy.fft.irfftn(numpy.fft.rfftn(values) * weight, s=values.shape)


def fractal(random, shape, exponent):
    """Returns noise with a spectrum that falls by a power of the frequency; mean 0, standard deviation 1."""
    frequency = frequencies(shape)
    frequency[0, 0, 0] = 1
    noise = numpy.fft.irfftn(numpy.fft.rfftn(random.standard_normal(shape)) * frequency**-exponent, s=shape)
    return (noise - noise.mean()) / noise.std()


def grid(shape):
    return numpy.meshgrid(*(numpy.arange(n, dtype=numpy.float32) for n in shape), indexing="ij", copy=False)


def spread_points(random, count, shape, distance):
    """Returns points at least `distance` apart, away from the volume's faces."""
    points = []
    while len(points) < count:
        point = numpy.array([random.uniform(0.3 * n, 0.7 * n) if n < 100 else random.uniform(22, n - 22) for n in shape])
        if all(numpy.linalg.norm(point - other) >= distance for other in points):
            points.append(point)
    return points


def make_cells(folder):
    """Cells of a culture under a microscope: nuclei, membranes, filaments and vesicles, 0.25 micrometres a voxel."""
    shape = (72, 224, 288)
    random = numpy.random.default_rng(3)
    centres = spread_points(random, 17, shape, 42)
    z, y, x = grid(shape)
    nearest = numpy.full(shape, 1e9, numpy.float32)
    second = nearest.copy()
    nuclei = numpy.zeros(shape, numpy.float32)
    for centre in centres:
        radius = random.uniform(12, 16)
        squeeze = random.uniform(0.8, 1.25)
        offsets = (1.3 * (z - centre[0]), (y - centre[1]) * squeeze, (x - centre[2]) / squeeze)
        distance = numpy.sqrt(sum(o * o for o in offsets))
        nuclei = numpy.maximum(nuclei, numpy.clip((radius - distance) / 2, 0, 1))
        second = numpy.minimum(second, numpy.maximum(nearest, distance))
        nearest = numpy.minimum(nearest, distance)
    height = numpy.clip((30 - numpy.abs(z - shape[0] / 2)) / 3, 0, 1)
    texture = fractal(random, shape, 1.2)
    reach = numpy.clip((46 - nearest) / 6, 0, 1)
    membranes = numpy.exp(-(((second - nearest) / 3.0) ** 2)) * reach + numpy.exp(-(((nearest - 44) / 2.5) ** 2))
    filaments = numpy.zeros(shape, numpy.float32)
    vesicles = numpy.zeros(shape, numpy.float32)
    for centre in centres:
        for _ in range(34):
            direction = random.standard_normal(3) * (0.25, 1, 1)
            direction /= numpy.linalg.norm(direction)
            place = centre + 9 * direction
            for _ in range(70):
                direction += 0.13 * random.standard_normal(3) * (0.4, 1, 1)
                direction /= numpy.linalg.norm(direction)
                place = place + 0.5 * direction
                cell = tuple(int(round(p)) for p in place)
                if all(0 <= c < n for c, n in zip(cell, shape)):
                    filaments[cell] += 1
        for _ in range(26):
            direction = random.standard_normal(3) * (0.4, 1, 1)
            cell = tuple(int(round(p)) for p in centre + direction / numpy.linalg.norm(direction) * random.uniform(15, 32))
            if all(0 <= c < n for c, n in zip(cell, shape)):
                vesicles[cell] += random.uniform(0.5, 1)
    channels = {
        "nuclei": blurred(nuclei, 1) * (0.75 + 0.16 * texture),
        "membranes": blurred(membranes * height, 0.8) * (0.8 + 0.12 * texture),
        "filaments": blurred(filaments * height, 0.9),
        "vesicles": blurred(vesicles, 1.5),
    }
    for name, values in channels.items():
        values = numpy.clip(values / numpy.quantile(values, 0.9995), 0, 1.2)
        noisy = random.poisson(120 * values + 2) * 250
        write_nrrd(folder / f"{name}.nrrd", noisy.astype(numpy.uint16), (0.25, 0.25, 0.5), (0, 0, 0), "um", "space dimension: 3")


def make_cloud(folder):
    """A cumulus: fractal noise in a pile of balls above a flat base, 10 m a voxel."""
    shape = (112, 176, 224)
    random = numpy.random.default_rng(11)
    z, y, x = grid(shape)
    inside = numpy.full(shape, -1e9, numpy.float32)
    for _ in range(26):
        along = random.uniform(-1, 1)
        centre = (
            26 + random.uniform(0, 44) * (1 - along * along),
            shape[1] / 2 + random.uniform(-26, 26),
            shape[2] / 2 + 66 * along,
        )
        radius = random.uniform(14, 27)
        distance = numpy.sqrt((z - centre[0]) ** 2 + (y - centre[1]) ** 2 + (x - centre[2]) ** 2)
        inside = numpy.maximum(inside, (radius - distance) / radius)
    noise = fractal(random, shape, 1.75)
    density = numpy.clip(2.2 * (inside + 0.21 * noise), 0, 1) * numpy.clip((z - 15 + 2 * noise) / 8, 0, 1)
    write_nrrd(folder / "cloud.nrrd", density.astype(numpy.float32), (10, 10, 10), (0, 0, 0), "m", "space dimension: 3")


def make_brain(templates, folder):
    """Uptake of sugar in a brain, as a PET of 4 mm: high in grey matter, low in one temporal lobe. Names of regions."""
    with gzip.open(templates / "aal.nii.gz") as file:
        atlas = numpy.frombuffer(file.read()[352:], numpy.uint8).reshape(181, 217, 181)
    names = [line.split()[:2] for line in (templates / "aal.nii.txt").read_text().splitlines() if line.strip()]
    random = numpy.random.default_rng(5)
    uptake = numpy.zeros(256, numpy.float32)
    for number, name in names:
        base = random.normal(6.6, 0.7)
        if name.startswith(("Occipital", "Calcarine", "Lingual", "Cuneus")):
            base += 1.6
        if name.startswith("Cerebelum"):
            base -= 1.5
        if name in ("Temporal_Mid_L", "Temporal_Inf_L", "Temporal_Sup_L", "Angular_L", "Parietal_Inf_L"):
            base -= 3.2
        uptake[int(number)] = base
    padded = numpy.pad(uptake[atlas], ((0, 3), (0, 3), (0, 3)))
    pet = blurred(padded, 3.4)
    coarse = pet.reshape(46, 4, 55, 4, 46, 4).mean((1, 3, 5)).astype(numpy.float32)
    write_nrrd(folder / "pet.nrrd", coarse, (4, 4, 4), (-88.5, -123.5, -69.5), "mm", "space: right-anterior-superior")
    # The deep nuclei, one colour for both sides of the brain.
    shown = {"Hippocampus": (224, 122, 95), "Amygdala": (242, 204, 143), "Caudate": (129, 178, 154),
             "Putamen": (61, 132, 184), "Pallidum": (150, 120, 182), "Thalamus": (214, 93, 121)}
    lines = ['0 0 0 0 0 0 0 "outside"']
    for number, name in names:
        for region, color in shown.items():
            if name.startswith(region):
                side = "left" if name.endswith("_L") else "right"
                lines.append(f'{number} {color[0]} {color[1]} {color[2]} 1 1 1 "{region}, {side}"')
    (folder / "nuclei.txt").write_text("\n".join(lines) + "\n")


def main():
    if len(sys.argv) != 3:
        sys.exit(f"pictures_data.py: expected two folders, TEMPLATES FOLDER (found {len(sys.argv) - 1} words)")
    templates, folder = (pathlib.Path(word) for word in sys.argv[1:])
    make_cells(folder)
    make_cloud(folder)
    make_brain(templates, folder)


if __name__ == "__main__":
    main()
