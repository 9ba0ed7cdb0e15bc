#!/usr/bin/env python3
"""What an accuracy ordered with --error costs, beside the cheapest fixed settings that reach the same error.

    tests/bench/ordered_error.py BIN_DIR [--scene NAME]... [--error P]... [--seeds N] [--points N] [--longest S]

For each scene (all of scenes.py by default) and each P (5, 2 and 1 %) it bakes with --error P and several seeds, and
prints how often the true error was above P, its root mean square, and the mean processor time. Then it bakes twice with
evenly spaced sites, 1000, 2000, 4000, ... of them with 128, 256, 512 and 1024 rays each, until one of these settings is
as accurate as the bakes with the smallest P, or its bakes take longer than another one's that is, or than S seconds of
processor time (60). It prints the cheapest settings whose error is no larger than that of the bakes with --error, and
the ratio of the times. All bakes estimate their error. Errors are those of the radiosity
at N points (3000) drawn uniformly by area on faces that do not emit, relative to its rms there; the reference is that
of scenes.py.
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

from scenes import DATA, GATHERED, SCENES, irradiance, processor_time, squares, table_of, write_points

RAYS = (128, 256, 512, 1024)


class Bakes:
    """Bakes of one scene with any options, judged at its points."""

    def __init__(self, program, scene, points, folder):
        self.program, self.scene, self.folder = program, scene, folder
        write_points(scene, points, folder / "points.txt")
        irradiance(program, scene, GATHERED.split(), folder)
        self.exact = table_of(folder, "radiosity")

    def error_and_time(self, options, seed):
        command = [self.program, self.scene, self.folder / "out.vtp", "--at", self.folder / "points.txt", "--at-output",
                   self.folder / "points.csv", "--quiet", "--output-spacing", "1000", "--seed", seed, *options]
        began = processor_time()
        subprocess.run([*map(str, command)], check=True)
        took = processor_time() - began
        found = table_of(self.folder, "radiosity")
        error = squares([[x - y for x, y in zip(a, b)] for a, b in zip(found, self.exact)]) / squares(self.exact)
        return math.sqrt(error), took

    def over_seeds(self, options, seeds):
        """Errors, and the mean processor time."""
        all_of_them = [self.error_and_time(options, seed) for seed in range(1, seeds + 1)]
        return [error for error, _ in all_of_them], sum(took for _, took in all_of_them) / seeds


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def fixed_settings(bakes, smallest, seeds, longest):
    """(error, seconds, options) of evenly spaced sites, among them the cheapest whose error is at most the smallest."""
    found = []
    for rays in RAYS:
        sites, took, error = 1000, 0.0, math.inf
        while took < longest / 2 and error > smallest:
            options = ["--no-adaptive", "--sites", str(sites), "--rays", str(rays)]
            errors, took = bakes.over_seeds(options, seeds)
            error = rms(errors)
            found.append((error, took, " ".join(options)))
            if error <= smallest:
                longest = min(longest, 2 * took)
            sites *= 2
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, help="folder of bake_radiosity")
    parser.add_argument("--scene", action="append", choices=sorted(SCENES), default=[])
    parser.add_argument("--error", action="append", type=float, default=[], help="per cent")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--points", type=int, default=3000)
    parser.add_argument("--longest", type=float, default=60.0)
    arguments = parser.parse_args()
    print("| scene | ordered | bakes | above | true error, rms | time, s | fixed settings | their error | time, s | ratio |\n"
          "|---|---|---|---|---|---|---|---|---|---|")
    for name in arguments.scene or sorted(SCENES):
        with tempfile.TemporaryDirectory() as temporary:
            bakes = Bakes(arguments.bin / "bake_radiosity", DATA / SCENES[name], arguments.points,
                          pathlib.Path(temporary))
            ordered = [(percent, *bakes.over_seeds(["--error", f"{percent}%"], arguments.seeds))
                       for percent in arguments.error or [5.0, 2.0, 1.0]]
            fixed = fixed_settings(bakes, min(rms(errors) for _, errors, _ in ordered), min(2, arguments.seeds),
                                   arguments.longest)
            for percent, errors, took in ordered:
                above = sum(error > percent / 100 for error in errors)
                enough = [each for each in fixed if each[0] <= rms(errors)]
                other = min(enough, key=lambda each: each[1], default=None)
                row = [name, f"{percent:g} %", len(errors), above, f"{100 * rms(errors):.2f} %", f"{took:.2f}"]
                row += ["none", "", f"> {max(each[1] for each in fixed):.0f}", ""] if other is None else [
                    other[2], f"{100 * other[0]:.2f} %", f"{other[1]:.2f}", f"{other[1] / took:.1f}"]
                print("| " + " | ".join(map(str, row)) + " |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
