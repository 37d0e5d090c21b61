"""Kiln and other renderers of Debian on the same volumes, cameras and transfer functions, in turn and in one run: medians
of seven warm frames from slightly different views, ratios, and pictures side by side. Called by scripts/bench_peers.sh."""

import argparse
import functools
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np

import pictures
import scene
import vdb_frames
import volpack_frames
import vtk_frames

# Pictures that show the same thing: of the pixels where either shows something, this part shows something in both; as
# bright, within this ratio; and no farther apart than this. Another kind of interpolation and of edges leaves 20 to 30 dB.
LEAST_COVERAGE = 0.9
BRIGHTNESS = (0.9, 1.1)
LEAST_PSNR = 20.0


class Kiln:
    def __init__(self, program, folder, threads):
        self._program, self._folder, self._threads = program, folder, threads

    def convert(self, volume):
        store = self._folder / "volume.kiln"
        volume.write_nrrd(self._folder / "volume.nrrd")
        self._run("convert", self._folder / "volume.nrrd", store, "--overwrite")
        return store

    def export(self, store):
        grid = self._folder / "volume.vdb"
        self._run("export", store, grid, "--overwrite")
        return grid

    def draw(self, store, volume, points, projection, shaded=True, **more):
        """Seconds of a warm frame of each of the seven views, and the middle one's picture.

        Each is a still picture of its own. The second picture in a process is still drawn into memory that is new to
        it; from the third on, it is what a picture before had."""
        stats, picture = self._folder / "stats.json", self._folder / "kiln.png"
        seconds, middle = [], None
        for number, view in enumerate(scene.views(volume, projection)):
            job = self._job(store, volume, points, [view], shaded, picture, more)
            self._run("render", job, "--repeat", "3", "--stats", stats)
            seconds.append(json.loads(stats.read_text())["frames"][2]["wall_s"])
            if number == scene.FRAMES // 2:
                middle = pictures.read_png(picture)
        return seconds, middle

    def draw_sequence(self, store, volume, points, projection, **more):
        """Seconds of the seven views as frames of one job, whose camera moves; a frame before them makes them warm."""
        stats, views = self._folder / "stats.json", scene.views(volume, projection)
        job = self._job(store, volume, points, [views[0]] + views, True, self._folder / "kiln_#.png", more)
        self._run("render", job, "--stats", stats)
        return [frame["wall_s"] for frame in json.loads(stats.read_text())["frames"]][1:]

    def _job(self, store, volume, points, cameras, shaded, output, more):
        job = self._folder / "job.json"
        more.setdefault("threads", self._threads)
        job.write_text(scene.kiln_job(store, volume, points, cameras, volume.edge_px, shaded, output, more))
        return job

    def _run(self, *arguments):
        done = subprocess.run([self._program, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"bench_peers: kiln {arguments[0]} failed: {done.stderr}")


class Report:
    def __init__(self, folder):
        self._folder, self._refused, self._sheets = folder, 0, {}
        print(f"{'volume':10} {'view':6} {'shows':6} {'Kiln':>20} {'peer':>24} {'Kiln/peer':>10}  likeness", flush=True)

    def compare(self, volume, projection, name, ours, theirs, labels):
        """`ours` and `theirs` are (seconds, picture), labels what they are."""
        likeness = pictures.Likeness(ours[1], theirs[1])
        key = f"{volume.name}_{projection}_{labels[1].split(',')[0].replace(' ', '_')}".replace(" ", "_")
        self._sheets.setdefault(key, []).append([ours[1], theirs[1], np.abs(ours[1] - theirs[1])])
        a, b = statistics.median(ours[0]), statistics.median(theirs[0])
        fault = self._fault(likeness)
        ratio = f"{a / b:10.2f}" if fault is None else "   refused"
        print(f"{volume.name[:10]:10} {projection[:5]:6} {name:6} {labels[0]:>12} {1e3 * a:6.1f}ms {labels[1]:>15} "
              f"{1e3 * b:6.1f}ms {ratio}  {likeness.psnr:.1f} dB, brightness {likeness.brightness:.3f}, coverage "
              f"{likeness.coverage:.3f}" + (f": {fault}" if fault else ""), flush=True)
        self._refused += fault is not None

    @staticmethod
    def quality(held, truth):
        """How far pictures are from rays in fine steps, when each is made as bright as they are."""
        told = ", ".join(f"{who} {pictures.Likeness(picture, truth).psnr_even:.1f}" for who, picture in held.items())
        print(f"{'':25} dB from VTK in steps of a fifth of a voxel: {told}", flush=True)

    @staticmethod
    def _fault(likeness):
        if likeness.shown == 0:
            return "neither shows anything"
        if likeness.coverage < LEAST_COVERAGE:
            return f"they cover other pixels (bound {LEAST_COVERAGE})"
        if not BRIGHTNESS[0] <= likeness.brightness <= BRIGHTNESS[1]:
            return f"one is brighter (bounds {BRIGHTNESS[0]} to {BRIGHTNESS[1]})"
        if likeness.psnr < LEAST_PSNR:
            return f"they are too far apart (bound {LEAST_PSNR:.0f} dB)"
        return None

    def finish(self):
        for key, rows in self._sheets.items():
            pictures.write_png(self._folder / f"{key}.png", pictures.sheet(rows))
        print(f"sheets of Kiln, the peer and their difference are in {self._folder}; {self._refused} comparisons refused")
        return 1 if self._refused else 0


def _fog():
    """Lumps of cubic voxels, for vdb_render."""
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, 128, dtype=np.float32)] * 3, indexing="ij")
    lumps = 0.6 + 0.4 * np.sin(9 * x) * np.sin(8 * y) * np.sin(7 * z)
    return scene.Volume("fog", 1000 * np.clip(1.2 - 1.6 * np.sqrt(x * x + y * y + z * z), 0, 1) * lumps, 0, 0, 512, (0, 0, 1))


def _bench_scan(volume, kiln, arguments, report, folder):
    store = kiln.convert(volume)
    vtk = vtk_frames.Renderer(volume, volume.edge_px, arguments.threads)
    volpack = volpack_frames.Renderer(volume, volume.edge_px, arguments.volpack, folder)
    for projection in ("orthographic", "perspective"):
        views = scene.views(volume, projection)
        for name, points in volume.functions().items():
            # A pixel takes no more light where VTK's takes none. VolPack is told Kiln's own threshold.
            draw = functools.partial(kiln.draw, store, volume, points, projection)
            draw_as_vtk = functools.partial(draw, visibility={"threshold": vtk_frames.OPAQUE_AT})
            ours = draw_as_vtk()
            as_far = draw_as_vtk(sampleDistance=1.0)  # in steps of a voxel, as VTK's
            two = draw_as_vtk(samples=2)
            turning = kiln.draw_sequence(store, volume, points, projection,
                                         visibility={"threshold": vtk_frames.OPAQUE_AT})
            seconds, first, picture = vtk.draw(views, points, True)
            report.compare(volume, projection, name, ours, (seconds, picture), ("pixel", "VTK"))
            report.compare(volume, projection, name, as_far, (seconds, picture), ("pixel, step 1", "VTK"))
            report.compare(volume, projection, name, two, (seconds, picture), ("pixel, 2", "VTK"))
            report.compare(volume, projection, name, (turning, ours[1]), (seconds, picture), ("pixel, turning", "VTK"))
            truth = vtk.truth(views[len(views) // 2], points)
            held = {"Kiln, pixel": ours[1], "Kiln, pixel, step 1": as_far[1], "Kiln, pixel, 2": two[1],
                    "VTK": picture}
            if projection != "orthographic":
                report.quality(held, truth)
                continue
            seconds, classify, normals, picture = volpack.draw(views, points)
            voxel = draw(lattice="voxel", threads=1)
            report.compare(volume, projection, name, voxel, (seconds, picture), ("voxel, 1 thr", "VolPack, 1 thr"))
            # VolPack knows no threads; whoever has more of them has them for Kiln.
            report.compare(volume, projection, name, draw(lattice="voxel"), (seconds, picture),
                           (f"voxel, {arguments.threads} thr", "VolPack, 1 thr"))
            report.quality({**held, "Kiln, voxel": voxel[1], "VolPack": picture}, truth)
            print(f"{'':25} VolPack classifies in {1e3 * classify:.0f} ms, makes normals in {1e3 * normals:.0f} ms; VTK's "
                  f"first frame {1e3 * first:.0f} ms")
    _bench_change(volume, kiln, store)


def _bench_change(volume, kiln, store):
    """A function that is another in each frame, against the one it is in the middle of them."""
    functions = volume.functions()
    low, high = functions["skin"], [(v + 8, o, c) for v, o, c in functions["skin"]]
    middle = [(v + 4, o, c) for v, o, c in low]
    as_job = lambda points: {"unit": 1.0, "colorSpace": "linear",
                             "points": [{"value": v, "opacity": o, "color": list(c)} for v, o, c in points]}
    keys = {"keyframes": [{"frame": 1, "function": as_job(low)}, {"frame": scene.FRAMES + 1, "function": as_job(high)}]}
    still = statistics.median(kiln.draw_sequence(store, volume, middle, "orthographic"))
    changing = statistics.median(kiln.draw_sequence(store, volume, middle, "orthographic", transferFunction=keys))
    print(f"{volume.name}: another transfer function in each frame, Kiln {1e3 * changing:.1f} ms; one for all "
          f"{1e3 * still:.1f} ms", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--kiln", required=True)
    parser.add_argument("--volpack", required=True, help="the program of volpack_frames.c")
    parser.add_argument("--data", required=True, help="folder of the scans")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--quick", action="store_true", help="the smaller scan only")
    arguments = parser.parse_args()
    # A job names its files from its own folder.
    arguments.out = arguments.out.resolve()
    work = arguments.out / "work"
    work.mkdir(parents=True, exist_ok=True)
    print(f"{arguments.threads} threads; {scene.FRAMES} frames {scene.TURN_DEG} degrees apart after a first, medians")
    kiln, report = Kiln(arguments.kiln, work, arguments.threads), Report(arguments.out)
    for volume in scene.volumes(arguments.data, arguments.quick):
        _bench_scan(volume, kiln, arguments, report, work)
    fog = _fog()
    store = kiln.convert(fog)
    vdb = vdb_frames.Renderer(kiln.export(store), fog.edge_px, arguments.threads, work)
    for projection in ("orthographic", "perspective"):
        ours = kiln.draw(store, fog, vdb_frames.fog(1000), projection, shaded=False)
        report.compare(fog, projection, "fog", ours, vdb.draw(scene.views(fog, projection)), ("pixel", "vdb_render"))
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
