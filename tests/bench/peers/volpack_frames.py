"""VolPack over the views of scene.py, by the program volpack_frames.c: 8-bit voxels, orthographic, one thread."""

import subprocess

import numpy as np

import scene


def _classified(points):
    """A window of values, of 8 bits, and of each of them opacity and colour. It is as wide as surfaces are steep, because
    VolPack takes normals of what is left of the values."""
    low, high = max(points[0][0] - 500, 0), points[-1][0] + 1000
    values = np.linspace(low, high, 256)
    at = [p[0] for p in points]
    opacity = np.interp(values, at, [p[1] for p in points])
    color = [np.interp(values, at, [p[2][c] for p in points]) for c in range(3)]
    return low, high, np.column_stack([opacity] + color)


class Renderer:
    def __init__(self, volume, size, program, folder):
        self._volume, self._size, self._program, self._folder = volume, size, program, folder

    def draw(self, views, points):
        """Seconds of each view after a first, of classifying, of making normals, and the middle picture, first row on
        top."""
        low, high, table = _classified(points)
        voxels = np.clip((self._volume.voxels.astype(np.float32) - low) * (255 / (high - low)) + 0.5, 0, 255)
        (self._folder / "voxels.u8").write_bytes(voxels.astype(np.uint8).tobytes())
        # The first view twice before: the middle one of what the program draws is then that of `views`.
        drawn = [views[0]] + list(views) + [views[-1]]
        numbers = [*self._volume.dims, self._size, views[0].height, scene.SHADING["ambient"], scene.SHADING["diffuse"],
                   len(drawn), *table.ravel()]
        for view in drawn:
            numbers += [*view.right, *view.up, *view.back]
        picture = self._folder / "volpack.rgb"
        out = subprocess.run([self._program, self._folder / "voxels.u8", picture], check=True, text=True,
                             input="\n".join(f"{n:.9g}" for n in numbers), stdout=subprocess.PIPE).stdout
        said = [line.split() for line in out.splitlines()]
        of = lambda key: [float(value) for name, value in said if name == key]
        pixels = np.frombuffer(picture.read_bytes(), np.uint8).reshape(self._size, self._size, 3)
        return of("frame")[1:-1], of("classify")[0], of("normals")[0], pixels[::-1].astype(np.float64) / 255
