#!/usr/bin/env python3
"""Error against processor time of bakes of the scenes in data/ and of generated ones, for any choices of options.

    tests/bench/scenes.py BIN_DIR [--scene NAME]... [--points N] [--seeds N] [--other BIN_DIR] [OPTIONS]...

Each OPTIONS is one argument with the options of a bake, such as "--rays 256 --sites 4000"; "" stands for the defaults.
For each scene (all by default) and each of them it prints the root mean square error of the indirect irradiance at N
points drawn uniformly by area, relative to the rms of that irradiance, over several seeds; and the least processor
time of a bake. Faces that emit are left out. The reference is a final gather at the same points, which evaluates light
where rays hit: with 16384 rays from a field of 20000 sites. For hall and engine, whose many vertices would be gathered
at as well, it is a field of 30000 sites of 2048 rays each, and --reference says another. --other is the BIN_DIR of
another version that has --at; its defaults are measured in the same run.
The scenes hall and engine are made by its generate_scenes; with --scenes DIR, files of these names there are used.
"""
import argparse
import csv
import math
import pathlib
import random
import resource
import shlex
import subprocess
import sys
import tempfile

DATA = pathlib.Path(__file__).resolve().parents[2] / "data"
SCENES = {
    "cornell_box": "cornell_box.obj",
    "courtyard": "courtyard.off",
    "room": "room.off",
    "room_a": "room_a.json",
    "room_b": "room_b.json",
    "room_c": "room_c.json",
    "room_d": "room_d.json",
}
GENERATED = ("hall", "engine")
GATHERED = "--sites 20000 --final-gather 16384 --seed 977 --output-spacing 1000"
FINE = "--sites 30000 --rays 2048 --seed 977 --output-spacing 1000"
REFERENCES = {"hall": FINE, "engine": FINE}


def read_obj(file):
    """Points, and the faces whose material does not emit."""
    emits, name = set(), None
    for line in file.with_suffix(".mtl").read_text().splitlines():
        words = line.split()
        if words[:1] == ["newmtl"]:
            name = words[1]
        elif words[:1] == ["Ke"] and any(float(word) > 0 for word in words[1:4]):
            emits.add(name)
    points, faces, material = [], [], None
    for line in file.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(tuple(map(float, words[1:4])))
        elif words[:1] == ["usemtl"]:
            material = words[1]
        elif words[:1] == ["f"] and material not in emits:
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            faces.append([number - 1 if number > 0 else len(points) + number for number in numbers])
    return points, faces


def read_off(file):
    lines = [line.split("#")[0].split() for line in file.read_text().splitlines()]
    lines = [words for words in lines if words]
    vertices, faces = int(lines[1][0]), int(lines[1][1])
    points = [tuple(map(float, words[:3])) for words in lines[2:2 + vertices]]
    rows = lines[2 + vertices:2 + vertices + faces]
    return points, [list(map(int, row[1:1 + int(row[0])])) for row in rows]


def triangles_of(scene):
    file = scene.with_suffix(".obj") if scene.suffix == ".json" else scene
    points, faces = read_obj(file) if file.suffix == ".obj" else read_off(file)
    return [[points[face[0]], points[face[k]], points[face[k + 1]]] for face in faces for k in range(1, len(face) - 1)]


def normal_of(triangle):
    """Of the length of twice the triangle's area."""
    a, b, c = triangle
    u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def write_points(scene, count, file):
    draw = random.Random(5)
    triangles = triangles_of(scene)
    normals = [normal_of(triangle) for triangle in triangles]
    lengths = [math.hypot(*normal) for normal in normals]
    with open(file, "w") as out:
        for t in draw.choices(range(len(triangles)), lengths, k=count):
            u, v = draw.random(), draw.random()
            if u + v > 1:
                u, v = 1 - u, 1 - v
            a, b, c = triangles[t]
            position = [(1 - u - v) * a[i] + u * b[i] + v * c[i] for i in range(3)]
            print(*map(repr, position + [x / lengths[t] for x in normals[t]]), sep=",", file=out)


def processor_time():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def irradiance(program, scene, options, folder):
    """Indirect irradiance at the points, and the processor time of the bake, without an error estimate."""
    table = folder / "points.csv"
    command = [program, scene, folder / "out.vtp", "--at", folder / "points.txt", "--at-output", table, "--quiet",
               "--error-points", "0"]
    began = processor_time()
    subprocess.run([*map(str, command), *options], check=True)
    took = processor_time() - began
    return table_of(folder, "irradiance_indirect"), took


def table_of(folder, quantity):
    """The channels of a quantity at the points."""
    with open(folder / "points.csv") as lines:
        return [[float(row[name]) for name in row if name in [quantity] + [f"{quantity}_{c}" for c in "RGB"]]
                for row in csv.DictReader(lines)]


def scene_file(name, arguments, folder):
    """The file of a scene in data/, or of one that is generated."""
    if name in SCENES:
        return DATA / SCENES[name]
    if arguments.scenes:
        return arguments.scenes / f"{name}.json"
    subprocess.run([arguments.bin / "generate_scenes", "--directory", folder, name], check=True)
    return folder / f"{name}.json"


def squares(rows):
    return sum(x * x for row in rows for x in row)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, help="folder of bake_radiosity")
    parser.add_argument("--scene", action="append", choices=[*sorted(SCENES), *GENERATED], default=[])
    parser.add_argument("--scenes", type=pathlib.Path, help="folder of the generated scenes")
    parser.add_argument("--points", type=int, default=4000)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--other", type=pathlib.Path, help="folder of another version's bake_radiosity")
    parser.add_argument("--reference", help="options of the bake that the others are compared with")
    parser.add_argument("options", nargs="*", default=[""])
    # An argument with a space is one of ours, whatever it begins with.
    words = [" " + word if " " in word or word == "" else word for word in sys.argv[1:]]
    arguments = parser.parse_intermixed_args(words)
    program = arguments.bin / "bake_radiosity"
    print("| scene | options | error, % | processor time, s |\n|---|---|---|---|")
    for name in arguments.scene or sorted(SCENES):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            scene = scene_file(name, arguments, folder)
            write_points(scene, arguments.points, folder / "points.txt")
            reference = arguments.reference or REFERENCES.get(name, GATHERED)
            exact, _ = irradiance(program, scene, shlex.split(reference), folder)
            measured = [(program, options) for options in arguments.options or [""]]
            if arguments.other:
                measured.append((arguments.other / "bake_radiosity", ""))
            for which, options in measured:
                error, least = 0.0, math.inf
                for seed in range(1, arguments.seeds + 1):
                    found, took = irradiance(which, scene, [*shlex.split(options), "--seed", str(seed)], folder)
                    error += squares([[x - y for x, y in zip(a, b)] for a, b in zip(found, exact)])
                    least = min(least, took)
                relative = math.sqrt(error / arguments.seeds / squares(exact))
                label = "defaults of the other version" if which != program else options.strip() or "defaults"
                print(f"| {name} | {label} | {100 * relative:.2f} | {least:.2f} |", flush=True)


if __name__ == "__main__":
    main()
