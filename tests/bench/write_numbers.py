"""Measured figures: numbers.json holds them with command, machine and commit, NUMBERS.md shows them as tables.

  write_numbers.py                                      writes NUMBERS.md from numbers.json
  write_numbers.py --check                              exit code 1 if NUMBERS.md is not what numbers.json gives
  write_numbers.py --kiln PROGRAM --data DIR [ID ...]   measures rows, all with a recipe below if none is named, stores
                                                  them with this machine and commit, and writes NUMBERS.md

DIR has the scans named in SCANS. Rows without a recipe come from the program in their column "command"; their values are
entered into numbers.json by hand. Times want a quiet machine; `--list` prints the rows with a recipe.
"""

import argparse
import datetime
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
JSON, MARKDOWN = HERE / "numbers.json", HERE / "NUMBERS.md"
SCANS = {"ct": "cthead_256x256x113_u16le.nrrd", "vhm": "vhm_head_512x512x245_i16le.nrrd"}

OPENING = """# Numbers

`tests/bench/write_numbers.py` writes this file from `tests/bench/numbers.json`. Each row has the machine and the commit of its
measurement. Rows of older commits were not measured again; their programs may have become faster or slower since.
Times are of release builds.
"""


def load():
    return json.loads(JSON.read_text(encoding="utf-8"))


def store(numbers):
    """Writes numbers.json with one row a line, so that a new figure is a change of one line."""
    def text(value):
        return json.dumps(value, ensure_ascii=False)
    lines = ["{", f' "machines": {text(numbers["machines"])},', ' "sections": [']
    for number, section in enumerate(numbers["sections"]):
        head = {key: value for key, value in section.items() if key != "rows"}
        lines.append("  " + text(head)[:-1] + ', "rows": [')
        lines.append(",\n".join("   " + text(row) for row in section["rows"]))
        lines.append("  ]}" + ("," if number + 1 < len(numbers["sections"]) else ""))
    JSON.write_text("\n".join(lines + [" ]", "}", ""]), encoding="utf-8")


def markdown(numbers):
    letters = {key: chr(ord("A") + index) for index, key in enumerate(numbers["machines"])}
    out = [OPENING, "| machine | |", "| --- | --- |"]
    out += [f"| {letters[key]} | {text} |" for key, text in numbers["machines"].items()]
    for section in numbers["sections"]:
        out += ["", f"## {section['title']}", ""]
        if section["note"]:
            out += [section["note"], ""]
        if section["command"]:
            out += [f"Command: `{section['command']}`", ""]
        with_command = any("command" in row for row in section["rows"])
        names = ["what", *section["columns"], *(["command"] if with_command else []), "machine", "commit, date"]
        out += [f"| {' | '.join(names)} |", "|" + " --- |" * len(names)]
        for row in section["rows"]:
            cells = [row["what"], *row["values"]]
            if with_command:
                cells.append(f"`{row['command']}`" if "command" in row else "")
            cells += [letters[row["machine"]], f"{row['commit']}, {row['date']}"]
            out.append(f"| {' | '.join(cells)} |")
    return "\n".join(out) + "\n"


class Bench:
    """Runs the program in a scratch folder. Stores are made once for each volume."""

    def __init__(self, kiln, data, folder):
        self._kiln, self._data, self._folder, self._stores = str(Path(kiln).resolve()), Path(data), Path(folder), {}

    def run(self, *arguments):
        done = subprocess.run([self._kiln, *map(str, arguments)], cwd=self._folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"write_numbers.py: kiln {arguments[0]}: {done.stderr}")
        return done.stdout + done.stderr

    def store(self, volume):
        """The store of a scan or a phantom."""
        if volume not in self._stores:
            name = f"volume_{len(self._stores)}.kiln"
            self.run("convert", self._data / SCANS[volume] if volume in SCANS else volume, name)
            self._stores[volume] = name
        return self._stores[volume]

    def convert(self, volume):
        """The printed million voxels a second of a conversion."""
        text = self.run("convert", self._data / SCANS[volume], "again.kiln", "--overwrite")
        return float(re.search(r"([0-9.]+) million voxels/s", text)[1])

    def render(self, volume, *options):
        """The statistics of a picture."""
        self.run("render", self.store(volume), "-o", "picture.exr", "--stats", "stats.json", "--progress", "none", *options)
        return json.loads((self._folder / "stats.json").read_text())

    def picture(self):
        return (self._folder / "picture.exr").read_bytes()


def warm_seconds(stats):
    return statistics.median(frame["wall_s"] for frame in stats["frames"][1:])


def convert_gzip(bench):
    return [f"{max(bench.convert('vhm') for _ in range(3)):.0f} million voxels/s (best of three)"]


NEXT_FRAME = ("--tf", "ct-skin", "--samples", 1, "--repeat", 12)


def next_frame(bench):
    stats = bench.render("vhm", *NEXT_FRAME, "--size", "1024x1024")
    used = statistics.median(frame["utilisation"] for frame in stats["frames"][1:])
    return [f"{warm_seconds(stats):.3f} s, with {100 * used:.0f} % of the time of {stats['threads']} threads in use"]


def next_frame_512(bench):
    options = (*NEXT_FRAME, "--size", "512x512")
    return ["; ".join(f"{warm_seconds(bench.render('vhm', *options, *more)):.3f} s"
                      for more in ((), ("--lattice", "voxel")))]


def resident(bench, memory):
    stats = bench.render("vhm", "--tf", "ct-skin", "--samples", 1, "--repeat", 2, "--size", "1024x1024", "--memory", memory)
    return stats["memory"]["peak_rss_bytes"] / 2**20


def resident_all(bench):
    return [f"{resident(bench, '2G'):.0f} MiB"]


def resident_32(bench):
    resident(bench, "2G")
    picture = bench.picture()
    small = resident(bench, "32M")
    if bench.picture() != picture:
        sys.exit("write_numbers.py: resident-32: the pictures differ")
    return [f"{small:.0f} MiB"]


def work_left(bench, volume, size):
    """Visited and drawn voxels with the mask in per cent of those without a test: ranges over three views."""
    cells = []
    for projection in (("orthographic",), ("perspective", "--fov", 60)):
        visited, drawn = [], []
        for azimuth in (-20, 0, 20):
            counts = []
            for method in ("mask", "none"):
                stats = bench.render(volume, "--tf", "ct-skin", "--lattice", "voxel", "--level", 0, "--samples", 1,
                                     "--size", size, "--projection", *projection, "--azimuth", azimuth,
                                     "--opacity-threshold", 0.95, "--visibility", method)
                counts.append(stats["voxels"])
            visited.append(100 * counts[0]["visited"] / counts[1]["visited"])
            drawn.append(100 * counts[0]["splats"] / counts[1]["splats"])
        cells.append(f"{min(visited):.1f}–{max(visited):.1f} %, {min(drawn):.1f}–{max(drawn):.1f} %")
    return cells


def footprints(bench, projection):
    rates = []
    for edge in (170, 256, 400, 512):
        stats = bench.render("phantom:head:256x256x256", "--tf", "ct-skin", "--size", f"{edge}x{edge}", "--lattice", "voxel",
                             "--level", 0, "--visibility", "none", "--projection", projection, "--threads", 1,
                             "--repeat", 10)
        rates.append(stats["frames"][1]["voxels"]["splats"] / warm_seconds(stats) / 1e6)
    return [f"{rates[0]:.0f}, {rates[1]:.0f}, {rates[2]:.0f} and {rates[3]:.0f} million"]


RECIPES = {
    "convert-gzip": convert_gzip,
    "next-frame": next_frame,
    "next-frame-512": next_frame_512,
    "resident-all": resident_all,
    "resident-32": resident_32,
    "work-ct": lambda bench: work_left(bench, "ct", "512x512"),
    "work-vhm": lambda bench: work_left(bench, "vhm", "512x512"),
    "footprints-orthographic": lambda bench: footprints(bench, "orthographic"),
    "footprints-perspective": lambda bench: footprints(bench, "perspective"),
}


def this_machine(numbers):
    """The key of this machine, which is entered if it is new."""
    flags = Path("/proc/cpuinfo").read_text()
    instructions = "avx512" if "avx512f" in flags else "avx2" if "avx2" in flags else "x86-64"
    cores = os.cpu_count()
    key = instructions if cores == 2 else f"{instructions}-{cores}"
    numbers["machines"].setdefault(key, f"{cores}-core machine with {instructions}")
    return key


def measure(numbers, arguments):
    rows = {row["id"]: row for section in numbers["sections"] for row in section["rows"]}
    commit = subprocess.run(["git", "-C", HERE, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True)
    machine = this_machine(numbers)
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(arguments.kiln, arguments.data, folder)
        for name in arguments.rows or RECIPES:
            if name not in RECIPES:
                sys.exit(f"write_numbers.py: {name}: no recipe; --list prints the rows with a recipe")
            values = RECIPES[name](bench)
            print(f"{name}: {' | '.join(values)} (was {' | '.join(rows[name]['values'])})", flush=True)
            rows[name].update(values=values, machine=machine, commit=commit.stdout.strip(),
                              date=datetime.date.today().isoformat())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kiln", help="the program to measure")
    parser.add_argument("--data", default=HERE.parents[2] / "shared/data", help="folder of the scans")
    parser.add_argument("--check", action="store_true", help="compare NUMBERS.md with numbers.json and write nothing")
    parser.add_argument("--list", action="store_true", help="print the rows with a recipe")
    parser.add_argument("rows", nargs="*", metavar="ID", help="rows to measure")
    arguments = parser.parse_args()
    if arguments.list:
        return print("\n".join(RECIPES))
    if arguments.rows and not arguments.kiln:
        parser.error("--kiln is required for a measurement")
    numbers = load()
    if arguments.check:
        if MARKDOWN.read_text(encoding="utf-8") != markdown(numbers):
            sys.exit(f"{MARKDOWN}: does not follow numbers.json; run {Path(__file__).name}")
        return None
    if arguments.kiln:
        measure(numbers, arguments)
        store(numbers)
    MARKDOWN.write_text(markdown(numbers), encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
