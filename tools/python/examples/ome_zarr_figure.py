# %% [markdown]
# # An OME-Zarr as a figure with a scale bar
# The example makes a small image of two channels first; a path of your own takes its place.

# %%
import json
import os

import numpy
import zarr
import kiln

rng = numpy.random.default_rng(7)
z, y, x = numpy.indices((48, 96, 96))
cells = numpy.zeros((2, 48, 96, 96), "uint16")
for cz, cy, cx, r in zip(rng.uniform(10, 38, 25), rng.uniform(12, 84, 25), rng.uniform(12, 84, 25), rng.uniform(4, 9, 25)):
    inside = numpy.exp(-((((z - cz) * 2) ** 2 + (y - cy) ** 2 + (x - cx) ** 2) / r**2))
    cells[0] += (900 * inside).astype("uint16")
    cells[1] += (2400 * inside**6).astype("uint16")
group = zarr.open_group("cells.ome.zarr", mode="w")
group.create_dataset("0", data=cells, chunks=(1, 24, 48, 48))
axes = [{"name": "c", "type": "channel"}] + [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"]
scale = [{"type": "scale", "scale": [1, 0.5, 0.25, 0.25]}]
group.attrs["multiscales"] = [{"version": "0.4", "axes": axes, "datasets": [{"path": "0", "coordinateTransformations": scale}]}]

# %% Each channel becomes a store beside the file, once; later runs open the stores.
membranes = kiln.convert("cells.ome.zarr", "membranes.kiln", channel=0, overwrite=True)
nuclei = kiln.convert("cells.ome.zarr", "nuclei.kiln", channel=1, overwrite=True)
print(membranes, membranes.spacing, membranes.unit)

# %% Both channels in one picture, with a bar of a round length.
image = membranes.render(
    tf=kiln.transfer_function([(200, 0), (900, 0.04, "cyan")]),
    add=nuclei,
    add_tf=kiln.transfer_function([(600, 0), (1200, 0.6, "magenta")]),
    azimuth=25,
    elevation=30,
    projection="orthographic",
    size=(640, 480),
    background="black",
    scale_bar=True,
)
image.save("figure.png")
image
