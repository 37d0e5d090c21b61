"""OpenVDB's vdb_render over the views of scene.py. It knows no transfer function, so it is compared on a fog whose light
is its density: no absorption, light that reaches everywhere, cubic voxels."""

import re
import subprocess

import pictures

EXTINCTION = 1e-4  # of a voxel value of 1, per mm


def fog(voxel_limit):
    """Points of the transfer function that is this fog."""
    values = [voxel_limit * i / 64 for i in range(65)]
    return [(v, 1 - 2.718281828459045 ** (-EXTINCTION * v), (1.0, 1.0, 1.0)) for v in values]


def _three(numbers):
    return ",".join(f"{n:.9g}" for n in numbers)


class Renderer:
    def __init__(self, grid, size, threads, folder):
        self._grid, self._size, self._threads, self._folder = grid, size, threads, folder

    def draw(self, views):
        """Seconds of rays of each view, as the program says, and the middle picture."""
        seconds, picture = [], self._folder / "vdb.png"
        for i, view in enumerate(views):
            lens = ["-camera", "persp", "-fov", f"{view.fov_deg:.9g}"]
            if view.projection == "orthographic":
                lens = ["-camera", "ortho", "-frame", f"{view.height:.9g}"]
            target = self._folder / ("vdb.png" if i == len(views) // 2 else "vdb_other.png")
            said = subprocess.run(
                ["vdb_render", self._grid, target, "-v", "-res", f"{self._size}x{self._size}", *lens,
                 "-translate", _three(view.eye), "-lookat", _three(view.target), "-up", _three(view.up),
                 "-absorb", "0,0,0", "-scatter", _three([EXTINCTION] * 3), "-light", "0,0,1,1,1,1",
                 "-shadowstep", "1e6", "-cutoff", "0.001", "-cpus", str(self._threads)],
                check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
            seconds.append(self._seconds(said))
        return seconds, pictures.read_png(picture, linear=True)

    @staticmethod
    def _seconds(said):
        found = re.search(r"ray-tracing.*?completed in ([0-9.e+-]+) (ms|milliseconds|sec)", said, re.S)
        if not found:
            raise RuntimeError(f"vdb_render says no time: {said}")
        return float(found[1]) * (1e-3 if found[2].startswith("m") else 1)
