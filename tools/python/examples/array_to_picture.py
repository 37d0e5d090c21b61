# %% [markdown]
# # NumPy in, picture out
# An array is drawn in place: no file is written but the picture.

# %%
import numpy
import kiln

z, y, x = numpy.mgrid[-1:1:80j, -1:1:96j, -1:1:112j].astype("float32")
radius = numpy.sqrt(x * x + y * y + z * z)
density = numpy.exp(-3 * radius) * (1 + 0.6 * numpy.sin(9 * x) * numpy.sin(9 * y) * numpy.sin(9 * z))

# %% Spacings are along z, y, x, as the axes of the array.
volume = kiln.open(density, spacing=(0.2, 0.2, 0.2), unit="mm")
print(volume, volume.range)

# %% Points of the transfer function: value, opacity, colour.
look = kiln.transfer_function([(0.15, 0), (0.3, 0.02, "steelblue"), (0.5, 0.3, "orange"), (0.8, 0.9, "white")])
image = volume.render(tf=look, azimuth=30, elevation=20, size=(480, 360), background="black", aov=["depth"])
image  # a notebook shows the picture

# %% Pixels are an array, without a copy: linear light, premultiplied.
pixels = numpy.asarray(image)
seen = numpy.isfinite(image.depth)
print(pixels.shape, pixels.dtype, f"{seen.mean():.0%} of the picture is seen, from {image.depth[seen].min():.1f} mm on")
image.save("array.png")
