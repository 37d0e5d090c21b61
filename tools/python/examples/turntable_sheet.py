# %% [markdown]
# # A turntable of 60 frames on one contact sheet
# Bricks stay in memory from frame to frame.

# %%
import struct
import time
import zlib

import numpy
import kiln

z, y, x = numpy.indices((64, 64, 64), dtype="float32") - 32
ring = 40 - numpy.hypot(numpy.hypot(y, z) - 20, x) * 5
ball = 40 - numpy.sqrt((x - 20) ** 2 + y * y + z * z) * 4
volume = kiln.open(numpy.maximum(ring, ball))

# %% Frames are drawn as they are iterated.
begin = time.perf_counter()
frames = [image.srgb8() for image in volume.frames(turntable=60, tf="iso:10", elevation=20, size=(96, 96), background="white")]
print(f"{len(frames)} frames in {time.perf_counter() - begin:.1f} s")

# %% Six rows of ten.
sheet = numpy.concatenate([numpy.concatenate(frames[i : i + 10], axis=1) for i in range(0, 60, 10)])
print(sheet.shape, sheet.dtype)


# %% A PNG without further packages.
def write_png(path, pixels):
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def part(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)))
        file.write(part(b"IDAT", zlib.compress(rows, 3)) + part(b"IEND", b""))


write_png("sheet.png", sheet)
