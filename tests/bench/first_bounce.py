#!/usr/bin/env python3
"""What relight --first-bounce operator costs in error beside live, by the number of rays.

    tests/bench/first_bounce.py BIN_DIR [--scene NAME] [--rays N]... [--points N] [--seeds N]

Bakes a scene (room_a) with 64, 128, 512 and 2048 rays, sites graded for its lights and --save-transport, lights it with
each --first-bounce, and prints the root mean square error of the indirect irradiance at N points (1500), relative to
its rms, over several seeds (2). Points and reference are those of scenes.py.
"""
import argparse
import math
import pathlib
import subprocess
import tempfile

from scenes import DATA, GATHERED, SCENES, irradiance, squares, table_of, write_points


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, help="folder of bake_radiosity and relight")
    parser.add_argument("--scene", choices=sorted(SCENES), default="room_a")
    parser.add_argument("--rays", type=int, action="append")
    parser.add_argument("--points", type=int, default=1500)
    parser.add_argument("--seeds", type=int, default=2)
    arguments = parser.parse_args()
    scene = DATA / SCENES[arguments.scene]
    print("| rays | live, % | operator, % |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        write_points(scene, arguments.points, folder / "points.txt")
        exact, _ = irradiance(arguments.bin / "bake_radiosity", scene, GATHERED.split(), folder)
        at = ["--at", folder / "points.txt", "--at-output", folder / "points.csv", "--quiet", "--error-points", 0]
        for rays in arguments.rays or [64, 128, 512, 2048]:
            error = {"live": 0.0, "operator": 0.0}
            for seed in range(1, arguments.seeds + 1):
                bake = [arguments.bin / "bake_radiosity", scene, folder / "out.vtp", "--rays", rays, "--seed", seed,
                        "--adaptive", "--error-points", 0, "--quiet", "--save-transport", folder / "saved.difusa"]
                subprocess.run([*map(str, bake)], check=True)
                for bounce in error:
                    light = [arguments.bin / "relight", folder / "saved.difusa", folder / "lit.vtp", "--first-bounce",
                             bounce, *at]
                    subprocess.run([*map(str, light)], check=True)
                    found = table_of(folder, "irradiance_indirect")
                    error[bounce] += squares([[x - y for x, y in zip(a, b)] for a, b in zip(found, exact)])
            relative = [100 * math.sqrt(error[b] / arguments.seeds / squares(exact)) for b in ("live", "operator")]
            print(f"| {rays} | {relative[0]:.1f} | {relative[1]:.1f} |", flush=True)


if __name__ == "__main__":
    main()
